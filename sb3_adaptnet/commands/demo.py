"""`adaptnet demo`: adapt the walk to a style in minutes, measure and draw what came of it, on one page."""

import argparse
import json
import shutil
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stable_baselines3.common.callbacks import BaseCallback

from adapt_envs import env_id
from adapt_envs.commands.exit_codes import INTERRUPTED
from adapt_envs.commands.numbers import minutes_of, positive, seconds_of
from adapt_envs.drawing.film import video_frames, write_video
from adapt_envs.drawing.motion_sheet import write_sheet
from adapt_envs.motion.clip import MotionClip
from adapt_envs.motion.library import STYLES, load_clip
from sb3_adaptnet.commands.algorithm import BEST, algorithm_of, best_for
from sb3_adaptnet.commands.algorithm import add_options as add_algorithm_options
from sb3_adaptnet.commands.export import export
from sb3_adaptnet.commands.policy_options import ProgressBar, open_policy
from sb3_adaptnet.evaluation.card import eval_command, write_evaluation
from sb3_adaptnet.evaluation.figures import Evaluation, Figures, evaluate
from sb3_adaptnet.evaluation.pictures import side_by_side
from sb3_adaptnet.evaluation.recording import open_worlds
from sb3_adaptnet.evaluation.report import link, listing, paragraph, picture, table, text_table, video, write_page
from sb3_adaptnet.evaluation.rollout_clips import clip_of, longest, typical_clip
from sb3_adaptnet.play.playground import ADDRESS, serving_command
from sb3_adaptnet.runs.experiment import experiment
from sb3_adaptnet.runs.run_folder import RUNS, RunFolder, RunSettings
from sb3_adaptnet.runs.training import start
from sb3_adaptnet.weights.shipped import pretrained_names

MINUTES, SECONDS = 5.0, 240.0
"""Training's budget, and simulated seconds of each evaluation: under 10 minutes in all."""
FILM_SECONDS, SHORTEST_FILM = 7.0, 1.0
"""Length of the video [s], and what a policy must last to be in it [s]."""
STYLE = "GooseStep"
"""What is learned if nothing else is asked for: no other style is so far from a walk."""
PAGE, TRAINING = "index.html", "demo-run"
"""File of the page and folder of the training, in the output's folder; a later demo replaces both."""


def add_parser(subparsers: Any) -> None:
    """Add the subcommand `demo`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "demo", help="adapt the walk to a style for a few minutes, and show what came of it on one page"
    )
    names = ", ".join(STYLES)
    parser.add_argument("--style", choices=STYLES, default=STYLE, metavar="STYLE", help=f"{names} (default {STYLE})")
    parser.add_argument("--base", default="walk", metavar="NAME_OR_FILE", help="base to adapt (default walk)")
    parser.add_argument("--samples", type=positive, help="training's samples; default: the entry's")
    add_algorithm_options(parser, BEST)
    parser.add_argument("--minutes", type=minutes_of, default=MINUTES, help=f"training's minutes (default {MINUTES:g})")
    words = f"simulated seconds of each evaluation (default {SECONDS:g})"
    parser.add_argument("--seconds", type=seconds_of, default=SECONDS, help=words)
    words = f"seconds of the video (default {FILM_SECONDS:g})"
    parser.add_argument("--film", type=seconds_of, default=FILM_SECONDS, help=words)
    parser.add_argument("-o", "--output", type=Path, default=RUNS / "demo", metavar="DIR", help="default runs/demo")
    parser.add_argument("--n-envs", type=positive, help="worlds; default: the entry's")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the demo and say where its page is."""
    if options.base == "walk" and "walk" not in pretrained_names():
        page = show_motions(options.output, options.style, options.film)
    else:
        trained = adapt(options)
        if trained is None:
            print("interrupted; nothing was measured")
            return INTERRUPTED
        page = show_policies(options, trained)
    print(f"\nopen {page.resolve()}")
    return 0


