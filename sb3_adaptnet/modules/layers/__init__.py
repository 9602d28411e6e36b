"""Building blocks of the networks: recurrence, convolution, normalisation, precision, penalties."""

from sb3_adaptnet.modules.layers.gru import last_state
from sb3_adaptnet.modules.layers.normalizer import Moments, RunningNormalizer, moments_of
from sb3_adaptnet.modules.layers.popart import PopArtHead
from sb3_adaptnet.modules.layers.precision import PRECISIONS, autocast, use_precision
from sb3_adaptnet.modules.layers.regularizers import AnchorPenalty, penalise_injections, penalise_parameters
from sb3_adaptnet.modules.layers.small_conv import relu_conv

__all__ = [
    "PRECISIONS",
    "AnchorPenalty",
    "Moments",
    "PopArtHead",
    "RunningNormalizer",
    "autocast",
    "last_state",
    "moments_of",
    "penalise_injections",
    "penalise_parameters",
    "relu_conv",
    "use_precision",
]
