"""Uneven ground: its shape, its heights, what stands on it and what is seen of it."""

import mujoco
import numpy as np
import pytest

from adapt_envs import AdaptEnv, env_id, make_vector
from adapt_envs.features import rotations
from adapt_envs.features.heightmap import AHEAD, ASIDE, SIZE, heightmaps
from adapt_envs.model.ground import Ground, make_ground
from adapt_envs.model.patch_grid import INSET, PATCH
from adapt_envs.model.surface import Surface
from adapt_envs.model.terrain import GRID, TERRAINS, normalised, perlin, sloped_surfaces, stepped, uniform_noise

ROWS = ("TerrainHills", "TerrainRocky", "TerrainRugged")
CELLS = round(PATCH / GRID) + 1
HILLS, ROCKY = (16506.299859587252, 91273.22547173171), (10280.571308375043, 61280.47968570627)
"""Sum of the heights [m] and of their squares [m2] of the atlas of seed 0."""


def ray_heights(model, xy):
    """Heights (n,) that MuJoCo's own rays meet below points (n, 2)."""
    data, geom = mujoco.MjData(model), np.zeros(1, np.int32)
    data.qpos[:2] = 1000  # the character is out of the way
    mujoco.mj_kinematics(model, data)
    down = np.array([0, 0, -1.0])
    return np.array([5 - mujoco.mj_ray(model, data, np.array([*p, 5.0]), down, None, 1, -1, geom) for p in xy])


@pytest.fixture(scope="module", params=ROWS)
def worlds(request):
    """256 worlds of one kind of terrain, just reset."""
    env = make_vector(env_id(request.param), 256, num_threads=1)
    env.reset(seed=0)
    return env.worlds


def test_heights_equal_rays(worlds):
    rng, half = np.random.default_rng(1), worlds.ground.patches.half + 8
    xy = rng.uniform(-half, half, (1500, 2))
    assert np.abs(worlds.ground.height_at(xy) - ray_heights(worlds.model, xy)).max() < 1e-3
    assert np.ptp(worlds.ground.height_at(xy)) > 0.9


def test_the_heightmap_equals_rays_around_turned_roots(worlds):
    found = heightmaps(worlds.ground, worlds.root_xy, worlds.root_heading)
    assert found.shape == (256, 1, SIZE, SIZE)
    rng = np.random.default_rng(2)
    for world in rng.integers(256, size=8):
        root, heading = worlds.root_xy[world].astype(float), float(worlds.root_heading[world])
        ahead, left = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
        rows, columns = rng.integers(SIZE, size=(2, 40))
        xy = root + (AHEAD - 0.1 * rows)[:, None] * ahead + (ASIDE - 0.1 * columns)[:, None] * left
        expected = ray_heights(worlds.model, xy) - ray_heights(worlds.model, root[None])
        assert np.abs(found[world, 0, rows, columns] - expected).max() < 1e-3
        assert abs(found[world, 0, 24, 17]) < 1e-3  # the root itself


def test_patches_reach_from_lowest_to_highest(worlds):
    heights = [patch_heights(worlds.ground, *place) for place in np.ndindex(4, 4)]
    for patch in heights:
        assert patch.min() == pytest.approx(-0.75, abs=1e-6)
        assert 0.4 < patch.max() < 0.75 + 1e-6
    assert not np.allclose(heights[0], heights[1])


def patch_heights(ground, row, column):
    surface, centres = ground.surface, ground.patches.centres_1d
    low = np.round((centres[[column, row]] - PATCH / 2 - surface.low) / surface.grid).astype(int)
    cells = round(PATCH / surface.grid) + 1
    return surface.heights[low[1] : low[1] + cells, low[0] : low[0] + cells]


def test_patches_join_without_cliffs(worlds):
    """Between patches the ground ramps to height 0 over 1.5 m, on both sides."""
    ground = worlds.ground
    seams = (ground.patches.centres_1d[:-1] + ground.patches.centres_1d[1:]) / 2
    along = np.linspace(-50, 50, 400)
    for seam in seams:
        for xy in (np.column_stack([np.full(400, seam), along]), np.column_stack([along, np.full(400, seam)])):
            assert np.abs(ground.height_at(xy)).max() < 1e-6


