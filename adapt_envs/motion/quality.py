"""How possible a motion is: sliding, sinking, limits, balance, forces and flights, measured from its configurations."""

from dataclasses import asdict, dataclass
from functools import cache

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.build import compile_model
from adapt_envs.model.humanoid import CONTROL_DT, FEET
from adapt_envs.model.soles import TOUCHING, sole_corners
from adapt_envs.motion.clip import FPS, MotionClip
from adapt_envs.motion.dynamics import GRAVITY, momentum

Array = NDArray[np.float64]
_SUPPORT_MARGIN = 0.05
"""A zero-moment point this near to the support polygon counts as inside [m]."""
_UNLOADED = 0.1
"""Below this share of the weight the zero-moment point means nothing."""


@dataclass(frozen=True)
class Thresholds:
    """What a kind of motion must keep to; None where it does not apply.

    Attributes:
        slip_median, slip_high: cm/s; `slip_percentile` says of which percentile the second is.
        zmp: least share of grounded frames with the zero-moment point in the support.
        force: range of the vertical force over weight, 2nd to 98th percentile.
        flight: largest error of the acceleration in flights over g.
    """

    slip_median: float = 5.0
    slip_high: float = 15.0
    slip_percentile: int = 90
    penetration: float = 1.0
    zmp: float | None = 0.90
    force: tuple[float, float] | None = (0.7, 1.4)
    flight: float | None = None


THRESHOLDS = {
    "walk": Thresholds(zmp=0.95),
    "run": Thresholds(slip_percentile=75, zmp=None, force=None, flight=0.2),
    "quiet": Thresholds(),
    "forceful": Thresholds(force=(0.4, 2.2)),
    "hopping": Thresholds(slip_percentile=75, zmp=None, force=None, flight=0.2),
}
"""Thresholds by kind of motion."""


@dataclass(frozen=True)
class Quality:
    """Measures of one clip; the fields are those of `adaptnet motions check --json`.

    Attributes:
        name: of the clip.
        seconds: its duration.
        slip_median_cm_s, slip_p90_cm_s: speed of the lowest foot corner while it stays near the ground; the second is
            the 75th percentile for runs and hops, whose contacts are brief.
        penetration_cm: depth of the deepest foot corner.
        limit_violation_deg: largest excess over a joint's range.
        zmp_in_support: share of grounded frames with the zero-moment point within 5 cm of the support polygon.
        force_min, force_max: 2nd and 98th percentile of the vertical ground force over weight.
        flight_g_error: |mean vertical acceleration in flights + g| / g; None without flights.
        ok: whether the thresholds of its kind hold.
    """

    name: str
    seconds: float
    slip_median_cm_s: float | None
    slip_p90_cm_s: float | None
    penetration_cm: float
    limit_violation_deg: float
    zmp_in_support: float | None
    force_min: float
    force_max: float
    flight_g_error: float | None
    ok: bool

    def as_dict(self) -> dict[str, object]:
        """The fields as plain values."""
        return asdict(self)


@cache
def _character() -> mujoco.MjModel:
    return compile_model()


def check(clip: MotionClip, kind: str = "walk") -> Quality:
    """Measure a clip and compare it with the thresholds of its kind.

    Raises:
        ValueError: if there are no thresholds for `kind`.
    """
    if kind not in THRESHOLDS:
        raise ValueError(f"no quality thresholds for kind {kind!r}; the kinds are {', '.join(THRESHOLDS)}")
    thresholds, model = THRESHOLDS[kind], _character()
    frames = np.arange(-2, len(clip.qpos) + 1) if clip.cyclic else np.arange(len(clip.qpos))
    qpos = clip.at(frames)
    corners = foot_corners(model, qpos)
    motion = momentum(model, qpos, CONTROL_DT)
    inner = corners[2:-2]
    slip = slip_speeds(inner if clip.cyclic else corners)
    grounded = (inner[..., 2] < TOUCHING).any(axis=1)
    flights = motion.com_acc[~grounded, 2]
    inside = support_distance(motion.zmp, inner)[grounded & (motion.force > _UNLOADED)] <= _SUPPORT_MARGIN
    low, high = np.percentile(motion.force, [2, 98])
    values = {
        "slip_median_cm_s": float(np.median(slip)) if len(slip) else None,
        "slip_p90_cm_s": float(np.percentile(slip, thresholds.slip_percentile)) if len(slip) else None,
        "penetration_cm": float(max(0.0, -100 * corners[..., 2].min())),
        "limit_violation_deg": limit_violation(model, clip.qpos[:, 7:]),
        "zmp_in_support": float(inside.mean()) if len(inside) else None,
        "force_min": float(low),
        "force_max": float(high),
        "flight_g_error": abs(float(flights.mean()) + GRAVITY) / GRAVITY if len(flights) else None,
    }
    seconds = clip.period / FPS if clip.cyclic else clip.seconds
    return Quality(clip.name, seconds, ok=_holds(thresholds, values), **values)  # type: ignore[arg-type]


