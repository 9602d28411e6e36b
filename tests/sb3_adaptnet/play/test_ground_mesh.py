"""The ground as triangles, against the heights that feet meet."""

import numpy as np
import pytest

from adapt_envs.model.ground import Ground, make_ground
from adapt_envs.model.ground_paint import painted
from adapt_envs.model.terrain import TERRAINS
from sb3_adaptnet.play.ground_mesh import TILE, goal_ring, grid_faces, tile, tiles_near

KEYS = [(0, 0), (-3, 2), (6, -7)]


@pytest.fixture(scope="module", params=["hills", "rocky"])
def ground(request):
    return make_ground(TERRAINS[request.param], None, seed=2)


def height_on(mesh, xy):
    """Heights (n,) of the triangles below points (n, 2)."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]].astype(float) for i in range(3))
    heights = np.full(len(xy), np.nan)
    for i, point in enumerate(xy):
        edges = np.stack([b - a, c - a], axis=-1)[:, :2]
        shares = np.linalg.solve(edges, (point - a[:, :2])[..., None])[..., 0]
        inside = np.flatnonzero((shares >= -1e-9).all(axis=1) & (shares.sum(axis=1) <= 1 + 1e-9))[0]
        heights[i] = a[inside, 2] + shares[inside] @ (np.stack([b - a, c - a])[:, inside, 2])
    return heights


@pytest.mark.parametrize("key", KEYS)
def test_vertices_lie_on_the_ground_and_so_do_the_triangles_between_them(ground, key):
    mesh = tile(ground, key).mesh
    assert mesh.vertices[:, 2] == pytest.approx(ground.height_at(mesh.vertices[:, :2]), abs=1e-5)
    assert np.ptp(mesh.vertices[:, 2]) > 0.05 or key == (6, -7)
    points = (np.array(key) + np.random.default_rng(0).uniform(0.01, 0.99, (15, 2))) * TILE
    assert height_on(mesh, points) == pytest.approx(ground.height_at(points), abs=1e-4)


def test_a_tile_of_finer_ground_has_its_steps():
    rugged = make_ground(TERRAINS["rugged"], None, seed=2)
    vertices = tile(rugged, (0, 0)).mesh.vertices.reshape(161, 161, 3)
    assert vertices[..., 2] == pytest.approx(rugged.height_at(vertices[..., :2]), abs=1e-5)
    assert np.abs(np.diff(vertices[..., 2])).max() > 0.08


def test_neighbouring_tiles_join(ground):
    left, right = (tile(ground, key).mesh.vertices.reshape(81, 81, 3) for key in ((0, 0), (1, 0)))
    assert left[:, -1] == pytest.approx(right[:, 0], abs=1e-5)


def test_triangles_face_upwards_and_cover_the_tile_once(ground):
    mesh = tile(ground, (0, 0)).mesh
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    area = np.cross(b[:, :2] - a[:, :2], c[:, :2] - a[:, :2]) / 2
    assert (area > 0).all() and area.sum() == pytest.approx(TILE**2, rel=1e-4)
    assert len(grid_faces(3, 4)) == 2 * 2 * 3 and grid_faces(3, 4).max() == 11


def test_the_paint_is_the_renderers(ground):
    made = tile(ground, (0, 0))
    size = len(made.picture)
    column, row = np.floor(made.texture_xy * size).astype(int).clip(0, size - 1).T
    lines = (np.abs(made.mesh.vertices[:, :2] - np.round(made.mesh.vertices[:, :2])) < 0.09).any(axis=1)
    for i in np.flatnonzero(~lines)[::97]:
        alone = painted(np.full((2, 2), made.mesh.vertices[i, 2]), (0.3, 0.3))[0, 0]
        assert made.picture[row[i], column[i]].tolist() == alone.tolist()


def test_tiles_near_a_point_cover_its_surroundings_the_nearest_first():
    xy, reach = np.array([3.0, -9.5]), 12.0
    keys = tiles_near(xy, reach)
    around = xy + np.random.default_rng(1).uniform(-reach, reach, (200, 2))
    assert set(map(tuple, np.floor(around / TILE).astype(int))) <= set(keys)
    distances = [np.linalg.norm((np.array(key) + 0.5) * TILE - xy) for key in keys]
    assert distances == sorted(distances) and len(set(keys)) == len(keys) <= 16


def test_the_ring_follows_the_ground_around_the_target(ground):
    target = np.array([4.2, -3.1])
    vertices = goal_ring(ground, target).vertices
    assert np.linalg.norm(vertices[:, :2] - target, axis=1) == pytest.approx(0.5, abs=0.0601)
    assert vertices[:, 2] == pytest.approx(ground.floor_at(vertices[:, :2]) + 0.03, abs=1e-5)
    assert goal_ring(Ground(), target).vertices[:, 2] == pytest.approx(0.03)
