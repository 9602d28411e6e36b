"""The critic learns what states lead to, acts when it knows, and slopes reach the policy through it."""

import numpy as np
import pytest
import torch
from world_cases import CHARACTER

from sb3_adaptnet.algorithms.cost_critic import CriticTraining, critic_inputs
from sb3_adaptnet.algorithms.imagination import imagine
from sb3_adaptnet.algorithms.svg import SVG
from sb3_adaptnet.algorithms.svg_loss import state_costs, window_loss
from sb3_adaptnet.algorithms.svg_settings import CostToGo
from sb3_adaptnet.runs.saver import restore, snapshot
from sb3_adaptnet.world_model.model import Sizes, WorldModel

SHORT = {"updates": (6, 2)}


@pytest.fixture
def svg(make_svg):
    return make_svg(episodes={"steps": (3, 9), "loose_share": 0}, cost_to_go={**SHORT, "average_decay": 0.9}).learn(96)


def window(svg, steps=4):
    return imagine(svg._mean_action, svg.world_model.frozen(), svg._rollouts.latest(1)[0].window(1, steps))


def test_it_reads_real_and_imagined_states_alike(svg):
    svg.collect_rollout(quiet())
    judged = svg._critic_training._judged(svg._rollouts.latest(1)[0], svg.loss_weights.at(0))
    read = judged.inputs.view(*judged.costs.shape, -1)
    with torch.no_grad(), svg.weight_average.learning():
        steps = list(window(svg))
    on = steps[-1].guided.weights.bool()
    for number, step in enumerate(steps, start=1):
        found = critic_inputs(svg.world_model, svg.motion, step.state, step.view, step.guided)
        assert torch.allclose(found[on], read[number][on], atol=0.05)  # normalised: soles are in centimetres
        costs = state_costs(step.state, step.view, svg.motion, step.guided, svg.loss_weights.at(0))
        assert torch.allclose(sum(costs.values())[on], judged.costs[number][on], atol=1e-2)


def test_every_world_is_valued_once_where_it_is_last_seen(svg):
    steps = list(window(svg))
    seen = sum(step.guided.last.int() for step in steps)
    assert torch.equal(seen, steps[0].guided.weights.int())
    ends = [step.last_seen() for step in steps]
    assert sum(len(end.actions) for end in ends if end is not None) == int(seen.sum())


def test_slopes_reach_the_policy_through_the_value_alone(svg):
    loss, parts = window_loss(window(svg), svg.motion, svg.loss_weights.at(0), svg._critic_training.to_come(1.0))
    plain, _ = window_loss(window(svg), svg.motion, svg.loss_weights.at(0))
    assert float((loss - plain).detach()) == pytest.approx(parts["to_come"], rel=1e-3)
    assert parts["to_come"] > 0
    slopes = torch.autograd.grad(loss - plain, svg._learned_weights(), allow_unused=True)
    assert any(slope is not None and bool(slope.abs().max() > 0) for slope in slopes)


def test_it_explains_the_costs_of_one_rollout_after_a_while(svg):
    training: CriticTraining = svg._critic_training
    for _ in range(100):
        log = training.learn(svg.loss_weights.at(0), [svg._rollouts.latest(1)[0]])
    assert log["critic_explains"] > 0.5
    assert log["cost_to_go"] > 0
    assert not any(p.requires_grad for p in svg.critic.parameters())


def test_rare_falls_count_by_how_often_they_come(svg):
    training: CriticTraining = svg._critic_training
    judged = training._judged(svg._rollouts.latest(1)[0], svg.loss_weights.at(0))
    rng, state = np.random.default_rng(0), judged.inputs[:1]
    training.critic.requires_grad_(True)
    found = []
    for _ in range(600):
        costs = np.where(rng.random(128) < 0.05, 250.0, 50.0)
        training._descend(state.expand(128, -1), torch.tensor(costs).float())
        found.append(training.critic(state).item())
    assert np.mean(found[300:]) == pytest.approx(0.95 * 50 + 0.05 * 250, abs=3)  # their median is 50


def test_what_an_end_costs_may_grow_with_the_samples(svg):
    training: CriticTraining = svg._critic_training
    training.settings = CostToGo(weight=1.0, end_cost={0: 100.0, 1000: 300.0}, discount=0.9, updates=(1, 1))
    judged = training._judged(svg._rollouts.latest(1)[0], svg.loss_weights.at(0))
    failed = torch.zeros_like(judged.failed)
    failed[-1] = True
    doomed = judged._replace(failed=failed, ended=failed)
    for samples, end_cost in ((0, 100.0), (500, 200.0), (5000, 300.0)):
        assert training.learned(samples, svg.loss_weights.at(0), [svg._rollouts.latest(1)[0]]) is not None
        aims = training._aims(doomed).view_as(failed)
        assert torch.allclose(aims[-2], torch.tensor(0.9 * end_cost))


