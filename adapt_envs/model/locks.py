"""Locked joints: joints are removed and their links welded (paper, sec. 8.2). Pure edits of an `MjSpec`."""

from collections.abc import Sequence

import mujoco

from adapt_envs.model.humanoid import hinges, joint_group

_LOCK, _BESIDE = (0.80, 0.06, 0.06, 1.0), (0.96, 0.60, 0.18, 1.0)
"""Colours of a locked joint and of the links that it joins."""
_BALL = {"abdomen": 0.115, "neck": 0.065, "shoulder": 0.06, "elbow": 0.055, "hip": 0.075, "knee": 0.066, "ankle": 0.06}
"""Radius [m] of the ball that shows a locked joint, by group: just larger than the limbs that meet there."""


def joints_named(spec: mujoco.MjSpec, name: str) -> list[mujoco.MjsJoint]:
    """The joints that `name` means: one joint (`"right_hip_x"`), one place (`"right_knee"`) or a pair (`"elbow"`).

    Raises:
        ValueError: if it means none, listing the joints.
    """
    joints = hinges(spec)
    chosen = [joint for joint in joints if f"_{name}_" in f"_{joint.name}_"]
    if not name or not chosen:
        names = ", ".join(joint.name for joint in joints)
        raise ValueError(f"no joint is named {name!r}; the joints are {names}, or parts of these such as 'elbow'")
    return chosen


def lock(spec: mujoco.MjSpec, names: Sequence[str]) -> None:
    """Remove the joints that `names` mean from the character `spec`; the links stay as they are in the rest pose.

    A red ball shows where a joint was, and the links that it joins turn orange.

    Raises:
        ValueError: for a name that means no joint.
    """
    joints = {joint.name: joint for name in names for joint in joints_named(spec, name)}
    if not joints:
        return
    for material, colour in (("lock", _LOCK), ("beside_lock", _BESIDE)):
        spec.add_material(name=material, rgba=colour, specular=0.25, shininess=0.4)
    for joint in joints.values():
        _paint(joint)
        spec.delete(joint)


def _paint(joint: mujoco.MjsJoint) -> None:
    link, mark = joint.parent, f"{joint.parent.name}_lock"
    for beside in (link, link.parent):
        for geom in beside.geoms:
            if geom.contype:
                geom.material = "beside_lock"
    if any(geom.name == mark for geom in link.geoms):
        return
    link.add_geom(
        name=mark, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(_BALL[joint_group(joint.name)], 0, 0), material="lock",
        mass=0, contype=0, conaffinity=0, group=1,
    )  # fmt: skip
