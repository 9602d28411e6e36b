"""Which joint of a foreign skeleton is which: a table of common ones, and maps that users write.

A *role* is a place in the body, such as `left_knee`: the joint that turns there.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from adapt_envs.motion.clip import MotionError
from adapt_envs.motion.importing.files import read_text

SIDES = ("right", "left")
_LIMB_ROLES = ("hip", "knee", "ankle", "toe", "shoulder", "elbow", "wrist")
_OPTIONAL = ("neck", "head", *(f"{side}_{role}" for side in SIDES for role in ("toe", "wrist")))
ROLES = ("hips", "neck", "head", *(f"{side}_{role}" for side in SIDES for role in _LIMB_ROLES))
"""What a map may name; `shoulder` is the upper arm's joint, not the collar bone's; `hip` the thigh's."""
REQUIRED = tuple(role for role in ROLES if role not in _OPTIONAL)
"""What a map must name."""
UP_AXES = ("x", "y", "z", "-x", "-y", "-z")


@dataclass(frozen=True)
class Family:
    """How a family of skeletons names its joints: lower case, without prefix, spaces and `_-.`; `{}` is the side.

    Each role lists alternatives.
    """

    name: str
    sides: tuple[str, str]
    hips: tuple[str, ...]
    neck: tuple[str, ...]
    head: tuple[str, ...]
    hip: tuple[str, ...]
    knee: tuple[str, ...]
    ankle: tuple[str, ...]
    toe: tuple[str, ...]
    shoulder: tuple[str, ...]
    elbow: tuple[str, ...]
    wrist: tuple[str, ...]


FAMILIES = (
    Family("LAFAN1, Mixamo, MotionBuilder", ("right", "left"), ("hips",), ("neck",), ("head",),
           hip=("{}upleg",), knee=("{}leg",), ankle=("{}foot",), toe=("{}toebase", "{}toe"),
           shoulder=("{}arm",), elbow=("{}forearm",), wrist=("{}hand",)),
    Family("CMU, 100STYLE, Xsens", ("right", "left"), ("hips", "hip", "pelvis"), ("neck",), ("head",),
           hip=("{}hip", "{}upperleg"), knee=("{}knee", "{}lowerleg"), ankle=("{}ankle", "{}foot"),
           toe=("{}toe", "{}toebase"), shoulder=("{}upperarm", "{}shoulder"), elbow=("{}elbow", "{}lowerarm"),
           wrist=("{}wrist", "{}hand")),
    Family("CMU for Daz", ("r", "l"), ("hip",), ("neck",), ("head",),
           hip=("{}thigh",), knee=("{}shin",), ankle=("{}foot",), toe=("{}toe",),
           shoulder=("{}shldr",), elbow=("{}forearm",), wrist=("{}hand",)),
    Family("SMPL", ("r", "l"), ("pelvis",), ("neck",), ("head",),
           hip=("{}hip",), knee=("{}knee",), ankle=("{}ankle",), toe=("{}foot",),
           shoulder=("{}shoulder",), elbow=("{}elbow",), wrist=("{}wrist",)),
    Family("Bandai-Namco, VRM", ("r", "l"), ("hips",), ("neck",), ("head",),
           hip=("upperleg{}",), knee=("lowerleg{}",), ankle=("foot{}",), toe=("toes{}",),
           shoulder=("upperarm{}",), elbow=("lowerarm{}",), wrist=("hand{}",)),
    Family("Unreal", ("r", "l"), ("pelvis",), ("neck01",), ("head",),
           hip=("thigh{}",), knee=("calf{}",), ankle=("foot{}",), toe=("ball{}",),
           shoulder=("upperarm{}",), elbow=("lowerarm{}",), wrist=("hand{}",)),
    Family("Biped", ("r", "l"), ("bip01pelvis", "bip01"), ("bip01neck",), ("bip01head",),
           hip=("bip01{}thigh",), knee=("bip01{}calf",), ankle=("bip01{}foot",), toe=("bip01{}toe0",),
           shoulder=("bip01{}upperarm",), elbow=("bip01{}forearm",), wrist=("bip01{}hand",)),
)  # fmt: skip
"""Skeletons that are recognised by their joints' names."""


@dataclass(frozen=True)
class JointMap:
    """Joints of one file by role.

    Attributes:
        joints: role -> joint name in the file.
        up: the file's vertical axis, or None to find it from the motion.
        drop: leading frames to leave out, or None to find a T-pose by itself.
    """

    joints: dict[str, str]
    up: str | None = None
    drop: int | None = None


