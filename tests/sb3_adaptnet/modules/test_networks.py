"""Encoder, normaliser, base, value head: the mathematics of the parts that are trained first."""

import math

import numpy as np
import pytest
import torch
from torch import nn

from sb3_adaptnet.modules.architecture import Architecture
from sb3_adaptnet.modules.backbone import INITIAL_STD, Backbone
from sb3_adaptnet.modules.critic import Critic
from sb3_adaptnet.modules.heightmap import HeightmapEncoder
from sb3_adaptnet.modules.layers.gru import last_state
from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer, moments_of
from sb3_adaptnet.modules.layers.popart import PopArtHead
from sb3_adaptnet.modules.layers.small_conv import relu_conv
from sb3_adaptnet.modules.observation import Observation, split_observation

JOINTS = tuple(f"joint_{i}" for i in range(6))
SMALL = Architecture(JOINTS, gru_size=8, hidden_sizes=(16, 12))


def observation(batch: int = 5, heightmap: bool = False, seed: int = 0) -> Observation:
    generator = torch.Generator().manual_seed(seed)
    flat = torch.randn(batch, SMALL.observation_size, generator=generator)
    heights = torch.randn(batch, 1, 35, 35, generator=generator) if heightmap else None
    return split_observation(flat, SMALL, heights)


def random_backbone(architecture: Architecture = SMALL) -> Backbone:
    """A base whose heads are not near zero, as after training."""
    network = Backbone(architecture)
    nn.init.normal_(network.mean.weight, std=0.3)
    nn.init.normal_(network.mean.bias, std=0.3)
    network.normalizer.observe(moments_of(torch.randn(50, architecture.frame_size) * 2 + 1))
    return network


def test_observation_index_is_frame_major_then_goal():
    flat = torch.arange(784.0).repeat(2, 1)
    parts = split_observation(flat, Architecture(JOINTS))
    assert parts.frames.shape == (2, 4, 195)
    assert parts.frames[0, 3, 14 * 13 + 12] == (3 * 15 + 14) * 13 + 12
    assert parts.goal[1].tolist() == [780.0, 781.0, 782.0, 783.0]


def test_observation_of_another_width_is_refused():
    with pytest.raises(ValueError, match="783.*784"):
        split_observation(torch.zeros(1, 783), Architecture(JOINTS))


# -- GRU -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("steps", [1, 4])
def test_gru_and_its_gradients_equal_torch(steps):
    gru = nn.GRU(7, 5, batch_first=True).double()
    frames = torch.randn(3, steps, 7, dtype=torch.float64, requires_grad=True)
    wanted = gru(frames)[1][0]
    weights = (*gru.parameters(), frames)
    direction = torch.randn(3, 5, dtype=torch.float64)
    expected = torch.autograd.grad((wanted * direction).sum(), weights)
    # last_state returns float32; the computation itself is in the frames' type
    state = last_state(frames, gru)
    assert torch.allclose(state.double(), wanted, atol=1e-6)
    found = torch.autograd.grad((state * direction.float()).sum(), weights)
    for ours, theirs in zip(found, expected, strict=True):
        assert torch.allclose(ours.double(), theirs, atol=1e-6)


def test_gru_in_bfloat16_is_close_and_differentiable():
    gru = nn.GRU(20, 16, batch_first=True)
    frames = torch.randn(64, 4, 20)
    with torch.autocast("cpu", torch.bfloat16):
        state = last_state(frames, gru)
    assert state.dtype == torch.float32
    assert torch.allclose(state, gru(frames)[1][0], atol=0.03)
    state.square().sum().backward()
    found = gru.weight_hh_l0.grad.clone()
    gru.zero_grad()
    gru(frames)[1][0].square().sum().backward()
    assert (found - gru.weight_hh_l0.grad).norm() < 0.03 * gru.weight_hh_l0.grad.norm()


# -- normaliser ----------------------------------------------------------------------------------------------------


