"""What is a fall: any touch on flat ground, a low link's on uneven ground."""

import numpy as np
import pytest

from adapt_envs import SUITE, env_id, make_vector
from adapt_envs.model.build import FALL_PARTS
from adapt_envs.model.ground import Ground
from adapt_envs.model.humanoid import FEET, LINKS
from adapt_envs.simulation.falls import fallen
from adapt_envs.suite import FALL_HEIGHT
from adapt_envs.tasks.termination import FALL, RUNNING

WALL = 0.2
"""Height [m] of the walls of `walls`: below a knee."""


def walls(rng, size):
    """Ground with a wall every 2 m along x."""
    return np.tile(WALL * (np.arange(size) % 20 < 2), (size, 1))


@pytest.fixture(scope="module")
def rows():
    """Walkers at distances from a wall, in worlds where only low links fall."""
    env = make_vector(env_id("TerrainRugged"), 200, num_threads=1, terrain=walls)
    worlds = env.worlds
    env.reset(seed=0)
    every = np.arange(200)
    qpos, qvel, _ = worlds.reference.states(every)
    qpos[:, :2] = worlds.ground.patches.centres_1d[0]
    qpos[:, 0] += np.linspace(0, 2, 200)  # from wall to wall
    worlds.physics.set_states(every, qpos, qvel)
    worlds.physics.read_links(worlds.history[:, -1])
    return worlds


def test_every_link_but_the_feet_has_a_part():
    assert sorted([*(name for links in FALL_PARTS.values() for name in links), *FEET]) == sorted(LINKS)


def test_a_shin_may_brush_a_wall_on_uneven_ground(rows):
    touching, names = rows.physics.touching(), list(FALL_PARTS)
    shins = [names.index("right_shin"), names.index("left_shin")]
    brushing = touching[:, shins].any(axis=1)
    assert brushing.any() and not brushing.all()
    assert not touching[:, [i for i in range(len(names)) if i not in shins]].any()
    knees = rows.history[brushing, -1][:, [LINKS.index(names[i]) for i in shins], 2]
    assert knees.min() > WALL  # upright
    assert not rows.fallen.any()
    strict = fallen(touching, rows.history[:, -1, :, :3], rows.ground, None)
    assert np.array_equal(strict, brushing)


@pytest.mark.parametrize("height, falls", [(FALL_HEIGHT - 0.01, True), (FALL_HEIGHT + 0.01, False)])
def test_only_the_part_that_touches_must_be_low(height, falls):
    shin, other = list(FALL_PARTS).index("left_shin"), list(FALL_PARTS).index("right_shin")
    positions = np.ones((2, len(LINKS), 3))
    positions[:, LINKS.index("left_shin"), 2] = height
    touching = np.zeros((2, len(FALL_PARTS)), bool)
    touching[0, shin] = touching[1, other] = True
    assert fallen(touching, positions, Ground(), FALL_HEIGHT).tolist() == [falls, False]


def test_a_part_of_many_links_is_as_low_as_its_lowest():
    positions = np.ones((1, len(LINKS), 3))
    positions[0, LINKS.index("right_hand"), 2] = 0.05
    touching = np.arange(len(FALL_PARTS))[None] == list(FALL_PARTS).index("torso")
    assert fallen(touching, positions, Ground(), FALL_HEIGHT).all()


@pytest.mark.parametrize("name", ["Walk", "TerrainRugged", "TerrainHills"])
def test_who_stops_acting_falls_on_any_ground(name):
    env = make_vector(env_id(name), 8, num_threads=1)
    env.reset(seed=0)
    done, codes = np.zeros(8, bool), []
    for _ in range(150):
        _, _, code = env.worlds.step(np.ones((8, env.worlds.model.nu)), None)
        codes.append(code[~done])
        done |= code != RUNNING
    assert done.all()
    assert set(np.concatenate(codes)) == {RUNNING, FALL}


def test_heights_count_on_the_three_terrains_alone():
    assert {name for name, row in SUITE.items() if row.fall_height} == {"TerrainHills", "TerrainRocky", "TerrainRugged"}
