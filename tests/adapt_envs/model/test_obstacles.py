"""Obstacles: where they stand, that they are seen, and that touching one is a fall."""

import mujoco
import numpy as np
import pytest

from adapt_envs import env_id, make_vector
from adapt_envs.features.heightmap import heightmaps
from adapt_envs.model.ground import TARGET_MARGIN, make_ground
from adapt_envs.model.obstacles import OBSTACLES, ObstacleField
from adapt_envs.model.patch_grid import INSET, PATCH
from adapt_envs.model.terrain import TERRAINS

WORLDS = make_vector(env_id("Obstacles"), 256, num_threads=1)
WORLDS.reset(seed=0)
GROUND = WORLDS.worlds.ground


def rays(model, xy):
    data, geom = mujoco.MjData(model), np.zeros(1, np.int32)
    data.qpos[:2] = 1000
    mujoco.mj_kinematics(model, data)
    down = np.array([0, 0, -1.0])
    return np.array([5 - mujoco.mj_ray(model, data, np.array([*p, 5.0]), down, None, 1, -1, geom) for p in xy])


@pytest.mark.parametrize("terrain", [None, "rocky"])
def test_heights_equal_rays(terrain):
    worlds = make_vector(env_id("Obstacles"), 1, terrain=terrain).worlds
    half = worlds.ground.patches.half
    xy = np.random.default_rng(0).uniform(-half, half, (2000, 2))
    expected = rays(worlds.model, xy)
    assert np.abs(worlds.ground.height_at(xy) - expected).max() < 1e-3
    if terrain is None:
        assert 0.03 < (expected > 0.5).mean() < 0.3


def test_lanes_are_free_and_blocks_cannot_be_stepped_over():
    """Along x or y any two blocks, however turned, are at least a lane apart."""
    blocks = GROUND.obstacles
    assert len(blocks.centre) > 80
    assert blocks.top.min() >= 0.9
    reach = np.linalg.norm(blocks.half, axis=1)
    apart = np.abs(blocks.centre[:, None] - blocks.centre).max(axis=-1) - reach[:, None] - reach
    assert apart[~np.eye(len(reach), dtype=bool)].min() >= 1.2 - 1e-9


def test_targets_lie_in_no_block_and_inside_their_patch():
    worlds, rng = WORLDS.worlds, np.random.default_rng(0)
    for _ in range(30):
        worlds.goals.sample(np.arange(256), worlds.root_xy, worlds.root_heading, rng)
        target = worlds.goals.target.astype(float)
        assert (GROUND.height_at(target) == 0).all()
        around = target[:, None] + (TARGET_MARGIN - 0.01) * np.array([(1, 0), (-1, 0), (0, 1), (0, -1)])
        assert (GROUND.height_at(around) == 0).all()
        offset = np.abs(target[..., None] - GROUND.patches.centres_1d).min(axis=-1)
        assert offset.max() <= PATCH / 2 - INSET + 1e-4


def test_a_target_is_found_even_where_every_draw_fails():
    """From far away no direction leads into the patch: the nearest free place is taken."""
    root = np.column_stack([np.linspace(-26, 26, 60), np.full(60, 40.0)])
    target = GROUND.kept_targets(root, root, np.random.default_rng(0), np.zeros(60), np.ones(60)).astype(float)
    assert (GROUND.height_at(target) == 0).all()
    assert np.abs(target).max() <= GROUND.patches.half - 1.5 - INSET + 1e-4


def test_spawns_have_a_free_way_ahead():
    worlds = WORLDS.worlds
    start = worlds.root_xy.astype(float)
    ahead = np.stack([np.cos(worlds.root_heading), np.sin(worlds.root_heading)], -1)
    for distance in np.linspace(0, 2.0, 9):
        assert (GROUND.height_at(start + distance * ahead) == 0).all()


