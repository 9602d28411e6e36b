"""The average is the exponential one; PPO's policy holds it after learning, and learns from the latest weights."""

import pytest
import torch
from objective_cases import make_model
from stable_baselines3.common.callbacks import BaseCallback, CallbackList
from torch import nn
from torch.nn.utils import parameters_to_vector
from toy_env import ToyVectorEnv

from sb3_adaptnet import AdaptVecEnv, WeightAveraging
from sb3_adaptnet.objectives.weight_average import WeightAverage


def test_it_is_the_exponential_moving_average():
    weight = nn.Parameter(torch.tensor([7.0]))
    average = WeightAverage([weight])
    expected = None
    for value in (1.0, 2.0, -3.0):
        with average.learning():
            weight.data.fill_(value)
            average.update(0.9)
        expected = value if expected is None else 0.9 * expected + 0.1 * value
        assert weight.item() == pytest.approx(expected)
        with average.learning():
            assert weight.item() == value


def test_an_error_while_learning_leaves_the_average():
    weight = nn.Parameter(torch.tensor([0.0]))
    average = WeightAverage([weight])
    for value in (0.0, 1.0):
        with average.learning():
            weight.data.fill_(value)
            average.update(0.5)
    with pytest.raises(KeyError), average.learning():
        raise KeyError
    assert weight.item() == 0.5


class Weights(BaseCallback):
    """The actor's weights at the end of each rollout, which are the latest."""

    def _on_training_start(self):
        self.seen = []

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        self.seen.append(flat(self.model))


def flat(model):
    return parameters_to_vector(model.policy.actor.parameters()).detach().clone()


def test_ppo_acts_by_the_latest_weights_and_ends_with_their_average():
    model, averaging, weights = make_model(AdaptVecEnv(ToyVectorEnv(4))), WeightAveraging(0.5), Weights()
    both = CallbackList([averaging, weights])
    model.learn(3 * 4 * model.n_steps, callback=both)
    first, second, third = weights.seen
    assert not torch.equal(first, second)
    with averaging.average.learning():
        last = flat(model)
    torch.testing.assert_close(flat(model), 0.25 * second + 0.25 * third + 0.5 * last)
    model.learn(4 * model.n_steps, callback=both, reset_num_timesteps=False)
    assert torch.equal(weights.seen[0], last)


def test_ppo_goes_on_from_the_latest_weights_and_the_average_after_a_resume():
    model, averaging = make_model(AdaptVecEnv(ToyVectorEnv(4))), WeightAveraging(0.5)
    model.learn(2 * 4 * model.n_steps, callback=averaging)
    held, state = flat(model), averaging.state_dict()
    resumed = WeightAveraging(0.5)
    resumed.init_callback(make_model(AdaptVecEnv(ToyVectorEnv(4))))
    resumed.model.policy.load_state_dict(model.policy.state_dict())
    resumed.load_state_dict(state)
    resumed.model.learn(4 * model.n_steps, callback=resumed, reset_num_timesteps=False)
    with resumed.average.learning():
        latest = flat(resumed.model)
    torch.testing.assert_close(flat(resumed.model), (held + latest) / 2)


@pytest.mark.parametrize("decay", [1.0, -0.1])
def test_an_average_over_all_gets_a_sentence(decay):
    with pytest.raises(ValueError, match=f"decay of an average must be .* at least 0 and below 1, not {decay}"):
        WeightAveraging(decay)
