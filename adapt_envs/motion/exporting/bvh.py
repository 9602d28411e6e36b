"""A performance as a BVH file: centimetres, y up, rotations as angles about y, z and x."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from adapt_envs.motion.exporting.performance import Performance
from adapt_envs.motion.whole_file import write_whole

_CENTIMETRES = 100.0
"""BVH states no unit; animation tools take this one."""
_ENDS = {
    "Head": (0.0, 0.27, 0.0),
    "RightHand": (0.0, -0.08, 0.0), "LeftHand": (0.0, -0.08, 0.0),
    "RightFoot": (0.0, -0.05, 0.1335), "LeftFoot": (0.0, -0.05, 0.1335),
}  # fmt: skip
"""Where the last bones end [m], y up: they only say how long a bone is drawn and where a foot points."""
_ROTATIONS = "Yrotation Zrotation Xrotation"
"""About the vertical first, so that a heading may be any; only a limb held out to the side loses an angle."""


def write_bvh(performed: Performance, path: str | Path) -> None:
    """Write a performance as a BVH file, whole or not at all.

    Raises:
        OSError: if the file cannot be written.
    """
    motion = [" ".join(_texts(row)) for row in _channels(performed)]
    times = [f"Frames: {len(motion)}", f"Frame Time: {1 / performed.fps:.8f}"]
    lines = ["HIERARCHY", *_joint(performed, 0, ""), "MOTION", *times, *motion]
    write_whole(Path(path), ("\n".join(lines) + "\n").encode())


def _joint(performed: Performance, bone: int, indent: str) -> Iterator[str]:
    """Lines of a bone and of all below it."""
    name, root = performed.names[bone], performed.parents[bone] < 0
    inner = f"{indent}  "
    yield f"{indent}{'ROOT' if root else 'JOINT'} {name}"
    yield f"{indent}{{"
    yield f"{inner}OFFSET {' '.join(_texts(performed.offsets[bone] * _CENTIMETRES))}"
    yield f"{inner}CHANNELS {'6 Xposition Yposition Zposition ' if root else '3 '}{_ROTATIONS}"
    for child, parent in enumerate(performed.parents):
        if parent == bone:
            yield from _joint(performed, child, inner)
    if name in _ENDS:
        end = " ".join(_texts(np.array(_ENDS[name]) * _CENTIMETRES))
        yield from (f"{inner}End Site", f"{inner}{{", f"{inner}  OFFSET {end}", f"{inner}}}")
    yield f"{indent}}}"


def _channels(performed: Performance) -> NDArray[np.float64]:
    """(T, 3 + 3 J) numbers of the frames: the root's position [cm], then every bone's angles [degrees]."""
    frames, bones = performed.quats.shape[:2]
    turns = Rotation.from_quat(np.roll(performed.quats.reshape(-1, 4), -1, axis=1))
    angles = turns.as_euler("YZX").reshape(frames, 3 * bones)
    return np.concatenate([performed.root * _CENTIMETRES, np.degrees(np.unwrap(angles, axis=0))], axis=1)


def _texts(numbers: NDArray[np.float64]) -> list[str]:
    return [f"{number:.5f}" for number in numbers]
