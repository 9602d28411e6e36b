"""What users install: the wheel finds its data without the checkout."""

import json
import subprocess
import sys
import sysconfig
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
