"""The average is the exponential one, it is what the policy holds, and learning goes on from the latest weights."""

import numpy as np
import pytest
import torch
from stable_baselines3.common.callbacks import BaseCallback
from torch import nn

from sb3_adaptnet import save_adaptation
from sb3_adaptnet.algorithms.svg import SVG
from sb3_adaptnet.algorithms.weight_average import WeightAverage
from sb3_adaptnet.runs.saver import restore, snapshot


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


def flat(model):
    return torch.cat([p.detach().flatten() for p in model.policy.actor.parameters() if p.requires_grad])


def both(model):
    average = flat(model)
    with model.weight_average.learning():
        return average, flat(model)


def test_saving_and_checkpoints_keep_average_and_latest(make_svg, tmp_path):
    model = make_svg().learn(96)
    average, latest = both(model)
    assert not torch.equal(average, latest)
    model.save(tmp_path / "model")
    assert all(map(torch.equal, both(SVG.load(tmp_path / "model", device="cpu")), (average, latest)))
    other = make_svg()
    restore(other, None, snapshot(model, None, 0.0))
    assert all(map(torch.equal, both(other), (average, latest)))
    other.learn(48, reset_num_timesteps=False)
    assert not torch.equal(both(other)[1], latest)


def test_without_memory_the_average_is_the_latest(make_svg):
    assert torch.equal(*both(make_svg(average_decay=0.0).learn(96)))


def test_whoever_looks_from_outside_sees_the_average(make_svg, tmp_path):
    class Watcher(BaseCallback):
        def _on_step(self):
            self.predicted = self.model.predict(observations, deterministic=True)[0]
            self.model.save(tmp_path / "within")
            return True

        def _on_rollout_end(self):
            self.average = flat(self.model)
            assert np.array_equal(self.predicted, self.model.policy.predict(observations, deterministic=True)[0])

    model = make_svg()
    observations = model.env.reset()
    watcher = Watcher()
    model.learn(144, callback=watcher)
    assert torch.equal(flat(SVG.load(tmp_path / "within", device="cpu")), watcher.average)


def test_a_loaded_adaptation_begins_a_new_average(make_svg, tmp_path):
    model = make_svg().learn(48)
    file = save_adaptation(model.policy, tmp_path / "mine")
    model.learn(96, reset_num_timesteps=False)
    model.policy.load_adaptation(file)
    average, latest = both(model)
    assert torch.equal(average, latest)
    model.learn(48, reset_num_timesteps=False)
    assert not torch.equal(flat(model), average)
