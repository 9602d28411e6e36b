"""`adaptnet bench train`: samples per second of whole training iterations, and where the time goes.

An iteration is what PPO does per rollout: act and simulate, train the discriminators for one pass, score the windows,
compute advantages, update actor and critic for some epochs, all by the zoo's entry. The plain version is the same
networks in float32 with torch's own GRU, an unfused optimiser and, adapting, no memory of what the frozen encoder made
of a sample; both take turns in one process.
"""

import argparse
import json
import statistics
import time
from collections import defaultdict
from collections.abc import Callable
from typing import Any

import torch
from stable_baselines3 import PPO

from adapt_envs.commands.numbers import positive
from sb3_adaptnet.modules.encoder import StateEncoder
from sb3_adaptnet.objectives.callback import DiscriminatorRewardCallback
from sb3_adaptnet.runs.experiment import Experiment, experiment
from sb3_adaptnet.runs.run_folder import RunSettings
from sb3_adaptnet.runs.worlds import make_worlds

PARTS = ("act", "simulate", "discriminators", "imitation_reward", "update", "other")
"""What an iteration's time is divided into."""
PLAIN = {"precision": "fp32", "optimizer_kwargs": {"fused": False}}
"""Arguments of the plain version's policy."""


def add_parser(subparsers: Any) -> None:
    """Add the subcommand `train`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "train", help="samples per second of whole training iterations, against plain float32"
    )
    parser.add_argument("--id", default="AdaptNet/Humanoid-Walk-v0", help="environment (default: %(default)s)")
    parser.add_argument("--worlds", type=positive, help="number of worlds; default: the entry's")
    parser.add_argument("--threads", type=positive, help="threads of physics and networks; default: all cores")
    parser.add_argument(
        "--iterations", type=positive, default=3, help="measured iterations of each (default: %(default)s)"
    )
    parser.add_argument("--conf-file", help="YAML file with the entry to measure")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Measure and print."""
    figures = measure(options.id, options.worlds, options.threads, options.iterations, options.conf_file)
    if options.json:
        print(json.dumps(figures))
        return 0
    seconds, plain_seconds = figures.pop("seconds"), figures.pop("plain_seconds")
    for name, value in figures.items():
        print(f"{name:28s}{value:.2f}" if isinstance(value, float) else f"{name:28s}{value}")
    for name, value in seconds.items():
        print(f"  {name:26s}{value:.3f} s per iteration, plain {plain_seconds[name]:.3f} s")
    return 0


def measure(
    env_id: str,
    worlds: int | None = None,
    threads: int | None = None,
    iterations: int = 3,
    conf_file: str | None = None,
) -> dict[str, Any]:
    """Time whole iterations of the fast and the plain version in turn.

    Args:
        env_id: environment; its zoo entry says what is trained.
        worlds: number of worlds; None for the entry's.
        threads: threads of physics and networks; None for all cores.
        iterations: measured iterations of each version, after one to warm up.
        conf_file: YAML file; None for the shipped one.

    Returns:
        samples_per_second, plain_samples_per_second, speedup_over_plain (medians of wall time); speedup_in_cpu_time,
        which other processes on the machine disturb less; seconds per part of one iteration of each version.
    """
    if threads is not None:
        torch.set_num_threads(threads)
    entry = experiment(env_id, conf_file=conf_file)
    worlds = entry.n_envs if worlds is None else worlds
    fast, plain = (_Bench(entry, worlds, threads, plain) for plain in (False, True))
    for bench in (fast, plain):
        bench.iterate()
        bench.forget()
    for _ in range(iterations):
        fast.iterate()
        plain.iterate()
    rates = [worlds * fast.model.n_steps / statistics.median(bench.totals) for bench in (fast, plain)]
    figures: dict[str, Any] = {
        "environment": env_id,
        "policy": entry.policy.__name__,
        "worlds": worlds,
        "threads": torch.get_num_threads(),
        "precision": fast.model.policy.precision,
        "samples_per_second": rates[0],
        "plain_samples_per_second": rates[1],
        "speedup_over_plain": rates[0] / rates[1],
        "speedup_in_cpu_time": statistics.median(plain.cpu) / statistics.median(fast.cpu),
        "seconds": fast.seconds(),
        "plain_seconds": plain.seconds(),
    }
    for bench in (fast, plain):
        bench.model.env.close()
    return figures


