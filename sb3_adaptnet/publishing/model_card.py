"""The Hub's model card of a weight file: metadata that the Hub reads, and a page that people do."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from adapt_envs import SUITE, env_id
from adapt_envs.motion.library import ships
from sb3_adaptnet.evaluation.report import ROWS, text_of
from sb3_adaptnet.publishing.model_index import model_index
from sb3_adaptnet.weights.checkpoint import ADAPTATION

LIBRARY = "adaptnet-gym"
PICTURE, FILM = "picture.png", "replay.mp4"
"""Files beside the card; the Hub itself plays a reinforcement learning model's `replay.mp4`."""
PAPER = "[AdaptNet: Policy Adaptation for Physics-Based Character Control](https://doi.org/10.1145/3618375)"
_TAGS = ("deep-reinforcement-learning", "reinforcement-learning", "character-animation", "gymnasium", "mujoco")


def model_card(
    name: str, card: Mapping[str, Any], repo: str, base_model: str | None = None, license_id: str | None = None,
    pictures: bool = True,
) -> str:  # fmt: skip
    """The text of `README.md`.

    Args:
        name: what the weights are called.
        card: the weight file's card.
        repo: `OWNER/NAME`, where it will lie.
        base_model: `OWNER/NAME` of an adaptation's base.
        license_id: the weights' licence as the Hub abbreviates it, such as "mit"; None leaves it open.
        pictures: whether picture and film lie beside it.
    """
    parts = [
        _introduction(name, card, base_model),
        f"![{name}, as time goes on]({PICTURE})\n\n"
        f'<video src="{FILM}" controls loop muted></video>' if pictures else "",
        _use(name, card, repo),
        _evaluation(card),
        _training(card),
        _origin(card),
    ]  # fmt: skip
    metadata = yaml.safe_dump(_metadata(name, card, base_model, license_id), sort_keys=False, width=1000)
    return f"---\n{metadata}---\n\n" + "\n\n".join(part for part in parts if part) + "\n"


def _metadata(name: str, card: Mapping[str, Any], base_model: str | None, license_id: str | None) -> dict[str, Any]:
    environment = card.get("environment")
    entries = {
        "license": license_id,
        "library_name": LIBRARY,
        "pipeline_tag": "reinforcement-learning",
        "tags": [*_TAGS, *([environment] if environment else [])],
        "base_model": base_model,
        "base_model_relation": None if base_model is None else "adapter",
        "model-index": model_index(name, card),
    }
    return {entry: value for entry, value in entries.items() if value is not None}


def _introduction(name: str, card: Mapping[str, Any], base_model: str | None) -> str:
    base = card.get("base") or {}
    if card["kind"] == ADAPTATION:
        where = f"[{base_model}](https://huggingface.co/{base_model})" if base_model else f"`{base.get('name')}`"
        kind = f"An adaptation of the frozen base {where}: small parts beside it, {PAPER}."
    else:
        kind = f"A base, which adaptations leave as it is: {PAPER}."
    summaries = {env_id(row): spec.summary for row, spec in SUITE.items()}
    environment = card.get("environment")
    words = f" {summaries[environment].rstrip('.')}." if environment in summaries else ""
    return (
        f"# {name}\n\nA policy for a simulated humanoid in `{environment}`.{words}\n{kind}\n\n"
        "It drives a character in MuJoCo, and nothing else; it was not made for robots."
    )


def _use(name: str, card: Mapping[str, Any], repo: str) -> str:
    imports, motion = _of_motion(card, repo)
    return f"""## Use

```
pip install 'adaptnet-gym[hub]'
adaptnet eval hf://{repo} --video {name}.mp4
```

```python
{imports}
from sb3_adaptnet import load_policy

env = gym.make("{card.get("environment")}"{motion})
policy = load_policy("hf://{repo}", env)
observation, _ = env.reset(seed=0)
action, _ = policy.predict(observation, deterministic=True)
```

`{name}.safetensors` holds numbers and a JSON card (`{name}.json` is a copy of it): opening it runs no code."""


def _of_motion(card: Mapping[str, Any], repo: str) -> tuple[str, str]:
    """Imports, and the argument of `gym.make` where the policy learned another motion than the environment's own."""
    motion, imports = card.get("motion"), "import gymnasium as gym"
    own = next((spec.motion for row, spec in SUITE.items() if env_id(row) == card.get("environment")), None)
    if motion is None or motion == own:
        return imports, ""
    if ships(motion):
        return imports, f", motion={motion!r}"
    clip = Path(motion).name  # as it lies beside the weights
    return f"{imports}\nfrom huggingface_hub import hf_hub_download", f', motion=hf_hub_download("{repo}", {clip!r})'


def _evaluation(card: Mapping[str, Any]) -> str:
    block = card.get("evaluation")
    if not block:
        return "## Evaluation\n\nNot measured; `adaptnet eval --write-card` does it."
    figures = block["figures"]
    rows = [f"| {words} | {text_of(figures[field], text)} |" for words, field, text in ROWS if field in figures]
    failed = [f"- {test}" for test in figures.get("failed_tests", ())]
    lines = [
        f"## Evaluation\n\n`{block['command']}`: {block['seconds']:g} simulated seconds, the mean action.\n",
        "| figure | found |\n|---|---|",
        *rows,
        *(["\nThe style does not count as visible:\n", *failed] if failed else []),
    ]
    return "\n".join(lines)


def _training(card: Mapping[str, Any]) -> str:
    training = card.get("training", {})
    words = {name: training[name] for name in ("samples", "seed", "worlds", "policy") if name in training}
    algorithm = next((name.upper() for name in ("ppo", "svg") if name in training), None)
    entries = [f"{name} {value:,}" if isinstance(value, int) else f"{name} `{value}`" for name, value in words.items()]
    by = f"Trained with {algorithm}: " if algorithm else ""
    return f"## Training\n\n{by}{', '.join(entries)}.\nThe card has every setting." if entries else ""


def _origin(card: Mapping[str, Any]) -> str:
    base = card.get("base") or {}
    rows = [("weights (SHA-256)", card["hash"])]
    if card["kind"] == ADAPTATION:
        rows.append(("base that it fits (SHA-256)", base.get("hash")))
    rows.append(("motion", card.get("motion")))
    rows.append(("motion (SHA-256)", card.get("clip_hash")))
    return "\n".join(["## Origin\n\n| | |\n|---|---|", *(f"| {word} | `{value}` |" for word, value in rows if value)])
