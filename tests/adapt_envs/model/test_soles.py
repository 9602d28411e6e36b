"""The soles' geometry: one set of boxes, seen as corners, grids, edges and heights."""

import mujoco
import numpy as np
import pytest

from adapt_envs.features import rotations
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import build_character, compile_model, plain_model
from adapt_envs.model.humanoid import FEET, FOOT_LINKS, load_spec
from adapt_envs.model.morphology import MORPHOLOGIES, Morphology
from adapt_envs.model.soles import lowest_corner, sole_corners, sole_edges, sole_grid

LARGE_FEET = Morphology(size={"right_foot": 1.3, "left_foot": 0.8})


def poses(model, count=200):
    """Random configurations (count, nq) of the character, upright or not."""
    rng = np.random.default_rng(0)
    qpos = np.zeros((count, model.nq))
    qpos[:, :3] = rng.normal(size=(count, 3))
    qpos[:, 3:7] = rng.normal(size=(count, 4))
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    qpos[:, 7:] = rng.uniform(*model.jnt_range[1:].T, size=(count, model.nu))
    return qpos


def test_the_corners_are_those_of_mujocos_boxes():
    model = plain_model()
    for foot, corners in zip(FEET, sole_corners(model), strict=True):
        geom = model.geom(foot)
        assert geom.type == mujoco.mjtGeom.mjGEOM_BOX
        assert np.allclose(np.abs(corners - geom.pos), geom.size)
        assert np.allclose(corners[:, 2], corners[:, 2].min()) and corners[0, 2] < geom.pos[2]
        assert len(np.unique(corners, axis=0)) == 4


def test_edges_are_as_far_from_the_ankle_as_the_corners():
    corners = sole_corners(plain_model())
    edges = sole_edges()
    assert np.allclose(corners[..., 2], -edges.below)
    assert np.allclose(np.sort(np.unique(corners[..., 0])), [-edges.behind, edges.ahead])


def test_a_grid_fills_the_rectangle_between_the_corners():
    model = plain_model()
    corners, grid = sole_corners(model), sole_grid(model, along=6, across=4)
    assert grid.shape == (2, 24, 3)
    for reduced in (np.min, np.max):
        assert np.allclose(reduced(grid, axis=1), reduced(corners, axis=1))
    steps = [np.diff(np.unique(np.round(grid[0, :, axis], 9))) for axis in (0, 1)]
    assert [len(step) for step in steps] == [5, 3]
    assert all(np.ptp(step) < 1e-8 for step in steps)
    assert np.allclose(sole_grid(model, 2, 2).sum(axis=1), corners.sum(axis=1))


@pytest.mark.parametrize("shape", [None, LARGE_FEET, MORPHOLOGIES["super_long_legs"]])
def test_a_spec_and_its_model_have_the_same_soles(shape):
    expected = sole_corners(compile_model(build_character(shape)))
    assert np.allclose(sole_corners(build_character(shape)), expected)
    assert np.allclose(expected, sole_corners(load_spec())) == (shape is not LARGE_FEET)


@pytest.mark.parametrize("shape", [None, LARGE_FEET])
def test_the_lowest_corner_is_the_lowest_of_all_corners_of_the_boxes(shape):
    model = compile_model(build_character(shape))
    qpos = poses(model)
    data, lowest = mujoco.MjData(model), []
    signs = np.stack(np.meshgrid(*[(-1, 1)] * 3), axis=-1).reshape(-1, 3)
    for row in qpos:
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        boxes = [model.geom(foot) for foot in FEET]
        corners = [data.geom_xpos[box.id] + signs * box.size @ data.geom_xmat[box.id].reshape(3, 3).T for box in boxes]
        lowest.append(np.min(np.array(corners)[..., 2]))
    assert np.allclose(lowest_corner(model, Kinematics(model).link_states(qpos)), lowest, atol=1e-5)


def test_the_lowest_corner_of_an_upright_foot_is_a_corner_of_its_sole():
    model = plain_model()
    qpos = np.zeros((1, model.nq))
    qpos[:, 2:4] = (0.881416, 1)
    links = Kinematics(model).link_states(qpos)
    feet = links[:, FOOT_LINKS].astype(np.float64)
    corners = rotations.placed(feet[..., :3], feet[..., 3:7], sole_corners(model))
    assert corners[..., 2].min() == pytest.approx(0, abs=1e-6)
    assert lowest_corner(model, links) == pytest.approx(corners[..., 2].min(axis=(1, 2)), abs=1e-6)
