"""Blend two adaptations of one base while the character walks: from the first style to the second and back.

python examples/blend_two_styles.py            # prints what happens
python examples/blend_two_styles.py --window   # shows it; `adaptnet play` has keys and sliders for the same
"""

import argparse
import math

import gymnasium as gym
from sb3_adaptnet import load_policy

CYCLE = 20.0
"""Seconds from the first style to the second and back."""


def main() -> None:
    """Walk straight ahead; set the blend at every step."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--styles", nargs=2, default=["walk-strutting", "walk-joyful"], help="adaptations of one base")
    parser.add_argument("--steps", type=int, default=600, help="control steps of 1/30 s")
    parser.add_argument("--speed", type=float, default=1.0, help="preferred speed [m/s]")
    parser.add_argument("--window", action="store_true", help="open a window")
    options = parser.parse_args()

    env = gym.make(
        "AdaptNet/Humanoid-Walk-v0", max_episode_steps=-1, render_mode="human" if options.window else None
    )  # the id is known: sb3_adaptnet imports adapt_envs
    first, second = options.styles
    policy = load_policy(first, env)
    other = policy.add_adaptation(second)
    ahead = {"goal_heading": 0.0, "goal_speed": options.speed}
    observation, _ = env.reset(seed=0, options=ahead)
    for step in range(options.steps):
        share = 0.5 - 0.5 * math.cos(2 * math.pi * step / 30 / CYCLE)
        policy.blend({"main": 1 - share, other: share})
        action, _ = policy.predict(observation, deterministic=True)
        observation, reward, terminated, _, info = env.step(action)
        if step % 30 == 0:
            print(f"{step / 30:5.1f} s   {1 - share:.2f} {first} + {share:.2f} {second}   goal reward {reward:.2f}")
        if terminated:
            print(f"{step / 30:5.1f} s   {info['end']}")
            observation, _ = env.reset(options=ahead)
    env.close()


if __name__ == "__main__":
    main()
