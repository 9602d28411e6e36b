"""Many worlds of one task as a Gymnasium `VectorEnv`."""

from numbers import Integral, Real
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from adapt_envs.drawing.world_view import SceneRenderer
from adapt_envs.features.heading_frame import OBSERVATION_SIZE
from adapt_envs.features.heightmap import SIZE
from adapt_envs.features.observation_rows import Observations, put_rows, rows_of
from adapt_envs.simulation.state_access import StateAccess
from adapt_envs.simulation.worlds import Worlds
from adapt_envs.spaces import JointSpace
from adapt_envs.suite import EPISODE_STEPS, TaskSpec, configured
from adapt_envs.tasks.termination import DIVERGED, ENDS, RUNNING, TIME

RESET_OPTIONS = ("goal_heading", "goal_speed", "start")
"""Keys of `reset(options=...)`: a goal to hold [rad, m/s], and the number of the start state."""
RENDER_FPS = 30


def spaces_of(worlds: Worlds) -> tuple[gym.Space[Any], JointSpace]:
    """Observation and action space of one world."""
    observation: gym.Space[Any] = gym.spaces.Box(-np.inf, np.inf, (OBSERVATION_SIZE,), np.float32)
    if worlds.spec.heightmap:
        heightmap = gym.spaces.Box(-np.inf, np.inf, (1, SIZE, SIZE), np.float32)
        observation = gym.spaces.Dict({"observation": observation, "heightmap": heightmap})
    reference = worlds.reference
    return observation, JointSpace(reference.joint_names, worlds.spec.base, reference.mean_pose)


def apply_options(worlds: Worlds, ids: NDArray[np.integer], options: dict[str, Any] | None) -> int | None:
    """Hold or release goals as `reset(options=...)` asks; return the number of the start state it asks for, if any.

    A goal that an earlier reset asked for is released, so that a seed means the same episodes whatever went before;
    one that `set_goal` holds stays.

    Raises:
        ValueError: for an unknown option, a start state that does not exist, or a goal that cannot be held.
    """
    options = options or {}
    unknown = [key for key in options if key not in RESET_OPTIONS]
    if unknown:
        raise ValueError(f"unknown reset option {unknown[0]!r}; the options are {', '.join(RESET_OPTIONS)}")
    start = options.get("start")
    last = worlds.reference.num_states - 1
    if start is not None and not (_is_number(start, Integral) and 0 <= start <= last):
        raise ValueError(f"start state {start!r} does not exist; they are 0 to {last}")
    heading, speed = options.get("goal_heading"), options.get("goal_speed")
    for name, value in (("goal_heading", heading), ("goal_speed", speed)):
        if not (value is None or _is_number(value, Real)):
            raise ValueError(f"reset option {name} is {value!r}, expected a number")
    if heading is not None or speed is not None or "goal_heading" in options:
        worlds.goals.restore(ids)
        worlds.goals.hold(ids, heading, speed, until_reset=heading is not None)  # the reset samples
    else:
        worlds.goals.restore(ids)
    return None if start is None else int(start)


def _is_number(value: Any, kind: type) -> bool:
    return isinstance(value, kind) and not isinstance(value, bool)


def _for_each_world(name: str, values: ArrayLike, worlds: int) -> NDArray[np.float64]:
    """One number for all worlds, or one for each, as an array (N,) of its own; ValueError for anything else."""
    try:
        return np.broadcast_to(np.asarray(values, np.float64), worlds).copy()
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} is {values!r}, expected a number, or {worlds} of them, one for each world") from error


class Adjustable:
    """What may be set at any time, of one world as of many; `AttributeRamp` lets it grow in training.

    A `gym.Wrapper` does not hand on what is set: set it on `env.unwrapped`.

    Attributes:
        worlds: the worlds.
    """

    worlds: Worlds

    @property
    def push_scale(self) -> NDArray[np.float64]:
        """Factors (N,) on the force of pushes; 1 unless set.

        Set it to one factor for all worlds or to one for each; ValueError if the task has no pushes, and for a negative
        or non-finite factor.
        """
        return np.ones_like(self.worlds.goals.spread) if self.worlds.pushes is None else self.worlds.pushes.scale

    @push_scale.setter
    def push_scale(self, factors: ArrayLike) -> None:
        if self.worlds.pushes is None:
            raise ValueError("this environment has no pushes to scale; give it `push=PushSchedule(...)`")
        scale = _for_each_world("push_scale", factors, len(self.worlds.pushes.scale))
        if not ((scale >= 0) & np.isfinite(scale)).all():
            raise ValueError(f"push_scale is {factors!r}, expected factors of at least 0")
        self.worlds.pushes.scale = scale

    @property
    def goal_spread(self) -> NDArray[np.float64]:
        """Shares (N,) of the circle, centred straight ahead, that goals are sampled from; 1 unless set.

        Set it to one share for all worlds or to one for each; ValueError for a share outside [0, 1].
        """
        return self.worlds.goals.spread

    @goal_spread.setter
    def goal_spread(self, shares: ArrayLike) -> None:
        spread = _for_each_world("goal_spread", shares, len(self.worlds.goals.spread))
        if not ((spread >= 0) & (spread <= 1)).all():
            words = "expected shares of the circle from 0 (ahead) to 1 (anywhere)"
            raise ValueError(f"goal_spread is {shares!r}, {words}")
        self.worlds.goals.spread = spread


