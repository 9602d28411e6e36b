"""A motion clip: configurations of the character at 30 Hz, possibly one cycle that repeats."""

import hashlib
import io
import json
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.motion.whole_file import write_whole

FPS = 30
"""Frames per second of every clip: the control rate."""
_FORMAT = "adaptnet-motion-1"
_RECORDINGS = (".bvh", ".json")


class MotionError(ValueError):
    """A motion that cannot be used; the message names the file, the place and the problem."""


@dataclass(frozen=True, eq=False)  # a clip is itself alone, which lets caches know it
class MotionClip:
    """Configurations of the character, one every 1/30 s.

    Attributes:
        name: short name, such as `"Stoop"`.
        qpos: (T, 7 + J) float64: root position in the world [m] (z above the ground), root quaternion (w, x, y, z),
            joint angles [rad] in the order of `joint_names`.
        joint_names: the J joints.
        cyclic: whether the clip repeats; its last frame then is the first one, moved and turned on the ground by
            `cycle_transform`, and its period is T - 1 frames.
        origin: where it comes from, in words (generator and its version, or the file's name).
    """

    name: str
    qpos: NDArray[np.float64] = field(repr=False)
    joint_names: tuple[str, ...] = field(repr=False)
    cyclic: bool = False
    origin: str = ""

    def __post_init__(self) -> None:
        """Check shapes and numbers.

        Raises:
            MotionError: for a wrong shape, too few frames, a non-finite number or a quaternion far from unit length.
        """
        width = 7 + len(self.joint_names)
        if self.qpos.ndim != 2 or self.qpos.shape[1] != width:
            raise MotionError(f"clip {self.name!r}: qpos has shape {self.qpos.shape}, expected (frames, {width})")
        if len(self.qpos) < 6:
            raise MotionError(f"clip {self.name!r}: {len(self.qpos)} frames, at least 6 are needed")
        if not np.isfinite(self.qpos).all():
            frame = int(np.argmin(np.isfinite(self.qpos).all(axis=1)))
            raise MotionError(f"clip {self.name!r}: frame {frame} holds a number that is not finite")
        norms = np.linalg.norm(self.qpos[:, 3:7], axis=1)
        if np.abs(norms - 1).max() > 1e-3:
            frame = int(np.abs(norms - 1).argmax())
            raise MotionError(f"clip {self.name!r}: frame {frame} has a root quaternion of length {norms[frame]:.3f}")

    @property
    def period(self) -> int:
        """Frames until a cyclic clip repeats; for any other clip its number of frames."""
        return len(self.qpos) - 1 if self.cyclic else len(self.qpos)

    @property
    def seconds(self) -> float:
        """Duration in seconds: one period, or first to last frame."""
        return (len(self.qpos) - 1) * CONTROL_DT

    @cached_property
    def cycle_transform(self) -> tuple[float, NDArray[np.float64]]:
        """Turn about z [rad] and displacement (2,) [m] of one period: frame T - 1 from frame 0."""
        turn = rotations.heading(self.qpos[-1, 3:7]) - rotations.heading(self.qpos[0, 3:7])
        yaw = float(rotations.wrapped(turn))
        first, last = self.qpos[0, :2], self.qpos[-1, :2]
        return yaw, last - _turn(first, np.asarray(yaw))

    @cached_property
    def mean_speed(self) -> float:
        """Mean horizontal speed of the root along its path [m/s]."""
        return float(np.linalg.norm(np.diff(self.qpos[:, :2], axis=0), axis=1).mean() * FPS)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the configurations (float32) and joint names: what a checkpoint's card refers to."""
        payload = self.qpos.astype("<f4").tobytes() + json.dumps([self.joint_names, self.cyclic]).encode()
        return hashlib.sha256(payload).hexdigest()

    def at(self, frames: NDArray[np.integer] | Sequence[int]) -> NDArray[np.float64]:
        """Configurations (n, 7 + J) at frame numbers; a cyclic clip goes on beyond its ends, any other holds them."""
        frames = np.asarray(frames)
        if not self.cyclic:
            return self.qpos[np.clip(frames, 0, len(self.qpos) - 1)]
        cycles, rows = np.divmod(frames, self.period)
        qpos = self.qpos[rows].copy()
        yaw, shift = self.cycle_transform
        for cycle in np.unique(cycles[cycles != 0]):
            chosen = cycles == cycle
            for _ in range(abs(cycle)):
                qpos[chosen] = transformed(qpos[chosen], yaw, shift) if cycle > 0 else _undo(qpos[chosen], yaw, shift)
        return qpos

    @cached_property
    def qvel(self) -> NDArray[np.float64]:
        """Velocities (T, 6 + J) by central differences (one-sided at the ends of a clip that does not repeat).

        Root velocity in the world [m/s], root angular velocity in the root's frame [rad/s], joint velocities [rad/s]:
        MuJoCo's convention.
        """
        frames = np.arange(len(self.qpos))
        return velocities(self.at(frames - 1), self.at(frames + 1), self._spans() * CONTROL_DT)

    def _spans(self) -> NDArray[np.float64]:
        spans = np.full(len(self.qpos), 2.0)
        if not self.cyclic:
            spans[[0, -1]] = 1.0
        return spans

    def mirrored(self) -> "MotionClip":
        """The clip with left and right exchanged (reflected in the x-z plane)."""
        qpos = self.qpos.copy()
        qpos[:, 1] *= -1
        qpos[:, 3:7] *= (1, -1, 1, -1)
        for column, joint in enumerate(self.joint_names):
            source = self.joint_names.index(_other_side(joint))
            # A reflection in y keeps turns about y and flips those about x and z.
            sign = -1 if joint.endswith(("_x", "_z")) else 1
            qpos[:, 7 + column] = sign * self.qpos[:, 7 + source]
        return replace(self, name=f"{self.name} mirrored", qpos=qpos)

    def save(self, path: str | Path) -> None:
        """Write the clip as `.npz` without pickle, whole or not at all."""
        meta = {"format": _FORMAT, "name": self.name, "joints": self.joint_names, "cyclic": self.cyclic,
                "origin": self.origin, "fps": FPS}  # fmt: skip
        content = io.BytesIO()
        np.savez_compressed(content, qpos=self.qpos.astype(np.float32), meta=np.array(json.dumps(meta)))
        write_whole(Path(path), content.getvalue())

    @classmethod
    def load(cls, path: str | Path) -> "MotionClip":
        """Read a clip that `save` wrote. Opening a file never runs code.

        Raises:
            MotionError: if the file is missing, cut, foreign or holds an unusable motion.
        """
        if Path(path).is_file() and not zipfile.is_zipfile(path):
            words = f"import it first: adaptnet motions import {Path(path).name} -o NAME.npz"
            wanted = f"a recording; {words}" if Path(path).suffix.lower() in _RECORDINGS else "or cut short"
            raise MotionError(f"{path}: not a motion clip, {wanted}")
        try:
            with np.load(path, allow_pickle=False) as data:
                meta = json.loads(str(data["meta"]))
                qpos = data["qpos"].astype(np.float64)
            if meta["format"] != _FORMAT:
                raise ValueError(f"format {meta['format']!r}, expected {_FORMAT!r}")
            if meta.get("fps", FPS) != FPS:
                raise ValueError(f"{meta['fps']} frames a second, expected {FPS}")
            if not all(isinstance(word, str) for word in (meta["name"], meta["origin"], *meta["joints"])):
                raise ValueError("name, origin and joints must be text")
            clip = cls(meta["name"], qpos, tuple(meta["joints"]), bool(meta["cyclic"]), meta["origin"])
            # Single precision leaves the quaternions 1e-7 off; velocities want them exact.
            qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
            return clip
        except MotionError as error:
            raise MotionError(f"{path}: {error}") from None
        except FileNotFoundError:
            raise MotionError(f"{path}: no such file") from None
        except Exception as error:  # np.load raises half a dozen kinds for archives of something else
            raise MotionError(f"{path}: not a motion clip ({error})") from None


