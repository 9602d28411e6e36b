"""What rl_zoo3 needs, no more: the native vector environment, under the constructor that it calls.

`python -m rl_zoo3.train ... --gym-packages sb3_adaptnet.zoo` imports this folder; that registers the environments and
makes rl_zoo3 use the native vector environment.
"""

import sys

from sb3_adaptnet.zoo.vec_env import ZooVecEnv

_manager = sys.modules.get("rl_zoo3.exp_manager")  # optional, slow to import: only there when rl_zoo3 is running
if _manager is not None:
    _manager.ExperimentManager.default_vec_env_cls = ZooVecEnv

__all__ = ["ZooVecEnv"]