def test_spawns_stand_on_the_ground_where_goals_may_be(worlds):
    """No sole sinks in, and the lowest one is as high over the ground as it is in the clip."""
    env = worlds
    model, ground = env.model, env.ground
    inside = np.abs(env.root_xy - ground.patches.clipped(env.root_xy, env.root_xy))
    assert inside.max() < 1e-4
    data = mujoco.MjData(model)
    fine = np.stack(np.meshgrid(*[np.linspace(-1, 1, 30)] * 2, [-1.0]), -1).reshape(-1, 3)
    for world in range(24):
        data.qpos[:] = env.physics.qpos[world]
        mujoco.mj_kinematics(model, data)
        clearance = np.inf
        for foot in ("right_foot", "left_foot"):
            geom = data.geom(foot)
            sole = geom.xpos + (fine * model.geom(foot).size) @ geom.xmat.reshape(3, 3).T
            clearance = min(clearance, (sole[:, 2] - ground.height_at(sole)).min())
        assert -0.03 < clearance < 0.06
    assert np.ptp(env.root_heading) > 5  # spawned facing everywhere


def test_heights_in_the_observation_are_relative_to_the_ground_below(worlds):
    pelvis = worlds.physics.qpos[:, 2] - worlds.ground.height_at(worlds.physics.qpos[:, :2])
    seen = worlds._last
    assert np.allclose(seen["observation"][:, 3 * 15 * 13 + 2], pelvis, atol=1e-5)
    assert np.ptp(worlds.physics.qpos[:, 2]) > 0.8 > np.ptp(pelvis)


def test_goals_stay_three_metres_inside_their_patch(worlds):
    ids, rng = np.arange(256), np.random.default_rng(0)
    centres = worlds.ground.patches.centres_1d
    for _ in range(20):
        worlds.goals.sample(ids, worlds.root_xy, worlds.root_heading, rng)
        target = worlds.goals.target
        offset = np.abs(target[..., None] - centres).min(axis=-1)
        assert offset.max() <= PATCH / 2 - INSET + 1e-4
        same = np.abs(worlds.root_xy[..., None] - centres).argmin(-1) == np.abs(target[..., None] - centres).argmin(-1)
        assert same.all()
        assert np.allclose(worlds.goals.distance, np.linalg.norm(target - worlds.root_xy, axis=1), atol=1e-4)
    assert worlds.goals.distance.max() > 6


def test_narrow_goals_lie_ahead_where_the_patch_has_room():
    worlds = make_vector(env_id("TerrainHills"), 256, num_threads=1).worlds
    worlds.reset(np.arange(256))
    worlds.goals.spread[:] = 0.1
    rng, middle = np.random.default_rng(0), np.zeros((256, 2)) + worlds.ground.patches.centres_1d[0]
    worlds.goals.sample(np.arange(256), middle, worlds.root_heading, rng)
    away = worlds.goals.target - middle
    aside = np.abs(rotations.wrapped(np.arctan2(away[:, 1], away[:, 0]) - worlds.root_heading))
    assert aside.max() <= 0.1 * np.pi + 1e-3  # from the middle every direction has room
    edge = middle + [PATCH / 2 - INSET - 1.0, 0.0]
    worlds.goals.sample(np.arange(256), edge, worlds.root_heading, rng)
    away = worlds.goals.target - edge
    aside = np.abs(rotations.wrapped(np.arctan2(away[:, 1], away[:, 0]) - worlds.root_heading))
    along = np.abs(worlds.root_heading) > 0.7 * np.pi
    assert aside[along].max() <= 0.1 * np.pi + 1e-3


def test_a_goal_is_found_even_from_beyond_the_corner():
    ground, rng = make_ground(TERRAINS["hills"], None, 0), np.random.default_rng(0)
    root = np.full((50, 2), ground.patches.half + 5.0)
    target = ground.kept_targets(root + 1.0, root, rng, np.zeros(50), np.ones(50))
    assert np.allclose(target, ground.patches.centres_1d[-1] + PATCH / 2 - INSET)


