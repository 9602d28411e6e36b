"""A reference motion whose start states are in the body's own steps, as what its windows show."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from adapt_envs.motion.library import ReferenceMotion, windows_of
from adapt_envs.motion.on_body import shown_by


class ShownMotion(ReferenceMotion):
    """Clips of the model's own body, put there before: nothing has to be moved any more."""

    @cached_property
    def _qpos(self) -> NDArray[np.float64]:
        return self._clip_qpos

    @cached_property
    def _windows(self) -> NDArray[np.float32]:
        return windows_of(self.model, self.clips)


def as_shown(motion: ReferenceMotion) -> ReferenceMotion:
    """The motion as its body shows it (`shown_by`), start states, tempo and speed, too, where its windows are that."""
    if not motion.windows_on_body:
        return motion
    return ShownMotion([shown_by(clip, motion.model) for clip in motion.clips], motion.model)