class TimeLimit(BaseCallback):
    """Ends training after some minutes."""

    def __init__(self, minutes: float) -> None:
        """Allow `minutes` from the start of training."""
        super().__init__()
        self.minutes = minutes

    @property
    def over(self) -> bool:
        """Whether the time is up."""
        return time.monotonic() - self._start > 60.0 * self.minutes

    def _on_training_start(self) -> None:
        self._start = time.monotonic()

    def _on_step(self) -> bool:
        return not self.over


def adapt(options: argparse.Namespace) -> RunFolder | None:
    """Adapt the base for the budget; None if a person interrupted it.

    Raises:
        ValueError: if what stands where the training goes is no training run, or the time was too short.
    """
    path = options.output / TRAINING
    if path.exists() and not (path / "run.json").is_file():
        raise ValueError(f"{path} is in the way; choose another folder with -o")
    settings = settings_of(options)
    words = f"{settings.samples:,} samples or {options.minutes:g} minutes of {settings.algo}"
    print(f"1/3 adapting {Path(options.base).stem} to {options.style}: {words}")
    limit = TimeLimit(options.minutes)
    folder = start(settings, path, callbacks=[limit], anew=True)
    if limit.over and not folder.curve.exists():
        raise ValueError(f"{options.minutes:g} minutes are too few, not one rollout was finished: give more --minutes")
    return folder if limit.over or folder.load()["samples"] >= settings.samples else None


def settings_of(options: argparse.Namespace) -> RunSettings:
    """Settings of the training."""
    algo, environment = algorithm_of(options, best_for(options.base)), env_id(options.style)
    return RunSettings(
        env_id=environment,
        samples=options.samples or experiment(environment, options.base, algo=algo).samples,
        base=options.base,
        n_envs=options.n_envs,
        algo=algo,
        world_model=options.world_model,
    )


def show_policies(options: argparse.Namespace, trained: RunFolder) -> Path:
    """Measure base, result and the shipped adaptation, draw them, write the result's card and the page; return it."""
    output, environment = options.output, trained.settings.env_id
    samples, asked = trained.load()["samples"], trained.settings.samples
    policies = {f"base {Path(options.base).stem}": str(options.base)}
    file, caption = export(trained.path, output / "own"), f"own, {samples / 1000:,.0f} k samples"
    policies[caption] = str(file)
    shipped = f"walk-{options.style.lower()}"
    if options.base == "walk" and shipped in pretrained_names():
        policies[f"shipped {shipped}"] = shipped
    print(f"2/3 measuring {', '.join(policies)}")
    found = measure(policies, environment, options.base, options.seconds)
    figures = {name: evaluation.figures for name, evaluation in found.items()}
    own = figures[caption]
    base = None if options.base in pretrained_names() else options.base
    write_evaluation(file, own, eval_command(str(file), own, base=base))
    print(text_table(figures))
    (output / "figures.json").write_text(
        json.dumps({name: values.as_dict() for name, values in figures.items()}, indent=2) + "\n", encoding="utf-8"
    )
    print("3/3 drawing")
    shutil.copyfile(trained.curve, output / "curve.png")
    reference = load_clip(options.style)
    sheets = draw_sheets(found, reference, output)
    filmed = film(found, reference, output, options.film)
    page = output / PAGE
    write_page(page, f"The walk learns {options.style}", _sections(options, samples, asked, figures, sheets, filmed))
    return page


def measure(policies: Mapping[str, str], environment: str, base: str, seconds: float) -> dict[str, Evaluation]:
    """Evaluations by caption of the policies (caption -> name or file), all in the same worlds from the same seed."""
    env = open_worlds(environment)
    found = {}
    for caption, policy in policies.items():
        opened = open_policy(policy, env, base=None if policy == base else base)
        found[caption] = evaluate(opened, env, seconds, progress=ProgressBar(caption))
    env.close()
    return found


