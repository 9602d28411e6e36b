"""The skeleton's motion: chained back together it is MuJoCo's, turned to y up."""

import mujoco
import numpy as np
import pytest

from adapt_envs.features import rotations
from adapt_envs.model.build import build_character, compile_model
from adapt_envs.model.humanoid import LINKS
from adapt_envs.model.morphology import MORPHOLOGIES
from adapt_envs.motion.exporting import perform
from adapt_envs.motion.exporting.performance import BONES, y_up
from adapt_envs.motion.importing.bvh import compose

CHARACTERS = {"plain": (None, ()), "long shins": (MORPHOLOGIES["long_shins"], ()), "stiff": (None, ("abdomen", "knee"))}


def tumbling(model, frames=12, seed=0):
    """Configurations (T, nq) with any angles within the limits, the root anywhere."""
    rng = np.random.default_rng(seed)
    low, high = model.jnt_range[1:].T
    quats = rng.normal(size=(frames, 4))
    quats /= np.linalg.norm(quats, axis=1, keepdims=True)
    angles = rng.uniform(low, high, (frames, len(low)))
    return np.concatenate([rng.uniform(-3, 3, (frames, 3)), quats, angles], axis=1)


@pytest.mark.parametrize("character", CHARACTERS)
def test_chained_together_it_is_where_mujoco_has_it(character):
    model = compile_model(build_character(*CHARACTERS[character]))
    qpos = tumbling(model)
    made = perform(model, qpos, 30.0, floor=0.25)
    local = np.broadcast_to(made.offsets, (len(qpos), len(LINKS), 3)).copy()
    local[:, 0] = made.root
    pos, quat = compose(np.array(made.parents), local, made.quats)
    start, data = np.array([*qpos[0, :2], 0.25]), mujoco.MjData(model)
    for frame, configuration in enumerate(qpos):
        data.qpos[:] = configuration
        mujoco.mj_kinematics(model, data)
        for bone, link in enumerate(LINKS):
            assert pos[frame, bone] == pytest.approx(y_up(data.body(link).xpos - start), abs=1e-9)
            point = np.array([0.1, -0.2, 0.3])
            turned = rotations.rotate(data.body(link).xquat, point)
            assert rotations.rotate(quat[frame, bone], y_up(point)) == pytest.approx(y_up(turned), abs=1e-9)


def test_y_is_up_z_ahead_and_x_left():
    assert y_up(np.eye(3)).tolist() == [[0, 0, 1], [1, 0, 0], [0, 1, 0]]


def test_at_rest_it_stands_with_its_arms_down():
    made = perform(compile_model(), np.array([compile_model().qpos0]), 30.0)
    assert np.allclose(made.quats, [1, 0, 0, 0])
    at = dict(zip(made.names, made.rest, strict=True))
    assert at["Head"][1] > at["Spine"][1] > at["Hips"][1] > at["LeftLeg"][1] > at["LeftFoot"][1] > 0
    assert at["LeftHand"][0] > 0 > at["RightHand"][0] and at["LeftHand"][1] < at["LeftArm"][1]
    assert made.names == tuple(BONES[link] for link in LINKS) and made.parents[0] == -1
