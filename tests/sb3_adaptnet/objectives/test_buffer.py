"""The K-objective buffer against numbers worked out by hand and against Stable-Baselines3's own."""

import numpy as np
import pytest
import torch
from gymnasium import spaces
from stable_baselines3.common.buffers import RolloutBuffer

from sb3_adaptnet.modules.layers.popart import PopArtHead
from sb3_adaptnet.objectives.buffer import ObjectiveRolloutBuffer, combine_advantages, generalized_advantages

BOX, ACTION = spaces.Box(-1, 1, (3,), np.float32), spaces.Box(-1, 1, (2,), np.float32)
DICT = spaces.Dict(observation=BOX, heightmap=spaces.Box(-1, 1, (1, 5, 5), np.float32))


class Identity:
    """A value normaliser that does nothing."""

    def update(self, returns):
        self.returns = returns

    def normalize(self, x):
        return x


def fill(buffer, rng, space=BOX):
    """Random steps; returns the arrays that were added."""
    steps, worlds, k = buffer.buffer_size, buffer.n_envs, getattr(buffer, "num_objectives", 1)
    rows = []
    for step in range(steps):
        obs = (
            {name: s.sample()[None].repeat(worlds, 0) for name, s in space.items()}
            if space is DICT
            else (rng.standard_normal((worlds, 3)).astype(np.float32))
        )
        starts = (rng.random(worlds) < 0.3) if step else np.ones(worlds, bool)
        values = torch.from_numpy(rng.standard_normal((worlds, k)).astype(np.float32))
        reward, log_prob = rng.standard_normal(worlds), torch.randn(worlds)
        action = rng.standard_normal((worlds, 2)).astype(np.float32)
        buffer.add(obs, action, reward, starts, values, log_prob)
        rows.append((obs, action, reward, starts, values, log_prob))
    return rows


def test_gae_by_hand():
    """Two steps, one world, one objective, gamma 0.5, lambda 0.5, then the same with a done in between."""
    rewards, values = np.array([[[1.0]], [[2.0]]]), np.array([[[0.5]], [[1.0]]])
    last, going = np.array([[4.0]]), np.zeros((2, 1), bool)
    # delta_1 = 2 + 0.5 * 4 - 1 = 3; delta_0 = 1 + 0.5 * 1 - 0.5 = 1; A_1 = 3, A_0 = 1 + 0.25 * 3
    np.testing.assert_allclose(generalized_advantages(rewards, values, last, going, 0.5, 0.5).ravel(), [1.75, 3.0])
    ended = np.array([[True], [False]])
    # delta_0 = 1 - 0.5, and nothing of the next episode reaches it
    np.testing.assert_allclose(generalized_advantages(rewards, values, last, ended, 0.5, 0.5).ravel(), [0.5, 3.0])
    # the last step ended: no value of the state after it
    ended = np.array([[False], [True]])
    np.testing.assert_allclose(generalized_advantages(rewards, values, last, ended, 0.5, 0.5).ravel(), [1.25, 1.0])


@pytest.mark.parametrize("k", [1, 2, 3])
def test_gae_equals_sb3_in_every_column(k):
    rng = np.random.default_rng(k)
    steps, worlds = 7, 5
    rewards = rng.standard_normal((steps, worlds, k)).astype(np.float32)
    values = rng.standard_normal((steps, worlds, k)).astype(np.float32)
    starts = rng.random((steps, worlds)) < 0.3
    last, last_dones = rng.standard_normal((worlds, k)).astype(np.float32), rng.random(worlds) < 0.5
    dones = np.concatenate([starts[1:], last_dones[None]])
    ours = generalized_advantages(rewards, values, last, dones, 0.95, 0.9)
    for column in range(k):
        stock = RolloutBuffer(steps, BOX, ACTION, device="cpu", gamma=0.95, gae_lambda=0.9, n_envs=worlds)
        stock.rewards, stock.values = rewards[..., column], values[..., column]
        stock.episode_starts = starts.astype(np.float32)
        stock.compute_returns_and_advantage(torch.from_numpy(last[:, column]), last_dones)
        np.testing.assert_allclose(ours[..., column], stock.advantages, rtol=1e-5, atol=1e-6)


