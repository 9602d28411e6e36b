"""An algorithm that learns a policy of this package together with a world model, from an `AdaptVecEnv`."""

import copy
import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.type_aliases import GymEnv
from stable_baselines3.common.utils import FloatSchedule
from tqdm import tqdm

from sb3_adaptnet.algorithms.checks import NEW
from sb3_adaptnet.algorithms.cost_critic import LEARNING_RATE, CostCritic
from sb3_adaptnet.algorithms.gradient_taming import NormLimit
from sb3_adaptnet.algorithms.model_learning import fit_anew, fitted_to, record
from sb3_adaptnet.algorithms.servo_regression import regress_to_servo_aims, servo_aims
from sb3_adaptnet.algorithms.svg_settings import ModelFits, ModelRefresh
from sb3_adaptnet.algorithms.tracking.tracked_groups import Env, character_of, groups_of, worlds_of
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.modules.observation import COMPANION, FLAT
from sb3_adaptnet.objectives.schedule import Schedule, check_schedule, value_at
from sb3_adaptnet.objectives.weight_average import WeightAverage
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy
from sb3_adaptnet.policies.optimizer_groups import restore_moments
from sb3_adaptnet.policies.space_contract import default_base
from sb3_adaptnet.weights.weight_file import CheckpointError
from sb3_adaptnet.world_model.fitting.collecting import Act
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.transitions import Transitions
from sb3_adaptnet.world_model.world_file import beside_base, read_world

ADAM = {"eps": 1e-8, "betas": (0.9, 0.98)}
"""The policy's optimiser: gradients are small, and a rollout's windows resemble each other."""


class ModelBasedAlgorithm(BaseAlgorithm):
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

    policy: ObjectivePolicy
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
        self._average: WeightAverage | None = None
        if init_setup_model:
            self._open_world_model(world_model)
            self._setup_model()

    def _open_world_model(self, given: str | Path | WorldModel | None) -> None:
        self.world_model_is_new = given == NEW
        if given == NEW:
            self.world_model = WorldModel(character_of(self._worlds_of_env()), Sizes(width=self.model_fits.width))
        else:
            self.world_model = self._known_world_model(given)
        self._model_description = (self.world_model.character, self.world_model.sizes)  # from which `load` builds it

    def _known_world_model(self, given: str | Path | WorldModel | None) -> WorldModel:
        if given is None:
            base = (self.policy_kwargs or {}).get("base") or default_base(self.action_space)
            given = beside_base(base)
            if not given.is_file():
                fit = f"fit one by `adaptnet world-model fit {base}`, and name its file"
                raise CheckpointError(f"{str(base)!r} has no {given.name} beside it: {fit}")
        model = copy.deepcopy(given) if isinstance(given, WorldModel) else read_world(given).model
        return fitted_to(model, character_of(self._worlds_of_env()))

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
            self._fits_done += 1
        return observations

    @property
    def weight_average(self) -> WeightAverage:
        """Average of what the policy learns, which the policy holds except while it learns.

        A policy that was given other weights, as by `load_adaptation`, begins a new one.
        """
        weights, average = self._learned_weights(), self._average
        if average is None or not average.watches(weights):
            self._average = average = WeightAverage(weights)
        return average

    def _learned_weights(self) -> list[torch.nn.Parameter]:
        return [parameter for parameter in self.policy.actor.parameters() if parameter.requires_grad]

    def _setup_lr_schedule(self) -> None:
        """A constant for the policy's constructor: the learning rate follows the samples, not the progress."""
        self.lr_schedule = FloatSchedule(self._learning_rate_now())

    def _learning_rate_now(self) -> float:
        return value_at(cast(Schedule, self.learning_rate), self.num_timesteps)

    def predict(self, *args: Any, **kwargs: Any) -> tuple[NDArray[Any], tuple[NDArray[Any], ...] | None]:
        """Act by the average weights; as in Stable-Baselines3."""
        with self.weight_average.acting():
            return super().predict(*args, **kwargs)

    def _mean_action(self, observations: torch.Tensor, companions: NDArray[np.integer] | None = None) -> torch.Tensor:
        """Mean actions (B, J) for observations (B, 784), beside companions (B,) if there are any."""
        if not isinstance(self.observation_space, spaces.Dict):
            return self.policy.get_distribution(observations).mode()
        numbers = torch.as_tensor(companions, device=observations.device)
        return self.policy.get_distribution({FLAT: observations, COMPANION: numbers}).mode()

    def _steady_action(self, observations: NDArray[np.float32]) -> NDArray[np.float32]:
        return self.predict(observations, deterministic=True)[0]

    def save(self, *args: Any, **kwargs: Any) -> None:
        """Save, with the average as the policy; as in Stable-Baselines3."""
        with self.weight_average.acting():
            super().save(*args, **kwargs)

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
        if read != (now := self.critic.layers[0].in_features):  # older ones' did not read the strength
            raise ValueError(f"the checkpoint's critic reads {read} numbers, now there are {now}: begin the run anew")
        self._learn_by(WorldModel(self.world_model.character, Sizes.of(state["model"])))  # older ones are wider
        self.world_model.load_state_dict(state["model"])
        restore_moments(self.world_optimizer, state["optimizer"])
        self.weight_average.load_state_dict(state["latest"])
        self.norm_limit.mean = state["gradient_norm"]
        self.critic.load_state_dict(state["critic"])
        restore_moments(self.critic_optimizer, state["critic_optimizer"])
        self._fits_done, self._begun = state["fits_done"], state["begun"]
        self.rng.bit_generator.state = json.loads(state["rng"])

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "_average", "_recorded"]

    def _get_torch_save_params(self) -> tuple[list[str], list[str]]:
        learning = ["policy", "weight_average", "world_model", "critic"]
        return [*learning, "policy.optimizer", "world_optimizer", "critic_optimizer"], []
