"""The character: its links, joints and servo gains, and its `MjSpec` on a plain ground."""

import math
from functools import cache

import mujoco

from adapt_envs.assets import asset_path

PHYSICS_STEPS = 4
"""Physics steps (120 Hz) per control step (30 Hz); paper, sec. 7."""
CONTROL_DT = 1 / 30
"""Control step in seconds."""

LINKS = (
    "pelvis", "torso", "head",
    "right_upper_arm", "right_lower_arm", "right_hand", "left_upper_arm", "left_lower_arm", "left_hand",
    "right_thigh", "right_shin", "right_foot", "left_thigh", "left_shin", "left_foot",
)  # fmt: skip
"""The 15 links in the order of the observation."""
FEET = ("right_foot", "left_foot")
"""The only links that may touch the ground."""
FOOT_LINKS = tuple(LINKS.index(foot) for foot in FEET)
"""Their numbers in `LINKS`: right, left."""

_GAINS = {
    "abdomen": (600.0, 60.0),
    "neck": (50.0, 5.0),
    "shoulder": (200.0, 20.0),
    "elbow": (150.0, 15.0),
    "hip": (300.0, 30.0),
    "knee": (300.0, 30.0),
    "ankle": (200.0, 20.0),
}
"""Servo gains kp [N m/rad] and kd [N m s/rad] by joint group."""


def joint_group(name: str) -> str:
    """Group of a joint, such as `"hip"` for `"right_hip_x"`; the key of its servo gains.

    Raises:
        ValueError: for a joint that belongs to no group.
    """
    for group in _GAINS:
        if group in name:
            return group
    raise ValueError(f"joint {name!r} belongs to no group; the groups are {', '.join(_GAINS)}")


def load_spec() -> mujoco.MjSpec:
    """A fresh, editable `MjSpec` of the character alone: no ground and no servos yet (see `build.compile_model`)."""
    return mujoco.MjSpec.from_file(str(asset_path("humanoid.xml")))


def hinges(spec: mujoco.MjSpec) -> list[mujoco.MjsJoint]:
    """The actuated joints of a character in the model's order (all but the free root)."""
    return [joint for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_HINGE]


@cache
def joint_names() -> tuple[str, ...]:
    """The plain character's 28 joints in the order of a configuration and of an action."""
    return tuple(joint.name for joint in hinges(load_spec()))


def joints_of(model: mujoco.MjModel) -> tuple[str, ...]:
    """The joints of any character, locked ones left out, in the order of its configurations and actions."""
    return tuple(model.actuator(i).name for i in range(model.nu))


def add_servos(spec: mujoco.MjSpec) -> None:
    """Add one position servo per hinge: torque = kp (target - q) - kd qdot, target = mid + action * range width.

    An action of +-1 thus aims half a range past a limit, which is how a servo can push near it. Limits are degrees in
    the spec; the servo's control is the action itself, in [-1, 1].
    """
    for joint in hinges(spec):
        kp, kd = _GAINS[joint_group(joint.name)]
        low, high = (math.radians(limit) if spec.compiler.degree else float(limit) for limit in joint.range)
        servo = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.ctrlrange, servo.ctrllimited = (-1.0, 1.0), True
        servo.gaintype, servo.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
        servo.gainprm[0] = kp * (high - low)
        servo.biasprm[:3] = (kp * (low + high) / 2, -kp, -kd)
