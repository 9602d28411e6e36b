"""How possible a motion is: sliding, sinking, limits, balance, forces and flights, measured from its configurations."""

from dataclasses import asdict, dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.model.build import plain_model
from adapt_envs.model.humanoid import CONTROL_DT, FEET
from adapt_envs.model.soles import TOUCHING, sole_corners
from adapt_envs.motion.clip import FPS, MotionClip
from adapt_envs.motion.dynamics import GRAVITY, momentum

Array = NDArray[np.float64]
_SUPPORT_MARGIN = 0.05
"""A zero-moment point this near to the support polygon counts as inside [m]."""
_UNLOADED = 0.1
"""Below this share of the weight the zero-moment point means nothing."""
_LIMIT_TOLERANCE = 0.01
"""Largest excess over a joint's range [deg] that every kind of motion may have."""


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


def check(clip: MotionClip, kind: str = "walk") -> Quality:
    """Measure a clip and compare it with the thresholds of its kind.

    Raises:
        ValueError: if there are no thresholds for `kind`.
    """
    if kind not in THRESHOLDS:
        raise ValueError(f"no quality thresholds for kind {kind!r}; the kinds are {', '.join(THRESHOLDS)}")
    thresholds, model = THRESHOLDS[kind], plain_model()
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
    measured = Quality(
        name=clip.name,
        seconds=clip.seconds,
        slip_median_cm_s=float(np.median(slip)) if len(slip) else None,
        slip_p90_cm_s=float(np.percentile(slip, thresholds.slip_percentile)) if len(slip) else None,
        penetration_cm=float(max(0.0, -100 * corners[..., 2].min())),
        limit_violation_deg=limit_violation(model, clip.qpos[:, 7:]),
        zmp_in_support=float(inside.mean()) if len(inside) else None,
        force_min=float(low),
        force_max=float(high),
        flight_g_error=abs(float(flights.mean()) + GRAVITY) / GRAVITY if len(flights) else None,
        ok=False,
    )
    return replace(measured, ok=_holds(thresholds, measured))


def _holds(thresholds: Thresholds, measured: Quality) -> bool:
    """Whether every threshold that applies is kept; a measure that is missing keeps none."""
    zmp, force = measured.zmp_in_support, thresholds.force
    return (
        _at_most(measured.slip_median_cm_s, thresholds.slip_median)
        and _at_most(measured.slip_p90_cm_s, thresholds.slip_high)
        and _at_most(measured.penetration_cm, thresholds.penetration)
        and _at_most(measured.limit_violation_deg, _LIMIT_TOLERANCE)
        and _at_most(measured.flight_g_error, thresholds.flight)
        and (thresholds.zmp is None or (zmp is not None and zmp >= thresholds.zmp))
        and (force is None or (measured.force_min >= force[0] and measured.force_max <= force[1]))
    )


def _at_most(value: float | None, threshold: float | None) -> bool:
    return threshold is None or (value is not None and value <= threshold)


def foot_corners(model: mujoco.MjModel, qpos: Array) -> Array:
    """The eight lower corners of both feet's boxes (T, 8, 3) [m], world: four of the right foot, four of the left."""
    data, feet = mujoco.MjData(model), [model.body(name).id for name in FEET]
    pos, quat = np.empty((len(qpos), 2, 3)), np.empty((len(qpos), 2, 4))
    for row, position in enumerate(qpos):
        data.qpos[:] = position
        mujoco.mj_kinematics(model, data)
        pos[row], quat[row] = data.xpos[feet], data.xquat[feet]
    return np.asarray(rotations.placed(pos, quat, sole_corners(model)).reshape(-1, 8, 3), np.float64)


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
