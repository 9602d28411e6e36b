"""What a character shall look like, and what it costs not to: reference motions, guides and losses."""

from sb3_adaptnet.algorithms.tracking.guide import Guidance, Guide, Guiding
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.algorithms.tracking.tracking_loss import TrackingWeights, tracking_loss
from sb3_adaptnet.algorithms.tracking.travel_loss import TravelWeights, travel_errors, travel_loss

__all__ = [
    "Guidance",
    "Guide",
    "Guiding",
    "TrackedMotion",
    "TrackingWeights",
    "TravelWeights",
    "tracking_loss",
    "travel_errors",
    "travel_loss",
]
