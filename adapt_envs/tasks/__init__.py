"""What is asked of the character: goals, pushes, foot slip, tracking, clearance, ends of episodes; over arrays."""

from adapt_envs.tasks.clearance import clearance_reward
from adapt_envs.tasks.foot_slip import footing_reward
from adapt_envs.tasks.goal import GOAL_RADIUS, goal_observation, goal_reward, targets_ahead
from adapt_envs.tasks.goal_state import Goals
from adapt_envs.tasks.push import Pushes, PushSchedule
from adapt_envs.tasks.termination import DIVERGED, ENDS, FALL, LOST, RUNNING, TIME, ends
from adapt_envs.tasks.tracking import GaitClocks, GaitCycle, PhaseClock, tracking_reward

__all__ = [
    "DIVERGED",
    "ENDS",
    "FALL",
    "GOAL_RADIUS",
    "LOST",
    "RUNNING",
    "TIME",
    "GaitClocks",
    "GaitCycle",
    "Goals",
    "PhaseClock",
    "PushSchedule",
    "Pushes",
    "clearance_reward",
    "ends",
    "footing_reward",
    "goal_observation",
    "goal_reward",
    "targets_ahead",
    "tracking_reward",
]
