"""From rollouts of a policy to figures, pictures and a page: imitation error, falls, goal reward, sliding, jerk."""

from sb3_adaptnet.evaluation.figures import Figures, evaluate
from sb3_adaptnet.evaluation.imitation_error import imitation_error
from sb3_adaptnet.evaluation.recording import Recording, open_worlds, record, record_straight

__all__ = ["Figures", "Recording", "evaluate", "imitation_error", "open_worlds", "record", "record_straight"]
