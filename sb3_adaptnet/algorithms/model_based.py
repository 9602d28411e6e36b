"""An algorithm that learns a policy of this package together with a world model, from an `AdaptVecEnv`."""

import json
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Self, cast

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.type_aliases import GymEnv
from stable_baselines3.common.utils import FloatSchedule
from tqdm import tqdm

from sb3_adaptnet.algorithms.averaged import AveragedAlgorithm
from sb3_adaptnet.algorithms.checks import NEW
from sb3_adaptnet.algorithms.cost_critic import LEARNING_RATE, CostCritic
from sb3_adaptnet.algorithms.gradient_taming import NormLimit
from sb3_adaptnet.algorithms.model_learning import fit_anew, fitted_to, opened, record
from sb3_adaptnet.algorithms.rollouts.strengths import acting_at
from sb3_adaptnet.algorithms.servo_regression import regress_to_servo_aims, servo_aims
from sb3_adaptnet.algorithms.svg_loss import LossSchedules
from sb3_adaptnet.algorithms.svg_settings import CostToGo, Episodes, Exploration, ModelFits, ModelRefresh, grouped
from sb3_adaptnet.algorithms.tracking.guide import Guiding
from sb3_adaptnet.algorithms.tracking.tracked_groups import Env, character_of, groups_of, worlds_of
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.modules.observation import COMPANION, FLAT
from sb3_adaptnet.objectives.schedule import Schedule, check_schedule, value_at
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy
from sb3_adaptnet.policies.optimizer_groups import restore_moments
from sb3_adaptnet.policies.space_contract import default_base
from sb3_adaptnet.world_model.fitting.collecting import Act
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.transitions import Transitions

ADAM = {"eps": 1e-8, "betas": (0.9, 0.98)}
"""The policy's optimiser: gradients are small, and a rollout's windows resemble each other."""

GROUPS: dict[str, Callable[[Any], Any]] = {
    "episodes": partial(grouped, Episodes),
    "guiding": partial(grouped, Guiding),
    "exploration": partial(grouped, Exploration),
    "model_refresh": partial(grouped, ModelRefresh),
    "model_fits": partial(grouped, ModelFits),
    "loss_weights": LossSchedules.of,
    "cost_to_go": partial(grouped, CostToGo),
}
"""Settings that are groups: name -> what makes one of a mapping."""


