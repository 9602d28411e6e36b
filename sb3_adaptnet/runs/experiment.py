"""Experiments of the zoo's YAML files: what to train with on an environment."""

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from stable_baselines3 import PPO
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.policies import BasePolicy

from sb3_adaptnet.algorithms.svg import SVG
from sb3_adaptnet.runs.yaml_values import arguments_of, load_class, mapping, whole
from sb3_adaptnet.weights.shipped import zoo_config_path

ALGORITHMS: dict[str, type[BaseAlgorithm]] = {"ppo": PPO, "svg": SVG}
"""Algorithms by name; the configuration that is read where none is named has the same name."""
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""Reads plain values alone, in C where libyaml is there."""
FALLBACK = "default"
"""Entry for ids that are not named in the file, as in rl_zoo3."""
RUN_KEYS = ("n_envs", "n_timesteps", "policy", "callback", "env_kwargs")
"""Keys of an entry that belong to the run, not to the algorithm."""
FIRST_STEP = 1e-6
"""PPO's first actor rate when it goes on from an adaptation: 1e-4 gave the first update a KL of 1.9."""
NOT_FROM_YAML = ("self", "env", "policy", "seed", "device", "_init_setup_model")
"""Arguments of an algorithm that an entry cannot give: they are the run's."""


@dataclass(frozen=True)
class Experiment:
    """One entry of a YAML file.

    Attributes:
        env_id: environment it is for.
        policy: the policy class.
        algorithm: name of the algorithm in `ALGORITHMS`.
        arguments: its keyword arguments besides policy and environment, with `policy_kwargs`.
        n_envs: worlds.
        samples: control steps over all worlds to train for.
        callbacks: (class, keyword arguments) in order.
        env_kwargs: arguments of the environment.
    """

    env_id: str
    policy: type
    algorithm: str
    arguments: dict[str, Any]
    n_envs: int
    samples: int
    callbacks: tuple[tuple[type, dict[str, Any]], ...]
    env_kwargs: dict[str, Any] = field(default_factory=dict)

    def make_callbacks(self) -> list[BaseCallback]:
        """Make fresh callbacks; one that has been in a training cannot serve another."""
        return [cls(**kwargs) for cls, kwargs in self.callbacks]


def hyperparameters(
    env_id: str, base: str | None = None, conf_file: str | Path | None = None, algo: str = "ppo"
) -> dict[str, Any]:
    """Return an algorithm's keyword arguments for an environment from the zoo's YAML entry.

    Args:
        env_id: such as "AdaptNet/Humanoid-Stoop-v0".
        base: name or file of the base to adapt; None keeps the entry's.
        conf_file: YAML file, or the name of a shipped one; default: the algorithm's.
        algo: "ppo" or "svg".

    Returns:
        `n_steps`, `batch_size`, `policy_kwargs` and so on, a fresh dict.

    Raises:
        ValueError: if the file is unknown, it has neither an entry for the id nor a `default`, or the entry holds a key
            that nothing reads; for an unknown algorithm.
    """
    return dict(experiment(env_id, base, conf_file, algo).arguments)


def callbacks(env_id: str, conf_file: str | Path | None = None, algo: str = "ppo") -> list[BaseCallback]:
    """Make the callbacks of the zoo's YAML entry, for `learn`: discriminators for PPO, then ramps, averages and such.

    Args:
        env_id: such as "AdaptNet/Humanoid-Stoop-v0".
        conf_file: YAML file, or the name of a shipped one; default: the algorithm's.
        algo: "ppo" or "svg".

    Raises:
        ValueError: as `hyperparameters`.
    """
    return experiment(env_id, conf_file=conf_file, algo=algo).make_callbacks()


def experiment(
    env_id: str, base: str | None = None, conf_file: str | Path | None = None, algo: str = "ppo",
    start: str | None = None,
) -> Experiment:  # fmt: skip
    """Read and check the whole entry of an environment; arguments and errors as `hyperparameters`.

    `start` is the adaptation to go on from; None keeps the entry's, if it has one. It is treated gently: PPO's first
    steps are small unless the entry has its own `actor_lr`; SVG's first guess, which would overwrite it, is left out.
    """
    file = conf_path(check_algorithm(algo) if conf_file is None else conf_file)
    return experiment_of(read_entry(file, env_id), env_id, base, algo, file.name, start)


def check_algorithm(algo: str) -> str:
    """Return the name of an algorithm.

    Raises:
        ValueError: if there is none of that name.
    """
    if algo not in ALGORITHMS:
        raise ValueError(f"there is no algorithm {algo!r}; there are: {', '.join(ALGORITHMS)}")
    return algo


