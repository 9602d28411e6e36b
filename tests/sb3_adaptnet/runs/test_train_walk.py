"""A short real training: a small base learns to stay on its feet longer."""

import numpy as np
import pytest
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback

from sb3_adaptnet import AdaptVecEnv, DiscriminatorRewardCallback, PretrainPolicy

SAMPLES = 80_000


class Lengths(BaseCallback):
    """Mean length of the episodes that ended in each rollout."""

    def __init__(self, discriminators):
        super().__init__()
        self.discriminators, self.means = discriminators, []

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        self.means.append(self.discriminators.metrics.get("episode_length", np.nan))


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow), pytest.param(2, marks=pytest.mark.slow)])
def test_episodes_grow_longer(seed):
    """The mean over the last tenth of the rollouts is at least 1.1 times that of the first full-length ones."""
    env = AdaptVecEnv("AdaptNet/Humanoid-Walk-v0", num_envs=256, seed=seed, stagger=False)
    callback = DiscriminatorRewardCallback(
        kl_range=(0.03, 0.08),
        actor_lr_range=(1e-6, 2e-3),
        discriminator={"share": 0.25, "network": {"gru": 32, "hidden": [32]}},
    )
    model = PPO(
        PretrainPolicy,
        env,
        n_steps=8,
        batch_size=512,
        n_epochs=5,
        gamma=0.95,
        learning_rate=1e-3,
        max_grad_norm=1.0,
        policy_kwargs={"gru_size": 32, "hidden_sizes": (128, 64), "critic_lr": 1e-3},
        seed=seed,
    )
    lengths = Lengths(callback)
    model.learn(SAMPLES, callback=[callback, lengths])
    env.close()
    first, last = np.nanmean(lengths.means[4:12]), np.nanmean(lengths.means[-8:])
    assert last > 1.1 * first, (first, last)