def test_combination_by_hand():
    advantages = np.stack([[[1.0, 3.0]], [[10.0, 30.0]]], axis=-1)  # (1, 2, 2): both standardise to -1, 1
    np.testing.assert_allclose(combine_advantages(advantages, (0.35, 0.65)), [[-1.0, 1.0]], rtol=1e-6)
    opposed = np.stack([[[1.0, 3.0]], [[30.0, 10.0]]], axis=-1)
    np.testing.assert_allclose(combine_advantages(opposed, (0.35, 0.65)), [[0.3, -0.3]], rtol=1e-6)
    constant = np.zeros((2, 2, 1))
    assert np.array_equal(combine_advantages(constant, (1.0,)), np.zeros((2, 2)))


@pytest.mark.parametrize("space", [BOX, DICT], ids=["box", "dict"])
@pytest.mark.parametrize("k", [1, 2, 3])
def test_samples_are_the_rows_that_were_added(space, k):
    rng = np.random.default_rng(0)
    buffer = ObjectiveRolloutBuffer(
        4, space, ACTION, device="cpu", gamma=0.9, gae_lambda=0.9, n_envs=3, num_objectives=k
    )
    rows = fill(buffer, rng, space)
    buffer.compute_returns_and_advantage(torch.zeros(3, 1), np.zeros(3, bool))
    rewards = rng.standard_normal((4, 3, k)).astype(np.float32)
    buffer.finish(rewards, np.zeros((3, k), np.float32), [1.0 / k] * k, Identity())
    batches = list(buffer.get(5))
    assert [len(batch.actions) for batch in batches] == [5, 5, 2]
    added = np.concatenate([row[1] for row in rows])
    values = torch.cat([row[4] for row in rows])
    returns = buffer.returns.reshape(12, k)
    seen = []
    for batch in batches:
        batch_values = batch.old_values.reshape(-1, k)
        for i, action in enumerate(batch.actions.numpy()):
            (row,) = np.flatnonzero((added == action).all(axis=1))
            seen.append(row)
            torch.testing.assert_close(batch_values[i], values[row])
            np.testing.assert_allclose(batch.returns.reshape(-1, k)[i].numpy(), returns[row], rtol=1e-6)
            observation = rows[row // 3][0]
            if space is DICT:
                np.testing.assert_array_equal(batch.observations["heightmap"][i], observation["heightmap"][row % 3])
            else:
                np.testing.assert_array_equal(batch.observations[i], observation[row % 3])
    assert sorted(seen) == list(range(12))


def test_returns_are_normalised_and_the_critic_keeps_its_outputs():
    torch.manual_seed(0)
    rng = np.random.default_rng(0)
    head, latent = PopArtHead(6, 2), torch.randn(9, 6)
    before = head.denormalize(head(latent))
    buffer = ObjectiveRolloutBuffer(
        8, BOX, ACTION, device="cpu", gamma=0.9, gae_lambda=0.9, n_envs=16, num_objectives=2
    )
    fill(buffer, rng)
    buffer.compute_returns_and_advantage(torch.zeros(16, 1), np.zeros(16, bool))
    rewards = (rng.standard_normal((8, 16, 2)) * [1.0, 50.0] + [0.0, 100.0]).astype(np.float32)
    buffer.finish(rewards, np.zeros((16, 2), np.float32), [0.5, 0.5], head)
    torch.testing.assert_close(head.denormalize(head(latent)), before, rtol=1e-4, atol=1e-3)
    (batch,) = buffer.get()
    normalised = batch.returns.reshape(-1, 2)
    torch.testing.assert_close(normalised.mean(0), torch.zeros(2), atol=1e-4, rtol=0)
    torch.testing.assert_close(normalised.std(0, correction=0), torch.ones(2), atol=1e-4, rtol=0)


def test_refuses_samples_before_the_callback_finished():
    buffer = ObjectiveRolloutBuffer(2, BOX, ACTION, device="cpu", n_envs=2, num_objectives=2)
    fill(buffer, np.random.default_rng(0))
    with pytest.raises(RuntimeError, match="DiscriminatorRewardCallback"):
        next(buffer.get(2))
