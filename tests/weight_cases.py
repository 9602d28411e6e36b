"""An environment, settings and observations that the tests of weights share; not a test itself."""

import numpy as np
from toy_env import ToyEnv

ENV = ToyEnv()
OBSERVATIONS = np.random.default_rng(0).normal(0, 0.5, (5, 784)).astype(np.float32)
ARGUMENTS = {"n_steps": 32, "batch_size": 16, "n_epochs": 1, "device": "cpu"}


def act(policy):
    return policy.predict(OBSERVATIONS, deterministic=True)[0]
