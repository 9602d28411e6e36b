"""What a learner that models the world reads of all worlds and sets, beside what policies see."""

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.features.observation_rows import Observations
from adapt_envs.motion.library import ReferenceMotion
from adapt_envs.motion.shown_motion import as_shown
from adapt_envs.simulation.gait_cycles import gaits_at
from adapt_envs.simulation.situations import Situations
from adapt_envs.simulation.worlds import Worlds


class PhysicsStates(NamedTuple):
    """Generalised coordinates, as MuJoCo has them.

    Attributes:
        qpos: (N, nq): root position [m], root quaternion (w, x, y, z), joint angles [rad].
        qvel: (N, nv): root velocity [m/s], world; root angular velocity [rad/s], along the root's axes; joint rates.
    """

    qpos: NDArray[np.float64]
    qvel: NDArray[np.float64]


class GoalStates(NamedTuple):
    """What the worlds' characters are after.

    Attributes:
        target: (N, 2) targets on the ground [m], world.
        speed: (N,) preferred speeds [m/s].
    """

    target: NDArray[np.float32]
    speed: NDArray[np.float32]


class ReferenceStates(NamedTuple):
    """The start states of the reference motion, one every 1/30 s, each over the world's origin.

    Attributes:
        qpos, qvel: (P, nq) and (P, nv), as in `PhysicsStates`.
        history: (P, 5, 15, 13) link states that end in them, world frame.
        cyclic: whether the first state follows the last one.
        mean_speed: mean speed of the root along its path [m/s].
    """

    qpos: NDArray[np.float64]
    qvel: NDArray[np.float64]
    history: NDArray[np.float32]
    cyclic: bool
    mean_speed: float


class StateAccess:
    """States and goals of all worlds, as copies.

    Attributes:
        worlds: the worlds.
    """

    worlds: Worlds

    @property
    def model(self) -> mujoco.MjModel:
        """The character on its ground."""
        return self.worlds.model

    @property
    def physics_states(self) -> PhysicsStates:
        """Where the worlds are now; where one just restarted, its start state."""
        return PhysicsStates(self.worlds.physics.qpos.copy(), self.worlds.physics.qvel.copy())

    @property
    def link_histories(self) -> NDArray[np.float32]:
        """(N, 5, 15, 13) states of the links up to now, world frame, oldest first."""
        return self.worlds.history.copy()

    @property
    def goal_states(self) -> GoalStates:
        """The present goals."""
        return GoalStates(self.worlds.goals.target.copy(), self.worlds.goals.speed.copy())

    @property
    def situations(self) -> Situations:
        """What all worlds are in the middle of, for `restart` to go on from there."""
        goals = self.worlds.goals
        when = goals.distance.copy(), goals.steps_left.copy()
        return Situations(*self.physics_states, self.link_histories, *self.goal_states, *when)

    @property
    def reference_states(self) -> ReferenceStates:
        """All start states of the reference motion, in order; with `clip_on_body` in the body's own steps and tempo."""
        return _all_states(self.worlds.reference)

    def reference_gaits(self, speeds: Sequence[float]) -> list[ReferenceStates]:
        """Gait cycles of a reference motion of minutes, one at about each speed [m/s] that it has.

        Raises:
            MotionError: if it holds no cycle at any of them.
        """
        return [_all_states(gait) for gait in gaits_at(self.worlds.reference, speeds)]

    def restart(self, ids: NDArray[np.integer], situations: Situations | None = None) -> Observations:
        """End the episodes of the worlds `ids` and begin others.

        Args:
            ids: (n,) worlds.
            situations: n situations to go on from; None begins in sampled states of the reference motion.

        Returns:
            First observations of these n worlds.
        """
        return self.worlds.reset(ids) if situations is None else self.worlds.resume(ids, situations)


def _all_states(motion: ReferenceMotion) -> ReferenceStates:
    motion = as_shown(motion)
    clip = motion.clips[0]
    return ReferenceStates(*motion.states(np.arange(motion.num_states)), clip.cyclic, clip.mean_speed)
