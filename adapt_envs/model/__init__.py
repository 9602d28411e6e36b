"""The character and what it stands on, as MuJoCo models: body shapes, locked joints, terrain, obstacles."""

from adapt_envs.model.build import build_character, compile_model
from adapt_envs.model.ground import Ground, make_ground
from adapt_envs.model.humanoid import CONTROL_DT, FEET, LINKS, PHYSICS_STEPS, joint_names
from adapt_envs.model.morphology import MORPHOLOGIES, SEGMENTS, Morphology
from adapt_envs.model.obstacles import OBSTACLES, ObstacleField
from adapt_envs.model.soles import TOUCHING, sole_corners
from adapt_envs.model.terrain import (
    GRID,
    HIGHEST,
    TERRAINS,
    Heights,
    Terrain,
    hills,
    normalised,
    perlin,
    rectangular_steps,
    rocky,
    rugged,
    sloped_surfaces,
    stepped,
    uniform_noise,
)

__all__ = [
    "CONTROL_DT",
    "FEET",
    "GRID",
    "HIGHEST",
    "LINKS",
    "MORPHOLOGIES",
    "OBSTACLES",
    "PHYSICS_STEPS",
    "SEGMENTS",
    "TERRAINS",
    "TOUCHING",
    "Ground",
    "Heights",
    "Morphology",
    "ObstacleField",
    "Terrain",
    "build_character",
    "compile_model",
    "hills",
    "joint_names",
    "make_ground",
    "normalised",
    "perlin",
    "rectangular_steps",
    "rocky",
    "rugged",
    "sloped_surfaces",
    "sole_corners",
    "stepped",
    "uniform_noise",
]