def experiment_of(
    entry: Mapping[str, Any], env_id: str, base: str | None = None, algo: str = "ppo", source: str = "entry",
    start: str | None = None,
) -> Experiment:  # fmt: skip
    """Check the entry of an environment; `source` says in errors where it stands, for `start` see `experiment`.

    Raises:
        ValueError: as `hyperparameters`.
    """
    check_algorithm(algo)
    where = f"{source}: {env_id}"
    keys = tuple(name for name in inspect.signature(ALGORITHMS[algo]).parameters if name not in NOT_FROM_YAML)
    _refuse_unknown(where, entry, (*keys, *RUN_KEYS))
    for key in ("policy", "n_envs", "n_timesteps"):
        if key not in entry:
            raise ValueError(f"{where}: the entry lacks {key!r}")
    policy = load_class(where, entry["policy"], BasePolicy)
    policy_kwargs = dict(mapping(f"{where}: policy_kwargs", entry.get("policy_kwargs") or {}))
    start = policy_kwargs.get("start") if start is None else start
    if base is not None:
        policy_kwargs["base"] = base
    if start is not None:
        policy_kwargs["start"] = start
        if algo == "ppo":
            policy_kwargs.setdefault("actor_lr", FIRST_STEP)
        else:
            entry = {**entry, "regression_updates": 0}
    _refuse_unknown(f"{where}: policy_kwargs", policy_kwargs, arguments_of(policy))
    policy_kwargs = {key: _number(where, key, value) for key, value in policy_kwargs.items()}
    arguments = {key: _number(where, key, value) for key, value in entry.items() if key in keys}
    return Experiment(
        env_id=env_id,
        policy=policy,
        algorithm=algo,
        arguments={**arguments, "policy_kwargs": policy_kwargs},
        n_envs=whole(f"{where}: n_envs", entry["n_envs"], least=1),
        samples=whole(f"{where}: n_timesteps", entry["n_timesteps"], least=1),
        callbacks=tuple(_callbacks(where, entry.get("callback"))),
        env_kwargs=dict(mapping(f"{where}: env_kwargs", entry.get("env_kwargs") or {})),
    )


def conf_path(conf_file: str | Path) -> Path:
    """Find a YAML file by path or shipped name.

    Raises:
        ValueError: if there is neither such a file nor such a name.
    """
    if Path(conf_file).is_file():
        return Path(conf_file)
    if Path(conf_file).suffix in (".yml", ".yaml") and len(Path(conf_file).parts) > 1:
        raise ValueError(f"no such configuration file: {conf_file}")
    return zoo_config_path(str(conf_file))


def read_entry(file: Path, env_id: str) -> dict[str, Any]:
    """Read the entry of an environment as it stands, or the file's fallback.

    Raises:
        ValueError: if the file is no YAML file, or has neither.
    """
    try:
        entries = yaml.load(file.read_text(encoding="utf-8"), Loader=LOADER)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ValueError(f"{file} is not a YAML file: {' '.join(str(error).split())}") from error
    if not isinstance(entries, dict):
        raise ValueError(f"{file} must hold a mapping from environment ids to their settings")
    names = (env_id, env_id.rpartition(":")[2], FALLBACK)  # "module:id" may have its own entry, or its id's
    entry = next((entries[name] for name in names if name in entries), None)
    if not isinstance(entry, dict):
        known = ", ".join(key for key in entries if not str(key).startswith("."))
        raise ValueError(f"{file.name} has no entry for {env_id!r}; it has: {known}")
    return entry


def _refuse_unknown(where: str, given: Mapping[str, Any], valid: tuple[str, ...]) -> None:
    unknown = [str(key) for key in given if key not in valid]
    if unknown:
        raise ValueError(f"{where}: unknown key {unknown[0]!r}; valid are: {', '.join(sorted(valid))}")


def _number(where: str, key: str, value: Any) -> Any:
    """Refuse numbers that YAML reads as text (5e-6), and rl_zoo3's schedules."""
    if isinstance(value, str) and value.startswith("lin_"):
        raise ValueError(f"{where}: {key} is {value!r}, a schedule; write a number, kl_range adjusts it")
    if isinstance(value, str):
        try:
            float(value)
        except ValueError:
            return value
        raise ValueError(f"{where}: {key} is text to YAML: write {float(value)!r} with a decimal point, as in 5.0e-6")
    return value


def _numbers(where: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """`_number` of all settings, also of those within others."""
    found = {}
    for key, value in settings.items():
        inner = isinstance(value, dict) and all(isinstance(name, str) for name in value)
        found[key] = _numbers(where, value) if inner else _number(where, key, value)
    return found


def _callbacks(where: str, entries: Any) -> list[tuple[type, dict[str, Any]]]:
    found = []
    for entry in entries if isinstance(entries, list) else [] if entries is None else [entries]:
        if isinstance(entry, dict) and len(entry) != 1:
            raise ValueError(f"{where}: each callback has a dash of its own, unlike {', '.join(map(str, entry))}")
        name, settings = next(iter(entry.items())) if isinstance(entry, dict) else (entry, {})
        cls = load_class(where, name, BaseCallback)
        settings = _numbers(f"{where}: {name}", mapping(f"{where}: {name}", settings or {}))
        _refuse_unknown(f"{where}: {name}", settings, arguments_of(cls))
        found.append((cls, dict(settings)))
    return found