def recognise(path: Path, names: tuple[str, ...]) -> JointMap:
    """Find the family of a skeleton from its joints' names.

    Raises:
        MotionError: if no family has all the joints that are needed.
    """
    plain = {_plain(name): name for name in reversed(names)}
    maps = [{role: plain[word] for role, word in _wanted(family, plain).items()} for family in FAMILIES]
    missing = [[role for role in REQUIRED if role not in joints] for joints in maps]
    best = min(range(len(maps)), key=lambda i: len(missing[i]))
    if missing[best]:
        raise MotionError(
            f"{path}: line 1: unknown skeleton, no joint found for {', '.join(missing[best])}"
            f" (nearest: {FAMILIES[best].name}); write a map (--map map.yml). The file's joints are {_listed(names)}"
        )
    return JointMap(maps[best])


def read_map(path: Path, motion: Path, names: tuple[str, ...]) -> JointMap:
    """Read a YAML map for a motion file.

    Args:
        path: the map: `joints` (role: joint name), and optionally `up` and `drop`.
        motion: the file it is for, which messages name.
        names: that file's joints.

    Raises:
        MotionError: naming the map, the line and what is wrong.
    """
    text = read_text(path, (".yml", ".yaml"), max_bytes=2**20)
    try:
        content = yaml.safe_load(text)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = mark.line + 1 if mark else 1
        problem = getattr(error, "problem", None) or "unreadable"
        raise MotionError(f"{path}: line {line}: not YAML ({problem})") from None
    except (RecursionError, ValueError) as error:
        raise MotionError(f"{path}: line 1: not sane YAML ({error})") from None
    return _checked(path, text, content, motion, names)


def _checked(path: Path, text: str, content: Any, motion: Path, names: tuple[str, ...]) -> JointMap:
    def fail(problem: str, word: object = "joints") -> None:
        lines = text.splitlines()
        line = next((i for i, row in enumerate(lines, 1) if row.split(":")[0].strip(" \"'-") == str(word)), 1)
        raise MotionError(f"{path}: line {line}: {problem}")

    if not isinstance(content, dict) or not isinstance(content.get("joints"), dict):
        fail("a map needs 'joints:' with lines 'role: joint name'")
    for key in content:
        if key not in ("joints", "up", "drop"):
            fail(f"unknown key {key!r}; the keys are joints, up, drop", key)
    up, drop = content.get("up"), content.get("drop")
    if up is not None and up not in UP_AXES:
        fail(f"up is {up!r}; the axes are {', '.join(UP_AXES)}", "up")
    if drop is not None and (isinstance(drop, bool) or not isinstance(drop, int) or drop < 0):
        fail(f"drop is {drop!r}; a number of frames is expected", "drop")
    joints = {role: str(joint) for role, joint in content["joints"].items()}
    for role, joint in joints.items():
        if role not in ROLES:
            fail(f"unknown role {role!r}; the roles are {', '.join(ROLES)}", role)
        if joint not in names:
            fail(f"{role}: {motion.name} has no joint {joint!r}; its joints are {_listed(names)}", role)
    if absent := [role for role in REQUIRED if role not in joints]:
        fail(f"no joint for {', '.join(absent)}")
    return JointMap(joints, up, drop)


def _wanted(family: Family, plain: dict[str, str]) -> dict[str, str]:
    """Role -> plain name, for the roles that this family has among the names."""
    options = {role: getattr(family, role) for role in ("hips", "neck", "head")}
    for side, word in zip(SIDES, family.sides, strict=True):
        for role in _LIMB_ROLES:
            options[f"{side}_{role}"] = tuple(option.format(word) for option in getattr(family, role))
    found = {role: [option for option in names if option in plain] for role, names in options.items()}
    return {role: names[0] for role, names in found.items() if names}


def _plain(name: str) -> str:
    """`mixamorig:Left_Arm` -> `leftarm`."""
    word = name.rsplit(":", 1)[-1].lower()
    for sign in "_-. ":
        word = word.replace(sign, "")
    return word.removeprefix("mixamorig")


def _listed(names: tuple[str, ...], most: int = 40) -> str:
    real = [name for name in names if not name.endswith(" end")]
    return ", ".join(real[:most]) + (f" and {len(real) - most} more" if len(real) > most else "")
