"""Integration undoes differencing; a step with its residual is the real one; slopes reach actions and states."""

import pytest
import torch
from world_cases import CHARACTER, random_state

from sb3_adaptnet.world_model.integration import CONTROL_DT, change_between, change_size, integrate
from sb3_adaptnet.world_model.model import Sizes, WorldModel

JOINTS = len(CHARACTER.joints)


def model(seed=0):
    torch.manual_seed(seed)
    world = WorldModel(CHARACTER, Sizes(16, 2))
    torch.nn.init.normal_(world.dynamics.last.weight, std=0.3)
    return world


def close(found, expected, atol):
    return all(torch.allclose(a, b, atol=atol) for a, b in zip(found, expected, strict=True))


def test_integration_undoes_differencing():
    world, before, after = model().double(), random_state(20, 0), random_state(20, 1)
    view = world.view(world.kinematics(before))
    found = integrate(before, change_between(before, after, view), view)
    aligned = torch.where((found.orientation * after.orientation).sum(0) < 0, -1.0, 1.0)
    assert close(found._replace(orientation=found.orientation * aligned), after, 1e-9)


def test_differencing_undoes_integration():
    world, state = model().double(), random_state(20, 0)
    view = world.view(world.kinematics(state))
    change = torch.randn(20, change_size(JOINTS), dtype=torch.float64)
    assert torch.allclose(change_between(state, integrate(state, change, view), view), change, atol=1e-6)


def test_without_a_change_velocities_are_kept():
    world, state = model().double(), random_state(5, 0)
    later = integrate(state, torch.zeros(5, change_size(JOINTS)).double(), world.view(world.kinematics(state)))
    assert torch.allclose(later.position, state.position + CONTROL_DT * state.velocity)
    assert close((later.velocity, later.spin, later.rates), (state.velocity, state.spin, state.rates), 1e-12)


def test_changes_do_not_depend_on_place_and_heading():
    world, state, actions = model().double(), random_state(5, 0), torch.rand(5, JOINTS).double()
    quarter = torch.tensor(0.5).double().sqrt()
    w, x, y, z = state.orientation
    turned = state._replace(
        position=torch.stack((4 - state.position[1], 7 + state.position[0], state.position[2])),
        orientation=quarter * torch.stack((w - z, x - y, y + x, z + w)),
        velocity=torch.stack((-state.velocity[1], state.velocity[0], state.velocity[2])),
        spin=torch.stack((-state.spin[1], state.spin[0], state.spin[2])),
    )
    changes = [world.change(world.view(world.kinematics(s)), s, actions) for s in (state, turned)]
    assert torch.allclose(*changes, atol=1e-9)


def test_a_step_with_its_residual_is_the_real_one():
    world, before, actions = model().double(), random_state(8, 0), torch.rand(8, JOINTS).double()
    view = world.view(world.kinematics(before))
    after = integrate(before, torch.randn(8, change_size(JOINTS)).double(), view)
    residual = world.residual(before, after, actions)
    assert close(world.step(before, view, actions, residual), after, 1e-9)
    assert not close(world.step(before, view, actions), after, 1e-2)


def test_the_slopes_of_a_step_equal_finite_differences():
    world = model().double().frozen()
    state, actions = random_state(2, 0), torch.rand(2, JOINTS).double().requires_grad_()

    def two_steps(actions, rates):
        now = state._replace(rates=rates)
        for _ in range(2):
            now = world.step(now, world.view(world.kinematics(now)), actions)
        return now

    assert torch.autograd.gradcheck(two_steps, (actions, state.rates.clone().requires_grad_()))


@pytest.mark.parametrize("precision", ["fp32", "bf16"])
def test_a_frozen_copy_agrees(precision):
    world = model()
    world.dynamics.precision = precision
    frozen, inputs = world.frozen(), torch.randn(50, len(world.dynamics.input_mean))
    found, expected = frozen.dynamics(inputs), world.dynamics(inputs)
    assert torch.allclose(found, expected, atol=1e-6 if precision == "fp32" else 0.1)
    assert not any(p.requires_grad for p in frozen.parameters())
    assert all(p.requires_grad for p in world.parameters())


def test_statistics_normalise():
    network = model().dynamics
    inputs, changes = torch.randn(500, len(network.input_mean)) * 3 + 1, torch.randn(500, len(network.output_mean)) * 5
    network.set_statistics(inputs, changes)
    normal = network.normalise(changes)
    assert torch.allclose(normal.mean(0), torch.zeros(1), atol=1e-4)
    assert torch.allclose(normal.std(0), torch.ones(1), atol=1e-2)
