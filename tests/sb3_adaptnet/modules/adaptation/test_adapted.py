"""Injector, adaptors, blending, merging and regularisers against the paper's equations."""

import pytest
import torch
from torch import nn
from torch.nn import functional

from sb3_adaptnet.modules.adaptation.adapted import Adaptation, AdaptedActor, Penalties
from sb3_adaptnet.modules.adaptation.anchored import AnchoredActor
from sb3_adaptnet.modules.adaptation.merge import merge
from sb3_adaptnet.modules.adaptation.progressive import ProgressiveActor
from sb3_adaptnet.modules.architecture import AdaptationShape, Architecture
from sb3_adaptnet.modules.backbone import Backbone
from sb3_adaptnet.modules.layers.normalizer import moments_of
from sb3_adaptnet.modules.layers.regularizers import penalise_injections, penalise_parameters
from sb3_adaptnet.modules.observation import Observation, split_observation

SMALL = Architecture(tuple(f"joint_{i}" for i in range(6)), gru_size=8, hidden_sizes=(16, 12))
SHAPES = {
    "adaptnet": AdaptationShape(),
    "z1": AdaptationShape(injection="z1"),
    "z2": AdaptationShape(injection="z2"),
    "all": AdaptationShape(injection="all"),
    "no_encoder": AdaptationShape(own_encoder=False),
    "no_adaptors": AdaptationShape(adaptors=None),
    "no_injector": AdaptationShape(injector=False),
    "lora": AdaptationShape(adaptors="lora", rank=3),
    "heightmap": AdaptationShape(heightmap=True),
}
NO_PENALTY = Penalties(0.0, 0.0)


@pytest.fixture(autouse=True)
def _seed():
    torch.manual_seed(0)


def observation(batch: int = 7, seed: int = 0) -> Observation:
    generator = torch.Generator().manual_seed(seed)
    flat = torch.randn(batch, SMALL.observation_size, generator=generator)
    return split_observation(flat, SMALL, torch.randn(batch, 1, 35, 35, generator=generator))


def make_base() -> Backbone:
    base = Backbone(SMALL)
    nn.init.normal_(base.mean.weight, std=0.3)
    base.normalizer.observe(moments_of(torch.randn(50, SMALL.frame_size) * 2 + 1))
    return base


def adapt(base: Backbone, shape: AdaptationShape, penalties: Penalties = NO_PENALTY) -> AdaptedActor:
    adaptation = Adaptation(SMALL, shape)
    adaptation.start_from(base)
    return AdaptedActor(base, {"main": adaptation}, penalties)


def disturb(module: nn.Module, scale: float = 0.1) -> None:
    """As if trained: no parameter is left at zero."""
    with torch.no_grad():
        for parameter in module.parameters():
            parameter.add_(torch.randn_like(parameter) * scale)


@pytest.mark.parametrize("name", SHAPES)
def test_adapted_equals_base_bit_for_bit_at_the_start(name):
    base = make_base()
    wanted = base(observation())
    found = adapt(base, SHAPES[name])(observation())
    assert all(torch.equal(ours, theirs) for ours, theirs in zip(found, wanted, strict=True))


@pytest.mark.parametrize("name", SHAPES)
def test_trained_adaptation_changes_actions_and_alpha_zero_is_the_base_bit_for_bit(name):
    base = make_base()
    actor = adapt(base, SHAPES[name])
    disturb(actor.adaptations)
    mean, _ = base(observation())
    assert not torch.allclose(actor(observation())[0], mean, atol=1e-3)
    actor.alpha = 0.0
    assert torch.equal(actor(observation())[0], mean)


def test_forward_is_the_interpolation_equation():
    """Eqs. 4, 5, 7 and the interpolation of sec. 8.1, written out once more."""
    base = make_base()
    actor = adapt(base, SHAPES["heightmap"])
    disturb(actor.adaptations)
    actor.alpha = 0.7
    obs, part = observation(), actor.parts()["main"]
    code = part.injector.encoder.gru(part.injector.normalizer(obs.frames))[1][0]
    code = torch.cat((code, obs.goal, part.injector.heightmap(obs.heightmap)), dim=1)
    latent = base.encode(obs) + 0.7 * part.injector.maps[0](code)
    for layer, adaptor in zip(base.layers, part.adaptors, strict=True):
        increment = functional.linear(latent, adaptor.weight, adaptor.bias)
        latent = functional.relu6(layer(latent) + 0.7 * increment)
    assert torch.allclose(actor(obs)[0], base.mean(latent), atol=1e-5)


@pytest.mark.parametrize("name", SHAPES)
def test_gradients_reach_the_adaptation_and_nothing_else(name):
    actor = adapt(make_base(), SHAPES[name], Penalties())
    disturb(actor.adaptations, 0.01)
    mean, log_std = actor(observation())
    (mean.square().sum() + log_std.sum()).backward()
    assert all(p.grad is None for p in actor.base.parameters())
    assert all(p.grad is not None and p.grad.abs().sum() > 0 for p in actor.adaptations.parameters())