class ModelBasedAlgorithm(AveragedAlgorithm):
    """Builds, saves and loads what a model-based learner consists of; how it learns is a subclass's matter.

    Attributes:
        world_model: the model, refreshed while the policy learns.
        world_model_is_new: whether it begins from nothing.
        world_optimizer: Adam for the model.
        critic: which costs a state leads to; frozen, except while it learns.
        critic_optimizer: Adam for the critic.
        norm_limit: running mean of the policy's gradients.
        rng: source of all randomness but the networks' first weights and the worlds.
    """

    world_model: WorldModel
    world_optimizer: torch.optim.Optimizer

    def __init__(
        self,
        policy: type[ObjectivePolicy],
        env: GymEnv | None,
        world_model: str | Path | WorldModel | None,
        learning_rate: Schedule,
        model_refresh: ModelRefresh,
        model_fits: ModelFits,
        policy_kwargs: dict[str, Any] | None,
        init_setup_model: bool,
        **settings: Any,
    ) -> None:
        """Take over the choices; see `SVG`. `settings` are `BaseAlgorithm`'s.

        Raises:
            ValueError: for a negative learning rate, or worlds, policy or model that do not fit.
            CheckpointError: for a model's file that cannot be read.
        """
        super().__init__(
            policy,
            env,
            learning_rate=cast(Any, learning_rate),  # what SB3 makes of it, _setup_lr_schedule overrules
            policy_kwargs={"optimizer_kwargs": dict(ADAM)} | (policy_kwargs or {}),
            support_multi_env=True,
            supported_action_spaces=(spaces.Box,),
            **settings,
        )
        check_schedule("learning_rate", learning_rate)
        self.model_refresh, self.model_fits, self.norm_limit = model_refresh, model_fits, NormLimit()
        self._fits_done, self._recorded = 0, list[Transitions]()
        self._n_updates, self._begun = 0, False
        self._average = None
        if init_setup_model:
            self._open_world_model(world_model)
            self._setup_model()

    def _open_world_model(self, given: str | Path | WorldModel | None) -> None:
        self.world_model_is_new = given == NEW
        if given == NEW:
            self.world_model = WorldModel(character_of(self._worlds_of_env()), Sizes(width=self.model_fits.width))
        else:
            base = (self.policy_kwargs or {}).get("base") or default_base(self.action_space)
            self.world_model = fitted_to(opened(given, base), character_of(self._worlds_of_env()))
        self._model_description = (self.world_model.character, self.world_model.sizes)  # from which `load` builds it

    def _worlds_of_env(self) -> Env:
        return worlds_of(self.env, self.observation_space)

    def _setup_model(self) -> None:
        self._setup_lr_schedule()
        self.set_random_seed(self.seed)
        self.rng = np.random.default_rng(self.seed)
        policy = self.policy_class(self.observation_space, self.action_space, self.lr_schedule, **self.policy_kwargs)
        if not isinstance(policy, ObjectivePolicy):
            raise ValueError(f"SVG needs one of this package's policies, such as AdaptNetPolicy, not {policy}")
        self.policy = policy.to(self.device)
        self._learn_by(vars(self).get("world_model") or WorldModel(*self._model_description))
        self.critic = CostCritic(self.world_model).to(self.device).requires_grad_(False)
        self.critic_optimizer = torch.optim.Adam(self.critic.parameters(), lr=LEARNING_RATE)

    def _learn_by(self, model: WorldModel) -> None:
        self.world_model, rate = model.to(self.device), self.model_refresh.learning_rate
        self.world_optimizer = torch.optim.Adam(self.world_model.parameters(), lr=rate)

    def model_fit_is_due(self) -> bool:
        """Whether a new world model has to be fitted now."""
        return self.world_model_is_new and self.model_fits.due(self._fits_done, self.num_timesteps)

    def _begin(self, motion: TrackedMotion, updates: int, progress_bar: bool) -> float:
        """What comes before the first rollout: input statistics and a first model where there are none, and a guess.

        Returns:
            The guess's error; see `regress_to_servo_aims`.
        """
        knows_nothing = self.policy.knows_nothing
        if knows_nothing or self.model_fit_is_due():
            act = servo_aims(motion) if knows_nothing else self._steady_action
            observations = self._fit_model(act, progress_bar)
            if knows_nothing:
                self.policy.learn_statistics(torch.as_tensor(observations, device=self.device))
        if updates and not knows_nothing:
            self.policy.expect(motion.frames)
        speeds = groups_of(self._worlds_of_env())[0].simulation.goal_states.speed
        return regress_to_servo_aims(self.policy, motion, speeds, updates, self.rng)

    def _fit_model(self, act: Act, progress_bar: bool) -> NDArray[np.float32]:
        """Record what a policy does, disturbed, and fit a model that is new; returns observations (n, 784) of it."""
        data, observations = record(groups_of(self._worlds_of_env())[0], act, self.model_fits.steps, self.rng)
        self.num_timesteps += data.actions.shape[0] * data.num_worlds
        if self.world_model_is_new:
            self._recorded.append(data)
            self.world_model.dynamics.precision = self.policy.precision
            effort = self.model_fits.effort(self._fits_done)
            hidden = None if progress_bar or self.verbose else True  # None: in a terminal alone
            bar = partial(tqdm, desc="world model", unit=" updates", disable=hidden, leave=False)
            fit_anew(self.world_model, Transitions.together(self._recorded), effort, self.rng, bar)
            self._learn_by(self.world_model)  # the optimiser's moments were of other weights
            self._fits_done += 1
        return observations

    def _setup_lr_schedule(self) -> None:
        """A constant for the policy's constructor: the learning rate follows the samples, not the progress."""
        self.lr_schedule = FloatSchedule(self._learning_rate_now())

    def _learning_rate_now(self) -> float:
        return value_at(cast(Schedule, self.learning_rate), self.num_timesteps)

    def _mean_action(self, observations: torch.Tensor, companions: NDArray[np.integer] | None = None) -> torch.Tensor:
        """Mean actions (B, J) for observations (B, 784), beside companions (B,) if there are any."""
        if not isinstance(self.observation_space, spaces.Dict):
            return self.policy.get_distribution(observations).mode()
        numbers = torch.as_tensor(companions, device=observations.device)
        return self.policy.get_distribution({FLAT: observations, COMPANION: numbers}).mode()

    @torch.no_grad()
    def _mean_actions(
        self, observations: NDArray[np.float32], strengths: NDArray[np.float32], companions: NDArray[np.integer]
    ) -> NDArray[np.float32]:
        """Mean actions (N, J) in all worlds, where what learns acts at its strength there (N,)."""
        with acting_at(self.policy, strengths):
            seen = torch.as_tensor(observations, device=self.device)
            return self._mean_action(seen, companions).cpu().numpy()

    def _steady_action(self, observations: NDArray[np.float32]) -> NDArray[np.float32]:
        return self.predict(observations, deterministic=True)[0]

    def world_state(self) -> dict[str, Any]:
        """What a checkpoint needs beside the policy (which is the average): plain values."""
        return {
            "model": self.world_model.state_dict(),
            "optimizer": self.world_optimizer.state_dict(),
            "latest": self.weight_average.state_dict(),
            "gradient_norm": self.norm_limit.mean,
            "critic": self.critic.state_dict(),
            "critic_optimizer": self.critic_optimizer.state_dict(),
            "fits_done": self._fits_done,
            "begun": self._begun,
            "rng": json.dumps(self.rng.bit_generator.state),
        }

    def set_world_state(self, state: Mapping[str, Any]) -> None:
        """Restore what `world_state` gave.

        Raises:
            ValueError: for the state of an older version, whose critic read fewer numbers.
        """
        read = state["critic"]["layers.0.weight"].shape[1]
        if read != (now := self.critic.layers[0].in_features):  # older ones' lacked the strength or the motion's angles
            raise ValueError(f"the checkpoint's critic reads {read} numbers, now there are {now}: begin the run anew")
        self._model_description = (self.world_model.character, Sizes.of(state["model"]))  # older ones are wider
        self._learn_by(WorldModel(*self._model_description))
        self.world_model.load_state_dict(state["model"])
        restore_moments(self.world_optimizer, state["optimizer"])
        self.weight_average.load_state_dict(state["latest"])
        self.norm_limit.mean = state["gradient_norm"]
        self.critic.load_state_dict(state["critic"])
        restore_moments(self.critic_optimizer, state["critic_optimizer"])
        self._fits_done, self._begun = state["fits_done"], state["begun"]
        self.rng.bit_generator.state = json.loads(state["rng"])

    @classmethod
    def load(cls, *args: Any, **settings: Any) -> Self:
        """Load what `save` wrote, as in Stable-Baselines3; settings that are given anew are checked when it learns.

        Raises:
            ValueError: for a group that cannot be used, and for a world model: a saved model has its own.
        """
        if "world_model" in settings:
            raise ValueError("a saved model has its own world model; a new SVG takes another")
        groups = {name: group(settings[name]) for name, group in GROUPS.items() if name in settings}
        return super().load(*args, **{**settings, **groups})

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "_recorded"]

    def _get_torch_save_params(self) -> tuple[list[str], list[str]]:
        learning = ["policy", "weight_average", "world_model", "critic"]
        return [*learning, "policy.optimizer", "world_optimizer", "critic_optimizer"], []
