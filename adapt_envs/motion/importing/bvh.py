"""BVH files: any hierarchy, channel order and number of channels; every complaint names file and line.

The reader is the project's own because files in the wild have joints with six channels or with one, which the libraries
at hand refuse, and because a complaint about a number must name its line.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.motion.clip import MotionError
from adapt_envs.motion.importing.files import read_text

_CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "xyz")
_FRAME_TIMES = (0.001, 0.2)
"""Shortest and longest time between frames [s] that is believed."""
_MAX_JOINTS = 2000
_MAX_NUMBER = 1e7
_BRACES = "{}"


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


class _Reader:
    """Words of the text with their lines, one at a time."""

    def __init__(self, path: Path, text: str) -> None:
        self.path, self.lines = path, text.splitlines()
        self.line = 0
        self._words = self._stream()

    def _stream(self) -> Iterator[str]:
        for number, line in enumerate(self.lines, start=1):
            for word in line.replace("{", " { ").replace("}", " } ").split():
                self.line = number
                yield word

    def fail(self, problem: str, line: int | None = None) -> NoReturn:
        raise MotionError(f"{self.path}: line {line or self.line}: {problem}")

    def word(self, wanted: str) -> str:
        """The next word; `wanted` says what for, should the file end here."""
        for word in self._words:
            return word
        self.fail(f"the file ends where {wanted} should follow", len(self.lines))

    def expect(self, *choices: str) -> str:
        word = self.word(" or ".join(choices))
        if word.upper() not in choices:
            self.fail(f"found {word[:40]!r} where {' or '.join(choices)} should stand")
        return word.upper()

    def number(self, wanted: str) -> float:
        word = self.word(wanted)
        try:
            value = float(word)
        except ValueError:
            self.fail(f"found {word[:40]!r} where {wanted} should stand")
        if not np.isfinite(value) or abs(value) > _MAX_NUMBER:
            self.fail(f"{wanted} is {word[:40]}")
        return value

    def name(self) -> str:
        """The rest of this line up to a brace: names may hold spaces."""
        line = self.line
        rest = self.lines[line - 1].split("{")[0].split(maxsplit=1)
        if len(rest) < 2:
            self.fail("a joint without a name")
        for _ in rest[1].split():
            self.word("a name")
        return rest[1].strip()


def read_bvh(path: Path) -> Bvh:
    """Read a BVH file.

    Raises:
        MotionError: naming file, line and problem, if it is not a whole and sane BVH file.
    """
    reader = _Reader(path, read_text(path, (".bvh",)))
    joints = _hierarchy(reader)
    reader.expect("FRAMES:")
    count = int(reader.number("the number of frames"))
    if count < 1:
        reader.fail(f"{count} frames")
    reader.expect("FRAME")
    reader.expect("TIME:")
    frame_time = reader.number("the frame time")
    low, high = _FRAME_TIMES
    if not low <= frame_time <= high:
        reader.fail(f"a frame time of {frame_time:g} s is absurd; {low} to {high} s are believed")
    numbers = _frames(reader, count, sum(len(joint.channels) for joint in joints))
    return _assemble(joints, numbers, frame_time)


def _hierarchy(reader: _Reader) -> list[_Joint]:
    reader.expect("HIERARCHY")
    joints: list[_Joint] = []
    open_joints: list[int] = []
    while True:
        word = reader.expect("ROOT", "JOINT", "END", "}") if open_joints else reader.expect("ROOT", "MOTION")
        if word == "MOTION":
            return _checked(reader, joints)
        if word == "}":
            open_joints.pop()
            continue
        if word == "ROOT" and joints:
            reader.fail("a second ROOT; one skeleton to a file, please")
        joints.append(_block(reader, word, joints, open_joints[-1] if open_joints else -1))
        if len(joints) > _MAX_JOINTS:
            reader.fail(f"more than {_MAX_JOINTS} joints")
        if word == "END":
            reader.expect("}")
        else:
            open_joints.append(len(joints) - 1)


def _block(reader: _Reader, kind: str, joints: list[_Joint], parent: int) -> _Joint:
    """Name, offset and channels of a joint: what stands before its children."""
    if kind == "END":
        reader.word("Site")
        joint = _Joint(f"{joints[parent].name} end", parent, reader.line)
    else:
        joint = _Joint(reader.name(), parent, reader.line)
    reader.expect("{")
    reader.expect("OFFSET")
    joint.offset = tuple(reader.number(f"an offset of {joint.name!r}") for _ in range(3))
    if kind != "END":
        reader.expect("CHANNELS")
        joint.channels = _channels(reader, joint.name)
    return joint


def _channels(reader: _Reader, name: str) -> tuple[str, ...]:
    count = reader.number(f"the number of channels of {name!r}")
    if count not in range(7):
        reader.fail(f"joint {name!r} declares {count:g} channels; 0 to 6 are possible")
    channels = tuple(reader.word("a channel").lower() for _ in range(int(count)))
    for channel in channels:
        if channel not in _CHANNELS:
            reader.fail(f"joint {name!r} has a channel {channel[:40]!r}; the channels are {', '.join(_CHANNELS)}")
    if len(set(channels)) < len(channels):
        reader.fail(f"joint {name!r} names a channel twice")
    return channels


def _checked(reader: _Reader, joints: list[_Joint]) -> list[_Joint]:
    names: dict[str, int] = {}
    for joint in joints:
        if joint.name in names and not joint.name.endswith(" end"):
            reader.fail(f"joint {joint.name!r} stands already in line {names[joint.name]}", joint.line)
        names[joint.name] = joint.line
    if not any(joint.channels for joint in joints):
        reader.fail("no joint has a channel")
    return joints


def _frames(reader: _Reader, count: int, width: int) -> NDArray[np.float64]:
    """The numbers (count, width) of the motion, one frame to a line."""
    first = reader.line  # lines before it are read
    numbered = [i for i, line in enumerate(reader.lines[first:], start=first + 1) if line and not line.isspace()]
    if len(numbered) > count:
        reader.fail(f"more lines than the {count} frames declared", numbered[count])
    if len(numbered) < count and numbered and len(reader.lines[numbered[-1] - 1].split()) == width:
        reader.fail(f"the file ends after {len(numbered)} of {count} frames", numbered[-1])
    if not numbered:
        reader.fail(f"the file ends before the first of {count} frames", len(reader.lines))
    numbers = np.empty((len(numbered), width))
    for row, line in zip(numbers, numbered, strict=True):
        row[:] = _frame(reader, line, width)
    return numbers


def _frame(reader: _Reader, line: int, width: int) -> NDArray[np.float64]:
    words = reader.lines[line - 1].split()
    if len(words) != width:
        reader.fail(f"{len(words)} numbers, the hierarchy has {width} channels", line)
    try:
        values = np.array(words, dtype=np.float64)
    except ValueError:
        word = next(word for word in words if not _is_number(word))
        reader.fail(f"{word[:40]!r} is not a number", line)
    sane = np.abs(values) <= _MAX_NUMBER
    if not sane.all():
        channel = int(np.argmin(sane))
        reader.fail(f"channel {channel + 1} is {words[channel][:40]}", line)
    return values


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


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
