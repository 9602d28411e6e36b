"""A character as plain data: its tree of links, hinges, servos and soles, read from a MuJoCo model."""

from dataclasses import dataclass

import mujoco
import numpy as np

from sb3_adaptnet.modules.json_values import JsonValues

AXES = "xyz"
"""A link's hinges turn about some of its axes, in this order (intrinsic XYZ)."""


@dataclass(frozen=True)
class Character(JsonValues):
    """A tree of links under a free root, joined by hinges with servos. Equal characters compare equal.

    Attributes:
        links: names of the L links, parents first; the first is the root.
        parents: number of each link's parent, -1 for the root.
        offsets: origin of each link in its parent's frame [m]; the root's is zero.
        joints: names of the J hinges in the order of `qpos` and of the actions.
        hinges: link that each joint turns, and the number of its axis in `AXES`.
        middles: middle of each joint's range [rad], where its servo aims at action 0.
        widths: width of each joint's range [rad], by which an action of 1 moves the servo's aim.
        corners: lower corners of the soles: the foot's link and the point in its frame [m].
    """

    links: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: tuple[tuple[float, float, float], ...]
    joints: tuple[str, ...]
    hinges: tuple[tuple[int, int], ...]
    middles: tuple[float, ...]
    widths: tuple[float, ...]
    corners: tuple[tuple[int, tuple[float, float, float]], ...]

    @classmethod
    def of(cls, model: mujoco.MjModel) -> "Character":
        """Read the character of a model; the ground and whatever else is there does not matter.

        Raises:
            ValueError: if the model has no free root, or a link or joint that the kinematics do not cover.
        """
        _check_root(model)
        root = int(model.jnt_bodyid[0])
        bodies = [body for body in range(model.nbody) if model.body_rootid[body] == root]
        joints = list(range(1, model.njnt))
        low, high = model.jnt_range[joints].T
        _check_servos(model, joints)
        return cls(
            links=tuple(model.body(body).name for body in bodies),
            parents=(-1, *(bodies.index(model.body_parentid[body]) for body in bodies[1:])),
            offsets=((0.0, 0.0, 0.0), *(_offset(model, body) for body in bodies[1:])),
            joints=tuple(model.joint(joint).name for joint in joints),
            hinges=_hinges(model, bodies, joints),
            middles=tuple(((low + high) / 2).tolist()),
            widths=tuple((high - low).tolist()),
            corners=_corners(model, bodies),
        )


def _check_root(model: mujoco.MjModel) -> None:
    kinds = list(model.jnt_type)
    if not kinds or kinds[0] != mujoco.mjtJoint.mjJNT_FREE:
        raise ValueError("the model's first joint must be the character's free root")
    for joint, kind in enumerate(kinds[1:], start=1):
        if kind != mujoco.mjtJoint.mjJNT_HINGE:
            raise ValueError(f"joint {model.joint(joint).name!r} is no hinge; a character has a free root and hinges")


def _check_servos(model: mujoco.MjModel, joints: list[int]) -> None:
    driven = model.actuator_trnid[:, 0].tolist()
    if driven != joints:
        names = [model.joint(joint).name for joint in driven]
        raise ValueError(f"every hinge must have one servo, in the hinges' order, but the servos drive {names}")


def _offset(model: mujoco.MjModel, body: int) -> tuple[float, float, float]:
    if not np.allclose(model.body_quat[body], (1, 0, 0, 0)):
        raise ValueError(f"link {model.body(body).name!r} is turned in its parent's frame by {model.body_quat[body]}")
    x, y, z = model.body_pos[body].tolist()
    return x, y, z


def _hinges(model: mujoco.MjModel, bodies: list[int], joints: list[int]) -> tuple[tuple[int, int], ...]:
    hinges = [(bodies.index(model.jnt_bodyid[joint]), _axis(model, joint)) for joint in joints]
    for before, after, joint in zip(hinges[:-1], hinges[1:], joints[1:], strict=True):
        if before[0] == after[0] and before[1] >= after[1]:
            raise ValueError(f"joint {model.joint(joint).name!r} comes out of order: a link turns about {AXES}")
    return tuple(hinges)


def _axis(model: mujoco.MjModel, joint: int) -> int:
    axis, name = model.jnt_axis[joint], model.joint(joint).name
    number = int(np.argmax(axis))
    if not np.allclose(axis, np.eye(3)[number]):
        raise ValueError(f"joint {name!r} turns about {axis}, expected one of its link's axes {', '.join(AXES)}")
    if np.any(model.jnt_pos[joint]) or model.qpos0[model.jnt_qposadr[joint]]:
        raise ValueError(f"joint {name!r} must turn about its link's origin and be 0 in the rest pose")
    return number


def _corners(model: mujoco.MjModel, bodies: list[int]) -> tuple[tuple[int, tuple[float, float, float]], ...]:
    """Lower corners of the boxes that touch things: the feet; all other parts of the body are round."""
    corners = []
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        if body not in bodies or model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_BOX or not model.geom_contype[geom]:
            continue
        for signs in ((1, 1, -1), (1, -1, -1), (-1, -1, -1), (-1, 1, -1)):
            x, y, z = (model.geom_pos[geom] + np.array(signs) * model.geom_size[geom]).tolist()
            corners.append((bodies.index(body), (x, y, z)))
    return tuple(corners)
