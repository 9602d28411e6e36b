"""The character and random states of it."""

import numpy as np
import pytest

from adapt_envs.model.build import plain_model


@pytest.fixture(scope="module")
def model():
    return plain_model()


@pytest.fixture(scope="module")
def states(model):
    rng = np.random.default_rng(0)
    qpos = np.zeros((40, model.nq))
    qpos[:, :3] = rng.normal(size=(40, 3)) * 3
    qpos[:, 3:7] = rng.normal(size=(40, 4))
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    qpos[:, 7:] = rng.uniform(*model.jnt_range[1:].T, size=(40, model.nu))
    return qpos, rng.normal(size=(40, model.nv)) * 3
