"""The only place that compiles a model: character, ground and contact sensors put together."""

import mujoco

from adapt_envs.model.humanoid import add_servos, load_spec

FALL_SENSOR = "fall"
"""Prefix of the contact sensors that report links other than feet touching anything static."""
_FALL_PARTS = (
    ("subtree", "torso"), ("body", "pelvis"),
    ("body", "right_thigh"), ("body", "right_shin"), ("body", "left_thigh"), ("body", "left_shin"),
)  # fmt: skip


def add_ground(spec: mujoco.MjSpec, friction: float = 1.0) -> None:
    """Add the flat ground; its priority makes its friction the contact's (else the larger of two geoms' counts)."""
    spec.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0, 0, 0.25), material="ground", priority=1,
        friction=(friction, 0.005, 0.0001), condim=3,
    )  # fmt: skip


def add_fall_sensors(spec: mujoco.MjSpec) -> None:
    """Add sensors whose first number counts contacts of trunk, arms, thighs and shins with static geometry.

    Six sensors cover the 13 links that must not touch the ground: the torso's whole subtree is one of them.
    """
    for kind, name in _FALL_PARTS:
        sensor = spec.add_sensor(name=f"{FALL_SENSOR}_{name}", type=mujoco.mjtSensor.mjSENS_CONTACT)
        sensor.objtype = mujoco.mjtObj.mjOBJ_XBODY if kind == "subtree" else mujoco.mjtObj.mjOBJ_BODY
        sensor.objname = name
        sensor.reftype, sensor.refname = mujoco.mjtObj.mjOBJ_BODY, "world"
        sensor.intprm[0] = 1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND)
        sensor.intprm[2] = 1


def compile_model(spec: mujoco.MjSpec | None = None, friction: float = 1.0) -> mujoco.MjModel:
    """Compile a character (the plain humanoid if None) with servos, ground and fall sensors.

    Args:
        spec: a character from `humanoid.load_spec`, possibly edited; it is used up.
        friction: sliding friction between ground and feet.

    Returns:
        The model: 120 Hz, `nu` servos whose controls are actions in [-1, 1].
    """
    spec = load_spec() if spec is None else spec
    add_servos(spec)
    add_ground(spec, friction)
    add_fall_sensors(spec)
    return spec.compile()