def test_a_held_goal_that_the_ground_cuts_short_says_so():
    goals = make_vector(env_id("TerrainHills"), 2, num_threads=1).worlds.goals
    edge = goals.ground.patches.half - INSET
    at, ids = np.array([[0.0, 0.0], [edge - 2.0, 0.0]]), np.arange(2)
    goals.sample(ids, at, np.zeros(2), np.random.default_rng(0))
    assert not goals.shortened.any()  # random ones are as near as they like
    goals.hold(ids, 0.0, 1.5)
    goals.sample(ids, at, np.zeros(2), np.random.default_rng(0))
    assert goals.shortened.tolist() == [False, True]


def test_held_goals_stay_on_the_terrain():
    env = make_vector(env_id("TerrainHills"), 16)
    env.reset(seed=0, options={"goal_heading": 0.3, "goal_speed": 1.5})
    offset = env.worlds.goals.target - env.worlds.root_xy
    heading = np.arctan2(offset[:, 1], offset[:, 0])
    assert (np.abs(heading - 0.3) < 1e-4).sum() >= 12
    assert np.abs(env.worlds.goals.target).max() <= env.worlds.ground.patches.half - INSET + 1e-4


@pytest.mark.parametrize("name", ROWS)
def test_the_terrain_follows_its_own_seed(name):
    """`terrain_seed` draws the ground, `reset(seed=...)` the spawns and goals on it."""
    first, again, other = (AdaptEnv(name, terrain_seed=seed) for seed in (0, 0, 1))
    surfaces = [env.worlds.ground.surface.heights for env in (first, again, other)]
    assert np.array_equal(surfaces[0], surfaces[1])
    assert not np.array_equal(surfaces[0], surfaces[2])
    assert np.array_equal(AdaptEnv(name).worlds.ground.surface.heights, surfaces[0])
    ours, same, elsewhere = first.reset(seed=3)[0], again.reset(seed=3)[0], first.reset(seed=4)[0]
    assert all(np.array_equal(ours[key], same[key]) for key in ours)
    assert not np.array_equal(ours["heightmap"], elsewhere["heightmap"])


def test_the_terrain_is_as_high_as_asked():
    plain, higher = (AdaptEnv(ROWS[0], terrain_scale=scale).worlds for scale in (1.0, 1.25))
    assert np.allclose(higher.ground.surface.heights, 1.25 * plain.ground.surface.heights, atol=1e-6)
    assert np.isclose(np.ptp(higher.ground.surface.heights), 1.25 * 1.5, atol=1e-6)


def test_perlin_noise_is_zero_at_its_nodes_smooth_and_as_coarse_as_asked():
    heights = perlin(np.random.default_rng(0), 241, 6.0)
    assert np.abs(heights[::60, ::60]).max() < 1e-9
    assert np.abs(heights).max() > 0.5
    curvature = np.abs(np.diff(heights, 2, axis=0)) / GRID**2
    assert curvature.max() < 2.5  # no kink, also across cells
    spectrum = np.abs(np.fft.rfft(heights - heights.mean(axis=0), axis=0)).mean(axis=1) ** 2
    wavelengths = 24.1 / np.arange(1, len(spectrum))
    assert spectrum[1:][wavelengths > 3].sum() > 0.9 * spectrum[1:].sum()


def test_uniform_noise_fills_its_range_and_interpolates():
    noise = uniform_noise(np.random.default_rng(0), 241)
    assert 0.099 < noise.max() <= 0.1
    assert -0.1 <= noise.min() < -0.099
    nodes, inside = noise[::4, ::4], np.arange(4) / 4
    lower = nodes[:-1, None, :] + inside[:, None] * np.diff(nodes, axis=0)[:, None, :]
    assert np.abs(lower.reshape(-1, nodes.shape[1]) - noise[:-1, ::4]).max() < 1e-14
    across = noise[:, :-1:4, None] + inside * np.diff(noise[:, ::4], axis=1)[:, :, None]
    assert np.abs(across.reshape(241, -1) - noise[:, :-1]).max() < 1e-14


