"""What training maximises: imitation, goal and further rewards, their advantages and step sizes."""

from sb3_adaptnet.objectives.attribute_ramp import AttributeRamp
from sb3_adaptnet.objectives.buffer import combine_advantages, generalized_advantages
from sb3_adaptnet.objectives.callback import DiscriminatorRewardCallback
from sb3_adaptnet.objectives.imitation import ImitationObjective

__all__ = [
    "AttributeRamp",
    "DiscriminatorRewardCallback",
    "ImitationObjective",
    "combine_advantages",
    "generalized_advantages",
]
