"""From rollouts of a policy to figures, pictures and a page: goals, falls, visible styles, sliding, jerk."""

from sb3_adaptnet.evaluation.alpha import alpha_clips
from sb3_adaptnet.evaluation.card import evaluation_block, write_evaluation
from sb3_adaptnet.evaluation.figures import Evaluation, Figures, evaluate
from sb3_adaptnet.evaluation.imitation_error import ImitationError, imitation_error
from sb3_adaptnet.evaluation.recording import Recording, open_worlds, record, record_straight
from sb3_adaptnet.evaluation.style import StyleFigures, style_figures
from sb3_adaptnet.evaluation.style_callback import StyleCallback

__all__ = [
    "Evaluation",
    "Figures",
    "ImitationError",
    "Recording",
    "StyleCallback",
    "StyleFigures",
    "alpha_clips",
    "evaluate",
    "evaluation_block",
    "imitation_error",
    "open_worlds",
    "record",
    "record_straight",
    "style_figures",
    "write_evaluation",
]
