"""Measure an adaptation at several strengths and plot style against task."""

import argparse

from matplotlib import pyplot
from sb3_adaptnet import AdaptNetPolicy, load_policy
from sb3_adaptnet.evaluation import evaluate, open_worlds


def main() -> None:
    """Measure at each alpha, print a line each, write the plot."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--policy", default="walk-stoop", help="an adaptation, a name or a file")
    parser.add_argument("--env", default="AdaptNet/Humanoid-Stoop-v0", help="environment to measure it in")
    parser.add_argument("--alphas", type=float, nargs="+", default=[0.0, 0.25, 0.5, 0.75, 1.0], help="strengths")
    parser.add_argument("--seconds", type=float, default=300.0, help="simulated seconds at each strength")
    parser.add_argument("--output", default="alpha.png", help="picture to write")
    options = parser.parse_args()

    env = open_worlds(options.env)
    policy = load_policy(options.policy, env)
    if not isinstance(policy, AdaptNetPolicy):
        parser.error(f"{options.policy} is a base, which has no strength; name an adaptation, such as walk-stoop")
    found = []
    for alpha in options.alphas:
        policy.alpha = alpha
        figures = evaluate(policy, env, seconds=options.seconds, seed=0).figures
        found.append(figures)
        print(
            f"alpha {alpha:g}: goal reward {figures.goal_reward:.3f}, imitation error {figures.imitation_error_m} m, "
            f"{figures.falls_per_minute:.2f} falls a minute"
        )

    figure, goal_axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    error_axes = goal_axes.twinx()
    goal_axes.plot(options.alphas, [figures.goal_reward for figures in found], "o-", color="C0")
    error_axes.plot(options.alphas, [figures.imitation_error_m for figures in found], "s-", color="C1")
    goal_axes.set(xlabel="alpha", title=options.policy)
    goal_axes.set_ylabel("goal reward", color="C0")
    error_axes.set_ylabel("imitation error [m]", color="C1")
    figure.savefig(options.output, dpi=120)


if __name__ == "__main__":
    main()
