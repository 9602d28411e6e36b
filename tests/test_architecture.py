"""The rooms and their arrows: every module has a layer, imports go down, nothing goes round in circles."""

import ast
import graphlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FILES = sorted([*ROOT.glob("adapt_envs/**/*.py"), *ROOT.glob("sb3_adaptnet/**/*.py")])

LAYERS = """
adapt_envs.assets  adapt_envs.tables  adapt_envs.spaces  adapt_envs.progress
adapt_envs.model
adapt_envs.features
adapt_envs.tasks  adapt_envs.motion
adapt_envs.motion.gaits
adapt_envs.motion.importing  adapt_envs.motion.exporting  adapt_envs.motion.synthesis
adapt_envs.suite
adapt_envs.simulation
adapt_envs.portable  adapt_envs.drawing
adapt_envs.vector_env
adapt_envs.env
adapt_envs.registration
adapt_envs.commands
adapt_envs
sb3_adaptnet.openmp
sb3_adaptnet.modules.layers
sb3_adaptnet.modules
sb3_adaptnet.modules.adaptation  sb3_adaptnet.hub
sb3_adaptnet.weights
sb3_adaptnet.world_model
sb3_adaptnet.world_model.fitting
sb3_adaptnet.policies  sb3_adaptnet.vec_env
sb3_adaptnet.stacking
sb3_adaptnet.objectives
sb3_adaptnet.algorithms.tracking
sb3_adaptnet.algorithms.rollouts
sb3_adaptnet.algorithms
sb3_adaptnet.runs
sb3_adaptnet.evaluation  sb3_adaptnet.play  sb3_adaptnet.zoo  sb3_adaptnet.exporting
sb3_adaptnet.evaluation.stacking  sb3_adaptnet.evaluation.pictures
sb3_adaptnet.publishing
sb3_adaptnet
sb3_adaptnet.sweeps  sb3_adaptnet.commands.bench
sb3_adaptnet.commands
"""
"""Rooms, lowest first. A room imports from the layers below it, and from itself."""
LAYER_OF = {room: layer for layer, rooms in enumerate(LAYERS.split("\n")) for room in rooms.split()}
ROOMS_WITH_A_VIEW = (
    "vec_env", "stacking", "evaluation", "runs", "play", "publishing", "exporting", "sweeps", "commands", "zoo",
)  # fmt: skip
MAY_SEE_THE_WORLD = {f"sb3_adaptnet.{room}" for room in ROOMS_WITH_A_VIEW}
LEARNING = {"torch", "sb3_adaptnet", "stable_baselines3", "rl_zoo3"}
MOST_LINES, LONGEST_FUNCTION, MOST_MODULES = 250, 60, 14
TOP_LEVEL = {"adapt_envs": 10, "sb3_adaptnet": 4}


def module_name(path):
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


MODULES = {module_name(path): path for path in FILES}


def room_of(module):
    """The room a module is in: a folder, or a file at the top of a package."""
    folder = module if MODULES[module].name == "__init__.py" else module.rpartition(".")[0]
    return module if folder in ("adapt_envs", "sb3_adaptnet") else folder


def imported_by(module):
    """Every module, ours or not, that a file imports, wherever the statement stands."""
    for node in ast.walk(ast.parse(MODULES[module].read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from (name if name in MODULES else node.module for name in names)


@pytest.mark.parametrize("module", MODULES)
def test_every_module_has_a_layer_and_imports_from_below(module):
    room = room_of(module)
    assert room in LAYER_OF, f"{room} has no layer: put it into LAYERS"
    for other in map(room_of, set(imported_by(module)) & set(MODULES)):
        assert other == room or LAYER_OF[other] < LAYER_OF[room], f"{module} imports {other}, which is not below it"


def test_every_layer_has_modules():
    assert set(LAYER_OF) == {room_of(module) for module in MODULES}


@pytest.mark.parametrize("module", MODULES)
def test_the_world_knows_no_learner_and_networks_no_framework(module):
    tops = {name.split(".")[0] for name in imported_by(module)}
    if module.startswith("adapt_envs"):
        assert not tops & LEARNING
    elif not any(module == room or module.startswith(f"{room}.") for room in MAY_SEE_THE_WORLD):
        assert "adapt_envs" not in tops, f"only {', '.join(sorted(MAY_SEE_THE_WORLD))} may import adapt_envs"
    if module.startswith("sb3_adaptnet.modules"):
        assert not tops & {"stable_baselines3", "gymnasium", "rl_zoo3"}


def test_no_imports_go_round_in_circles():
    graph = {module: set(imported_by(module)) & set(MODULES) - {module} for module in MODULES}
    assert len([*graphlib.TopologicalSorter(graph).static_order()]) == len(MODULES)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_files_and_functions_stay_short(path):
    source = path.read_text()
    assert source.count("\n") <= MOST_LINES
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef):
            # A docstring may be as long as it needs to be.
            body = node.body[1:] if ast.get_docstring(node) else node.body
            first = body[0].lineno if body else node.lineno
            assert (node.end_lineno or first) - first < LONGEST_FUNCTION, f"{path.name}:{node.lineno} {node.name}"


def test_folders_can_be_seen_at_a_glance():
    for folder in {path.parent for path in FILES}:
        modules = [path for path in folder.glob("*.py") if path.name != "__init__.py"]
        assert len(modules) <= MOST_MODULES, f"{folder.relative_to(ROOT)} holds {len(modules)} modules"
    for package, most in TOP_LEVEL.items():
        assert len([path for path in (ROOT / package).iterdir() if path.is_file()]) <= most


def test_tests_lie_where_their_rooms_lie():
    for path in ROOT.glob("tests/*/**/*.py"):
        folder = path.parent.relative_to(ROOT / "tests")
        assert (ROOT / folder).is_dir(), f"{path.relative_to(ROOT)} mirrors no folder"
