"""Adapt a shipped walk to one gait cycle of a motion file, then save what was learned.

python examples/adapt_to_a_motion.py my_walk.bvh --samples 2000000
"""

import argparse
from pathlib import Path

from adapt_envs.motion.importing import import_motion
from sb3_adaptnet import AdaptNetPolicy, AdaptVecEnv, callbacks, hyperparameters, save_adaptation
from stable_baselines3 import PPO

STYLE = "AdaptNet/Humanoid-Style-v0"
"""The environment whose motion is an argument."""


def clip_of(motion: str, output: Path) -> str:
    """The motion as `gym.make(motion=...)` takes it; of a recorded file one gait cycle, fitted to the character."""
    if Path(motion).suffix.lower() not in (".bvh", ".json"):
        return motion
    clip = import_motion(motion, style=True)
    file = output.with_suffix(".npz")
    clip.save(file)
    print(f"one gait cycle, {clip.seconds:.2f} s at {clip.mean_speed:.2f} m/s: {file}")
    return str(file)


def main() -> None:
    """Import, adapt, save."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("motion", help="a BVH, JSON or clip file, or the name of a motion that ships")
    parser.add_argument("--base", default="walk", help="policy to adapt, a name or a file")
    parser.add_argument("--samples", type=int, default=2_000_000, help="control steps over all worlds")
    parser.add_argument("--num-envs", type=int, default=256, help="worlds")
    parser.add_argument("--output", type=Path, default=Path("my_style.safetensors"), help="weight file to write")
    options = parser.parse_args()

    motion = clip_of(options.motion, options.output)
    env = AdaptVecEnv(STYLE, num_envs=options.num_envs, motion=motion, stagger=True)
    model = PPO(AdaptNetPolicy, env, **hyperparameters(STYLE, base=options.base))
    model.learn(options.samples, callback=callbacks(STYLE))
    file = save_adaptation(model, options.output, environment=STYLE, motion=motion)
    print(f"look at it: adaptnet play {file}")


if __name__ == "__main__":
    main()
