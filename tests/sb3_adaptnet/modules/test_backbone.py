"""The base: its start, its sizes, fewer joints, heightmaps."""

import math

import numpy as np
import pytest
import torch
from network_cases import JOINTS, SMALL, make_base, observation

from sb3_adaptnet.modules.architecture import Architecture
from sb3_adaptnet.modules.backbone import INITIAL_STD, Backbone


def test_fresh_base_acts_near_the_mean_pose_with_the_initial_std():
    network = Backbone(SMALL)
    pose = np.linspace(-0.5, 0.5, 6)
    network.start_at(pose.tolist())
    mean, log_std = network(observation(5, False))
    assert torch.allclose(mean, torch.tensor(pose, dtype=torch.float32).expand(5, -1), atol=0.2)
    assert torch.allclose(log_std, torch.full_like(log_std, math.log(INITIAL_STD)), atol=0.2)


def test_default_sizes_are_the_papers():
    network = Backbone(Architecture(tuple(map(str, range(28)))))
    shapes = [tuple(layer.weight.shape) for layer in network.layers]
    assert shapes == [(1024, 260), (512, 1024)]
    assert network.encoder.gru.hidden_size == 256
    assert network.mean.weight.shape == (28, 512)


def test_pruned_base_equals_the_remaining_outputs():
    network = make_base()
    kept = ("joint_4", "joint_0", "joint_5")
    pruned = network.with_joints(kept)
    mean, log_std = network(observation(5, False))
    few_mean, few_log_std = pruned(observation(5, False))
    assert torch.allclose(few_mean, mean[:, [4, 0, 5]], atol=1e-6)
    assert torch.allclose(few_log_std, log_std[:, [4, 0, 5]], atol=1e-6)
    assert pruned.architecture.joints == kept


def test_base_for_unknown_joints_is_refused():
    with pytest.raises(ValueError, match=r"tail.*joint_0"):
        make_base().with_joints(("joint_1", "tail"))


def test_base_that_reads_a_heightmap_says_when_there_is_none():
    network = Backbone(Architecture(JOINTS, gru_size=8, hidden_sizes=(16, 12), heightmap=True))
    with pytest.raises(ValueError, match="heightmap"):
        network(observation(5, False))
    flat, sloped = observation(5), observation(5)
    sloped = sloped._replace(heightmap=sloped.heightmap + 1.0)
    assert not torch.equal(network(flat)[0], network(sloped)[0])