def draw_sheets(found: Mapping[str, Evaluation], reference: MotionClip, output: Path) -> dict[str, str]:
    """Contact sheets of the reference and of every policy that stays up long enough; caption -> file."""
    clips = {f"the motion {reference.name}": reference}
    for caption, evaluation in found.items():
        if _filmable(evaluation):
            clips[caption] = typical_clip(evaluation.straight, reference, reference.joint_names, caption)
    files = {}
    for number, (caption, clip) in enumerate(ProgressBar("sheets")(clips.items())):
        files[caption] = f"sheet_{number}.png"
        write_sheet(clip, output / files[caption])
    return files


def film(found: Mapping[str, Evaluation], reference: MotionClip, output: Path, seconds: float) -> str | None:
    """Video of the policies side by side, each its longest stretch without a fall; None if none stays up."""
    clips = {
        caption: clip_of(found.straight, longest(found.straight, seconds), reference.joint_names, caption)
        for caption, found in found.items()
        if _filmable(found)
    }
    if not clips:
        return None
    write_video(ProgressBar("filming")(side_by_side(clips)), output / "side_by_side.mp4")
    return "side_by_side.mp4"


def _filmable(evaluation: Evaluation) -> bool:
    return any((stop - start) / 30 > SHORTEST_FILM for _, start, stop in evaluation.straight.segments())


def _sections(
    options: argparse.Namespace, samples: int, asked: int, figures: Mapping[str, Figures], sheets: Mapping[str, str],
    filmed: str | None,
) -> list[tuple[str, list[str]]]:  # fmt: skip
    words = (
        f"The base {Path(options.base).stem!r} walks to targets. It was frozen, and a small part beside it learned from"
        f" {samples:,} samples to walk in the style {options.style}: injected into its latent state, added to its"
        " layers, and zero at the start."
    )
    if samples < asked:
        words += f" The whole training takes {asked:,}."
    again = f"adaptnet play {options.output / 'own.safetensors'}\nadaptnet train {env_id(options.style)}\n"
    sections = [("", [paragraph(words)]), ("Figures", [table(figures)])]
    if filmed is not None:
        sections.append(("Side by side, straight ahead", [video(filmed)]))
    sections.append(("Learning curve", [picture("curve.png", "learning curve")]))
    sections.append(("Contact sheets", [picture(file, caption) for caption, file in sheets.items()]))
    go_on = listing(again + "adaptnet adapt --motion YOUR.bvh -o yours.safetensors")
    return [*sections, ("Go on", [go_on, *playground()])]


def playground() -> list[str]:
    """Parts of a page: how to serve the playground and a link to it, or how to build it."""
    command, what = serving_command(), "The playground, a page in which the walk is steered, pushed and blended"
    if command is None:
        return [paragraph(f"{what}, is not built here; in a checkout, 'make web' builds it.")]
    return [paragraph(f"{what}: serve it, then follow the link."), listing(command), link(ADDRESS, ADDRESS)]


def show_motions(output: Path, style: str, seconds: float) -> Path:
    """Without a pretrained walk: the motions that would be learned, as pictures; return the page."""
    output.mkdir(parents=True, exist_ok=True)
    print("there is no pretrained walk yet (assets/pretrained/walk.safetensors): showing the motions instead;")
    print("train one with: adaptnet train AdaptNet/Humanoid-Walk-v0")
    blocks = []
    for name in ("walk", style):
        clip, file = load_clip(name), f"{name.lower()}.png"
        write_sheet(clip, output / file)
        blocks.append(picture(file, f"contact sheet of {name}"))
    clip = load_clip(style)
    write_video(ProgressBar("filming")(video_frames(clip, min_seconds=seconds)), output / "style.mp4")
    page = output / PAGE
    words = "No pretrained walk is there yet; these are the reference motions that policies learn from."
    blocks = [paragraph(words), *blocks, video("style.mp4"), *playground()]
    write_page(page, f"The walk and {style}", [("", blocks)])
    return page
