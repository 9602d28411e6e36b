"""One world of one task as a Gymnasium `Env`: a batch of one."""

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from adapt_envs.drawing.world_view import SceneRenderer, Window
from adapt_envs.features.observation_rows import Observations, rows_of
from adapt_envs.simulation.worlds import Worlds
from adapt_envs.suite import EPISODE_STEPS, TaskSpec, configured
from adapt_envs.tasks.termination import DIVERGED, ENDS, RUNNING, TIME
from adapt_envs.vector_env import RENDER_FPS, Adjustable, apply_options, check_render_mode, spaces_of

_ALL = np.zeros(1, np.int64)


class AdaptEnv(Adjustable, gym.Env[Observations, NDArray[Any]]):
    """A physically simulated humanoid that walks or runs to targets in the manner of a reference motion.

    ## Description
    The character, task and observation of *AdaptNet* (Xu et al. 2023, doi:10.1145/3618375): 15 links, 28 hinges,
    48.9 kg, 120 Hz physics, 30 Hz control. The environment's reward is the goal reward alone; a discriminator that
    compares `pose_windows` with `sample_reference_windows` supplies the imitation reward.

    ## Action space
    `Box(-1, 1, (28,), float32)`, a `JointSpace` (it names its joints): servo targets; target angle = middle of the
    joint's range + action x width of the range; torque = kp (target - q) - kd qdot.

    | Index | Joints (x, y, z each unless one axis) | kp [N m/rad] | kd [N m s/rad] |
    |---|---|---|---|
    | 0-2 | abdomen | 600 | 60 |
    | 3-5 | neck | 50 | 5 |
    | 6-8, 9 | right shoulder, right elbow (y) | 200, 150 | 20, 15 |
    | 10-12, 13 | left shoulder, left elbow (y) | 200, 150 | 20, 15 |
    | 14-16, 17, 18-20 | right hip, right knee (y), right ankle | 300, 300, 200 | 30, 30, 20 |
    | 21-23, 24, 25-27 | left hip, left knee (y), left ankle | 300, 300, 200 | 30, 30, 20 |

    ## Observation space
    `Box(-inf, inf, (784,), float32)`, in the heading frame of the present root (origin on the ground under it, z up,
    x along its heading). Index (frame * 15 + link) * 13 + component, oldest of the four frames first:

    | Index | Observation | Unit |
    |---|---|---|
    | (f * 15 + l) * 13 + 0..2 | position of link l in frame f, f = 3 being the present | m |
    | (f * 15 + l) * 13 + 3..6 | orientation quaternion w, x, y, z with w >= 0 | - |
    | (f * 15 + l) * 13 + 7..9 | linear velocity of the link frame's origin, absolute | m/s |
    | (f * 15 + l) * 13 + 10..12 | angular velocity, absolute | rad/s |
    | 780..781 | unit direction to the target (zero below 1 cm) | - |
    | 782 | horizontal distance to the target | m |
    | 783 | preferred speed | m/s |

    With a heightmap (terrain, obstacles): `Dict(observation=Box(784,), heightmap=Box(1, 35, 35))`; the map reaches
    2.4 m ahead, 1 m behind and 1.7 m to either side of the root, relative to the ground below.

    Links l: 0 pelvis, 1 torso, 2 head, 3 right_upper_arm, 4 right_lower_arm, 5 right_hand, 6 left_upper_arm,
    7 left_lower_arm, 8 left_hand, 9 right_thigh, 10 right_shin, 11 right_foot, 12 left_thigh, 13 left_shin,
    14 left_foot.

    ## Reward
    exp(-3 |v - v*|^2 / |v*|^2) with v the root's horizontal displacement over the step times 30 and v* the preferred
    speed towards the target; 1 within 0.5 m of it (paper, app. A). A new target is sampled when a timer ends, never
    on arrival: root + preferred speed x timer x direction, uniform in direction.

    ## Starting state
    A random moment of the reference motion, with the frames before it as history; on terrain at a random place, lifted
    to stand on the ground.

    ## Episode end
    `info["end"]` names why: `fall` (any link but the feet touches the ground or an obstacle; on uneven ground, one
    lower than 0.15 m), `lost` (3 m farther from the target than when it was sampled), `diverged` (the physics broke
    down; the last finite observation is returned and `info["diverged_worlds"]` counts), all `terminated`. After 300
    steps it is `truncated`: under `gym.make` by Gymnasium's `TimeLimit`, which names no reason; of an `AdaptEnv` or
    `AdaptVectorEnv` by itself, `time`.

    ## Arguments
    See `__init__`; `reset(options={"goal_heading": rad, "goal_speed": m/s, "start": number})` holds the goal ahead in a
    world direction until the next reset, and names the start state. `set_goal` holds it until it is set again.
    `push_scale` scales the force of pushes, `goal_spread` narrows where goals are sampled from.

    ## Version history
    * v0: initial version.
    """

    metadata = {"render_modes": ["rgb_array", "human"], "render_fps": RENDER_FPS}

    def __init__(self, task: str | TaskSpec, render_mode: str | None = None, **overrides: Any) -> None:
        """Make one world of `task`.

        Args:
            task: name of a row of `suite.SUITE`, or your own `TaskSpec`.
            render_mode: "rgb_array", "human" or None.
            **overrides: fields of `TaskSpec` to replace, such as `motion` (a clip's name or file) or `speed_range`.
        """
        self.worlds = Worlds(configured(task, overrides), num_worlds=1, num_threads=1)
        self.render_mode = check_render_mode(render_mode, self.metadata["render_modes"])
        self.observation_space, self.action_space = spaces_of(self.worlds)
        self.diverged_worlds = 0
        self._renderer: SceneRenderer | None = None
        self._window: Window | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Restart from a state of the motion; see Gymnasium's `Env.reset` and the class's notes on `options`."""
        super().reset(seed=seed)
        self.worlds.rng = self.np_random
        observations = self.worlds.reset(_ALL, apply_options(self.worlds, _ALL, options))
        self._show()
        return rows_of(observations, 0), {}

    def step(self, action: NDArray[np.float32]) -> tuple[Observations, float, bool, bool, dict[str, Any]]:
        """Advance by 1/30 s; see Gymnasium's `Env.step`."""
        observations, rewards, codes = self.worlds.step(np.asarray(action)[None], self._max_steps)
        code = int(codes[0])
        self.diverged_worlds += code == DIVERGED
        info = {"end": ENDS[code], "diverged_worlds": self.diverged_worlds} if code != RUNNING else {}
        self._show()
        return rows_of(observations, 0), float(rewards[0]), code not in (RUNNING, TIME), code == TIME, info

    @property
    def _max_steps(self) -> int | None:
        # `gym.make` wraps a time limit around it, whose number is not in the spec that it leaves here.
        return EPISODE_STEPS if self.spec is None else None

    @property
    def pose_windows(self) -> NDArray[np.float32]:
        """(5, 15, 7) poses up to the last transition: what discriminators see."""
        return self.worlds.windows[0]

    @property
    def footing(self) -> float:
        """In (0, 1]: how little the feet slid in the last transition; an objective beside goal and imitation."""
        return float(self.worlds.footing[0])

    @property
    def tracking(self) -> float:
        """In (0, 1]: how near the last pose was to the motion at its own tempo; `MotionError` without a gait."""
        return float(self.worlds.tracking[0])

    @property
    def clearance(self) -> float:
        """In [0, 1]: how much room obstacles left in the last transition; an objective, too."""
        return float(self.worlds.clearance[0])

    def sample_reference_windows(self, n: int, rng: np.random.Generator) -> NDArray[np.float32]:
        """`n` windows (n, 5, 15, 7) of the reference motion, laid out as `pose_windows`."""
        return self.worlds.reference.sample_windows(n, rng)

    def set_goal(self, heading: float | None, speed: float | None) -> None:
        """Hold the goal ahead in the world direction `heading` [rad] at `speed` [m/s]; None, None: random ones."""
        self.worlds.hold_goal(heading, speed, _ALL)

    def render(self) -> NDArray[np.uint8] | None:
        """A picture (480, 640, 3) in mode "rgb_array"; None in mode "human", which shows every step by itself."""
        if self.render_mode != "rgb_array":
            return None
        self._renderer = self._renderer or SceneRenderer(self.worlds)
        return self._renderer.picture()

    def _show(self) -> None:
        if self.render_mode == "human":
            self._window = self._window or Window(self.worlds)
            self._window.show()

    def close(self) -> None:
        """Free window and renderer."""
        for view in (self._renderer, self._window):
            if view is not None:
                view.close()
        self._renderer = self._window = None