def test_it_learns_long_before_it_first_acts(make_svg):
    model = make_svg(cost_to_go={**SHORT, "weight": {0: 0.0, 48: 0.0, 96: 0.25}})
    model.learn(48)
    assert model.critic.updates == 0
    model.learn(48, reset_num_timesteps=False)
    assert model.critic.updates == 6
    model.learn(48, reset_num_timesteps=False)
    assert model.critic.updates == 8


@pytest.mark.parametrize("decay", [0.0, 0.9])
def test_the_average_of_its_weights_judges(make_svg, monkeypatch, decay):
    svg = make_svg(episodes={"steps": (3, 9), "loose_share": 0}, cost_to_go={**SHORT, "average_decay": decay})
    training: CriticTraining = svg.learn(96)._critic_training
    losses, rollout, weights = svg.loss_weights.at(0), svg._rollouts.latest(1)[0], list(svg.critic.layers.parameters())
    before = [weight.detach().clone() for weight in weights]
    with svg.critic.average.learning():
        latest = [weight.detach().clone() for weight in weights]
    training.settings = CostToGo(updates=(1, 1), average_decay=decay)
    aims, valuing = training._aims(training._judged(rollout, losses)), []
    find_aims = training._aims

    def watched(judged):
        valuing.extend(weight.detach().clone() for weight in weights)
        return find_aims(judged)

    monkeypatch.setattr(training, "_aims", watched)
    training.learn(losses, [rollout])
    assert all(map(torch.equal, valuing, before)) and len(valuing) == len(before)
    assert not torch.allclose(training._aims(training._judged(rollout, losses)), aims, equal_nan=True)
    with svg.critic.average.learning():
        learned = [weight.detach().clone() for weight in weights]
    for weight, average, old, new in zip(weights, before, latest, learned, strict=True):
        assert torch.allclose(weight, decay * average + (1 - decay) * new, atol=1e-6)
        assert not torch.equal(old, new)


@pytest.mark.parametrize("decay", [1, -0.1, "0.9"])
def test_a_decay_that_is_none_is_refused(make_svg, decay):
    with pytest.raises(ValueError, match=f"average_decay of cost_to_go must be .* below 1, not {decay!r}"):
        CostToGo(average_decay=decay)
    with pytest.raises(ValueError, match=f"average_decay must be a number that is at least 0 .* not {decay!r}"):
        make_svg(average_decay=decay)


def test_a_checkpoint_whose_critic_reads_other_numbers_is_refused_whole(svg, make_svg):
    """As those that were made before adaptations acted in part."""
    state, again = svg.world_state(), make_svg()
    before = {name: value.clone() for name, value in again.world_model.state_dict().items()}
    state["critic"]["layers.0.weight"] = (weight := state["critic"]["layers.0.weight"])[:, 1:]
    read, now = weight.shape[1] - 1, weight.shape[1]
    with pytest.raises(ValueError, match=f"critic reads {read} numbers, now there are {now}: begin the run anew"):
        again.set_world_state(state)
    assert all(torch.equal(value, before[name]) for name, value in again.world_model.state_dict().items())


def test_a_checkpoint_of_a_wider_model_goes_on_with_it(svg, make_svg):
    """As those that were made before new models became half as wide."""
    svg.world_model = WorldModel(CHARACTER, Sizes(24, 3))
    svg.world_optimizer = torch.optim.Adam(svg.world_model.parameters())
    again = make_svg()
    again.set_world_state(svg.world_state())
    assert again.world_model.sizes == (24, 3)
    assert torch.equal(again.world_model.dynamics.last.weight, svg.world_model.dynamics.last.weight)
    again.learn(48)


def test_saving_and_checkpoints_keep_it(svg, make_svg, tmp_path):
    svg.save(tmp_path / "model")
    other = make_svg()
    restore(other, None, snapshot(svg, None, 0.0))
    for again in (SVG.load(tmp_path / "model", device="cpu"), other):
        for name, tensor in svg.critic.state_dict().items():
            assert torch.equal(again.critic.state_dict()[name], tensor)
        assert again.critic_optimizer.state_dict()["state"].keys() == svg.critic_optimizer.state_dict()["state"].keys()


def quiet():
    class Nothing:
        def __getattr__(self, name):
            return lambda *_: True

    return Nothing()
