"""What users install: the wheel finds its data without the checkout."""

import ast
import importlib.metadata
import json
import re
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PROGRAM = """
import json, sys
import gymnasium as gym
import adapt_envs, sb3_adaptnet
from sb3_adaptnet import hyperparameters
env = gym.make("adapt_envs:AdaptNet/Humanoid-Stoop-v0")
observation, _ = env.reset(seed=0)
print(json.dumps({"where": [adapt_envs.__file__, sb3_adaptnet.__file__], "shape": observation.shape,
                  "batch_size": hyperparameters("AdaptNet/Humanoid-Walk-v0")["batch_size"]}))
"""


def canonical(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def dependencies(*extras):
    """Declared distributions -> the comment that stands beside each."""
    text = (ROOT / "pyproject.toml").read_text()
    project = tomllib.loads(text)["project"]
    declared = [*project["dependencies"], *(one for extra in extras for one in project["optional-dependencies"][extra])]
    lines = {one: next(line for line in text.splitlines() if f'"{one}"' in line) for one in declared}
    return {canonical(re.match(r"[\w.-]+", one)[0]): lines[one].partition("#")[2].strip() for one in declared}


def imported():
    """Distributions that the two packages import, other than Python's own and each other."""
    trees = [
        ast.parse(file.read_text()) for name in ("adapt_envs", "sb3_adaptnet") for file in ROOT.glob(f"{name}/**/*.py")
    ]
    nodes = [node for tree in trees for node in ast.walk(tree)]
    modules = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    modules |= {node.module for node in nodes if isinstance(node, ast.ImportFrom)}
    tops = {module.split(".")[0] for module in modules} - sys.stdlib_module_names - {"adapt_envs", "sb3_adaptnet"}
    homes = importlib.metadata.packages_distributions()
    return {top: {canonical(home) for home in homes[top]} for top in tops}


def test_every_dependency_is_imported_or_says_why_not():
    used = set().union(*imported().values())
    for name, comment in dependencies().items():
        assert (name in used) != comment.startswith("not imported: "), f"{name}: {comment!r}"


def test_every_import_is_declared():
    """OpenCV may be there under any of its names; the one without a display is the one that is asked for."""
    declared = set(dependencies("play"))
    assert not {top: homes for top, homes in imported().items() if not homes & declared}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    out = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(out), str(ROOT)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return next(out.glob("*.whl"))


def test_the_wheel_holds_types_assets_and_configs(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    expected = {"adapt_envs/py.typed", "sb3_adaptnet/py.typed", "adapt_envs/assets/humanoid.xml",
                "adapt_envs/assets/motions/walk.npz", "sb3_adaptnet/zoo_configs/ppo.yml"}  # fmt: skip
    assert expected <= names
    assert not [name for name in names if name.startswith(("tests/", "docs/"))]


def test_an_installed_wheel_makes_an_environment(wheel, tmp_path):
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "venv"], check=True)
    python = tmp_path / "venv" / "bin" / "python"
    site = Path(subprocess.check_output(
        [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"], text=True).strip())  # fmt: skip
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", site, wheel]
    subprocess.run(command, check=True, capture_output=True)
    # The parent's packages, but not its editable install of this project: a path line does not follow .pth files there.
    (site / "parent.pth").write_text(sysconfig.get_path("purelib"))
    done = subprocess.run([python, "-c", PROGRAM], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout.strip().splitlines()[-1])
    assert all(str(site) in place for place in answer["where"])
    assert answer["shape"] == [784]
