"""Write what the page loads: the specification, scenes, grounds and policies, from the packages as they are.

python web/emit.py FOLDER
"""

import gzip
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from adapt_envs.motion.library import load_clip
from adapt_envs.portable import BODIES, GROUNDS, LOCKS, observation_specification, portable_scene, site_ground
from adapt_envs.registration import env_id
from adapt_envs.suite import SUITE, preferred_speeds
from sb3_adaptnet.exporting import Exported, graph_of, split_weights
from sb3_adaptnet.modules.adaptation import Adaptation
from sb3_adaptnet.weights import pretrained_names, read_adaptation


def main() -> None:
    """Write everything into the folder that the command line names."""
    folder = Path(sys.argv[1])
    specification = observation_specification()
    index = {"bodies": words_of(BODIES), "locks": words_of(LOCKS), "grounds": words_of(GROUNDS), "bases": {}}
    for base in specification["bases"]:
        index["bases"][base] = emit_policies(folder / "policies" / base, base)
    for name in GROUNDS:
        emit_ground(folder / "grounds", name)
    names = [(body, lock, ground) for body in BODIES for lock in LOCKS for ground in GROUNDS]
    for body, lock, ground in tqdm(names, desc="scenes", disable=not sys.stderr.isatty()):
        write(folder / "scenes" / f"{body}-{lock}-{ground}.json", to_json(portable_scene(body, lock, ground)))
    write(folder / "specification.json", to_json(specification))
    write(folder / "index.json", to_json(index))


def words_of(choices: dict[str, Any]) -> dict[str, str]:
    """What each choice is, for people."""
    return {name: choice.words for name, choice in choices.items()}


def emit_ground(folder: Path, name: str) -> None:
    """Write a ground and, in a file of its own, its heights as shares of their range: what MuJoCo calls hfield_data."""
    ground = site_ground(name)
    values = ground.to_json()
    if ground.heights is not None:
        low, high = ground.heights.min(), ground.heights.max()
        values["surface"] |= {"lowest": float(low), "highest": float(high)}
        write(folder / f"{name}.bin", ((ground.heights - low) / (high - low)).astype("<f4").tobytes())
    write(folder / f"{name}.json", to_json(values))


def emit_policies(folder: Path, base: str) -> list[dict[str, Any]]:
    """Write the weights of a base and of its adaptations, and a graph for every number of them; return their list.

    A graph has slots: `flatN` for adaptations without a heightmap, then `mapN` for those with one. All of a kind have
    the same shapes, so whatever is loaded at the moment fills them.
    """
    exported = Exported.read(base, [name for name in pretrained_names() if name.startswith(f"{base}-")])
    write(folder / "base.bin", weights_of(exported, {})["base"])
    for name, part in exported.adaptations.items():
        write(folder / f"{name}.bin", weights_of(exported, {"slot": part})["slot"])
    maps = [part for part in exported.adaptations.values() if part.shape.heightmap]
    flats = [part for part in exported.adaptations.values() if not part.shape.heightmap]
    for flat in range(len(flats) + 1):
        for reading in range(len(maps) + 1):
            slots = slots_of("flat", flats[:flat]) | slots_of("map", maps[:reading])
            write(folder / f"graph-{flat}-{reading}.onnx", split_weights(model_of(exported, slots))[0])
    return [listed(name, part) for name, part in exported.adaptations.items()]


def slots_of(kind: str, parts: list[Adaptation]) -> dict[str, Adaptation]:
    """Adaptations under the names of slots."""
    return {f"{kind}{number}": part for number, part in enumerate(parts)}


def model_of(exported: Exported, slots: dict[str, Adaptation]) -> Any:
    """A graph of the base, called `base`, with some adaptations; weights in half precision."""
    chosen = Exported(exported.base._replace(name="base"), slots)
    return graph_of(chosen, dict.fromkeys(slots, 0.0), half=True)


def weights_of(exported: Exported, slots: dict[str, Adaptation]) -> dict[str, bytes]:
    """Part -> its weights."""
    return split_weights(model_of(exported, slots))[1]


def listed(name: str, part: Adaptation) -> dict[str, Any]:
    """An adaptation's entry in the index: its name, what it learned, the world it was trained in."""
    environment = read_adaptation(name).card["environment"]
    row_name, row = next((name, row) for name, row in SUITE.items() if env_id(name) == environment)
    return {
        "name": name, "title": row_name, "words": row.summary.rstrip("."), "heightmap": part.shape.heightmap,
        "body": row.morphology or "plain", "lock": row.locked[0] if row.locked else "plain",
        "speeds": preferred_speeds(row, load_clip(row.motion)),
        "ground": next((ground for ground, choice in GROUNDS.items() if choice.row == row), "flat"),
    }  # fmt: skip


def to_json(values: Any) -> bytes:
    """Compact JSON."""
    return json.dumps(values, separators=(",", ":"), default=np.ndarray.tolist).encode()


def write(file: Path, content: bytes) -> None:
    """Write a file, compressed: the page unpacks it, whatever the web server can do."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.with_name(file.name + ".gz").write_bytes(gzip.compress(content, compresslevel=9, mtime=0))


if __name__ == "__main__":
    main()
