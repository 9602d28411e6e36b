"""AdaptNet's actor against the paper's equations: injection, adaptors, blending, penalties."""

import pytest
import torch
from network_cases import (
    NO_PENALTY,
    SHAPES,
    adapt,
    disturb,
    gradients,
    loss_of,
    make_base,
    observation,
    two_adaptations,
)
from torch.nn import functional

from sb3_adaptnet.modules.adaptation.adapted import AdaptedActor, Penalties
from sb3_adaptnet.modules.architecture import AdaptationShape
from sb3_adaptnet.modules.observation import Observation


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


def test_blend_refuses_unknown_names_and_infinite_weights():
    _, actor = two_adaptations()
    with pytest.raises(ValueError, match=r"moonwalk.*stoop.*limp"):
        actor.blend({"moonwalk": 1.0})
    with pytest.raises(ValueError, match="finite"):
        actor.blend({"stoop": float("nan")})


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


def test_one_update_of_many_passes_has_the_gradient_of_one():
    """The mean over passes of the same batch has the same gradient as one pass, penalties included."""
    actor, batch = adapt(make_base(), SHAPES["adaptnet"], Penalties(0.3, 0.2)), observation()
    disturb(actor.adaptations)

    def gradient(passes):
        actor.zero_grad()
        with actor.one_update(passes):
            torch.stack([actor(batch)[0].square().mean() for _ in range(passes)]).mean().backward()
        return torch.cat([p.grad.flatten() for p in actor.parameters() if p.grad is not None])

    assert torch.allclose(gradient(5), gradient(1), rtol=1e-4, atol=1e-7)
    assert actor.penalties == Penalties(0.3, 0.2)