def test_normalizer_statistics_equal_those_of_all_samples():
    data = np.random.default_rng(0).normal(3.0, 2.0, (1000, 4, 5)).astype(np.float32)
    normalizer = RunningNormalizer(5)
    for start in range(0, 1000, 130):
        normalizer.observe(moments_of(torch.from_numpy(data[start : start + 130])))
    flat = data.reshape(-1, 5).astype(np.float64)
    assert normalizer.count == 4000
    assert np.allclose(normalizer.running_mean, flat.mean(0), atol=1e-6)
    assert np.allclose(normalizer.running_var, flat.var(0), atol=1e-5)


def test_normalizer_moves_only_when_applied_but_takes_the_first_batch_at_once():
    normalizer = RunningNormalizer(2)
    normalizer.observe(moments_of(torch.tensor([[1.0, 0.0], [3.0, 4.0]])))
    assert torch.allclose(normalizer.mean, torch.tensor([2.0, 2.0]))
    before = normalizer(torch.ones(1, 2))
    normalizer.observe(moments_of(torch.randn(100, 2) * 9))
    assert torch.equal(normalizer(torch.ones(1, 2)), before)
    normalizer.apply_statistics()
    assert not torch.equal(normalizer(torch.ones(1, 2)), before)


def test_normalizer_clamps_to_five_standard_deviations_and_survives_constants():
    normalizer = RunningNormalizer(2)
    normalizer.observe(moments_of(torch.tensor([[1.0, 7.0], [3.0, 7.0]])))
    assert normalizer(torch.tensor([[1000.0, 7.0], [-1000.0, 1e6]])).tolist() == [[5.0, 0.0], [-5.0, 5.0]]


def test_copied_statistics_can_still_move():
    base = RunningNormalizer(1)
    base.observe(moments_of(torch.randn(4000, 1)))
    base.count.fill_(1e9)
    own = RunningNormalizer(1)
    own.start_at(base, 1000)
    assert torch.equal(own.mean, base.mean)
    own.observe(moments_of(torch.randn(1000, 1) + 10))
    own.apply_statistics()
    assert own.mean.item() == pytest.approx(5.0, abs=0.3)


# -- base ----------------------------------------------------------------------------------------------------------


def test_fresh_base_acts_near_the_mean_pose_with_the_initial_std():
    network = Backbone(SMALL)
    pose = np.linspace(-0.5, 0.5, 6)
    network.start_at(pose.tolist())
    mean, log_std = network(observation())
    assert torch.allclose(mean, torch.tensor(pose, dtype=torch.float32).expand(5, -1), atol=0.2)
    assert torch.allclose(log_std, torch.full_like(log_std, math.log(INITIAL_STD)), atol=0.2)


def test_default_sizes_are_the_papers():
    network = Backbone(Architecture(tuple(map(str, range(28)))))
    shapes = [tuple(layer.weight.shape) for layer in network.layers]
    assert shapes == [(1024, 260), (512, 1024)]
    assert network.encoder.gru.hidden_size == 256
    assert network.mean.weight.shape == (28, 512)


def test_pruned_base_equals_the_remaining_outputs():
    network = random_backbone()
    kept = ("joint_4", "joint_0", "joint_5")
    pruned = network.with_joints(kept)
    mean, log_std = network(observation())
    few_mean, few_log_std = pruned(observation())
    assert torch.allclose(few_mean, mean[:, [4, 0, 5]], atol=1e-6)
    assert torch.allclose(few_log_std, log_std[:, [4, 0, 5]], atol=1e-6)
    assert pruned.architecture.joints == kept


def test_base_for_unknown_joints_is_refused():
    with pytest.raises(ValueError, match=r"tail.*joint_0"):
        random_backbone().with_joints(("joint_1", "tail"))


def test_heightmap_encoder_makes_256_numbers():
    code = HeightmapEncoder()(torch.randn(3, 1, 35, 35))
    assert code.shape == (3, 256)


