"""N characters with their goals: reset and step over arrays, without any notion of Gymnasium."""

from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.features.heading_frame import POSE, WINDOW_FRAMES, heading_frame_features, observations, pose_windows
from adapt_envs.features.heightmap import heightmaps
from adapt_envs.features.kinematics import LINK_STATE
from adapt_envs.features.observation_rows import Observations, copied, put_rows, rows_of
from adapt_envs.model.build import build_character, compile_model
from adapt_envs.model.ground import Ground, make_ground
from adapt_envs.model.humanoid import LINKS
from adapt_envs.model.morphology import MORPHOLOGIES
from adapt_envs.model.obstacles import OBSTACLES
from adapt_envs.model.soles import sole_corners
from adapt_envs.model.terrain import TERRAINS
from adapt_envs.motion.library import reference_motion
from adapt_envs.simulation.falls import fallen
from adapt_envs.simulation.gait_cycles import gait_cycles
from adapt_envs.simulation.physics import PhysicsBatch
from adapt_envs.simulation.situations import Situations
from adapt_envs.simulation.spawn import spawned
from adapt_envs.suite import TaskSpec, preferred_speeds
from adapt_envs.tables import entry
from adapt_envs.tasks.clearance import clearance_reward
from adapt_envs.tasks.foot_slip import footing_reward
from adapt_envs.tasks.goal import GOAL_RADIUS, goal_observation, goal_reward
from adapt_envs.tasks.goal_state import Goals
from adapt_envs.tasks.push import Pushes
from adapt_envs.tasks.termination import LOST_DISTANCE, RUNNING, ends
from adapt_envs.tasks.tracking import GaitClocks

Array = NDArray[np.float64]


