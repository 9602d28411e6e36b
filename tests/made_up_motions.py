"""Small motion files made up for the import tests: a walking stick figure, written in many dialects."""

import json
import math
from collections.abc import Sequence
from pathlib import Path

THIGH, SHIN, FOOT = 0.4, 0.4, 0.16

MIXAMO = {
    "hips": "mixamorig:Hips", "spine": "mixamorig:Spine", "neck": "mixamorig:Neck", "head": "mixamorig:Head",
    "arm": "mixamorig:{}Arm", "forearm": "mixamorig:{}ForeArm", "hand": "mixamorig:{}Hand",
    "thigh": "mixamorig:{}UpLeg", "shin": "mixamorig:{}Leg", "foot": "mixamorig:{}Foot", "toe": "mixamorig:{}ToeBase",
}  # fmt: skip
CMU = {
    "hips": "Hips", "spine": "Chest", "neck": "Neck", "head": "Head", "arm": "{}Shoulder", "forearm": "{}Elbow",
    "hand": "{}Wrist", "thigh": "{}Hip", "shin": "{}Knee", "foot": "{}Ankle", "toe": "{}Toe",
}  # fmt: skip
LAFAN = {key: name.replace("mixamorig:", "").replace("ToeBase", "Toe") for key, name in MIXAMO.items()}
STRANGE = {key: f"bone_{i}_{'{}' if '{}' in name else ''}" for i, (key, name) in enumerate(MIXAMO.items())}


def strange_map() -> dict[str, str]:
    """The map that makes sense of `STRANGE`."""
    roles = {"hips": "hips", "neck": "neck", "head": "head"}
    arm = {"shoulder": "arm", "elbow": "forearm", "wrist": "hand"}
    limbs = {**arm, "hip": "thigh", "knee": "shin", "ankle": "foot", "toe": "toe"}
    joints = {role: STRANGE[key] for role, key in roles.items()}
    for side in ("left", "right"):
        joints |= {f"{side}_{role}": STRANGE[key].format(side.capitalize()) for role, key in limbs.items()}
    return joints


def _angles(phase: float) -> dict[str, dict[str, float]]:
    """Turns about the lateral axis [deg] of a walk, positive = lower end backward for a leg; toe down for a foot."""
    out: dict[str, dict[str, float]] = {}
    for side, shift in (("Left", 0.0), ("Right", math.pi)):
        hip = -16.4 * math.sin(phase + shift)
        knee = 8 + 45 * max(0.0, math.cos(phase + shift))
        arm = 20 * math.sin(phase + shift)
        out[side] = {"thigh": hip, "shin": knee, "foot": -hip - knee, "arm": arm, "forearm": -25.0}
    return out


def bvh_text(
    names: dict[str, str] = CMU, frames: int = 60, frame_time: float = 1 / 30, unit: float = 0.01, up: str = "y",
    order: str = "ZXY", six_channels: bool = False, t_pose: int = 0, still: bool = False,
) -> str:  # fmt: skip
    """A stick figure that walks along its forward axis (z for y up, x for z up) at 1.2 m/s, one cycle in 1.2 s.

    Arms hang down at rest, so the skeleton's zero pose is a stand; for a leading T-pose the arms are turned out.
    """
    axes = _Axes(up)
    rows: list[str] = []
    joints: list[tuple[str, str]] = []

    def open_joint(kind: str, key: str, side: str, offset: Sequence[float]) -> None:
        name = names[key].format(side)
        joints.append((key, side))
        positions = [f"{axis}position" for axis in "XYZ"] if kind == "ROOT" or six_channels else []
        channels = positions + [f"{axis}rotation" for axis in order]
        rows.extend([f"{kind} {name}", "{", "OFFSET " + _numbers(axes.place(offset), 1 / unit),
                     f"CHANNELS {len(channels)} {' '.join(channels)}"])  # fmt: skip
        offsets[(key, side)] = offset

    def end(offset: Sequence[float]) -> None:
        rows.extend(["End Site", "{", "OFFSET " + _numbers(axes.place(offset), 1 / unit), "}"])

    offsets: dict[tuple[str, str], Sequence[float]] = {}
    open_joint("ROOT", "hips", "", (0, 0, 0))
    for side, sign in (("Left", 1), ("Right", -1)):
        open_joint("JOINT", "thigh", side, (0, 0.09 * sign, 0))
        open_joint("JOINT", "shin", side, (0, 0, -THIGH))
        open_joint("JOINT", "foot", side, (0, 0, -SHIN))
        open_joint("JOINT", "toe", side, (0.12, 0, -0.05))
        end((0.04, 0, 0))
        rows.extend(["}"] * 4)
    open_joint("JOINT", "spine", "", (0, 0, 0.22))
    for side, sign in (("Left", 1), ("Right", -1)):
        open_joint("JOINT", "arm", side, (0, 0.17 * sign, 0.22))
        open_joint("JOINT", "forearm", side, (0, 0, -0.26))
        open_joint("JOINT", "hand", side, (0, 0, -0.25))
        end((0, 0, -0.08))
        rows.extend(["}"] * 3)
    open_joint("JOINT", "neck", "", (0, 0, 0.24))
    open_joint("JOINT", "head", "", (0, 0, 0.1))
    end((0, 0, 0.15))
    rows.extend(["}"] * 4)
    lines = [
        _frame(joints, offsets, time, unit, axes, order, six_channels, i < t_pose)
        for i, time in enumerate(0.0 if i < t_pose or still else i * frame_time for i in range(frames))
    ]
    return "\n".join(["HIERARCHY", *rows, "MOTION", f"Frames: {frames}", f"Frame Time: {frame_time:.7f}", *lines, ""])


