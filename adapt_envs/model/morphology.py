"""Body shapes: the character with longer, shorter or larger parts (paper, sec. 8.2). Pure edits of an `MjSpec`.

Masses and inertias follow from the geoms' volumes, since the character is made of densities.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.humanoid import FEET
from adapt_envs.model.soles import sole_corners


@dataclass(frozen=True)
class Segment:
    """A part of the body from one joint to the next.

    Attributes:
        link: the link whose frame is at its near joint.
        spans: geoms that run along it.
        tips: geoms at its far end.
        carries: links that hang at its far end.
    """

    link: str
    spans: tuple[str, ...]
    tips: tuple[str, ...] = ()
    carries: tuple[str, ...] = ()


def _limb(name: str, carried: str) -> dict[str, Segment]:
    return {f"{side}_{name}": Segment(f"{side}_{name}", (f"{side}_{name}",), (), (f"{side}_{carried}",))
            for side in ("right", "left")}  # fmt: skip


SEGMENTS: dict[str, Segment] = {
    "abdomen": Segment("pelvis", ("waist",), (), ("torso",)),
    "torso": Segment(
        "torso", ("torso",), ("right_clavicle", "left_clavicle"), ("head", "right_upper_arm", "left_upper_arm")
    ),
    **_limb("upper_arm", "lower_arm"), **_limb("lower_arm", "hand"), **_limb("thigh", "shin"), **_limb("shin", "foot"),
    **{name: Segment(name, (name,)) for name in ("head", "right_hand", "left_hand", *FEET)},
}  # fmt: skip
"""What a `Morphology` can change, by name. Those that carry nothing have a size but no length."""


@dataclass(frozen=True)
class Morphology:
    """A body shape.

    Attributes:
        length: segment -> factor on the distance from its joint to the next one; radii stay.
        size: segment -> factor on all its dimensions; its mass grows with the cube.
    """

    length: Mapping[str, float] = field(default_factory=dict)
    size: Mapping[str, float] = field(default_factory=dict)

    def __hash__(self) -> int:
        """Equal shapes hash alike, although their factors come in dictionaries."""
        return hash((frozenset(self.length.items()), frozenset(self.size.items())))

    def __post_init__(self) -> None:
        """Check names and factors.

        Raises:
            ValueError: for an unknown segment or a factor that is not positive.
        """
        longable = [name for name, segment in SEGMENTS.items() if segment.carries]
        for what, factors, valid in (("length", self.length, longable), ("size", self.size, list(SEGMENTS))):
            for name, factor in factors.items():
                if name not in valid:
                    raise ValueError(f"no segment with a {what} is named {name!r}; the names are {', '.join(valid)}")
                if not 0 < factor < np.inf:
                    raise ValueError(f"the {what} of {name!r} is {factor!r}, expected a positive factor")


def _both(name: str, factor: float) -> dict[str, float]:
    return {f"right_{name}": factor, f"left_{name}": factor}


MORPHOLOGIES: dict[str, Morphology] = {
    "long_body": Morphology(length={"abdomen": 1.5}),
    "big_body": Morphology(size={"torso": 1.5}),
    "long_upper_arms": Morphology(length=_both("upper_arm", 1.25)),
    "long_lower_arms": Morphology(length=_both("lower_arm", 1.25)),
    "asymmetric_upper_arms": Morphology(length={"right_upper_arm": 1.25, "left_upper_arm": 0.75}),
    "long_thighs": Morphology(length=_both("thigh", 1.5)),
    "long_shins": Morphology(length=_both("shin", 1.5)),
    "super_long_legs": Morphology(length=_both("thigh", 1.5) | _both("shin", 1.5)),
}
"""The eight body shapes of the paper's sec. 8.2, by name."""


def reshape(spec: mujoco.MjSpec, morphology: Morphology) -> None:
    """Give the character `spec` another body shape; its rest pose stands on the ground again."""
    for name, factor in morphology.size.items():
        _scale(spec, SEGMENTS[name], factor)
    for name, factor in morphology.length.items():
        _stretch(spec, SEGMENTS[name], factor)
    soles = sole_corners(spec)[:, 0, 2]
    spec.body("pelvis").pos[2] = -min(_over_pelvis(spec, foot, sole) for foot, sole in zip(FEET, soles, strict=True))


def _scale(spec: mujoco.MjSpec, segment: Segment, factor: float) -> None:
    for name in (*segment.spans, *segment.tips):
        geom = spec.geom(name)
        geom.size = geom.size * factor
        _place(geom, _ends(geom) * factor)
    for name in segment.carries:
        spec.body(name).pos *= factor


def _stretch(spec: mujoco.MjSpec, segment: Segment, factor: float) -> None:
    """Move the far joint along the link's z axis, with all that sits there; geoms keep their gaps to both joints."""
    growth = np.array([0, 0, (factor - 1) * spec.body(segment.carries[0]).pos[2]])
    for name in segment.carries:
        spec.body(name).pos += growth
    for name in segment.tips:
        geom = spec.geom(name)
        _place(geom, _ends(geom) + growth)
    outward = np.sign(spec.body(segment.carries[0]).pos[2])
    for name in segment.spans:
        _lengthen(spec.geom(name), growth, outward)


def _lengthen(geom: mujoco.MjsGeom, growth: NDArray[np.float64], outward: float) -> None:
    """Move the far end of a capsule; a sphere becomes a capsule, for it must cover what it covered and more."""
    near, far = sorted(np.resize(_ends(geom), (2, 3)), key=lambda end: outward * end[2])
    far = far + growth
    ball = outward * (far[2] - near[2]) <= 0  # too short for a cylinder between the caps
    geom.type = mujoco.mjtGeom.mjGEOM_SPHERE if ball else mujoco.mjtGeom.mjGEOM_CAPSULE
    _place(geom, np.array([far]) if ball else np.array([near, far]))


def _ends(geom: mujoco.MjsGeom) -> NDArray[np.float64]:
    """Both ends (2, 3) of a capsule's axis, or the middle (1, 3) of anything else, in the link's frame [m]."""
    return np.reshape(np.array(geom.fromto if np.isfinite(geom.fromto[0]) else geom.pos), (-1, 3))


def _place(geom: mujoco.MjsGeom, ends: NDArray[np.float64]) -> None:
    """Put a geom where `ends` says; see `_ends`."""
    axis = len(ends) == 2
    geom.fromto = ends.ravel() if axis else np.full(6, np.nan)
    geom.pos = np.zeros(3) if axis else ends[0]


def _over_pelvis(spec: mujoco.MjSpec, link: str, height: float) -> float:
    """Height [m] over the pelvis' origin, in the rest pose, of what is at `height` [m] in a link's frame."""
    body = spec.body(link)
    while body.name != "pelvis":
        height += float(body.pos[2])
        body = body.parent
    return height
