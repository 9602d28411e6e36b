"""Run an exported policy with onnxruntime and MuJoCo, without torch: the walk, then bent over, as strength grows to 1.

adaptnet export walk walk-stoop -o walk.onnx
python examples/run_onnx.py walk.onnx
"""

import argparse
import json

import adapt_envs  # noqa: F401 (registers the ids)
import gymnasium as gym
import numpy as np
import onnxruntime

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("graph", help="what `adaptnet export walk walk-stoop -o walk.onnx` wrote")
policy = onnxruntime.InferenceSession(parser.parse_args().graph)
about = {key: json.loads(value) for key, value in policy.get_modelmeta().custom_metadata_map.items()}
env = gym.make("AdaptNet/Humanoid-Walk-v0", max_episode_steps=-1)
FLAT = np.zeros((1, 1, 35, 35), np.float32)
ahead = {"goal_heading": 0.0, "goal_speed": 1.0}
observation, _ = env.reset(seed=0, options=ahead)
for step in range(301):
    strength = min(1.0, step / 150)
    strengths = np.full((1, len(about["adaptations"])), strength, np.float32)
    given = {"observation": observation[None], "strengths": strengths, "heightmap": FLAT}
    (action,) = policy.run(None, {wanted.name: given[wanted.name] for wanted in policy.get_inputs()})
    observation, reward, terminated, _, info = env.step(action[0])
    if step % 30 == 0 or terminated:
        head = observation[3 * 195 + 2 * 13 + 2]  # frame 3 (now), link 2 (head), component 2 (height)
        end = "" if not terminated else f"   {info['end']}"
        print(f"{step / about['control_hz']:4.1f} s   strength {strength:.2f}   head {head:.2f} m{end}")
    if terminated:
        observation, _ = env.reset(options=ahead)
