"""BVH files: any hierarchy, channel order and number of channels; every complaint names file and line.

The reader is the project's own because files in the wild have joints with six channels or with one, which the libraries
at hand refuse, and because a complaint about a number must name its line.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.motion.importing.bvh_words import BvhWords
from adapt_envs.motion.importing.files import read_text

_CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "xyz")
_FRAME_TIMES = (0.001, 0.2)
"""Shortest and longest time between frames [s] that is believed."""
_MAX_JOINTS = 2000


@dataclass(frozen=True)
class Bvh:
    """A skeleton and its motion, in the file's own unit and axes.

    Attributes:
        names: (J,) joints, parents before children; the end site of joint `a` is called `a end`.
        parents: (J,) index of each joint's parent, -1 for the root.
        offsets: (J, 3) position in the parent when the file gives no position channels.
        pos: (T, J, 3) position in the parent.
        quat: (T, J, 4) rotation in the parent, wxyz.
        frame_time: seconds between frames.
    """

    names: tuple[str, ...]
    parents: NDArray[np.int64]
    offsets: NDArray[np.float64]
    pos: NDArray[np.float64]
    quat: NDArray[np.float64]
    frame_time: float

    def world(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Positions (T, J, 3) and orientations (T, J, 4) in the file's world."""
        return compose(self.parents, self.pos, self.quat)

    def rest(self) -> NDArray[np.float64]:
        """Positions (J, 3) when no joint is turned."""
        still = np.broadcast_to(np.array([1.0, 0, 0, 0]), (1, len(self.names), 4))
        return compose(self.parents, self.offsets[None], still)[0][0]


def compose(
    parents: NDArray[np.int64], pos: NDArray[np.float64], quat: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Chain local positions (T, J, 3) and rotations (T, J, 4) into the world; parents come before children."""
    world_pos, world_quat = pos.copy(), quat.copy()
    for joint, parent in enumerate(parents):
        if parent >= 0:
            world_quat[:, joint] = rotations.multiply(world_quat[:, parent], quat[:, joint])
            world_pos[:, joint] = world_pos[:, parent] + rotations.rotate(world_quat[:, parent], pos[:, joint])
    return world_pos, world_quat


@dataclass
class _Joint:
    name: str
    parent: int
    line: int
    offset: tuple[float, ...] = ()
    channels: tuple[str, ...] = ()


def read_bvh(path: Path) -> Bvh:
    """Read a BVH file.

    Raises:
        MotionError: naming file, line and problem, if it is not a whole and sane BVH file.
    """
    words = BvhWords(path, read_text(path, (".bvh",)))
    joints = _hierarchy(words)
    words.expect("FRAMES:")
    count = int(words.number("the number of frames"))
    if count < 1:
        words.fail(f"{count} frames")
    words.expect("FRAME")
    words.expect("TIME:")
    frame_time = words.number("the frame time")
    low, high = _FRAME_TIMES
    if not low <= frame_time <= high:
        words.fail(f"a frame time of {frame_time:g} s is absurd; {low} to {high} s are believed")
    numbers = words.rows(count, sum(len(joint.channels) for joint in joints))
    return _assemble(joints, numbers, frame_time)


def _hierarchy(words: BvhWords) -> list[_Joint]:
    words.expect("HIERARCHY")
    joints: list[_Joint] = []
    open_joints: list[int] = []
    while True:
        word = words.expect("ROOT", "JOINT", "END", "}") if open_joints else words.expect("ROOT", "MOTION")
        if word == "MOTION":
            return _checked(words, joints)
        if word == "}":
            open_joints.pop()
            continue
        if word == "ROOT" and joints:
            words.fail("a second ROOT; one skeleton to a file, please")
        joints.append(_block(words, word, joints, open_joints[-1] if open_joints else -1))
        if len(joints) > _MAX_JOINTS:
            words.fail(f"more than {_MAX_JOINTS} joints")
        if word == "END":
            words.expect("}")
        else:
            open_joints.append(len(joints) - 1)


def _block(words: BvhWords, kind: str, joints: list[_Joint], parent: int) -> _Joint:
    """Name, offset and channels of a joint: what stands before its children."""
    if kind == "END":
        words.word("Site")
        joint = _Joint(f"{joints[parent].name} end", parent, words.line)
    else:
        joint = _Joint(words.name(), parent, words.line)
    words.expect("{")
    words.expect("OFFSET")
    joint.offset = tuple(words.number(f"an offset of {joint.name!r}") for _ in range(3))
    if kind != "END":
        words.expect("CHANNELS")
        joint.channels = _channels(words, joint.name)
    return joint


def _channels(words: BvhWords, name: str) -> tuple[str, ...]:
    count = words.number(f"the number of channels of {name!r}")
    if count not in range(7):
        words.fail(f"joint {name!r} declares {count:g} channels; 0 to 6 are possible")
    channels = tuple(words.word("a channel").lower() for _ in range(int(count)))
    for channel in channels:
        if channel not in _CHANNELS:
            words.fail(f"joint {name!r} has a channel {channel[:40]!r}; the channels are {', '.join(_CHANNELS)}")
    if len(set(channels)) < len(channels):
        words.fail(f"joint {name!r} names a channel twice")
    return channels


def _checked(words: BvhWords, joints: list[_Joint]) -> list[_Joint]:
    names: dict[str, int] = {}
    for joint in joints:
        if joint.name in names and not joint.name.endswith(" end"):
            words.fail(f"joint {joint.name!r} stands already in line {names[joint.name]}", joint.line)
        names[joint.name] = joint.line
    if not any(joint.channels for joint in joints):
        words.fail("no joint has a channel")
    return joints


def _assemble(joints: list[_Joint], numbers: NDArray[np.float64], frame_time: float) -> Bvh:
    offsets = np.array([joint.offset for joint in joints])
    pos = np.broadcast_to(offsets, (len(numbers), len(joints), 3)).copy()
    quat = np.zeros((len(numbers), len(joints), 4))
    quat[..., 0] = 1
    column = 0
    for index, joint in enumerate(joints):
        for channel in joint.channels:
            axis, values = "xyz".index(channel[0]), numbers[:, column]
            if channel.endswith("position"):
                pos[:, index, axis] = values
            else:  # channels apply left to right: R = R1 R2 R3
                turn = rotations.from_axis_angle(np.broadcast_to(np.eye(3)[axis], (len(values), 3)), np.radians(values))
                quat[:, index] = rotations.multiply(quat[:, index], turn)
            column += 1
    parents = np.array([joint.parent for joint in joints])
    return Bvh(tuple(joint.name for joint in joints), parents, offsets, pos, quat, frame_time)
