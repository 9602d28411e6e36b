"""The action space: a Box that knows its joints.

An SB3 policy sees nothing of an environment but its spaces, so what it must know of the character travels here.
"""

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray


class JointSpace(gym.spaces.Box):
    """Box(-1, 1, (J,), float32) of servo targets, one per actuated joint.

    Attributes:
        joint_names: the J joints in the action's order.
        default_base: name of the pretrained policy that adapts to this environment unless another is named.
        mean_pose: (J,) float32, the reference motion's mean pose as an action: where exploration starts.
    """

    def __init__(self, joint_names: Sequence[str], default_base: str, mean_pose: NDArray[np.floating]) -> None:
        """Make the space of the joints `joint_names`; `mean_pose` is (J,)."""
        self.joint_names = tuple(joint_names)
        self.default_base = default_base
        self.mean_pose = np.asarray(mean_pose, np.float32)
        if self.mean_pose.shape != (len(self.joint_names),):
            raise ValueError(f"mean_pose has shape {self.mean_pose.shape}, expected ({len(self.joint_names)},)")
        super().__init__(-1.0, 1.0, (len(self.joint_names),), np.float32)

    def __eq__(self, other: Any) -> bool:
        """Equal bounds and joints; a plain Box of the same bounds is not equal."""
        return isinstance(other, JointSpace) and self.joint_names == other.joint_names and super().__eq__(other)

    def __setstate__(self, state: Any) -> None:
        """Restore from a pickle, which Box's own method would strip of this class's attributes."""
        state = dict(state)
        super().__setstate__(state)
        vars(self).update({name: state[name] for name in ("joint_names", "default_base", "mean_pose") if name in state})