class Worlds:
    """N worlds of one task.

    Attributes:
        spec: the task's row, with overrides applied.
        ground: what all worlds stand on.
        model: the character on it.
        reference: the reference motion.
        physics: the worlds' physics.
        goals: the worlds' goals.
        pushes: the worlds' pushes, or None.
        rng: source of all randomness but the terrain's; replace it to seed.
        steps: (N,) control steps since the worlds' last reset.
        starts: (N,) number of the start state that this reset took, -1 where none did.
        clearance: (N,) how much room obstacles left in the last step, in [0, 1]; see `clearance_reward`.
    """

    def __init__(self, spec: TaskSpec, num_worlds: int, num_threads: int | None = None) -> None:
        """Build the model, load the motion and make `num_worlds` worlds; `reset` comes first."""
        self._shape = entry("morphology", MORPHOLOGIES, spec.morphology)
        self.reference = reference_motion(spec.motion, self._shape, tuple(spec.locked), spec.clip_on_body)
        speeds = preferred_speeds(spec, self.reference.clips[0], self.reference.shown)
        self.spec = replace(spec, speed_range=speeds)
        terrain, obstacles = entry("terrain", TERRAINS, spec.terrain), entry("obstacles", OBSTACLES, spec.obstacles)
        self.ground = make_ground(terrain, obstacles, spec.terrain_seed, spec.terrain_scale)
        self.model = self.compiled(self.ground)
        self.physics = PhysicsBatch(self.model, num_worlds, num_threads)
        self.goals = Goals(num_worlds, self.ground, speeds, spec.timer_range)
        self.pushes = None if spec.push is None else Pushes(spec.push, num_worlds)
        self.rng = np.random.default_rng()
        self.steps = np.zeros(num_worlds, np.int64)
        self.starts = np.zeros(num_worlds, np.int64)
        self.clearance = np.ones(num_worlds)
        self.history = np.zeros((num_worlds, WINDOW_FRAMES, len(LINKS), LINK_STATE), np.float32)
        self._all = np.arange(num_worlds)
        self._features = np.zeros_like(self.history)
        self._last: Observations | None = None
        self._clocks: GaitClocks | None = None
        self._tracking = np.zeros(num_worlds)

    def compiled(self, ground: Ground) -> mujoco.MjModel:
        """The task's character on some ground: on its own for physics, on a piece of it for pictures."""
        return compile_model(build_character(self._shape, self.spec.locked), self.spec.friction, ground)

    @property
    def root_xy(self) -> NDArray[np.float32]:
        """(N, 2) position of the roots on the ground [m], world."""
        return self.history[:, -1, 0, :2]

    @property
    def root_heading(self) -> NDArray[np.float32]:
        """(N,) heading of the roots [rad], world."""
        return rotations.heading(self.history[:, -1, 0, 3:7])

    @property
    def windows(self) -> NDArray[np.float32]:
        """(N, 5, 15, 7) pose windows of the last step's transitions, before any reset."""
        return pose_windows(self._features)

    @property
    def footing(self) -> NDArray[np.float64]:
        """(N,) how little the feet slid in the last step, in (0, 1]; see `footing_reward`. Even ground alone has it."""
        if self.ground.surface is not None:
            raise ValueError("footing is how little feet slide on even ground, and this ground is not even")
        return footing_reward(self._features[..., :POSE], sole_corners(self.model))

    @property
    def tracking(self) -> NDArray[np.float64]:
        """(N,) how near the last step was to the motion at its own tempo, in (0, 1]; see `tracking_reward`.

        Of a motion of minutes the gait cycle nearest to the preferred speed counts; what holds none is a `MotionError`.
        The first reading begins with the nearest frames. Within 0.5 m of the target it stays as it was: one may stand.
        """
        if self._clocks is None:
            self._clocks = GaitClocks(gait_cycles(self.reference, self.goals.speed_range), len(self._all))
            self._clocks.restart(self._all, self._positions)
            self._tracking = self._clocks.rewards(self._positions, self.goals.speed)
            now = heading_frame_features(self.history, self.ground.floor_at(self.root_xy))[:, -1, :, :3]
            self._clocks.restart(self._all, now)  # some worlds have begun again since that step
        return self._tracking.copy()

    @property
    def fallen(self) -> NDArray[np.bool_]:
        """(N,) whose character lies or touches what it must not, now; see `falls.fallen`."""
        positions = self.history[:, -1, :, :3]
        return fallen(self.physics.touching(), positions, self.ground, self.spec.fall_height)

    @property
    def _positions(self) -> NDArray[np.float32]:
        """(N, 15, 3) of the links [m] now, heading frame."""
        return self._features[:, -1, :, :3]

    def reset(self, ids: NDArray[np.integer], start: int | None = None) -> Observations:
        """Restart the worlds `ids` from states of the motion with new goals; held goals stay held.

        Args:
            ids: (n,) worlds; all of them the first time.
            start: number of the start state, below `reference.num_states`; None samples them.

        Returns:
            First observations of these n worlds.
        """
        count = self.reference.num_states
        self.starts[ids] = self.rng.integers(count, size=len(ids)) if start is None else start
        self._place(ids, *self._somewhere(*self.reference.states(self.starts[ids])))
        self.goals.sample(ids, self.root_xy[ids], self.root_heading[ids], self.rng)
        return self._begun(ids)

    def resume(self, ids: NDArray[np.integer], situations: Situations) -> Observations:
        """Let the worlds (n,) go on from n situations of this task; returns observations of these n worlds."""
        self._place(ids, situations.qpos, situations.qvel, situations.history)
        self.starts[ids] = -1
        self.goals.put(ids, situations.target, situations.speed, situations.distance, situations.steps_left)
        return self._begun(ids)

    def _place(self, ids: NDArray[np.integer], qpos: Array, qvel: Array, history: NDArray[np.float32]) -> None:
        self.physics.set_states(ids, qpos, qvel)
        self.history[ids] = history
        self.steps[ids] = 0
        if self.pushes is not None:
            self.pushes.restart(ids, self.rng)

    def _begun(self, ids: NDArray[np.integer]) -> Observations:
        features = heading_frame_features(self.history[ids], self.ground.floor_at(self.root_xy[ids]))
        if self._clocks is not None:
            self._clocks.restart(ids, features[:, -1, :, :3])
        fresh = self._observed(features, ids)
        if self._last is None:
            self._features[ids] = features
        if self._last is None or len(ids) == len(self._all):
            self._last = copied(fresh)
        else:
            put_rows(self._last, ids, fresh)
        return fresh

    def _somewhere(
        self, qpos: Array, qvel: Array, history: NDArray[np.float32]
    ) -> tuple[Array, Array, NDArray[np.float32]]:
        """Start states at random places of bounded ground."""
        if self.ground.plain:
            return qpos, qvel, history
        return spawned(self.model, self.ground, qpos, qvel, history, *self.ground.spawns(len(qpos), self.rng))

    def step(
        self, actions: NDArray[np.floating], max_steps: int | None
    ) -> tuple[Observations, NDArray[np.float64], NDArray[np.int8]]:
        """Advance all worlds by one control step; worlds that end are not reset.

        Args:
            actions: (N, nu), clipped to [-1, 1]; a world whose actions are not finite diverges.
            max_steps: time limit in control steps, or None.

        Returns:
            Observations of the N worlds, goal rewards (N,) in [0, 1], and why each episode ended (N,), codes into
            `termination.ENDS`. A world that diverged has its last finite observation and reward 0.

        Raises:
            ValueError: for actions of another shape, or before a reset.
        """
        actions = np.asarray(actions)
        if self._last is None:
            raise ValueError("worlds that were never reset cannot step: call reset() first")
        if actions.shape != (shape := (len(self._all), self.model.nu)):
            raise ValueError(f"actions have the shape {actions.shape}, expected {shape}")
        meant = np.isfinite(actions).all(axis=1)
        before, speed = self.root_xy.copy(), self.goals.speed.copy()
        if self.pushes is not None:
            self.physics.push(self.pushes.step(self.rng))
        diverged = self.physics.step(np.where(meant[:, None], np.clip(actions, -1, 1), 0)) | ~meant
        self._remember_links(diverged)
        self.steps += 1
        after = self.root_xy
        self.clearance = clearance_reward(self.ground.distance_to_obstacles(after))
        reward = goal_reward(before, after, self.goals.target, speed)
        reward[diverged] = 0
        left = np.linalg.norm(self.goals.target - after, axis=1)
        timed_out = self.steps >= max_steps if max_steps is not None else np.zeros(len(left), bool)
        code = ends(self.fallen, left > self.goals.distance + LOST_DISTANCE, diverged, timed_out)
        renewed = np.flatnonzero(self.goals.expire() & (code == RUNNING))
        self.goals.sample(renewed, after[renewed], self.root_heading[renewed], self.rng)
        self._features = heading_frame_features(self.history, self.ground.floor_at(after))
        if self._clocks is not None:
            self._clocks.advance(self._positions, speed)
            fresh = self._clocks.rewards(self._positions, speed)
            self._tracking = np.where(left < GOAL_RADIUS, self._tracking, fresh)
        return self._remembered(self._observed(self._features, self._all), diverged), reward, code

    def _remember_links(self, diverged: NDArray[np.bool_]) -> None:
        self.history[:, :-1] = self.history[:, 1:]
        self.physics.read_links(self.history[:, -1])
        # The state of a world that diverged means nothing: its previous frame stands for it.
        self.history[diverged, -1] = self.history[diverged, -2]

    def _remembered(self, fresh: Observations, diverged: NDArray[np.bool_]) -> Observations:
        if self._last is not None and diverged.any():
            put_rows(fresh, diverged, rows_of(self._last, diverged))
        self._last = copied(fresh)  # what is returned belongs to the caller
        return fresh

    def _observed(self, features: NDArray[np.float32], ids: NDArray[np.integer]) -> Observations:
        root_xy, heading = self.root_xy[ids], self.root_heading[ids]
        seen = observations(features, goal_observation(root_xy, heading, self.goals.target[ids], self.goals.speed[ids]))
        if not self.spec.heightmap:
            return seen
        return {"observation": seen, "heightmap": heightmaps(self.ground, root_xy, heading)}

    def hold_goal(self, heading: float | None, speed: float | None, ids: NDArray[np.integer]) -> None:
        """Keep the targets ahead in the world direction `heading` [rad] at `speed` [m/s], as `Goals.hold` has it."""
        self.goals.hold(ids, heading, speed)
        self.goals.sample(ids, self.root_xy[ids], self.root_heading[ids], self.rng)