def test_injector_starts_at_the_bases_encoder_and_statistics():
    base = make_base()
    injector = adapt(base, AdaptationShape()).parts()["main"].injector
    for ours, theirs in zip(injector.encoder.parameters(), base.encoder.parameters(), strict=True):
        assert torch.equal(ours, theirs)
        assert ours.data_ptr() != theirs.data_ptr()
    assert torch.equal(injector.normalizer.mean, base.normalizer.mean)


def test_only_the_injectors_statistics_learn():
    base = make_base()
    actor = adapt(base, AdaptationShape())
    assert actor.normalizers() == [actor.parts()["main"].injector.normalizer]
    assert adapt(base, AdaptationShape(own_encoder=False)).normalizers() == []


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("alpha", [1.0, 0.4])
def test_merged_equals_unmerged(name, alpha):
    actor = adapt(make_base(), SHAPES[name])
    disturb(actor.adaptations)
    actor.alpha = alpha
    merged = merge(actor)
    for ours, theirs in zip(merged(observation()), actor(observation()), strict=True):
        assert torch.allclose(ours, theirs, atol=1e-5)
    assert all(part.adaptors is None for part in merged.parts().values())


def two_adaptations() -> tuple[Backbone, AdaptedActor]:
    base = make_base()
    parts = {"stoop": Adaptation(SMALL, AdaptationShape()), "limp": Adaptation(SMALL, SHAPES["lora"])}
    for part in parts.values():
        part.start_from(base)
        disturb(part)
    return base, AdaptedActor(base, parts, NO_PENALTY)


def test_blend_with_one_weight_is_that_adaptation_alone_and_switching_works_while_running():
    base, actor = two_adaptations()
    for name in ("stoop", "limp", "stoop"):
        actor.blend({name: 1.0})
        alone = AdaptedActor(base, {name: actor.parts()[name]}, NO_PENALTY)
        assert torch.equal(actor(observation())[0], alone(observation())[0])


def test_blend_of_two_adds_scaled_injections_and_increments():
    base, actor = two_adaptations()
    actor.blend({"stoop": 0.3, "limp": 0.7})
    actor.alpha = 0.5
    obs = observation()
    latent = base.encode(obs)
    stoop, limp = (actor.parts()[name] for name in ("stoop", "limp"))
    offsets = [part.injections(obs, latent, 0.0)[0] for part in (stoop, limp)]
    assert torch.allclose(actor.injections(obs, latent)[0], 0.15 * offsets[0] + 0.35 * offsets[1], atol=1e-6)
    weight = base.layers[1].weight + 0.15 * stoop.adaptors[1].weight
    weight = weight + 0.35 * limp.adaptors[1].up @ limp.adaptors[1].down
    assert torch.allclose(actor.hidden_layers()[1][0], weight, atol=1e-6)


def test_blend_merges_too():
    _, actor = two_adaptations()
    actor.blend({"stoop": 0.3, "limp": 0.7})
    assert torch.allclose(merge(actor)(observation())[0], actor(observation())[0], atol=1e-5)


def test_blend_refuses_unknown_names_and_infinite_weights():
    _, actor = two_adaptations()
    with pytest.raises(ValueError, match=r"moonwalk.*stoop.*limp"):
        actor.blend({"moonwalk": 1.0})
    with pytest.raises(ValueError, match="finite"):
        actor.blend({"stoop": float("nan")})


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"adaptors": "half"}, "full.*lora"),
        ({"rank": 0}, "at least 1"),
        ({"injector": False, "heightmap": True}, "injector"),
    ],
)
def test_impossible_shapes_are_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        AdaptationShape(**wrong)


def test_unknown_injection_lists_the_latent_spaces():
    with pytest.raises(ValueError, match=r"z0.*z1.*z2.*all.*z7"):
        Adaptation(SMALL, AdaptationShape(injection="z7"))


# -- regularisers (eq. 12) -----------------------------------------------------------------------------------------


def loss_of(actor: nn.Module, obs: Observation) -> torch.Tensor:
    mean, _ = actor(obs)
    return (mean * torch.linspace(-1, 1, mean.numel()).view_as(mean)).mean()


def gradients(actor: nn.Module, loss: torch.Tensor) -> list[torch.Tensor]:
    actor.zero_grad()
    loss.backward()
    return [p.grad.clone() for p in actor.parameters() if p.requires_grad]


def explicit_penalty(actor: AdaptedActor, obs: Observation, beta: float, kappa: float) -> torch.Tensor:
    part = actor.parts()["main"]
    penalty = torch.zeros(())
    if part.injector is not None:
        offsets = part.injector(obs, actor.base.encode(obs))
        everything = torch.cat(list(offsets.values()), dim=1)
        penalty = penalty + beta * torch.linalg.vector_norm(everything, dim=1).mean()
    if part.adaptors is not None:
        eta = torch.cat([p.flatten() for p in part.adaptors.parameters()])
        penalty = penalty + kappa * torch.linalg.vector_norm(eta)
    return penalty


