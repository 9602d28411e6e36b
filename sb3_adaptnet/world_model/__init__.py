"""A learned, differentiable world: the character's kinematics and dynamics, as one step of its simulation."""

from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.kinematics import Kinematics
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.state import State
from sb3_adaptnet.world_model.transitions import Transitions
from sb3_adaptnet.world_model.world_file import read_world, save_world

__all__ = ["Character", "Kinematics", "Sizes", "State", "Transitions", "WorldModel", "read_world", "save_world"]