def test_blocks_are_seen_in_the_heightmap():
    block = int(np.argmin(np.abs(GROUND.obstacles.centre).sum(axis=1)))
    centre, top = GROUND.obstacles.centre[block], GROUND.obstacles.top[block]
    seen = heightmaps(GROUND, (centre - (1.5, 0))[None], np.zeros(1))[0, 0]
    assert seen[9, 17] == pytest.approx(top)  # 1.5 m ahead: row (2.4 - 1.5) / 0.1
    assert seen.max() <= GROUND.obstacles.top.max() + 1e-6
    assert seen[24, 17] == 0
    behind = heightmaps(GROUND, (centre - (0, 1.3))[None], np.full(1, np.pi))[0, 0]
    assert behind[24, 30] == pytest.approx(top)  # 1.3 m to the right of a character that faces -x


def touching(offset):
    """Whether a character counts as fallen whose pelvis stands `offset` [m] before a block's face, and what touches."""
    worlds = make_vector(env_id("Obstacles"), 1, num_threads=1).worlds
    worlds.reset(np.zeros(1, int), start=0)
    blocks = worlds.ground.obstacles
    axis = np.array([np.cos(blocks.yaw[0]), np.sin(blocks.yaw[0])])
    qpos = worlds.model.qpos0[None].copy()
    qpos[0, :2] = blocks.centre[0] - (blocks.half[0, 0] + offset) * axis
    qpos[0, 3], qpos[0, 6] = np.cos(blocks.yaw[0] / 2), np.sin(blocks.yaw[0] / 2)
    worlds.physics.set_states(np.zeros(1, int), qpos, np.zeros((1, worlds.model.nv)))
    data = mujoco.MjData(worlds.model)
    worlds.physics.mujoco_data(0, data)
    names = {worlds.model.geom(int(geom)).name for contact in data.contact for geom in contact.geom}
    return bool(worlds.fallen[0]), names


def test_touching_a_block_with_a_foot_alone_is_no_fall():
    fallen, names = touching(0.12)
    assert {"obstacle_0", "right_foot"} <= names
    assert not fallen


def test_touching_a_block_with_anything_else_is_a_fall():
    fallen, names = touching(0.04)
    assert {"obstacle_0"} < names
    assert fallen
    assert touching(0.5) == (False, {"floor", "right_foot", "left_foot"})


def test_layouts_follow_the_seed_and_their_numbers():
    layouts = [make_ground(None, OBSTACLES["blocks"], seed).obstacles for seed in (0, 0, 1)]
    assert np.array_equal(layouts[0].centre, layouts[1].centre)
    assert layouts[0].centre.shape != layouts[2].centre.shape or not np.allclose(layouts[0].centre, layouts[2].centre)
    sparse = make_ground(None, ObstacleField(density=0.2), 0).obstacles
    assert len(sparse.centre) < 0.5 * len(layouts[0].centre)


def test_blocks_stand_on_hills():
    ground = make_ground(TERRAINS["hills"], OBSTACLES["blocks"], 0)
    below = ground.floor_at(ground.obstacles.centre)
    assert np.ptp(below) > 0.5
    assert (ground.obstacles.top - below).min() >= 0.9 - 1e-5


def test_blocks_reach_into_deep_valleys():
    ground = make_ground(TERRAINS["hills"], OBSTACLES["blocks"], 0, 4.0)
    assert ground.surface.heights.min() < -2
    assert ground.obstacles.bottom < ground.surface.heights.min()
    spec = mujoco.MjSpec()
    spec.add_material(name="ground")
    ground.add_to(spec)
    assert spec.compile().ngeom > len(ground.obstacles.top)


def test_wrong_layouts_are_named():
    with pytest.raises(ValueError, match="cell is 5"):
        ObstacleField(cell=5)
    with pytest.raises(ValueError, match="side"):
        ObstacleField(side=(0.5, 3.0))
    with pytest.raises(ValueError, match="lane"):
        ObstacleField(lane=0.0)
    with pytest.raises(ValueError, match=r"'trees'.*blocks"):
        make_vector(env_id("Walk"), 1, obstacles="trees")
