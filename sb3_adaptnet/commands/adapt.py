"""`adaptnet adapt`: a motion file becomes a style controller."""

import argparse
import shlex
from pathlib import Path
from typing import Any

from adapt_envs.commands.exit_codes import INTERRUPTED
from adapt_envs.commands.numbers import minutes_of, positive, seconds_of, seed_of
from adapt_envs.commands.output import check_output
from adapt_envs.motion.clip import MotionClip
from adapt_envs.motion.importing.pipeline import SUFFIXES, import_motion
from adapt_envs.motion.library import load_clip
from adapt_envs.progress import Progress
from sb3_adaptnet.commands.algorithm import BEST, algorithm_of, best_for
from sb3_adaptnet.commands.algorithm import add_options as add_algorithm_options
from sb3_adaptnet.commands.export import export
from sb3_adaptnet.commands.policy_options import ProgressBar, open_worlds_for
from sb3_adaptnet.commands.train import refuse_given
from sb3_adaptnet.evaluation.card import eval_command, write_evaluation
from sb3_adaptnet.evaluation.figures import Figures, evaluate
from sb3_adaptnet.evaluation.report import text_table
from sb3_adaptnet.policies.loading import load_policy
from sb3_adaptnet.runs.experiment import experiment
from sb3_adaptnet.runs.lock import held
from sb3_adaptnet.runs.run_folder import MOTION, RUNS, RunFolder, RunSettings
from sb3_adaptnet.runs.training import check_device, resume, start
from sb3_adaptnet.weights.checkpoint import read_base
from sb3_adaptnet.weights.shipped import WEIGHT_SUFFIX, pretrained_names
from sb3_adaptnet.weights.weight_file import check_card_place
from sb3_adaptnet.world_model.world_file import read_world

STYLE_ENV = "AdaptNet/Humanoid-Style-v0"
"""The environment that takes any motion."""
BASE = "walk"
"""What is adapted where nothing else is named."""
FROM_SCRATCH_ONLY = ("motion", "map", "base", "seed", "algo", "world_model", "n_envs", "run_dir")
"""Options that a resumed run cannot change."""
SECONDS = 300.0
"""Simulated seconds of the evaluation at the end."""


def add_parser(subparsers: Any) -> None:
    """Add the subcommand `adapt`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "adapt", help="adapt a base to a motion of your own: a BVH, JSON or clip file, or a shipped motion's name"
    )
    parser.add_argument("--motion", metavar="FILE", help="the motion; of a BVH or JSON file one gait cycle is cut out")
    parser.add_argument("--map", metavar="MAP.YML", help="which joint is which, for a BVH skeleton that is not known")
    parser.add_argument("--base", metavar="NAME_OR_FILE", help=f"base to adapt (default {BASE})")
    parser.add_argument("--samples", type=positive, help="control steps over all worlds; default: the entry's")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="weight file to write")
    parser.add_argument("--seed", type=seed_of, help="default 0")
    parser.add_argument("--run-dir", type=Path, metavar="DIR", help="folder of the run; default runs/adapt-OUT")
    parser.add_argument("--resume", metavar="RUN", help="go on with the run in this folder")
    parser.add_argument("--n-envs", type=positive, help="worlds; default: the entry's")
    parser.add_argument("--threads", type=positive, help="threads of physics and networks; default: all cores")
    parser.add_argument("--device", help="cpu (default) or cuda")
    parser.add_argument("--minutes", type=minutes_of, default=3.0, help="minutes between checkpoints (default 3)")
    add_algorithm_options(parser, BEST)
    words = f"simulated seconds that the result is measured for (default {SECONDS:g})"
    parser.add_argument("--seconds", type=seconds_of, default=SECONDS, help=words)
    parser.add_argument("--quiet", action="store_true", help="show no progress")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Adapt, or go on adapting, then write the weight file, measure it and say what to do with it."""
    check_output(options.output)
    check_card_place(options.output)
    shown = {"minutes": options.minutes, "quiet": options.quiet}
    if options.resume is not None:
        refuse_given(options, FROM_SCRATCH_ONLY)
        folder = resume(options.resume, options.samples, options.device, options.threads, **shown)
    else:
        settings, clip, path = prepare(options)
        with held(path):
            refuse_begun(path)  # again: another process may have begun since
            clip.save(path / MOTION)
            folder = start(settings, path, **shown)
    return report(folder, options.output, options.seconds, options.quiet)


