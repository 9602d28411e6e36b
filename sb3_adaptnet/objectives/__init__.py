"""What training maximises: imitation, goal and further rewards, their advantages and step sizes."""

from sb3_adaptnet.objectives.attribute_ramp import AttributeRamp
from sb3_adaptnet.objectives.buffer import ObjectiveRolloutBuffer, combine_advantages, generalized_advantages
from sb3_adaptnet.objectives.callback import DiscriminatorRewardCallback
from sb3_adaptnet.objectives.imitation import ImitationObjective
from sb3_adaptnet.objectives.reward_terms import TERMS, RewardTerm
from sb3_adaptnet.objectives.schedule import Schedule
from sb3_adaptnet.objectives.weight_average import WeightAveraging

__all__ = [
    "TERMS",
    "AttributeRamp",
    "DiscriminatorRewardCallback",
    "ImitationObjective",
    "ObjectiveRolloutBuffer",
    "RewardTerm",
    "Schedule",
    "WeightAveraging",
    "combine_advantages",
    "generalized_advantages",
]
