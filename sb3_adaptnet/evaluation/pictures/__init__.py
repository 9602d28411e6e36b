"""Pictures of policies beside each other: strips of poses, films side by side, before and after adapting."""

from sb3_adaptnet.evaluation.pictures.before_after import before_after, check_world, write_before_after
from sb3_adaptnet.evaluation.pictures.strips import captioned, pose_strip, side_by_side, write_strip

__all__ = [
    "before_after",
    "captioned",
    "check_world",
    "pose_strip",
    "side_by_side",
    "write_before_after",
    "write_strip",
]
