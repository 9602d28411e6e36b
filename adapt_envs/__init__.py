"""AdaptNet's worlds: a humanoid, its reference motions and batched Gymnasium environments.

Importing the package registers the ids `AdaptNet/Humanoid-...-v0`.
"""

from adapt_envs.drawing import headless as headless  # first: it chooses OpenGL's backend before MuJoCo is imported
from adapt_envs.env import AdaptEnv
from adapt_envs.registration import env_id, make_vector, register, register_suite
from adapt_envs.suite import SUITE, TaskSpec
from adapt_envs.vector_env import AdaptVectorEnv

__all__ = ["SUITE", "AdaptEnv", "AdaptVectorEnv", "TaskSpec", "env_id", "make_vector", "register", "register_suite"]

register_suite()
