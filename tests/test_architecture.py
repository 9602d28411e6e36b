"""The imports follow the arrows: world below learner, data in one direction."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FILES = sorted([*ROOT.glob("adapt_envs/**/*.py"), *ROOT.glob("sb3_adaptnet/**/*.py")])
MAY_SEE_THE_WORLD = ("sb3_adaptnet/vec_env.py", "sb3_adaptnet/zoo/", "sb3_adaptnet/evaluation/")
LAYERS = (
    ("adapt_envs/rotations.py", "adapt_envs/resources.py", "adapt_envs/headless.py", "adapt_envs/spaces.py"),
    ("adapt_envs/model/",),
    ("adapt_envs/kinematics.py", "adapt_envs/features.py", "adapt_envs/scene.py"),
    ("adapt_envs/motion/", "adapt_envs/physics.py", "adapt_envs/tasks/"),
    ("adapt_envs/suite.py",),
    ("adapt_envs/worlds.py",),
    ("adapt_envs/vector_env.py", "adapt_envs/env.py"),
)


def imported_modules(path):
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def layer_of(name):
    return next((i for i, names in enumerate(LAYERS) if any(name.startswith(part) for part in names)), None)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_follow_the_arrows(path):
    name = path.relative_to(ROOT).as_posix()
    modules = set(imported_modules(path))
    tops = {module.split(".")[0] for module in modules}
    if name.startswith("adapt_envs/"):
        assert not tops & {"torch", "sb3_adaptnet", "stable_baselines3", "rl_zoo3"}
    elif not name.startswith(MAY_SEE_THE_WORLD):
        assert "adapt_envs" not in tops, f"only {', '.join(MAY_SEE_THE_WORLD)} may import adapt_envs"
    own = layer_of(name)
    if own is not None:
        paths = [module.replace(".", "/") for module in modules]
        seen = {layer_of(f"{path}/") or layer_of(f"{path}.py") for path in paths}
        assert all(other is None or other <= own for other in seen), f"{name} imports from a layer above it"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_files_and_functions_stay_short(path):
    source = path.read_text()
    assert source.count("\n") <= 400
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef):
            # A docstring may be as long as it needs to be.
            body = node.body[1:] if ast.get_docstring(node) else node.body
            first = body[0].lineno if body else node.lineno
            assert (node.end_lineno or first) - first < 60, f"{path.name}:{node.lineno} {node.name}"
