"""The clips that ship, and what environments take from clips: start states and reference windows."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.assets import asset_path
from adapt_envs.features.heading_frame import WINDOW_FRAMES, heading_frame_features, pose_windows
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import build_character, compile_model, plain_model
from adapt_envs.model.humanoid import CONTROL_DT, joint_names, joints_of
from adapt_envs.model.morphology import Morphology
from adapt_envs.motion.clip import MotionClip, MotionError, velocities
from adapt_envs.motion.on_body import on_body, shown_by

BASES = ("walk", "run")
"""Clips of minutes that bases are trained on."""
STYLES = (
    "Swaggering", "GooseStep", "Stomp", "Kicking", "Stoop", "JauntySkip",
    "Sashay", "Limp", "Pace", "Penguin", "Strutting", "Joyful",
)  # fmt: skip
"""The twelve styles of the paper's Table 1, one or two gait cycles each."""
CLIPS = {name: f"motions/{name.lower()}.npz" for name in (*BASES, *STYLES)}
"""Every clip that ships, by name: its file under `assets/`."""
_PAST = WINDOW_FRAMES - 1


def ships(name_or_file: str) -> bool:
    """Whether this is the name of a clip that ships."""
    return name_or_file.lower() in (name.lower() for name in CLIPS)


def load_clip(name_or_file: str) -> MotionClip:
    """A shipped clip by name, or a clip file (`.npz`) by path; a file that did not change is read once.

    Raises:
        MotionError: for a name that is neither, listing the names that ship, or for an unusable file.
    """
    return _load(_version(name_or_file))


class _Version(NamedTuple):
    """A clip file as it is now: where it lies and, if it is there, when it was written and how large it is."""

    path: Path
    written: tuple[int, int] | None


def _version(name_or_file: str) -> _Version:
    by_name = {name.lower(): path for name, path in CLIPS.items()}
    if name_or_file.lower() in by_name:
        return _Version(asset_path(by_name[name_or_file.lower()]), None)
    path = Path(name_or_file)
    if path.suffix != ".npz" and not path.exists():
        raise MotionError(f"no motion named {name_or_file!r}; names are {', '.join(CLIPS)}, or give a clip's .npz file")
    if not path.is_file():
        return _Version(path, None)  # what is wrong with it is for loading to say
    status = path.stat()
    return _Version(path.resolve(), (status.st_mtime_ns, status.st_size))


@lru_cache(maxsize=32)
def _load(version: _Version) -> MotionClip:
    clip, names = MotionClip.load(version.path), joint_names()
    if clip.joint_names == names:
        return clip
    odd = sorted(set(names) ^ set(clip.joint_names))
    if odd or len(clip.joint_names) != len(names):
        words = ", ".join(odd) or "a joint that is there twice"
        raise MotionError(f"{version.path}: clip {clip.name!r} does not fit the character; they differ in: {words}")
    columns = [*range(7), *(7 + clip.joint_names.index(name) for name in names)]
    return replace(clip, qpos=clip.qpos[:, columns], joint_names=names)


@dataclass(frozen=True)
class _Frames:
    """Consecutive frames of a clip with the ones a window at its first frame needs before them."""

    qpos: NDArray[np.float64]
    qvel: NDArray[np.float64]

    @classmethod
    def of(cls, clip: MotionClip) -> "_Frames":
        frames = np.arange(-_PAST if clip.cyclic else 0, clip.period)
        if not clip.cyclic:
            return cls(clip.qpos, clip.qvel)
        return cls(clip.at(frames), velocities(clip.at(frames - 1), clip.at(frames + 1), 2 * CONTROL_DT))


