"""The public faces of the rooms: what each exports, and what stays first when they are imported."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import adapt_envs

PACKAGE = Path(adapt_envs.__file__).parent
ROOMS = (
    "", ".features", ".model", ".motion", ".motion.exporting", ".motion.gaits", ".motion.importing",
    ".motion.synthesis", ".simulation", ".tasks",
)  # fmt: skip


def face(room):
    return importlib.import_module(f"adapt_envs{room}")


@pytest.mark.parametrize("room", ROOMS)
def test_a_face_says_what_lives_there_and_exports_what_exists(room):
    module = face(room)
    assert module.__doc__ and module.__doc__.split("\n")[0].endswith(".")
    assert module.__all__ and len(set(module.__all__)) == len(module.__all__)
    for name in module.__all__:
        assert hasattr(module, name), f"adapt_envs{room} has no {name}"
        assert name == "rotations" or not isinstance(getattr(module, name), ModuleType)


@pytest.mark.parametrize(
    ("room", "names"),
    {
        ".model": ("Morphology", "MORPHOLOGIES", "SEGMENTS", "ObstacleField", "OBSTACLES", "TERRAINS", "GRID", "LINKS"),
        ".tasks": ("PushSchedule", "goal_reward", "ENDS"),
        ".motion": ("MotionClip", "load_clip", "CLIPS", "STYLES", "BASES"),
        ".motion.importing": ("import_motion", "SUFFIXES"),
        ".simulation": ("Worlds", "PhysicsBatch"),
    }.items(),
)
def test_users_find_what_they_need_by_short_paths(room, names):
    assert set(names) <= set(face(room).__all__)


def test_every_terrain_and_every_part_of_one_can_be_had_from_the_model():
    terrain = importlib.import_module("adapt_envs.model.terrain")
    public = {name for name, value in vars(terrain).items() if callable(value) and value.__module__ == terrain.__name__}
    assert {name for name in public if not name.startswith("_")} <= set(face(".model").__all__)


def test_modules_of_the_package_import_from_where_things_are_defined():
    """Through a room's face one would import all of the room, and soon in circles."""
    for path in PACKAGE.rglob("*.py"):
        if path.name in ("__init__.py", "__main__.py"):
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module in {f"adapt_envs{room}" for room in ROOMS}:
                found = importlib.import_module(node.module)
                for alias in node.names:
                    name = f"{path.name} imports {alias.name} from {node.module}"
                    assert isinstance(getattr(found, alias.name), ModuleType), name


@pytest.mark.parametrize("room", ["", ".motion.importing"])
def test_the_way_to_opengl_is_chosen_before_mujoco_is_imported(room):
    program = (
        "import sys\n"
        "class Watch:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'mujoco': print('adapt_envs.drawing.headless' in sys.modules)\n"
        "sys.meta_path.insert(0, Watch())\n"
        f"import adapt_envs{room}\n"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[:1] == ["True"], run.stderr


def test_what_imports_and_draws_motions_is_not_read_by_who_simulates():
    others = {"scipy.interpolate", "matplotlib", "torch", "adapt_envs.motion.importing"}
    program = f"import sys, adapt_envs; print(sorted({others} & set(sys.modules)))"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"
