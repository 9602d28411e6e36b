"""`adaptnet doctor`: what this machine has, and what to do about what it lacks."""

import argparse
import importlib.metadata
import os
import platform
from pathlib import Path

from adapt_envs.assets import asset_path
from adapt_envs.drawing.headless import GL_VARIABLE
from adapt_envs.drawing.scene import RenderingError, Scene
from adapt_envs.model.build import compile_model

PACKAGES = (
    "mujoco", "gymnasium", "numpy", "torch", "stable-baselines3", "rl_zoo3", "safetensors", "opencv-python-headless",
)  # fmt: skip
_BF16_FLAGS = ("amx_bf16", "avx512_bf16")


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the subcommand `doctor`."""
    parser = subparsers.add_parser("doctor", help="explain what this machine has: rendering, versions, cores, bf16")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print the findings; 0 if this machine can draw, else 1."""
    del arguments
    drawing, fault = _rendering()
    rows = [
        ("python", platform.python_version()),
        *((name, _version(name)) for name in PACKAGES),
        ("assets", str(asset_path("humanoid.xml").parent)),
        ("processor", f"{processor()}, {usable_cores()} cores"),
        ("bf16", bf16_words(cpu_flags())),
        (GL_VARIABLE, os.environ.get(GL_VARIABLE, "not set: MuJoCo takes the window system's OpenGL")),
        ("rendering", drawing),
    ]
    for name, words in rows:
        print(f"{name:24s}{words}")
    return int(fault)


def usable_cores() -> int:
    """Processor cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def processor() -> str:
    """Name of the first processor as Linux has it, else what Python knows."""
    return _cpuinfo("model name") or platform.processor() or platform.machine()


def cpu_flags() -> frozenset[str]:
    """Feature flags of the first processor as Linux names them; empty where unknown."""
    return frozenset((_cpuinfo("flags") or _cpuinfo("Features")).split())


def _cpuinfo(name: str) -> str:
    """What Linux says of the first processor under `name`; empty where it does not."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text(errors="replace").splitlines() if cpuinfo.exists() else []
    return next((line.split(":", 1)[1].strip() for line in lines if line.split(":")[0].strip() == name), "")


def bf16_words(flags: frozenset[str]) -> str:
    """What the processor's flags mean for training in bf16."""
    have = [flag for flag in _BF16_FLAGS if flag in flags]
    if not have:
        return "no hardware bf16 found: train with precision 'fp32' or 'medium'"
    return f"{', '.join(have)}: precision 'bf16' is fast here"


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def _rendering() -> tuple[str, bool]:
    """Words on whether a picture can be drawn, and whether that failed."""
    try:
        with Scene(compile_model(), 32, 32):
            return "works offscreen", False
    except RenderingError as error:
        return str(error), True