def prepare(options: argparse.Namespace) -> tuple[RunSettings, MotionClip, Path]:
    """Settings of a new run, its clip and its folder; nothing is written.

    Raises:
        ValueError: if no motion is given, it cannot be used, or the folder holds a run.
    """
    if options.motion is None:
        raise ValueError("name a motion with --motion, or a run with --resume")
    base = options.base or BASE
    algo = algorithm_of(options, best_for(base))
    if options.world_model is not None:
        read_world(options.world_model)  # before anything is written
    entry = experiment(STYLE_ENV, base, algo=algo)
    clip = opened(options.motion, options.map, options.quiet)
    path = options.run_dir or RUNS / f"adapt-{options.output.name.removesuffix(WEIGHT_SUFFIX)}"
    refuse_begun(path)
    read_base(base)
    check_device(options.device or "cpu")
    settings = RunSettings(
        env_id=STYLE_ENV,
        samples=options.samples or entry.samples,
        seed=options.seed or 0,
        base=base,
        motion=str(path / MOTION),
        n_envs=options.n_envs,
        device=options.device or "cpu",
        threads=options.threads,
        algo=algo,
        world_model=options.world_model,
    )
    return settings, clip, path


def refuse_begun(path: Path) -> None:
    """Refuse a folder whose run can be resumed.

    Raises:
        ValueError: saying how.
    """
    if RunFolder.has_begun(path):
        raise ValueError(f"{path} holds a run already; continue it with --resume {path}, or choose --run-dir")


def opened(motion: str, joint_map: str | None = None, quiet: bool = False) -> MotionClip:
    """A shipped motion, a clip file, or one gait cycle of a BVH or JSON file fitted to the character."""
    if Path(motion).suffix.lower() not in SUFFIXES:
        if joint_map is not None:
            raise ValueError(f"{joint_map}: a map is for BVH files; {motion} needs none")
        return load_clip(motion)
    return import_motion(motion, joint_map, style=True, progress=iter if quiet else ProgressBar("fitting"))


def report(folder: RunFolder, output: Path, seconds: float, quiet: bool = False) -> int:
    """Write the weight file of a finished run and measure it, or say how to go on with an interrupted one."""
    done, asked = folder.load()["samples"], folder.settings.samples
    if done < asked:
        print(f"stopped at {done:,} of {asked:,}; go on with: adaptnet adapt --resume {folder.path} -o {output}")
        return INTERRUPTED
    file = export(folder.path, output)
    print(f"wrote {file} after {done:,} samples (run: {folder.path})")
    print(text_table({file.stem: measure(file, folder.settings, seconds, iter if quiet else ProgressBar("walking"))}))
    words = shlex.join([str(file), *(["--base", named] if (named := folder.settings.base) not in (None, BASE) else [])])
    print(f"look at it:     adaptnet play {words}\nmeasure longer: adaptnet eval {words} --write-card")
    return 0


def measure(file: Path, settings: RunSettings, seconds: float, progress: Progress) -> Figures:
    """Measure a weight file where it was trained and write the figures into its card; return them."""
    env = open_worlds_for(str(file), threads=settings.threads)
    figures = evaluate(load_policy(file, env, base=settings.base), env, seconds, progress=progress).figures
    env.close()
    base = None if settings.base in pretrained_names() else settings.base
    write_evaluation(file, figures, eval_command(str(file), figures, base=base))
    return figures
