"""Opening a policy with its worlds from the words of a command line."""

import argparse
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import torch
from tqdm import tqdm

from adapt_envs import AdaptVectorEnv
from adapt_envs.commands.numbers import positive
from sb3_adaptnet.evaluation.recording import WORLDS, Acting, open_worlds
from sb3_adaptnet.policies.adaptnet import TRAINED, AdaptNetPolicy
from sb3_adaptnet.policies.loading import load_base_of, load_policy
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy
from sb3_adaptnet.weights.card import trained_in
from sb3_adaptnet.weights.checkpoint import BASE, read_kind

Item = TypeVar("Item")


@dataclass(frozen=True)
class LoadedPolicy:
    """A policy with the worlds it acts in.

    Attributes:
        policy: acts on `env`'s observations.
        env: worlds without a time limit.
        name: what was asked for.
        style: what its own adaptation is called, if it is one: the name, or the first of the styles of a base.
    """

    policy: ObjectivePolicy
    env: AdaptVectorEnv
    name: str
    style: str

    @property
    def title(self) -> str:
        """What acts, for people: the name, or the blend with its weights, and the strength where it is not 1."""
        if not isinstance(self.policy, AdaptNetPolicy):
            return Path(self.name).stem
        weights = {self.style if name == TRAINED else name: weight for name, weight in self.policy.weights.items()}
        parts = [name if weight == 1.0 else f"{weight:g} {name}" for name, weight in weights.items() if weight]
        title = " + ".join(parts) or "the base"
        return title if self.policy.alpha == 1.0 else f"{title}, alpha {self.policy.alpha:g}"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the policy and what goes with it: environment, motion, clip, base, alpha, blend, threads."""
    words = "name of a shipped base or adaptation, a weight file, or hf://OWNER/NAME"
    parser.add_argument("policy", metavar="POLICY", help=words)
    parser.add_argument("--env", metavar="ID", help="environment; default: the one it was trained in")
    parser.add_argument("--motion", metavar="NAME|FILE", help="reference clip, for environments that take motion=")
    words = "a style's clip: start from it, walk at its speeds and compare with it, whatever the environment"
    parser.add_argument("--clip", metavar="NAME|FILE", help=words)
    parser.add_argument("--base", metavar="NAME|FILE", help="base of the policy, where it is not found by itself")
    parser.add_argument("--alpha", type=float, help="strength of the adaptation: 0 is the base, 1 the default")
    words = "adaptations of the same base to blend, as in walk-stoop,walk-penguin or walk-stoop=0.3,walk-penguin=0.7"
    parser.add_argument("--styles", type=styles_of, default={}, metavar="A,B", help=words)
    parser.add_argument("--threads", type=positive, help="threads of networks and physics; default: all cores")


def open_from_options(options: argparse.Namespace, num_worlds: int = WORLDS) -> LoadedPolicy:
    """The policy and worlds that the options of `add_options` ask for.

    Raises:
        ValueError: if something asked for does not exist or does not fit.
    """
    if options.threads is not None:
        torch.set_num_threads(options.threads)
    env = open_worlds_for(options.policy, options.env, options.motion, num_worlds, options.threads, options.clip)
    policy = open_policy(options.policy, env, options.base, options.alpha, options.styles)
    first = next(iter(options.styles), options.policy) if read_kind(options.policy) == BASE else options.policy
    return LoadedPolicy(policy, env, options.policy, Path(first).stem)


def open_worlds_for(
    policy: str, env_id: str | None = None, motion: str | None = None, num_worlds: int = WORLDS,
    threads: int | None = None, clip: str | None = None,
) -> AdaptVectorEnv:  # fmt: skip
    """Worlds of an environment, or of the one that a weight file's card names if `env_id` is None.

    With `clip` they are a style's on this ground: its motion, and the speeds that its own environment asks for.

    Raises:
        ValueError: if the card names none, there is no such environment or motion, or two motions are given.
    """
    if clip is not None and motion is not None:
        raise ValueError(f"--clip {clip} and --motion {motion} both name a reference; give one of them")
    if env_id is None:
        env_id, trained_on = trained_in(policy)
        motion = motion or trained_on
    overrides: dict[str, Any] = {} if motion is None else {"motion": motion}
    if clip is not None:
        overrides = {"motion": clip, "speed_range": None}
    return open_worlds(env_id, num_worlds, num_threads=threads, **overrides)


def open_policy(
    name: str, env: Any, base: str | None = None, alpha: float | None = None,
    styles: dict[str, float | None] | None = None,
) -> ObjectivePolicy:  # fmt: skip
    """A policy at strength `alpha`, blended with further `styles` (name or file -> weight, None for an equal share).

    Weights that are not given share what the given ones leave of 1. Blending styles of a base blends them alone.

    Raises:
        ValueError: if there is nothing to scale or to blend.
    """
    rest = dict(styles or {})
    shares: dict[str, float | None] = {}
    if rest and read_kind(name) == BASE:
        base, name = name, next(iter(rest))
        shares[TRAINED] = rest.pop(name)
    policy = load_policy(name, env, base=base)
    if rest or shares or alpha is not None:
        if not isinstance(policy, AdaptNetPolicy):
            raise ValueError(f"alpha and styles need an adaptation; {name!r} is none")
        shares.setdefault(TRAINED, None)
        for style, weight in rest.items():
            shares[policy.add_adaptation(style)] = weight
        policy.blend(shared_out(shares))
        policy.alpha = policy.alpha if alpha is None else alpha
    return policy


def shared_out(shares: dict[str, float | None]) -> dict[str, float]:
    """Weights with the missing ones filled in: equal parts of what is left of 1."""
    missing = [name for name, weight in shares.items() if weight is None]
    left = max(0.0, 1.0 - sum(weight for weight in shares.values() if weight is not None))
    return {name: left / len(missing) if weight is None else weight for name, weight in shares.items()}


def styles_of(text: str) -> dict[str, float | None]:
    """Parse `a,b` or `a=0.3,b=0.7`."""
    styles: dict[str, float | None] = {}
    for part in filter(None, text.split(",")):
        name, equals, weight = part.partition("=")
        if name.strip() in styles:
            raise argparse.ArgumentTypeError(f"{name.strip()!r} stands there twice")
        try:
            styles[name.strip()] = float(weight) if equals else None
        except ValueError:
            raise argparse.ArgumentTypeError(f"{weight!r} is not a weight; write a,b or a=0.3,b=0.7") from None
    return styles


class ProgressBar:
    """A progress bar around anything that can be walked through, on a terminal's error stream; it leaves nothing."""

    def __init__(self, title: str) -> None:
        """Show `title` before the bar."""
        self.title = title

    def __call__(self, items: Iterable[Item]) -> Iterable[Item]:
        """The items, counted as they pass."""
        hidden = not sys.stderr.isatty()
        return tqdm(items, desc=self.title, leave=False, disable=hidden, dynamic_ncols=True)


def base_of(policy: ObjectivePolicy, name: str, env: AdaptVectorEnv, base: str | None = None) -> Acting | None:
    """What a style is compared with: `base`, or the one that the card of `name` names; None for an adaptation's own."""
    if isinstance(policy, AdaptNetPolicy):
        return None
    return load_base_of(name, env) if base is None else load_policy(base, env)
