"""Velocities and momentum against MuJoCo."""

import mujoco
import numpy as np

from adapt_envs.model.build import plain_model
from adapt_envs.motion.clip import velocities


def test_velocities_equal_mujocos_difference():
    model, rng = plain_model(), np.random.default_rng(0)
    qpos = rng.normal(size=(40, model.nq))
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    for a, b in zip(qpos[:-1], qpos[1:], strict=True):
        expected = np.zeros(model.nv)
        mujoco.mj_differentiatePos(model, expected, 1 / 15, a, b)
        assert np.allclose(velocities(a[None], b[None], 1 / 15)[0], expected, atol=1e-10)
