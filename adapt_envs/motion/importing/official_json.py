"""The motion files of the paper's authors: JSON with local rotations of this very character's links."""

import itertools
import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.model.humanoid import LINKS, joint_names
from adapt_envs.motion.clip import MotionError
from adapt_envs.motion.gaits.draft import Draft, angles_within, from_poses, joint_columns
from adapt_envs.motion.importing.files import read_text

_JOINT_OF = {
    "torso": "abdomen", "head": "neck",
    "right_upper_arm": "right_shoulder", "right_lower_arm": "right_elbow",
    "left_upper_arm": "left_shoulder", "left_lower_arm": "left_elbow",
    "right_thigh": "right_hip", "right_shin": "right_knee", "right_foot": "right_ankle",
    "left_thigh": "left_hip", "left_shin": "left_knee", "left_foot": "left_ankle",
}  # fmt: skip
"""The joint that turns each link in its parent; the hands are fused to the lower arms."""
_FPS = (5, 1000)
_MAX_NUMBER = 1e6


@dataclass(frozen=True)
class _File:
    path: Path
    text: str

    def fail(self, problem: str, frame: int | None = None) -> NoReturn:
        """Complain about the whole file, or about a frame by number and line."""
        if frame is None:
            raise MotionError(f"{self.path}: line 1: {problem}")
        raise MotionError(f"{self.path}: line {self._line(frame)}: frame {frame}: {problem}")

    def _line(self, frame: int) -> int:
        starts = (match.start() for match in re.finditer('"pelvis"', self.text))
        return self.text.count("\n", 0, next(itertools.islice(starts, frame, None), 0)) + 1


def read_official_json(path: Path) -> tuple[Draft, float]:
    """Read a file of the authors' format.

    An object with `fps` and `frames`; a frame has `pelvis` = [position [m], quaternion xyzw] and for every other link
    its rotation in its parent as a quaternion xyzw. Links that are missing keep their rest pose.

    Returns:
        The draft at the file's rate, and the seconds between its frames.

    Raises:
        MotionError: naming file, place and problem, if the file is anything else.
    """
    file = _File(path, read_text(path, (".json",)))
    content = _parsed(file)
    fps, frames = content["fps"], content["frames"]
    if isinstance(fps, bool) or not isinstance(fps, int | float) or not _FPS[0] <= fps <= _FPS[1]:
        file.fail(f"'fps' is {fps!r:.60}; a number from {_FPS[0]} to {_FPS[1]} is expected")
    if not isinstance(frames, list) or not frames:
        file.fail("'frames' holds no frames")
    links = _links(file, frames)
    return from_poses(_poses(file, frames, links)), 1 / fps


def _parsed(file: _File) -> dict[str, Any]:
    try:
        content = json.loads(file.text)
    except json.JSONDecodeError as error:
        problem = f"not whole JSON ({error.msg}, column {error.colno})"
        raise MotionError(f"{file.path}: line {error.lineno}: {problem}") from None
    except (RecursionError, ValueError) as error:
        file.fail(f"not sane JSON ({type(error).__name__})")
    if not isinstance(content, dict) or not {"fps", "frames"} <= set(content):
        file.fail("not a motion of the authors' format, an object with 'fps' and 'frames'")
    return content


def _links(file: _File, frames: list[Any]) -> list[str]:
    """Links of the first frame, which every frame must have."""
    for number, frame in enumerate(frames):
        if not isinstance(frame, dict) or "pelvis" not in frame:
            file.fail("not an object with a 'pelvis'", number)
        if unknown := sorted(set(frame) - set(LINKS)):
            file.fail(f"unknown link {unknown[0]!r:.60}; the links are {', '.join(LINKS)}", number)
        if missing := sorted(set(frames[0]) - set(frame)):
            file.fail(f"link {missing[0]!r} is missing, the first frame has it", number)
    return [link for link in frames[0] if link in _JOINT_OF]


def _poses(file: _File, frames: list[Any], links: list[str]) -> NDArray[np.float64]:
    qpos = np.zeros((len(frames), 7 + len(joint_names())))
    roots = [frame["pelvis"] for frame in frames]
    for number, root in enumerate(roots):
        if not isinstance(root, list) or len(root) != 2:
            file.fail("'pelvis' is not [position, quaternion]", number)
    qpos[:, :3] = _numbers(file, "pelvis", [root[0] for root in roots], 3)
    qpos[:, 3:7] = _rotations(file, "pelvis", [root[1] for root in roots])
    for link in links:
        quats = _rotations(file, link, [frame[link] for frame in frames])
        columns = joint_columns(_JOINT_OF[link])
        if len(columns) == 3:
            qpos[:, columns] = angles_within(quats, _JOINT_OF[link])
        else:  # a hinge about y: what turns about other axes has no joint to go to
            angle = 2 * np.arctan2(quats[:, 2], quats[:, 0])
            qpos[:, columns[0]] = rotations.wrapped(angle)
    return qpos


def _rotations(file: _File, link: str, rows: list[Any]) -> NDArray[np.float64]:
    quats = np.roll(_numbers(file, link, rows, 4), 1, axis=1)
    lengths = np.linalg.norm(quats, axis=1)
    worst = int(np.abs(lengths - 1).argmax())
    if abs(lengths[worst] - 1) > 0.05:
        file.fail(f"the quaternion of {link!r} has length {lengths[worst]:.3f}, not 1", worst)
    return quats / lengths[:, None]


def _numbers(file: _File, link: str, rows: list[Any], width: int) -> NDArray[np.float64]:
    for number, row in enumerate(rows):
        fit = isinstance(row, list) and len(row) == width
        if not fit or not all(isinstance(x, int | float) and not isinstance(x, bool) for x in row):
            file.fail(f"{link!r} holds {row!r:.60} where {width} numbers are expected", number)
        if not all(abs(x) < _MAX_NUMBER for x in row):
            file.fail(f"{link!r} holds {row!r:.60}: not finite numbers of a sane size", number)
    return np.array(rows, dtype=np.float64)