class ReferenceMotion:
    """Start states and pose windows of clips, for one character.

    The windows are the unmodified character's unless asked otherwise (paper, sec. 8.2: motions are not retargeted); the
    start states are `model`'s: missing joints are left out, and the feet of other legs are put where the clip's were.

    Attributes:
        windows_on_body: whether `model` shows the windows.
    """

    def __init__(self, clips: Sequence[MotionClip], model: mujoco.MjModel, windows_on_body: bool = False) -> None:
        """Prepare `clips` for `model`; `windows_on_body` says whether `model` shows the windows (`shown_by`).

        Raises:
            MotionError: if a clip does not know one of the model's joints.
        """
        self.clips = tuple(clips)
        self.model, self.windows_on_body = model, windows_on_body
        self.joint_names = joints_of(model)
        for clip in clips:
            missing = [joint for joint in self.joint_names if joint not in clip.joint_names]
            if missing:
                raise MotionError(f"clip {clip.name!r} lacks the joints {', '.join(missing)}")
        parts = [_Frames.of(clip) for clip in clips]
        self._starts = np.cumsum([0, *(len(part.qpos) for part in parts)])[:-1]
        ranges = [np.arange(s + _PAST, s + len(part.qpos)) for s, part in zip(self._starts, parts, strict=True)]
        self._valid = np.concatenate(ranges)
        self._clip_qpos = np.concatenate([part.qpos for part in parts])
        self._clip_qvel = np.concatenate([part.qvel for part in parts])

    def of(self, clip: MotionClip) -> "ReferenceMotion":
        """Another clip for the same character.

        Raises:
            MotionError: if the clip does not know one of the model's joints.
        """
        return ReferenceMotion([clip], self.model, self.windows_on_body)

    @cached_property
    def shown(self) -> MotionClip:
        """The first clip as `model` shows it (`shown_by`)."""
        return shown_by(self.clips[0], self.model)

    @cached_property
    def _qpos(self) -> NDArray[np.float64]:
        return on_body(self._clip_qpos, self.clips[0].joint_names, self.model)

    @cached_property
    def _qvel(self) -> NDArray[np.float64]:
        names = self.clips[0].joint_names
        qvel = self._clip_qvel[:, [*range(6), *(6 + names.index(joint) for joint in self.joint_names)]]
        lifts = np.split(self._qpos[:, 2] - self._clip_qpos[:, 2], self._starts[1:])  # by the body's other legs
        qvel[:, 2] += np.concatenate([np.gradient(lift, CONTROL_DT) for lift in lifts])
        return qvel

    @cached_property
    def _links(self) -> NDArray[np.float32]:
        return Kinematics(self.model).link_states(self._qpos, self._qvel)

    @cached_property
    def _windows(self) -> NDArray[np.float32]:
        if not self.windows_on_body:
            return _plain_windows(self.clips)
        return windows_of(self.model, [shown_by(clip, self.model) for clip in self.clips])

    @property
    def poses(self) -> NDArray[np.float32]:
        """(P, 15, 7) position [m] and quaternion of the links in each frame, heading frame: the windows' last ones."""
        return self._windows[:, -1]

    @property
    def speed(self) -> float:
        """Mean speed of the first clip [m/s], as the body shows it if the windows do."""
        return (self.shown if self.windows_on_body else self.clips[0]).mean_speed

    @property
    def num_states(self) -> int:
        """Number of start states."""
        return len(self._valid)

    def states(
        self, chosen: NDArray[np.integer]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float32]]:
        """Start states by number, each moved over the world's origin.

        Args:
            chosen: (n,) numbers below `num_states`.

        Returns:
            qpos (n, nq), qvel (n, nv), and the link histories (n, 5, 15, 13) that end in these states, world frame.
        """
        rows = self._valid[chosen]
        qpos, qvel = self._qpos[rows].copy(), self._qvel[rows]
        history = self._links[rows[:, None] + np.arange(-_PAST, 1)]
        history[..., :2] -= qpos[:, None, None, :2].astype(np.float32)
        qpos[:, :2] = 0
        return qpos, qvel, history

    def sample_windows(self, n: int, rng: np.random.Generator) -> NDArray[np.float32]:
        """`n` pose windows (n, 5, 15, 7) of the clips, uniformly over time."""
        return self._windows[rng.integers(len(self._windows), size=n)]

    def pose_actions(self, chosen: NDArray[np.integer]) -> NDArray[np.float64]:
        """Joint angles of start states by number as actions (n, nu): (q - middle of the range) / width of the range."""
        return self._as_actions(self._qpos[self._valid[chosen], 7:])

    @cached_property
    def mean_pose(self) -> NDArray[np.float64]:
        """(nu,) mean joint angles as an action."""
        return self._as_actions(self._qpos[:, 7:].mean(axis=0))

    def _as_actions(self, angles: NDArray[np.float64]) -> NDArray[np.float64]:
        low, high = self.model.jnt_range[1:].T
        return (angles - (low + high) / 2) / (high - low)


def reference_motion(
    name_or_file: str, morphology: Morphology | None = None, locked: tuple[str, ...] = (), windows_on_body: bool = False
) -> ReferenceMotion:
    """The reference motion of a clip (see `load_clip`) for the character with another shape or without some joints.

    Many environments share one; it never changes.
    """
    return _reference_motion(_version(name_or_file), morphology, locked, windows_on_body)


@lru_cache(maxsize=16)
def _reference_motion(
    version: _Version, morphology: Morphology | None, locked: tuple[str, ...], windows_on_body: bool
) -> ReferenceMotion:
    return ReferenceMotion([_load(version)], compile_model(build_character(morphology, locked)), windows_on_body)


@lru_cache(maxsize=8)
def _plain_windows(clips: tuple[MotionClip, ...]) -> NDArray[np.float32]:
    """The windows of all bodies that do not show them: one array, which nobody may change."""
    windows = windows_of(plain_model(), clips)
    windows.flags.writeable = False
    return windows


def windows_of(model: mujoco.MjModel, clips: Sequence[MotionClip]) -> NDArray[np.float32]:
    """Pose windows (n, 5, 15, 7) that end at each frame of clips which has the ones before it."""
    kinematics, found = Kinematics(model), []
    for frames in map(_Frames.of, clips):
        links = kinematics.link_states(frames.qpos, frames.qvel)
        last = np.arange(_PAST, len(links))
        found.append(pose_windows(heading_frame_features(links[last[:, None] + np.arange(-_PAST, 1)])))
    return np.concatenate(found)
