"""SVG: stochastic value gradients through a learned world model, as a Stable-Baselines3 algorithm.

Real rollouts are collected; the model is refreshed on them; the policy then descends the slope of a tracking loss,
propagated back through model and kinematics along the real states (Heess et al. 2015; Fussell et al. 2021).
"""

import sys
import time
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.type_aliases import GymEnv, MaybeCallback
from stable_baselines3.common.utils import FloatSchedule, safe_mean, update_learning_rate

from sb3_adaptnet.algorithms.gradient_taming import GradientTaming, NormLimit
from sb3_adaptnet.algorithms.imagination import imagine
from sb3_adaptnet.algorithms.real_rollout import RealRollout, RolloutRecorder
from sb3_adaptnet.algorithms.servo_regression import regress_to_servo_aims
from sb3_adaptnet.algorithms.svg_loss import LossWeights, window_loss
from sb3_adaptnet.algorithms.tracked_motion import TrackedMotion
from sb3_adaptnet.algorithms.tracked_worlds import TrackedStep, TrackedWorlds
from sb3_adaptnet.objectives.schedule import Points, check_points, value_at
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy
from sb3_adaptnet.vec_env import AdaptVecEnv
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.fitting import descend, draw, one_step, one_step_loss
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.world_file import read_world

ADAM = {"eps": 1e-8, "betas": (0.9, 0.98)}
"""The policy's optimiser: gradients are small, and a rollout's windows resemble each other."""
Self = TypeVar("Self", bound="SVG")


class SVG(BaseAlgorithm):
    """Adapts a policy of this package to the environment's reference motion and goals.

    Attributes:
        world_model: the model, refreshed while it learns.
        world_optimizer: Adam for the model.
        rng: source of noise, windows and batches.
    """

    policy: ObjectivePolicy
    world_model: WorldModel

    def __init__(
        self,
        policy: type[ObjectivePolicy],
        env: GymEnv | None,
        world_model: str | Path | WorldModel | None = None,
        learning_rate: Points = 5e-4,
        n_steps: int = 32,
        window: int = 16,
        gradient_steps: int = 6,
        recent_rollouts: int = 3,
        noise_std: float = 0.05,
        noise_share: float = 0.8,
        error_limit: Points = 0.2,
        turn_rate: Points = 0.3,
        episode_steps: tuple[int, int] = (50, 150),
        regression_updates: int = 300,
        model_learning_rate: float = 1e-4,
        model_updates: int = 3,
        model_batch: int = 1024,
        model_rollouts: int = 12,
        loss_weights: LossWeights | None = None,
        stats_window_size: int = 100,
        tensorboard_log: str | None = None,
        policy_kwargs: dict[str, Any] | None = None,
        verbose: int = 0,
        seed: int | None = None,
        device: torch.device | str = "auto",
        _init_setup_model: bool = True,
    ) -> None:
        """Choose how to learn.

        Args:
            policy: a policy of this package, such as `AdaptNetPolicy`.
            env: an `AdaptVecEnv` on flat ground.
            world_model: the character's model, or its file.
            learning_rate: of the policy; a number, or samples -> number, as the two schedules below.
            n_steps: control steps of a rollout.
            window: control steps that gradients pass through.
            gradient_steps: updates of the policy per rollout.
            recent_rollouts: rollouts that windows are drawn from; every other one is from the latest.
            noise_std: of the actions, as they have a standard deviation of their own only in PPO.
            noise_share: share of the steps of each world that have noise.
            error_limit: mean error of link positions [m] at which an episode ends.
            turn_rate: at most so fast the reference turns towards the goal [rad/s].
            episode_steps: fewest and most control steps of an episode.
            regression_updates: updates of the first guess, before the first rollout of all.
            model_learning_rate: of the model.
            model_updates: its updates per rollout.
            model_batch: transitions per such update.
            model_rollouts: rollouts that they are drawn from.
            loss_weights: of the loss's parts.
            stats_window_size: episodes that the logged means are of.
            tensorboard_log: folder for TensorBoard.
            policy_kwargs: further arguments of the policy.
            verbose: as in Stable-Baselines3.
            seed: of everything.
            device: of policy and model.
            _init_setup_model: build the networks.

        Raises:
            ValueError: for a window longer than a rollout, a negative number in a schedule, or worlds, policy or
                model that do not fit.
            CheckpointError: for a model's file that cannot be read.
        """
        adam = {"optimizer_kwargs": dict(ADAM)}
        super().__init__(
            policy,
            env,
            learning_rate=learning_rate,  # type: ignore[arg-type]  # see _setup_lr_schedule
            policy_kwargs=adam | (policy_kwargs or {}),
            stats_window_size=stats_window_size,
            tensorboard_log=tensorboard_log,
            verbose=verbose,
            device=device,
            support_multi_env=True,
            seed=seed,
            supported_action_spaces=(spaces.Box,),
        )
        if not 0 < window <= n_steps:
            raise ValueError(f"window is {window}, expected 1 to n_steps, which is {n_steps}")
        schedules: Mapping[str, Points] = {
            "learning_rate": learning_rate, "error_limit": error_limit, "turn_rate": turn_rate
        }  # fmt: skip
        for name, points in schedules.items():
            check_points(name, points)
        self.n_steps, self.window = n_steps, window
        self.gradient_steps, self.recent_rollouts = gradient_steps, recent_rollouts
        self.noise_std, self.noise_share = noise_std, noise_share
        self.error_limit, self.turn_rate = error_limit, turn_rate
        self.episode_steps, self.regression_updates = episode_steps, regression_updates
        self.model_learning_rate, self.model_updates = model_learning_rate, model_updates
        self.model_batch, self.model_rollouts = model_batch, model_rollouts
        self.loss_weights = loss_weights or LossWeights()
        self.taming, self.norm_limit = GradientTaming(), NormLimit()
        self._rollouts: deque[RealRollout] = deque(maxlen=max(model_rollouts, recent_rollouts))
        self._n_updates = 0
        if _init_setup_model:
            self._open_world(world_model)
            self._setup_model()
