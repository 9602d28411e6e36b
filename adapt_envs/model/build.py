"""The only place that compiles a model: character, ground and contact sensors put together."""

from collections.abc import Sequence
from functools import cache

import mujoco

from adapt_envs.model.ground import Ground
from adapt_envs.model.humanoid import FEET, LINKS, add_servos, load_spec
from adapt_envs.model.locks import lock
from adapt_envs.model.morphology import Morphology, reshape

FALL_SENSOR = "fall"
"""Prefix of the contact sensors that report links other than feet touching anything static."""
_ALONE = ("pelvis", "right_thigh", "right_shin", "left_thigh", "left_shin")
FALL_PARTS: dict[str, tuple[str, ...]] = {
    "torso": tuple(name for name in LINKS if name not in (*_ALONE, *FEET)),
    **{name: (name,) for name in _ALONE},
}
"""What must not touch the ground: parts by the name of their first link -> their links, in the sensors' order."""


def add_fall_sensors(spec: mujoco.MjSpec) -> None:
    """Add sensors whose first number counts contacts of trunk, arms, thighs and shins with static geometry.

    Six sensors cover the 13 links that must not touch the ground: the torso's whole subtree is one of them.
    """
    for name, links in FALL_PARTS.items():
        sensor = spec.add_sensor(name=f"{FALL_SENSOR}_{name}", type=mujoco.mjtSensor.mjSENS_CONTACT)
        sensor.objtype = mujoco.mjtObj.mjOBJ_XBODY if len(links) > 1 else mujoco.mjtObj.mjOBJ_BODY
        sensor.objname = name
        sensor.reftype, sensor.refname = mujoco.mjtObj.mjOBJ_BODY, "world"
        sensor.intprm[0] = 1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND)
        sensor.intprm[2] = 1


def build_character(morphology: Morphology | None = None, locked: Sequence[str] = ()) -> mujoco.MjSpec:
    """The character with another body shape and without some joints (see `morphology` and `locks`)."""
    spec = load_spec()
    if morphology is not None:
        reshape(spec, morphology)
    lock(spec, locked)
    return spec


def assemble(spec: mujoco.MjSpec | None = None, friction: float = 1.0, ground: Ground | None = None) -> mujoco.MjSpec:
    """Put a character (the plain humanoid if None) together with servos, ground and fall sensors.

    Args:
        spec: a character from `build_character` or `humanoid.load_spec`; it is used up.
        friction: sliding friction between ground and feet.
        ground: what it stands on; the flat, endless ground if None.
    """
    spec = load_spec() if spec is None else spec
    add_servos(spec)
    (Ground() if ground is None else ground).add_to(spec, friction)
    add_fall_sensors(spec)
    return spec


def compile_model(
    spec: mujoco.MjSpec | None = None, friction: float = 1.0, ground: Ground | None = None
) -> mujoco.MjModel:
    """Compile what `assemble` puts together.

    Returns:
        The model: 120 Hz, `nu` servos whose controls are actions in [-1, 1].
    """
    return assemble(spec, friction, ground).compile()


@cache
def plain_model() -> mujoco.MjModel:
    """The plain character on flat, endless ground; everybody shares it, so nobody may change it."""
    return compile_model()
