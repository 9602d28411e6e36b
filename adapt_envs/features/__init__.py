"""What policies and discriminators see: link states, the heading frame, the heightmap."""

from adapt_envs.features import rotations
from adapt_envs.features.heading_frame import (
    OBSERVATION_SIZE,
    OBSERVED_FRAMES,
    WINDOW_FRAMES,
    heading_frame_features,
    observations,
    pose_windows,
)
from adapt_envs.features.heightmap import heightmaps
from adapt_envs.features.kinematics import LINK_STATE, Kinematics
from adapt_envs.features.observation_rows import Observations, copied, put_rows, rows_of

__all__ = [
    "LINK_STATE",
    "OBSERVATION_SIZE",
    "OBSERVED_FRAMES",
    "WINDOW_FRAMES",
    "Kinematics",
    "Observations",
    "copied",
    "heading_frame_features",
    "heightmaps",
    "observations",
    "pose_windows",
    "put_rows",
    "rotations",
    "rows_of",
]