def test_normalised_heights_reach_from_end_to_end_on_one_line():
    heights = np.random.default_rng(0).normal(size=(40, 50))
    found = normalised(heights)
    assert (found.min(), found.max()) == pytest.approx((-0.75, 0.75), abs=1e-12)
    slope = 1.5 / np.ptp(heights)
    assert np.allclose(found - found[0, 0], slope * (heights - heights[0, 0]), atol=1e-12)


def test_noise_in_steps_is_a_multiple_of_them_and_every_multiple_is_as_likely():
    nodes = uniform_noise(np.random.default_rng(0), 241, apart=0.2, step=0.05)[::2, ::2]
    values, counts = np.unique(np.round(nodes / 0.05, 9), return_counts=True)
    assert values.tolist() == [-2, -1, 0, 1, 2]
    assert counts / counts.sum() == pytest.approx(0.2, abs=0.02)


def test_lower_ground_goes_on_to_beneath_the_upper_edge_of_a_steep_face():
    """A cell of 0.1 m that rises by more than 0.05 m: its lower height, and the wall in the last 5 cm."""
    profile = np.array([0.0, 0.02, 0.12, 0.14, 0.24, 0.34, 0.34, 0.1, 0.13])
    expected = [0, 0.01, 0.02, 0.02, 0.12, 0.13, 0.14, 0.14, 0.24, 0.24, 0.34, 0.34, 0.34, 0.1, 0.1, 0.115, 0.13]
    for heights in (np.tile(profile, (5, 1)), np.tile(profile[::-1], (5, 1))):
        along_x, along_y = stepped(heights, 0.5), stepped(heights.T, 0.5)
        assert along_x.shape == (9, 17) and np.array_equal(along_x, along_y.T)
        row = along_x[4] if heights[0, 0] == 0 else along_x[4, ::-1]
        assert row == pytest.approx(expected, abs=1e-12)


def test_a_wall_without_thickness_is_cut_off_at_the_higher_side():
    assert stepped(np.tile([0.0, 0.2, 0.03], (3, 1)), 0.5)[0] == pytest.approx([0, 0, 0.03, 0.03, 0.03])


def test_ground_that_is_nowhere_steep_stays_as_it_is():
    heights = TERRAINS["hills"](np.random.default_rng(0), 41) / 4
    assert np.abs(np.diff(heights)).max() < 0.05
    fine = stepped(heights, 0.5)
    assert np.array_equal(fine[::2, ::2], heights)
    assert fine[::2, 1::2] == pytest.approx((heights[:, 1:] + heights[:, :-1]) / 2, abs=1e-12)


def test_rugged_faces_are_gentle_or_walls_within_five_centimetres():
    patch = TERRAINS["rugged"](np.random.default_rng(0), 241)
    assert patch.shape == (481, 481)
    for rows in (patch[::2], patch.T[::2]):
        slope = np.abs(np.diff(rows, axis=1)) / (GRID / 2)
        assert 0.05 < (slope > 1).mean() < 0.25 and 2 < slope.max() < 4
        assert ((slope > 0.5 + 1e-9) & (slope < 1)).mean() < 0.02


def test_surfaces_and_noise_of_rugged_ground_are_never_made_smaller():
    """Else its steps would shrink with them: both together have less than the 1.5 m that they are scaled to."""
    for seed in range(5):
        rng = np.random.default_rng(seed)
        surfaces = sloped_surfaces(rng, 241)
        assert np.abs(surfaces).max() <= 0.65 + 1e-9
        assert np.abs(np.diff(surfaces)).max() <= 0.3 * GRID + 1e-9
        assert np.ptp(surfaces) > 0.6


def test_hills_have_no_steps_and_rocky_ground_has():
    patches = {name: TERRAINS[name](np.random.default_rng(0), CELLS) for name in ("hills", "rocky")}
    steepest = {name: np.abs(np.diff(patch, axis=1)).max() / GRID for name, patch in patches.items()}
    assert steepest["hills"] < 1
    assert 1.5 < steepest["rocky"] < 6
    assert np.array_equal(normalised(np.ones((3, 3))), np.zeros((3, 3)))


