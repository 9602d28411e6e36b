"""The average is what SVG's policy holds, and learning goes on from the latest weights."""

import numpy as np
import pytest
import torch
from stable_baselines3.common.callbacks import BaseCallback

from sb3_adaptnet import WeightAveraging, save_adaptation
from sb3_adaptnet.algorithms.svg import SVG
from sb3_adaptnet.runs.saver import restore, snapshot


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


def test_svg_is_not_averaged_twice(make_svg):
    with pytest.raises(ValueError, match="SVG averages its weights by itself"):
        make_svg().learn(48, callback=WeightAveraging())
