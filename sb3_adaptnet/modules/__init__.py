"""The networks, in plain torch: nothing here knows of Stable-Baselines3 or of environments."""

from sb3_adaptnet.modules.actor import Actor
from sb3_adaptnet.modules.architecture import AdaptationShape, Architecture
from sb3_adaptnet.modules.backbone import Backbone
from sb3_adaptnet.modules.critic import Critic
from sb3_adaptnet.modules.discriminator import Discriminator
from sb3_adaptnet.modules.encoder import StateEncoder
from sb3_adaptnet.modules.heightmap import HeightmapEncoder
from sb3_adaptnet.modules.observation import Observation, read_observation

__all__ = [
    "Actor",
    "AdaptationShape",
    "Architecture",
    "Backbone",
    "Critic",
    "Discriminator",
    "HeightmapEncoder",
    "Observation",
    "StateEncoder",
    "read_observation",
]