class _Bench:
    """A model whose parts are timed."""

    def __init__(self, entry: Experiment, worlds: int, threads: int | None, plain: bool) -> None:
        env: Any = make_worlds(RunSettings(entry.env_id, samples=1, n_envs=worlds, threads=threads), entry, seed=0)
        given = entry.arguments
        settings = {**given, "policy_kwargs": {**given["policy_kwargs"], **(PLAIN if plain else {})}}
        self.model: Any = PPO(entry.policy, env, seed=0, **settings)
        self.callback, self.plain = _callback(entry), plain
        if plain:
            _take_torch_gru(self.model.policy)
            _forget_base_codes(self.model.policy)
        self.totals: list[float] = []
        self.cpu: list[float] = []
        self.parts: dict[str, list[float]] = defaultdict(list)
        self._time(env, "step_wait", "simulate")
        self._time(self.model, "train", "update")
        self._time(self.model.policy, "forward", "act")

    def iterate(self) -> None:
        """One rollout and update."""
        samples = self.model.n_steps * self.model.n_envs
        fresh = self.callback.imitation is None
        start, cpu = time.perf_counter(), time.process_time()
        self.model.learn(samples, callback=self.callback, reset_num_timesteps=False)
        self.totals.append(time.perf_counter() - start)
        self.cpu.append(time.process_time() - cpu)
        if fresh and self.callback.imitation is not None:
            self._time(self.callback.imitation, "update", "discriminators")
            self._time(self.callback.imitation, "rewards", "imitation_reward")
            if self.plain:
                _take_torch_gru(self.callback.imitation.discriminator)

    def forget(self) -> None:
        """Drop what was measured so far."""
        self.totals.clear()
        self.cpu.clear()
        self.parts.clear()

    def seconds(self) -> dict[str, float]:
        """Mean seconds per iteration of each part; "other" is what no part covers."""
        iterations = len(self.totals)
        known = {part: sum(self.parts[part]) / iterations for part in PARTS[:-1]}
        return {**known, "other": sum(self.totals) / iterations - sum(known.values())}

    def _time(self, owner: Any, method: str, part: str) -> None:
        setattr(owner, method, _timed(getattr(owner, method), self.parts, part))


def _take_torch_gru(network: torch.nn.Module) -> None:
    """Let a network's state encoders run `torch.nn.GRU` instead of the project's own."""
    encoders: list[Any] = [module for module in network.modules() if isinstance(module, StateEncoder)]
    for encoder in encoders:
        encoder.forward = _torch_gru(encoder.gru)


def _forget_base_codes(policy: Any) -> None:
    """Let a policy around a frozen base encode every sample again in every epoch."""
    act = policy.forward

    def forgetful(*args: Any, **kwargs: Any) -> Any:
        result = act(*args, **kwargs)
        policy.remembered = {}
        return result

    policy.forward = forgetful


def _torch_gru(gru: torch.nn.GRU) -> Callable[[torch.Tensor], torch.Tensor]:
    return lambda frames: gru(frames)[1][0]


def _timed(function: Callable[..., Any], parts: dict[str, list[float]], part: str) -> Callable[..., Any]:
    def call(*args: Any, **kwargs: Any) -> Any:
        start = time.perf_counter()
        result = function(*args, **kwargs)
        parts[part].append(time.perf_counter() - start)
        return result

    return call


def _callback(entry: Experiment) -> DiscriminatorRewardCallback:
    for cls, kwargs in entry.callbacks:
        if issubclass(cls, DiscriminatorRewardCallback):
            return cls(**kwargs)
    return DiscriminatorRewardCallback()
