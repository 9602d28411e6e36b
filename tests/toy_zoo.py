"""Zoo entries and runs of the toy environment, and the command line in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

import yaml

from sb3_adaptnet.runs.run_folder import RunSettings

ROOT = Path(__file__).resolve().parents[1]
TOY = "toy_env:Toy-v0"
ENTRY = {
    "n_envs": 8,
    "n_timesteps": 640,
    "policy": "sb3_adaptnet.PretrainPolicy",
    "n_steps": 8,
    "batch_size": 32,
    "n_epochs": 1,
    "learning_rate": 3.0e-4,
    "normalize_advantage": False,
    "policy_kwargs": {"gru_size": 8, "hidden_sizes": [16, 8], "critic_lr": 6.0e-4},
    "callback": [
        {
            "sb3_adaptnet.DiscriminatorRewardCallback": {
                "objective_weights": {"imitation": 0.4, "goal": 0.6},
                "discriminator": {"batch_size": 32, "network": {"gru": 8, "hidden": [8], "heads": 4}},
            }
        }
    ],
}


def conf(folder, **changes):
    file = Path(folder) / "toy.yml"
    file.write_text(yaml.safe_dump({TOY: {**ENTRY, **changes}, "Toy-v0": {**ENTRY, **changes}}))
    return str(file)


def settings(folder, **changes):
    return RunSettings(TOY, **{"samples": 640, "seed": 1, "conf_file": conf(folder), "threads": 1, **changes})


def python_path():
    """PYTHONPATH of a process that is to find the toy."""
    return os.pathsep.join([str(ROOT), str(ROOT / "tests"), *filter(None, [os.environ.get("PYTHONPATH")])])


def run_command(arguments, **kwargs):
    env = {**os.environ, "PYTHONPATH": python_path()}
    command = [sys.executable, "-m", *arguments]
    return subprocess.Popen(command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **kwargs)