@pytest.mark.parametrize("name", SHAPES)
def test_penalties_equal_an_explicit_loss(name):
    actor = adapt(make_base(), SHAPES[name])
    disturb(actor.adaptations)
    obs, beta, kappa = observation(), 0.3, 0.2
    expected = gradients(actor, loss_of(actor, obs) + explicit_penalty(actor, obs, beta, kappa))
    plain = gradients(actor, loss_of(actor, obs))
    actor.penalties = Penalties(beta, kappa)
    found = gradients(actor, loss_of(actor, obs))
    for ours, theirs in zip(found, expected, strict=True):
        assert torch.allclose(ours, theirs, atol=1e-6, rtol=1e-4)  # float32 through four convolutions
    assert any(not torch.allclose(ours, theirs, atol=1e-4) for ours, theirs in zip(found, plain, strict=True))


def test_penalty_gradients_are_exact():
    generator = torch.Generator().manual_seed(0)
    x, y = (torch.randn(9, width, generator=generator, dtype=torch.float64, requires_grad=True) for width in (4, 6))
    norms = torch.linalg.vector_norm(torch.cat((x, y), dim=1), dim=1)
    expected = torch.autograd.grad((x**3).sum() + (y**2).sum() + 0.3 * norms.mean(), (x, y))
    attached = penalise_injections({0: x, 2: y}, 0.3)
    found = torch.autograd.grad((attached[0] ** 3).sum() + (attached[2] ** 2).sum(), (x, y))
    joint = torch.linalg.vector_norm(torch.cat((x.flatten(), y.flatten())))
    expected += torch.autograd.grad((x**3).sum() + (y**2).sum() + 0.3 * joint, (x, y))
    a, b = penalise_parameters([x, y], 0.3)
    found += torch.autograd.grad((a**3).sum() + (b**2).sum(), (x, y))
    for ours, theirs in zip(found, expected, strict=True):
        assert torch.allclose(ours, theirs, atol=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_penalties_at_the_zero_start_have_no_gradient_and_no_nan(name):
    actor = adapt(make_base(), SHAPES[name])
    plain = gradients(actor, loss_of(actor, observation()))
    actor.penalties = Penalties(5.0, 0.0)
    with_beta = gradients(actor, loss_of(actor, observation()))
    assert all(torch.equal(ours, theirs) for ours, theirs in zip(with_beta, plain, strict=True))
    actor.penalties = Penalties(5.0, 5.0)
    assert all(torch.isfinite(g).all() for g in gradients(actor, loss_of(actor, observation())))


def test_penalties_do_not_change_the_output():
    actor = adapt(make_base(), AdaptationShape(), Penalties(1.0, 1.0))
    disturb(actor.adaptations)
    mean = actor(observation())[0]
    actor.penalties = NO_PENALTY
    assert torch.equal(actor(observation())[0], mean)


def test_anchor_penalty_equals_an_explicit_loss():
    base = make_base()
    network = Backbone(SMALL)
    network.load_state_dict(base.state_dict())
    network.log_std.requires_grad_(False)
    actor = AnchoredActor(network, base, kappa=0.2)
    disturb(network)
    known = dict(base.named_parameters())
    drift = [p - known[name] for name, p in network.named_parameters() if p.requires_grad]
    distance = torch.linalg.vector_norm(torch.cat([d.flatten() for d in drift]))
    expected = torch.autograd.grad(
        loss_of(network, observation()) + 0.2 * distance, [p for p in network.parameters() if p.requires_grad]
    )
    found = gradients(actor, loss_of(actor, observation()))
    for ours, theirs in zip(found, expected, strict=True):
        assert torch.allclose(ours, theirs, atol=1e-7, rtol=1e-5)


def test_anchor_penalty_at_the_anchor_is_zero():
    base = make_base()
    network = Backbone(SMALL)
    network.load_state_dict(base.state_dict())
    network.log_std.requires_grad_(False)
    plain = gradients(network, loss_of(network, observation()))
    anchored = AnchoredActor(network, base, kappa=3.0)
    found = gradients(anchored, loss_of(anchored, observation()))
    assert all(torch.equal(ours, theirs) for ours, theirs in zip(found, plain, strict=True))


# -- progressive network -------------------------------------------------------------------------------------------


def test_progressive_column_learns_and_reads_the_frozen_base():
    base = make_base()
    actor = ProgressiveActor(base, heightmap=True)
    actor.start_from_base()
    mean, log_std = actor(observation())
    assert torch.equal(log_std, base(observation())[1])
    (mean.square().sum()).backward()
    learning = [p for p in actor.parameters() if p.requires_grad]
    assert all(p.grad is not None for p in learning)
    assert all(p.grad is None for p in base.parameters())
    with torch.no_grad():
        base.encoder.gru.bias_ih_l0.add_(1.0)
    assert not torch.allclose(actor(observation())[0], mean, atol=1e-4)
