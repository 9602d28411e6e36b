"""SVG: stochastic value gradients through a learned world model, as a Stable-Baselines3 algorithm.

Real rollouts are collected; the model is refreshed on them; the policy then descends the slope of a tracking loss,
propagated back through model and kinematics along the real states (Heess et al. 2015; Fussell et al. 2021).
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, Self, cast

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.type_aliases import GymEnv, MaybeCallback
from stable_baselines3.common.utils import update_learning_rate

from sb3_adaptnet.algorithms import checks
from sb3_adaptnet.algorithms import svg_settings as groups
from sb3_adaptnet.algorithms.cost_critic import RECENT, CriticTraining
from sb3_adaptnet.algorithms.gradient_taming import GradientTaming
from sb3_adaptnet.algorithms.imagination import imagine
from sb3_adaptnet.algorithms.joined_tracking import own_goals, tracked_worlds
from sb3_adaptnet.algorithms.model_based import ModelBasedAlgorithm
from sb3_adaptnet.algorithms.model_learning import refresh
from sb3_adaptnet.algorithms.rollouts.real_rollout import RealRollout, RolloutRecorder
from sb3_adaptnet.algorithms.rollouts.recent_rollouts import RecentRollouts
from sb3_adaptnet.algorithms.rollouts.reflection import Reflection
from sb3_adaptnet.algorithms.rollouts.strengths import acting_at
from sb3_adaptnet.algorithms.svg_log import record_means, record_rollout, record_times
from sb3_adaptnet.algorithms.svg_loss import CostToCome, LossSchedules, LossWeights, window_loss
from sb3_adaptnet.algorithms.tracking.guide import Guiding
from sb3_adaptnet.algorithms.tracking.tracked_groups import Env, TrackedMotions
from sb3_adaptnet.objectives.schedule import Schedule
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy
from sb3_adaptnet.world_model.model import WorldModel


class SVG(ModelBasedAlgorithm):
    """Adapts a policy of this package to the environment's reference motion and goals.

    Every `learn` begins new episodes in all worlds. The policy is the running average of the weights, but for callbacks
    within a rollout (`on_step`), which see the latest ones; `predict` and `save` use the average even there.

    Attributes:
        motion: what is tracked, once it learns.
    """

    def __init__(
        self,
        policy: type[ObjectivePolicy],
        env: GymEnv | None,
        world_model: str | Path | WorldModel | None = None,
        learning_rate: Schedule = 5e-4,
        n_steps: int = 32,
        window: int = 16,
        batch_size: int | None = None,
        gradient_steps: int = 6,
        recent_rollouts: int = 3,
        regression_updates: int = 300,
        average_decay: float = 0.98,
        mirror: bool = False,
        episodes: groups.Episodes | Mapping[str, Any] | None = None,
        guiding: Guiding | Mapping[str, Any] | None = None,
        exploration: groups.Exploration | Mapping[str, Any] | None = None,
        model_refresh: groups.ModelRefresh | Mapping[str, Any] | None = None,
        model_fits: groups.ModelFits | Mapping[str, Any] | None = None,
        loss_weights: LossWeights | Mapping[str, Schedule] | None = None,
        cost_to_go: groups.CostToGo | Mapping[str, Any] | None = None,
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
            env: an `AdaptVecEnv` on flat ground, or `JoinedWorlds` to learn beside companions in.
            world_model: the character's model, or its file; None for `BASE.world.safetensors` beside the policy's base;
                "new" for one that begins from nothing, as a policy without a base does.
            learning_rate: of the policy; a number, or samples -> number.
            n_steps: control steps of a rollout.
            window: control steps that gradients pass through.
            batch_size: worlds whose windows an update learns from, drawn anew each time; None for all.
            gradient_steps: updates of the policy per rollout.
            recent_rollouts: rollouts that windows are taken from; every other one is from the latest.
            regression_updates: updates of the first guess, before the first rollout; 0 for a policy that has a start.
            average_decay: what an update leaves of the running average of the weights, which is the policy.
            mirror: learn from rollouts in a mirror, too, if the motion half a cycle later is its own mirror image.
            episodes: how long they last, and what ends them.
            guiding: how the reference leads the characters to their goals.
            exploration: noise on the actions.
            model_refresh: how the model keeps up.
            model_fits: how a new model begins.
            loss_weights: of the loss's parts; each a number, or samples -> number.
            cost_to_go: the critic of what comes after a window.
            stats_window_size: episodes that the logged means are of.
            tensorboard_log: folder for TensorBoard.
            policy_kwargs: further arguments of the policy.
            verbose: as in Stable-Baselines3; from 1 on, fits of a new model show a progress bar in a terminal.
            seed: of everything.
            device: of policy and model.
            _init_setup_model: build the networks.

        Raises:
            ValueError: for an unknown or impossible setting, or worlds, policy, motion or model that do not fit.
            CheckpointError: for a model's file that cannot be read.
        """
        super().__init__(
            policy, env, world_model, learning_rate, groups.grouped(groups.ModelRefresh, model_refresh),
            groups.grouped(groups.ModelFits, model_fits), policy_kwargs, stats_window_size=stats_window_size, seed=seed,
            tensorboard_log=tensorboard_log, verbose=verbose, device=device, init_setup_model=_init_setup_model,
        )  # fmt: skip
        self.n_steps, self.window, self.regression_updates = n_steps, window, regression_updates
        self.batch_size, self.average_decay, self.mirror = batch_size, average_decay, mirror
        self.gradient_steps, self.recent_rollouts = gradient_steps, recent_rollouts
        self.episodes, self.guiding = groups.grouped(groups.Episodes, episodes), groups.grouped(Guiding, guiding)
        self.exploration = groups.grouped(groups.Exploration, exploration)
        self.loss_weights = LossSchedules.of(loss_weights)
        self.cost_to_go, self.taming = groups.grouped(groups.CostToGo, cost_to_go), GradientTaming()
        if _init_setup_model:  # `load` has its own settings
            checks.check_settings(self)

    def learn(
        self,
        total_timesteps: int,
        callback: MaybeCallback = None,
        log_interval: int = 1,
        tb_log_name: str = "SVG",
        reset_num_timesteps: bool = True,
        progress_bar: bool = False,
    ) -> Self:
        """Learn from `total_timesteps` more control steps over all worlds; as in Stable-Baselines3.

        Raises:
            ValueError: for worlds that the settings or the model do not fit, as `set_env` may bring.
        """
        checks.check_settings(self)
        env, asked = self._worlds_of_env(), (callback, reset_num_timesteps, tb_log_name, progress_bar)
        total_timesteps, callbacks = self._setup_learn(total_timesteps, *asked)  # as PPO's local is called
        self._motions = TrackedMotions.of(env, self.world_model.character, self.device, self.guiding.gaits)
        self.motion = self._motions.together
        callbacks.on_training_start(locals(), globals())
        if not (self._begun or self._n_updates):
            error, self._begun = self._begin(self.motion, self.regression_updates, progress_bar), True
            self.logger.record("svg/first_guess_error", error)
        self._critic_training = CriticTraining(
            self.critic, self.critic_optimizer, self.world_model, self.motion, self.cost_to_go, self.rng, self.logger
        )
        with own_goals(env):
            self._go_on(env, total_timesteps, callbacks, log_interval, progress_bar)
        callbacks.on_training_end()
        return self

    def _go_on(self, env: Env, samples: int, callback: BaseCallback, log_interval: int | None, shown: bool) -> None:
        """Collect and learn until there were so many samples, or a callback wants no more."""
        self._set_out(env)
        iteration = 0
        while self.num_timesteps < samples:
            if self.model_fit_is_due():
                self._fit_model(self._steady_action, shown)
                self._set_out(env)
            if not self.collect_rollout(callback):
                break
            iteration += 1
            self._update_current_progress_remaining(self.num_timesteps, samples)
            self.train()
            if log_interval is not None and iteration % log_interval == 0:
                self.dump_logs(iteration)

    def _set_out(self, env: Env) -> None:
        """Begin new episodes in all worlds, with guides, and forget past rollouts."""
        self._worlds = tracked_worlds(env, self._motions, self.episodes, self.guiding, self.rng)
        self._last_obs = self._worlds.begin(self.num_timesteps)
        reflection = Reflection.of(self.world_model.character, self.motion) if self.mirror else None
        kept = max(self.model_refresh.rollouts, self.recent_rollouts, RECENT)
        self._rollouts = RecentRollouts(kept, reflection, self.rng)

    def collect_rollout(self, callback: BaseCallback) -> bool:
        """Act in all worlds for `n_steps` control steps; returns whether the callbacks want to go on."""
        worlds, recorder, errors = self._worlds, RolloutRecorder(), list[NDArray[np.floating]]()
        worlds.schedule(self.num_timesteps)
        observations = cast(NDArray[np.float32], self._last_obs)  # an array: there is no heightmap, nor companions
        worlds.resynchronise(observations)
        self.policy.set_training_mode(False)
        callback.on_rollout_start()
        with self.weight_average.learning():
            for _ in range(self.n_steps):
                before = worlds.now()
                mean = self._mean_actions(observations, worlds.strengths, worlds.companions)
                noise = self.exploration.noise(mean.shape, self.rng)
                actions = np.clip(mean + noise, -1, 1)
                step = worlds.step(actions)
                new_obs, rewards, dones, infos = step.observations, step.rewards, step.dones, step.infos
                self.num_timesteps += self.n_envs
                callback.update_locals(locals())  # under the names that PPO's have
                if not callback.on_step():
                    return False
                self._update_info_buffer(infos, dones)
                recorder.add(before, actions, noise, step.guidance, step.ended, step.failed)
                errors.append(step.errors)
                self._last_obs = observations = new_obs
        self._rollouts.add(recorder.finish(worlds.now(), worlds.strengths, worlds.companions), worlds.left_from_behind)
        record_rollout(self.logger, np.stack(errors), worlds)
        callback.on_rollout_end()
        return True

    def train(self) -> None:
        """Refresh the model, then descend along windows of the latest rollouts."""
        self.policy.set_training_mode(True)
        self.world_model.dynamics.precision = self.policy.precision
        loss = refresh(self.world_model, self.world_optimizer, self._rollouts, self.model_refresh, self.rng)
        self.logger.record("svg/model_loss", loss)
        update_learning_rate(self.policy.optimizer, self._learning_rate_now())
        frozen, weights = self.world_model.frozen(), self.loss_weights.at(self.num_timesteps)
        to_come = self._critic_training.learned(self.num_timesteps, weights, self._rollouts.latest(RECENT))
        with self.weight_average.learning():
            chosen = self._rollouts.chosen(self.gradient_steps, self.recent_rollouts, self.batch_size)
            logs = [self._improve(frozen, rollout, weights, to_come) for rollout in chosen]
        record_means(self.logger, logs)

    def _improve(
        self, model: WorldModel, rollout: RealRollout, weights: LossWeights, to_come: CostToCome | None
    ) -> dict[str, float]:
        """One update of the policy along a window of a rollout; returns what to log."""
        part = rollout.window(rollout.drawn_starts(self.window, self.rng), self.window)
        with acting_at(self.policy, rollout.strengths), self.policy.actor.one_update(self.window):
            steps = imagine(partial(self._mean_action, companions=part.companions), model, part, self.taming)
            loss, parts = window_loss(steps, self.motion, weights, to_come)
            self.policy.optimizer.zero_grad()
            loss.backward()
        length = self.norm_limit.apply(self._learned_weights())
        self.policy.optimizer.step()
        self.weight_average.update(self.average_decay)
        self._n_updates += 1
        return {"loss": float(loss.detach()), **parts, "gradient_norm": length}

    def dump_logs(self, iteration: int = 0) -> None:
        """Write the log."""
        record_times(self, iteration)
        self.logger.dump(step=self.num_timesteps)

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "_worlds", "_rollouts", "_critic_training", "motion", "_motions"]