def _holds(thresholds: Thresholds, values: dict[str, float | None]) -> bool:
    def at_most(name: str, bar: float | None) -> bool:
        value = values[name]
        return bar is None or (value is not None and value <= bar)

    zmp, low, high = values["zmp_in_support"], values["force_min"], values["force_max"]
    return bool(
        at_most("slip_median_cm_s", thresholds.slip_median)
        and at_most("slip_p90_cm_s", thresholds.slip_high)
        and at_most("penetration_cm", thresholds.penetration)
        and at_most("limit_violation_deg", 0.01)
        and at_most("flight_g_error", thresholds.flight)
        and (thresholds.zmp is None or (zmp is not None and zmp >= thresholds.zmp))
        and (thresholds.force is None or (low >= thresholds.force[0] and high <= thresholds.force[1]))  # type: ignore[operator]
    )


def foot_corners(model: mujoco.MjModel, qpos: Array) -> Array:
    """The eight lower corners of both feet's boxes (T, 8, 3) [m], world: four of the right foot, four of the left."""
    data = mujoco.MjData(model)
    local, bodies = sole_corners(model), [int(model.geom(name).bodyid[0]) for name in FEET]
    corners = np.empty((len(qpos), 8, 3))
    for row, position in enumerate(qpos):
        data.qpos[:] = position
        mujoco.mj_kinematics(model, data)
        for i, body in enumerate(bodies):
            corners[row, 4 * i : 4 * i + 4] = data.xpos[body] + local[i] @ data.xmat[body].reshape(3, 3).T
    return corners


def slip_speeds(corners: Array) -> Array:
    """Horizontal speeds [cm/s] of the lowest corner between frames in both of which it is near the ground."""
    lowest = corners[:-1, :, 2].argmin(axis=1)
    rows = np.arange(len(lowest))
    before, after = corners[rows, lowest], corners[rows + 1, lowest]
    near = (before[:, 2] < TOUCHING) & (after[:, 2] < TOUCHING)
    return 100 * FPS * np.linalg.norm((after - before)[near, :2], axis=1)


def limit_violation(model: mujoco.MjModel, joints: Array) -> float:
    """Largest excess of joint angles (T, J) [rad] over their ranges, in degrees."""
    ranges = model.jnt_range[1:]
    excess = np.maximum(ranges[:, 0] - joints, joints - ranges[:, 1])
    return float(np.degrees(max(0.0, excess.max())))


def support_distance(points: Array, corners: Array) -> Array:
    """Distance (T,) [m] of points (T, 2) on the ground from the convex hull of the corners (T, 8, 3) that touch it.

    0 inside; infinite where nothing touches.
    """
    return np.array([_hull_distance(p, c[c[:, 2] < TOUCHING, :2]) for p, c in zip(points, corners, strict=True)])


def _hull_distance(point: Array, hull: Array) -> float:
    """Distance of a point from the convex hull of a few points: inside if no line through it leaves all on one side."""
    if not len(hull):
        return float("inf")
    offset = hull - point
    angles = np.sort(np.arctan2(offset[:, 1], offset[:, 0]))
    gaps = np.diff(np.r_[angles, angles[0] + 2 * np.pi])
    if gaps.max() <= np.pi:
        return 0.0
    start, end = (a.reshape(-1, 2) for a in np.broadcast_arrays(offset[:, None], offset[None]))
    edge = end - start
    along = np.clip(-(start * edge).sum(axis=1) / np.maximum((edge**2).sum(axis=1), 1e-12), 0, 1)
    return float(np.linalg.norm(start + along[:, None] * edge, axis=1).min())
