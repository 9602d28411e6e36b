"""Register an environment on a terrain of your own, look at it, and measure shipped policies on it.

python examples/terrain_of_your_own.py --picture dunes.png
"""

import argparse

import adapt_envs
from adapt_envs.drawing import write_png
from adapt_envs.model import GRID, perlin
import gymnasium as gym
import numpy as np
from sb3_adaptnet import load_policy
from sb3_adaptnet.evaluation import evaluate, open_worlds


def dunes(rng: np.random.Generator, size: int) -> np.ndarray:
    """Heights (size, size) [m] on a grid of 0.1 m: ridges along y every 6 m, a little uneven."""
    x = np.arange(size) * GRID
    return 0.3 * np.sin(2 * np.pi * x / 6)[None, :] + 0.1 * perlin(rng, size, wavelength=3.0)


def main() -> None:
    """Register, draw, measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--policies", nargs="+", default=["walk", "walk-terrainhills"], help="names or files")
    parser.add_argument("--seconds", type=float, default=200.0, help="simulated seconds of each policy")
    parser.add_argument("--picture", help="file to write: a picture of the world")
    options = parser.parse_args()

    spec = adapt_envs.TaskSpec("walk", terrain=dunes, heightmap=True, summary="Walk over dunes.")
    dunes_id = adapt_envs.register(spec, name="Dunes")
    if options.picture:
        env = gym.make(dunes_id, render_mode="rgb_array")
        env.reset(seed=0)
        write_png(env.render(), options.picture)
    for name in options.policies:
        env = open_worlds(dunes_id)
        figures = evaluate(load_policy(name, env), env, seconds=options.seconds).figures
        print(f"{name}: goal reward {figures.goal_reward:.3f}, {figures.falls_per_minute:.1f} falls a minute")
    print("To train on it, register it in a module my_envs.py here:")
    print("    PYTHONPATH=. adaptnet train my_envs:AdaptNet/Humanoid-Dunes-v0")


if __name__ == "__main__":
    main()