class AdaptVectorEnv(Adjustable, StateAccess, gym.vector.VectorEnv[Observations, NDArray[np.float32], NDArray[Any]]):
    """N worlds of one task, stepped together; ended worlds restart in the same step.

    The arrays that `reset` and `step` return are fresh at every call. `infos["final_obs"]` and `infos["final_info"]`
    follow Gymnasium's SAME_STEP convention; `infos["final_info"]["end"]` names why an episode ended.

    Attributes:
        worlds: the worlds themselves.
        diverged_worlds: how many worlds diverged so far.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": RENDER_FPS, "autoreset_mode": AutoresetMode.SAME_STEP}

    def __init__(
        self, task: str | TaskSpec, num_envs: int = 1, max_episode_steps: int | None = EPISODE_STEPS,
        num_threads: int | None = None, stagger: bool = False, render_mode: str | None = None, **overrides: Any,
    ) -> None:  # fmt: skip
        """Make `num_envs` worlds of `task`.

        Args:
            task: name of a row of `suite.SUITE`, or your own `TaskSpec`.
            num_envs: number of worlds.
            max_episode_steps: time limit in control steps (1/30 s); None, 0 or less is none.
            num_threads: threads of the physics; None for one per core.
            stagger: shorten the episodes that a `reset` of all worlds begins, each by another number of steps, so that
                time limits do not come all at once in training.
            render_mode: "rgb_array" (a picture per world) or None.
            **overrides: fields of `TaskSpec` to replace, such as `motion` or `speed_range`.
        """
        self.worlds = Worlds(configured(task, overrides), num_envs, num_threads)
        self.num_envs = num_envs
        self.render_mode = check_render_mode(render_mode, self.metadata["render_modes"])
        self.single_observation_space, self.single_action_space = spaces_of(self.worlds)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.diverged_worlds = 0
        limited = max_episode_steps is not None and max_episode_steps > 0
        self._max_steps, self._stagger = max_episode_steps if limited else None, stagger
        self._all = np.arange(num_envs)
        self._renderer: SceneRenderer | None = None

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Restart all worlds; `options` are `RESET_OPTIONS`. One seed serves all worlds; of a list the first is it."""
        seed = (seed or [None])[0] if isinstance(seed, list) else seed
        if seed is not None:
            self._np_random, self._np_random_seed = gym.utils.seeding.np_random(seed)
        self.worlds.rng = self.np_random
        start = apply_options(self.worlds, self._all, options)
        observations = self.worlds.reset(self._all, start)
        if self._stagger and self._max_steps is not None:
            self.worlds.steps[:] = self.np_random.integers(self._max_steps, size=self.num_envs)
        return observations, {}

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[Observations, NDArray[Any], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Advance all worlds by 1/30 s; see Gymnasium's `VectorEnv.step`."""
        observations, rewards, code = self.worlds.step(actions, self._max_steps)
        ended = np.flatnonzero(code != RUNNING)
        infos = self._restart(observations, code, ended) if len(ended) else {}
        return observations, rewards, (code != RUNNING) & (code != TIME), code == TIME, infos

    def _restart(
        self, observations: Observations, code: NDArray[np.int8], ended: NDArray[np.integer]
    ) -> dict[str, Any]:
        mask = code != RUNNING
        final_obs, end = (np.full(self.num_envs, None, dtype=object) for _ in range(2))
        for world in ended:
            final_obs[world], end[world] = rows_of(observations, world), ENDS[code[world]]
        self.diverged_worlds += int((code == DIVERGED).sum())
        put_rows(observations, ended, self.worlds.reset(ended))
        diverged = np.full(self.num_envs, self.diverged_worlds)
        final_info = {"end": end, "_end": mask, "diverged_worlds": diverged, "_diverged_worlds": mask}
        return {"final_obs": final_obs, "_final_obs": mask, "final_info": final_info, "_final_info": mask}

    @property
    def pose_windows(self) -> NDArray[np.float32]:
        """(N, 5, 15, 7) poses up to the last transition, before any restart: what discriminators see."""
        return self.worlds.windows

    @property
    def footing(self) -> NDArray[np.float64]:
        """(N,) in (0, 1]: how little the feet slid in the last transition; an objective beside goal and imitation."""
        return self.worlds.footing

    @property
    def tracking(self) -> NDArray[np.float64]:
        """(N,) in (0, 1]: how near the last poses were to the motion at its own tempo; `MotionError` without a gait."""
        return self.worlds.tracking

    @property
    def clearance(self) -> NDArray[np.float64]:
        """(N,) in [0, 1]: how much room obstacles left in the last transition; an objective, too."""
        return self.worlds.clearance

    def sample_reference_windows(self, n: int, rng: np.random.Generator) -> NDArray[np.float32]:
        """`n` windows (n, 5, 15, 7) of the reference motion, laid out as `pose_windows`."""
        return self.worlds.reference.sample_windows(n, rng)

    def set_goal(self, heading: float | None, speed: float | None, worlds: NDArray[np.integer] | None = None) -> None:
        """Hold the goal ahead in the world direction `heading` [rad] at `speed` [m/s]; None, None: random ones."""
        self.worlds.hold_goal(heading, speed, self._all if worlds is None else worlds)

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """A picture (480, 640, 3) of each world, or None without a render mode."""
        if self.render_mode is None:
            return None
        self._renderer = self._renderer or SceneRenderer(self.worlds)
        return tuple(self._renderer.picture(world) for world in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        """Free the renderer."""
        if self._renderer is not None:
            self._renderer.close()


def check_render_mode(mode: str | None, valid: list[str]) -> str | None:
    """`mode` if it is None or among `valid`.

    Raises:
        ValueError: otherwise, listing the valid ones.
    """
    if mode is not None and mode not in valid:
        raise ValueError(f"render_mode {mode!r} is unknown; the modes are {', '.join(valid)}")
    return mode