def test_hills_and_rocky_ground_are_what_policies_were_trained_on():
    """Sums of the atlas of seed 0, as they were before rugged ground got steps: weights that ship know these worlds."""
    for name, (total, squares) in {"hills": HILLS, "rocky": ROCKY}.items():
        heights = make_ground(TERRAINS[name], None, 0).surface.heights.astype(np.float64)
        assert heights.shape == (1281, 1281)
        assert (heights.sum(), (heights**2).sum()) == pytest.approx((total, squares), rel=1e-6)


def test_a_wrong_terrain_is_named():
    with pytest.raises(ValueError, match=r"'moon'.*hills, rocky, rugged"):
        AdaptEnv("Walk", terrain="moon")
    with pytest.raises(ValueError, match=r"\(3, 3\).*\(241, 241\)"):
        AdaptEnv("Walk", terrain=lambda rng, size: np.zeros((3, 3)))
    sides = (241, 481)
    with pytest.raises(ValueError, match="one grid for all"):
        AdaptEnv("Walk", terrain=lambda rng, size: np.zeros((sides[rng.integers(2)],) * 2))
    with pytest.raises(ValueError, match="finite"):
        AdaptEnv("Walk", terrain=lambda rng, size: np.full((size, size), np.nan))


def test_a_piece_for_pictures_has_the_same_heights():
    ground = make_ground(TERRAINS["rocky"], None, 0)
    middle = np.array([7.3, -11.8])
    piece = ground.for_pictures(middle, side=8.0)
    xy = middle + np.random.default_rng(0).uniform(-3.9, 3.9, (500, 2))
    assert piece.surface.heights.shape == (81, 81)
    assert np.allclose(piece.height_at(xy), ground.height_at(xy), atol=1e-5)
    edge = ground.for_pictures(np.array([1e3, 1e3]), side=8.0)
    assert edge.surface.heights.shape == (81, 81)


def test_a_finer_terrain_keeps_its_grid_in_the_atlas_and_in_pieces_of_it():
    ground = make_ground(TERRAINS["rugged"], None, 0)
    assert ground.surface.grid == pytest.approx(0.05) and ground.surface.heights.shape == (2561, 2561)
    middle = np.array([-7.3, 11.8])
    piece = ground.for_pictures(middle, side=8.0)
    xy = middle + np.random.default_rng(0).uniform(-3.9, 3.9, (500, 2))
    assert piece.surface.heights.shape == (161, 161)
    assert np.allclose(piece.height_at(xy), ground.height_at(xy), atol=2e-4)  # float32 on walls


def test_flat_ground_is_seen_as_zero():
    env = make_vector(env_id("Walk"), 3, heightmap=True)
    observation, _ = env.reset(seed=0)
    assert not observation["heightmap"].any()
    assert Ground().plain
    assert np.array_equal(Surface(np.eye(3), (0, 0)).heights, np.eye(3))


def test_a_diverged_world_on_terrain_keeps_its_last_finite_observation():
    env = make_vector(env_id("TerrainHills"), 4)
    env.reset(seed=0)
    pose = np.tile(env.single_action_space.mean_pose, (4, 1))
    before, *_ = env.step(pose)
    before = {key: values.copy() for key, values in before.items()}
    env.worlds.physics.qpos[2, 9] = np.nan
    after, _, terminated, _, infos = env.step(pose)
    assert terminated[2]
    assert infos["final_info"]["end"][2] == "diverged"
    for key in before:
        assert np.array_equal(infos["final_obs"][2][key], before[key][2])
        assert np.isfinite(after[key]).all()


@pytest.mark.slow
def test_4096_worlds_on_terrain_fit_in_4_gb():
    env = make_vector(env_id("TerrainRocky"), 4096)
    env.reset(seed=0)
    pose = np.tile(env.single_action_space.mean_pose, (4096, 1))
    for _ in range(5):
        env.step(pose)
    with open("/proc/self/status") as status:
        peak = next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))
    print(f"peak of the whole process: {peak / 1e6:.2f} GB")
    assert peak < 4e6
