"""Adapt the walk with a PPO loop of your own: policy, discriminators and advantages are parts that you call."""

import argparse

from adapt_envs import AdaptVectorEnv, make_vector
import numpy as np
from sb3_adaptnet import AdaptNetPolicy, save_adaptation
from sb3_adaptnet.objectives import ImitationObjective, combine_advantages, generalized_advantages
import torch

STOOP, WEIGHTS = "AdaptNet/Humanoid-Stoop-v0", (0.35, 0.65)  # of imitation and goal
FALL, GAMMA, LAMBDA, CLIP, STEPS, EPOCHS, BATCH = -10.0, 0.98, 0.95, 0.2, 16, 4, 1024


@torch.no_grad()
def collect(policy: AdaptNetPolicy, env: AdaptVectorEnv, observations: np.ndarray) -> list[np.ndarray]:
    """Arrays (T, N, ...) of T steps, then observations (N, 784) and values (N, K) after them."""
    policy.set_training_mode(False)
    rows = []
    for _ in range(STEPS):
        acted = [x.numpy() for x in policy(torch.from_numpy(observations))]  # actions, values, log-probabilities
        after, goal, fell, _, _ = env.step(acted[0])
        rows.append((observations, *acted, env.pose_windows.copy(), goal.astype(np.float32), fell))
        observations = after
    values = policy.predict_objective_values(torch.from_numpy(observations)).numpy()
    return [*(np.stack(column) for column in zip(*rows, strict=True)), observations, values]


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--samples", type=int, default=500_000, help="control steps over all worlds")
parser.add_argument("--num-envs", type=int, default=512, help="worlds")
options = parser.parse_args()
env, rng = make_vector(STOOP, options.num_envs, max_episode_steps=None), np.random.default_rng(0)
spaces = env.single_observation_space, env.single_action_space
policy = AdaptNetPolicy(*spaces, lambda _: 5e-4, base="walk", actor_lr=5e-5)  # 5e-4 is the critic's
policy.set_objectives(WEIGHTS)
judge, last = ImitationObjective(), env.reset(seed=0)[0]
for _ in range(-(-options.samples // (STEPS * env.num_envs))):
    seen, actions, values, old_log_prob, windows, goal, fell, last, last_values = collect(policy, env, last)
    windows = windows.reshape(-1, *windows.shape[2:])
    judge.update(windows, env.sample_reference_windows(len(windows), rng), rng)
    rewards = np.stack([judge.rewards(windows).reshape(goal.shape), goal], axis=-1)
    print(f"imitation {rewards[..., 0].mean():.3f}, goal {goal.mean():.3f}, {fell.sum()} falls")
    rewards[fell] = FALL
    gains = generalized_advantages(rewards, values, last_values, fell, GAMMA, LAMBDA)
    arrays = seen, actions, old_log_prob, combine_advantages(gains, WEIGHTS), gains + values
    samples = [torch.from_numpy(array).flatten(0, 1) for array in arrays]
    policy.value_norm.update(samples[-1])
    policy.set_training_mode(True)
    for rows in torch.cat([torch.randperm(len(samples[0])) for _ in range(EPOCHS)]).split(BATCH):
        observations, taken, before, advantages, returns = (column[rows] for column in samples)
        predicted, log_prob, _ = policy.evaluate_actions(observations, taken)
        ratio, error = (log_prob - before).exp(), predicted - policy.value_norm.normalize(returns)
        gained = torch.minimum(ratio * advantages, ratio.clamp(1 - CLIP, 1 + CLIP) * advantages)
        policy.optimizer.zero_grad()
        (0.5 * error.square().mean() - gained.mean()).backward()  # the adaptation's regularisers (eq. 12) join here
        torch.nn.utils.clip_grad_norm_(policy.parameters(), 1.0)
        policy.optimizer.step()
save_adaptation(policy, "own_stoop.safetensors", environment=STOOP)