def _frame(joints: list, offsets: dict, time: float, unit: float, axes: "_Axes", order: str, six: bool,
           t_pose: bool) -> str:  # fmt: skip
    angles = _angles(2 * math.pi * time / 1.2)
    numbers: list[str] = []
    for key, side in joints:
        place = (1.2 * time, 0, 0.82) if key == "hips" else offsets[(key, side)]
        if key == "hips" or six:
            numbers.append(_numbers(axes.place(place), 1 / unit))
        lateral, forward = (angles[side].get(key, 0.0), 0.0) if side else (0.0, 0.0)
        if t_pose:
            lateral, forward = 0.0, {"Left": 90.0, "Right": -90.0}.get(side, 0.0) if key == "arm" else 0.0
        # The character's y axis (to the left) and x axis (forward) as the file's axes.
        turns = {axes.left: lateral, axes.forward: forward}
        numbers.append(" ".join(f"{turns.get(axis.lower(), 0.0):.5f}" for axis in order))
    return " ".join(numbers)


class _Axes:
    """x forward, y left, z up in a file's own axes."""

    def __init__(self, up: str) -> None:
        self.up = up
        self.forward, self.left = {"y": ("z", "x"), "z": ("x", "y"), "x": ("y", "z")}[up]

    def place(self, point: Sequence[float]) -> list[float]:
        out = dict(zip((self.forward, self.left, self.up), point, strict=True))
        return [out[axis] for axis in "xyz"]


def _numbers(point: Sequence[float], scale: float) -> str:
    return " ".join(f"{value * scale:.6f}" for value in point)


def json_object(frames: int = 40, fps: int = 30) -> dict:
    """A walk in the format of the paper's authors: x forward, z up, quaternions x, y, z, w about y."""

    def about_y(degrees: float) -> list[float]:
        half = math.radians(degrees) / 2
        return [0.0, math.sin(half), 0.0, math.cos(half)]

    rows = []
    for i in range(frames):
        angles = _angles(2 * math.pi * i / fps / 1.2)
        row: dict = {"pelvis": [[1.2 * i / fps, 0.0, 0.85], [0.0, 0.0, 0.0, 1.0]]}
        row |= {"torso": about_y(5), "head": about_y(-5)}
        for side, word in (("Left", "left"), ("Right", "right")):
            links = {"upper_arm": "arm", "lower_arm": "forearm", "thigh": "thigh", "shin": "shin", "foot": "foot"}
            row |= {f"{word}_{link}": about_y(angles[side][key]) for link, key in links.items()}
            row[f"{word}_hand"] = about_y(0)
        rows.append(row)
    return {"_": "made up", "fps": fps, "frames": rows}


def write(folder: Path, name: str, content: str | bytes | dict) -> Path:
    """A file in a folder; an object becomes JSON, one frame to a line."""
    path = folder / name
    if isinstance(content, dict):
        rows = ",\n".join(json.dumps(frame) for frame in content["frames"])
        rest = {key: value for key, value in content.items() if key != "frames"}
        content = json.dumps(rest)[:-1] + (", " if rest else "") + f'"frames": [\n{rows}\n]}}'
    if isinstance(content, str):
        content = content.encode()
    path.write_bytes(content)
    return path