def velocities(
    before: NDArray[np.float64], after: NDArray[np.float64], dt: NDArray[np.float64] | float
) -> NDArray[np.float64]:
    """Velocities (n, 6 + J) that carry configurations `before` to `after` (n, 7 + J) in `dt` seconds.

    The root's angular velocity is in its own frame, as in MuJoCo's `qvel`.
    """
    turn = rotations.positive(rotations.multiply(rotations.conjugate(before[:, 3:7]), after[:, 3:7]))
    length = np.linalg.norm(turn[:, 1:], axis=1, keepdims=True)
    angle = 2 * np.arctan2(length, turn[:, :1])
    omega = turn[:, 1:] * np.where(length > 1e-12, angle / np.maximum(length, 1e-12), 2.0)
    change = np.concatenate([after[:, :3] - before[:, :3], omega, after[:, 7:] - before[:, 7:]], axis=1)
    return change / np.broadcast_to(np.asarray(dt, dtype=np.float64), len(change))[:, None]


def transformed(qpos: NDArray[np.float64], yaw: float, shift: NDArray[np.float64]) -> NDArray[np.float64]:
    """Configurations (n, 7 + J) turned about the world's z axis by `yaw` [rad], then moved by `shift` (2,) [m]."""
    qpos = qpos.copy()
    qpos[:, :2] = _turn(qpos[:, :2], np.asarray(yaw)) + shift
    qpos[:, 3:7] = rotations.multiply(rotations.from_yaw(np.asarray(yaw)), qpos[:, 3:7])
    return qpos


def _undo(qpos: NDArray[np.float64], yaw: float, shift: NDArray[np.float64]) -> NDArray[np.float64]:
    return transformed(qpos, -yaw, -_turn(shift, np.asarray(-yaw)))


def _turn(points: NDArray[np.float64], yaw: NDArray[np.float64]) -> NDArray[np.float64]:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack([c * points[..., 0] - s * points[..., 1], s * points[..., 0] + c * points[..., 1]], axis=-1)


def _other_side(joint: str) -> str:
    if joint.startswith("left_"):
        return "right_" + joint[5:]
    return "left_" + joint[6:] if joint.startswith("right_") else joint