@pytest.mark.parametrize("size, channels, kernel, stride", [(35, 1, 5, 5), (7, 8, 3, 1), (9, 4, 3, 2), (3, 8, 3, 1)])
def test_convolutions_by_patches_are_convolutions(size, channels, kernel, stride):
    torch.manual_seed(0)
    conv = torch.nn.Conv2d(channels, 6, kernel, stride).double()
    grid = 16 * torch.randn(5, channels, size, size, dtype=torch.float64)  # some outputs reach both ends of ReLU6
    outs, grads = [], []
    for layer in (
        lambda g: torch.nn.functional.relu6(conv(g)),
        lambda g: relu_conv(g.permute(0, 2, 3, 1), conv).permute(0, 3, 1, 2),
    ):
        leaf = grid.clone().requires_grad_()
        out = layer(leaf)
        grads.append(torch.autograd.grad(out.square().sum(), [leaf, conv.weight, conv.bias]))
        outs.append(out)
    torch.testing.assert_close(outs[1], outs[0])
    assert (outs[0] == 0).any() and (outs[0] == 6).any()
    for ours, theirs in zip(grads[1], grads[0], strict=True):
        torch.testing.assert_close(ours, theirs, check_dtype=False)  # weights' gradients are float32


def test_heightmap_codes_in_bfloat16_are_near_those_in_float32():
    torch.manual_seed(0)
    encoder, heights = HeightmapEncoder(), torch.randn(64, 1, 35, 35)
    exact = encoder(heights)
    with torch.autocast("cpu", torch.bfloat16):
        short = encoder(heights)
    assert short.dtype == torch.bfloat16
    assert (short.float() - exact).abs().max() < 0.02 * exact.abs().max()
    wanted, found = (
        torch.autograd.grad(code.float().square().sum(), list(encoder.parameters())) for code in (exact, short)
    )
    for ours, theirs in zip(found, wanted, strict=True):
        assert torch.nn.functional.cosine_similarity(ours.flatten(), theirs.flatten(), dim=0) > 0.99


def test_base_that_reads_a_heightmap_says_when_there_is_none():
    network = Backbone(Architecture(JOINTS, gru_size=8, hidden_sizes=(16, 12), heightmap=True))
    with pytest.raises(ValueError, match="heightmap"):
        network(observation())
    flat, sloped = observation(heightmap=True), observation(heightmap=True)
    sloped = sloped._replace(heightmap=sloped.heightmap + 1.0)
    assert not torch.equal(network(flat)[0], network(sloped)[0])


# -- critic --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("objectives", [1, 2, 3])
def test_popart_update_preserves_real_outputs_and_normalises_returns(objectives):
    torch.manual_seed(objectives)
    head = PopArtHead(10, objectives).double()
    latent = torch.randn(20, 10, dtype=torch.float64)
    head.linear.double()
    for scale in (1.0, 40.0, 0.3):
        before = head.denormalize(head.linear(latent))
        returns = torch.randn(500, objectives, dtype=torch.float64) * scale + 7 * scale
        head.update(returns)
        assert torch.allclose(head.denormalize(head.linear(latent)), before, atol=1e-9)
    head = PopArtHead(10, objectives)
    head.update(returns.float())
    normalized = head.normalize(returns.float())
    assert torch.allclose(normalized.mean(0), torch.zeros(objectives), atol=1e-4)
    assert torch.allclose(normalized.std(0), torch.ones(objectives), atol=1e-2)
    assert torch.allclose(head.denormalize(normalized), returns.float(), atol=1e-4)


def test_popart_is_the_identity_before_the_first_update():
    head = PopArtHead(4, 2)
    values = torch.randn(3, 2)
    assert torch.equal(head.denormalize(values), values)
    assert torch.equal(head.normalize(values), values)


def test_popart_refuses_other_columns():
    with pytest.raises(ValueError, match=r"\(M, 2\)"):
        PopArtHead(4, 2).update(torch.zeros(5, 3))


@pytest.mark.parametrize("objectives", [1, 2, 3])
@pytest.mark.parametrize("heightmap", [False, True])
def test_critic_has_one_value_per_objective(objectives, heightmap):
    critic = Critic(SMALL, heightmap, objectives)
    assert critic(observation(heightmap=heightmap)).shape == (5, objectives)
    critic.set_objectives(4)
    assert critic(observation(heightmap=heightmap)).shape == (5, 4)
