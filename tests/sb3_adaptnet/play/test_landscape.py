"""Ground and obstacles in the browser are where the physics has them."""

import mujoco
import numpy as np
import pytest

from sb3_adaptnet.evaluation.recording import open_worlds
from sb3_adaptnet.play.ground_mesh import TILE
from sb3_adaptnet.play.landscape import KEPT, REACH, ROOT, Landscape


def worlds_of(name):
    return open_worlds(f"AdaptNet/Humanoid-{name}-v0", 1, num_threads=1).worlds


@pytest.fixture(scope="module")
def hills():
    return worlds_of("TerrainHills")


def tiles(scene):
    return {tuple(map(int, name.split("_")[1:])) for name in scene.nodes if "tile" in name}


def test_obstacles_are_boxes_where_the_models_geoms_are(fakes, scene):
    worlds = worlds_of("Obstacles")
    Landscape(scene, worlds.model, worlds.ground).place(np.zeros(3), np.zeros(2))
    boxes = [node for name, node in scene.nodes.items() if "obstacle" in name]
    geoms = [worlds.model.geom(i) for i in range(worlds.model.ngeom) if worlds.model.geom(i).name.startswith("obst")]
    assert len(boxes) == len(geoms) == len(worlds.ground.obstacles.centre)
    for box, geom in zip(boxes, geoms, strict=True):
        assert geom.type == mujoco.mjtGeom.mjGEOM_BOX
        assert np.array_equal(box.position, geom.pos) and np.array_equal(box.wxyz, geom.quat)
        assert box.dimensions == pytest.approx(2 * geom.size) and box.color == (184, 115, 77)
        top = np.array([box.position[:2]])
        assert worlds.ground.height_at(top)[0] == pytest.approx(box.position[2] + box.dimensions[2] / 2, abs=1e-5)


def test_the_ground_moves_while_the_character_stays(fakes, scene, hills):
    landscape = Landscape(scene, hills.model, hills.ground)
    for middle in (np.array([3.0, 4.0, 0.2]), np.array([5.0, 4.5, -0.1])):
        landscape.place(middle, np.zeros(2))
        vertices = scene.world(f"{ROOT}/tile_0_0")
        assert vertices[0] + middle == pytest.approx(np.append(0, [0, hills.ground.floor_at(np.zeros((1, 2)))[0]]))
        assert np.array_equal(scene.nodes[ROOT].position, -middle)


def test_tiles_come_as_one_walks_and_go_again(fakes, scene, hills):
    landscape = Landscape(scene, hills.model, hills.ground)
    for x in np.linspace(-40, 40, 160):
        before = len(tiles(scene))
        landscape.place(np.array([x, 1.0, 0.0]), np.zeros(2))
        assert len(tiles(scene)) - before <= 2
        assert len(tiles(scene)) <= (2 * KEPT / TILE + 2) ** 2
        if x > -36:
            near = {(int(np.floor((x + d) / TILE)), 0) for d in (-REACH + 1, 0, REACH - 1)}
            assert near <= tiles(scene)
    assert min(x for x, _ in tiles(scene)) == int((40 - KEPT) // TILE)


def test_flat_ground_is_endless(fakes, scene):
    worlds = worlds_of("IceWalk")
    landscape = Landscape(scene, worlds.model, worlds.ground)
    landscape.place(np.array([1234.25, -7.5, 0.0]), np.array([1236.0, -7.5]))
    assert not tiles(scene) and scene.nodes["/lines"].position.tolist() == [-0.25, -0.5, 0]
    assert (scene.nodes["/floor"].vertices[:, 2] < 0).all()
    red, _, blue = scene.nodes["/floor"].color
    assert red < blue, "ice is blue"
    ring = scene.world(f"{ROOT}/goal")
    assert ring[:, :2].mean(axis=0) == pytest.approx([1.75, 0], abs=0.02)
