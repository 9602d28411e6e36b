"""Every example runs, with few samples, stays short and uses public names only."""

import runpy
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import pytest
from evaluation_cases import save_tiny_adaptation, save_tiny_base
from made_up_motions import bvh_text, write

from adapt_envs import SUITE
from adapt_envs.motion.clip import MotionClip
from sb3_adaptnet.commands.main import main

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run an example as a script in an empty folder; returns what it printed. What it registers is forgotten."""
    monkeypatch.chdir(tmp_path)
    names, ids = set(SUITE), set(gym.registry)

    def call(name, *arguments):
        monkeypatch.setattr(sys, "argv", [name, *map(str, arguments)])
        runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
        return capsys.readouterr().out

    yield call
    for name in set(SUITE) - names:
        del SUITE[name]
    for name in set(gym.registry) - ids:
        del gym.registry[name]


def test_adapt_to_a_motion(run, tmp_path):
    motion = write(tmp_path, "stroll.bvh", bvh_text())
    base = save_tiny_base(tmp_path)
    run("adapt_to_a_motion", motion, "--base", base, "--samples", 16, "--num-envs", 8)
    assert MotionClip.load(tmp_path / "my_style.npz").cyclic
    assert (tmp_path / "my_style.safetensors").stat().st_size > 0


def test_blend_two_styles(run, tmp_path):
    base = save_tiny_base(tmp_path)
    styles = [save_tiny_adaptation(base, name, seed) for seed, name in enumerate(("one", "two"))]
    printed = run("blend_two_styles", "--styles", *styles, "--steps", 301).splitlines()
    blends = [line for line in printed if "goal reward" in line]
    assert "1.00" in blends[0] and "0.50" in blends[5] and len(blends) == 11
    assert blends[10].split()[2] == "0.00", "after ten of the twenty seconds the second style acts alone"


def test_terrain_of_your_own(run, tmp_path):
    printed = run("terrain_of_your_own", "--policies", save_tiny_base(tmp_path), "--seconds", 1, "--picture", "a.png")
    assert "falls a minute" in printed
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert SUITE["Dunes"].heightmap


def test_own_ppo_loop(run, tmp_path):
    printed = run("own_ppo_loop", "--samples", 200, "--num-envs", 8)
    assert printed.count("imitation") == 2
    assert (tmp_path / "own_stoop.safetensors").stat().st_size > 0


def test_evaluate_and_plot(run, tmp_path):
    file = save_tiny_adaptation(save_tiny_base(tmp_path), "one")
    printed = run("evaluate_and_plot", "--policy", file, "--alphas", 0.5, "--seconds", 1)
    assert printed.startswith("alpha 0.5: goal reward")
    assert (tmp_path / "alpha.png").read_bytes().startswith(b"\x89PNG")


def test_run_onnx(tmp_path):
    """In a process of its own, which proves that no torch is needed."""
    for package in ("onnx", "onnxruntime"):
        pytest.importorskip(package, reason="the extra [onnx] is not installed")
    file = tmp_path / "walk.onnx"
    assert main(["export", "walk", "walk-stoop", "-o", str(file)]) == 0
    program = (
        "import runpy, sys\n"
        f"sys.argv = ['run_onnx', {str(file)!r}]\n"
        f"runpy.run_path({str(EXAMPLES / 'run_onnx.py')!r})\n"
        "learners = {'torch', 'stable_baselines3', 'sb3_adaptnet'} & set(sys.modules)\n"
        "assert not learners, learners"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=EXAMPLES.parent, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    heads = [float(line.split("head")[1].split()[0]) for line in lines]
    assert len(lines) == 11 and not any(word in done.stdout for word in ("fall", "lost"))
    assert heads[-1] < heads[0] - 0.1, "at strength 1 the walk is bent over"


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_examples_stay_short_and_are_listed_and_run(path):
    assert path.read_text().count("\n") < 60
    assert f"({path.name})" in (EXAMPLES / "README.md").read_text()
    assert f"def test_{path.stem}(" in Path(__file__).read_text()
