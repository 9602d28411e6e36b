"""`adaptnet eval`: measure a policy's mean action, and draw it."""

import argparse
import json
from pathlib import Path
from typing import Any

from adapt_envs.commands.numbers import positive, seconds_of, seed_of, speed_of
from adapt_envs.commands.output import check_output
from adapt_envs.drawing.film import rollout_frames, write_video
from adapt_envs.drawing.motion_sheet import write_sheet
from adapt_envs.model.ground import Ground
from adapt_envs.motion.exporting import write_bvh, write_glb
from adapt_envs.motion.exporting.extra import gltf_packages
from sb3_adaptnet.commands.policy_options import LoadedPolicy, ProgressBar, add_options, base_of, open_from_options
from sb3_adaptnet.evaluation.alpha import alpha_clips
from sb3_adaptnet.evaluation.card import eval_command, write_evaluation
from sb3_adaptnet.evaluation.figures import DEFAULT_SECONDS, Evaluation, evaluate
from sb3_adaptnet.evaluation.pictures import check_world, write_before_after, write_strip
from sb3_adaptnet.evaluation.report import text_table
from sb3_adaptnet.evaluation.rollout_clips import longest, performance_of, typical_clip
from sb3_adaptnet.evaluation.starts import start_falls
from sb3_adaptnet.hub import is_address
from sb3_adaptnet.policies.adaptnet import AdaptNetPolicy
from sb3_adaptnet.weights.checkpoint import resolve

VIDEO_SECONDS = 12.0
"""Longest video [s]."""


def add_parser(subparsers: Any) -> None:
    """Add the subcommand `eval`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "eval",
        help="measure a policy: goal reward, falls, imitation error, whether its style is visible, sliding, jerk",
    )
    add_options(parser)
    parser.add_argument("--seconds", type=seconds_of, default=DEFAULT_SECONDS, help="simulated seconds (default 1200)")
    parser.add_argument("--seed", type=seed_of, default=0, help="of start states and goals (default 0)")
    words = "preferred speed straight ahead, instead of the motion's own"
    parser.add_argument("--speed", type=speed_of, metavar="M_S", help=words)
    words = "begin N episodes of 2 s, too, and count those that fall: a base that stands at first may fall at once"
    parser.add_argument("--starts", type=positive, metavar="N", help=words)
    parser.add_argument("--push-scale", type=float, metavar="S", help="pushes at S times their force (default 1)")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--write-card", action="store_true", help="write the figures into the weight file's card")
    parser.add_argument("--sheet", type=Path, metavar="FILE.png", help="draw a contact sheet of it going straight on")
    parser.add_argument("--video", type=Path, metavar="FILE.mp4", help="film it going to targets")
    words = "write the same stretch as its film's as a skeleton's motion, for animation tools"
    parser.add_argument("--bvh", type=Path, metavar="FILE.bvh", help=words)
    words = "write it as glTF, a skeleton with its skin, for game engines and Blender (extra [motion])"
    parser.add_argument("--glb", type=Path, metavar="FILE.glb", help=words)
    parser.add_argument("--strip", type=Path, metavar="FILE.png", help="draw an adaptation at alpha 0, 0.25, ..., 1")
    parser.add_argument(
        "--before-after", type=Path, metavar="FILE.png", help="draw an adaptation and its base in the same world"
    )
    parser.add_argument("--world", type=int, default=0, metavar="N", help="world of --before-after (default 0)")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Measure, print, draw."""
    check_outputs(options)
    loaded = open_from_options(options)
    for option, path in (("--strip", options.strip), ("--before-after", options.before_after)):
        if path is not None and not isinstance(loaded.policy, AdaptNetPolicy):
            raise ValueError(f"{option} needs an adaptation; {loaded.name!r} is none")
    check_world(options.world, loaded.env)
    if options.push_scale is not None:
        loaded.env.push_scale = options.push_scale
    bar, base = ProgressBar("walking"), base_of(loaded.policy, loaded.name, loaded.env, options.base)
    found = evaluate(loaded.policy, loaded.env, options.seconds, options.seed, bar, base, options.speed)
    begun = None
    if options.starts is not None:
        begun = start_falls(loaded.policy, loaded.env, options.starts, options.seed, ProgressBar("beginning"))
    if options.json:
        figures = found.figures.as_dict() | ({} if begun is None else {"starts": begun.as_dict()})
        print(json.dumps(figures, indent=2, allow_nan=False))
    else:
        print(text_table({loaded.title: found.figures}))
        if begun is not None:
            print(begun)
    drawn = [write_card(options, found)] if options.write_card else []
    drawn += draw(loaded, found, options.sheet, options.video)
    drawn += write_motion(loaded, found, options.bvh, options.glb)
    drawn += draw_alphas(loaded, options.strip, options.before_after, options.seed, options.world)
    for path in () if options.json else drawn:
        print(f"wrote {path}")
    return 0


def check_outputs(options: argparse.Namespace) -> None:
    """Refuse pictures, motions and a card that cannot be written, before the measuring.

    Raises:
        ValueError: for an extension that is no picture's or video's, a folder that does not exist, or a card that would
            speak of something else than its file.
    """
    if options.write_card:
        if is_address(options.policy):
            raise ValueError("--write-card writes into your own file; get one with: adaptnet pull ADDRESS -o FOLDER")
        changes = (options.alpha, options.styles or None, options.push_scale, options.clip, options.speed)
        if any(change is not None for change in changes):
            words = "leave out --alpha, --styles, --push-scale, --clip and --speed"
            raise ValueError(f"--write-card measures the file as it is: {words}")
        check_output(resolve(options.policy))
    wanted = {
        (".png",): (options.sheet, options.strip, options.before_after), (".mp4", ".gif"): (options.video,),
        (".bvh",): (options.bvh,), (".glb",): (options.glb,),
    }  # fmt: skip
    for suffixes, paths in wanted.items():
        for path in paths:
            if path is not None:
                check_output(path, *suffixes)
    if options.glb is not None:
        gltf_packages()


def write_card(options: argparse.Namespace, found: Evaluation) -> Path:
    """Write the figures into the card of the weight file; return the file."""
    asked = {"env": options.env, "motion": options.motion, "base": options.base}
    return write_evaluation(options.policy, found.figures, eval_command(options.policy, found.figures, **asked))


def draw(loaded: LoadedPolicy, found: Evaluation, sheet: Path | None, video: Path | None) -> list[Path]:
    """Draw the contact sheet and the video that were asked for; return them.

    The video shows the longest stretch without a fall, up to 12 s.
    """
    worlds = loaded.env.worlds
    if sheet is not None:
        clip = typical_clip(found.straight, worlds.reference.clips[0], worlds.reference.joint_names, loaded.title)
        write_sheet(clip, sheet, worlds.compiled(Ground()))
    if video is not None:
        world, start, stop = longest(found.free, VIDEO_SECONDS)
        write_video(rollout_frames(worlds, found.free.qpos[start:stop, world]), video)
    return [path for path in (sheet, video) if path is not None]


def write_motion(loaded: LoadedPolicy, found: Evaluation, bvh: Path | None, glb: Path | None) -> list[Path]:
    """Write the longest stretch without a fall, up to 12 s, as the motion files that were asked for; return them."""
    if bvh is None and glb is None:
        return []
    model = loaded.env.worlds.model
    performed = performance_of(found.free, longest(found.free, VIDEO_SECONDS), model)
    if bvh is not None:
        write_bvh(performed, bvh)
    if glb is not None:
        write_glb(performed, model, glb, loaded.title)
    return [path for path in (bvh, glb) if path is not None]


def draw_alphas(
    loaded: LoadedPolicy, strip: Path | None, before_after: Path | None, seed: int, world: int
) -> list[Path]:
    """Draw an adaptation at five alphas, or with its base in one world, where asked for; return the pictures."""
    if isinstance(loaded.policy, AdaptNetPolicy):
        if strip is not None:
            write_strip(alpha_clips(loaded.policy, loaded.env, seed=seed), strip, loaded.env.worlds.compiled(Ground()))
        if before_after is not None:
            write_before_after(loaded.policy, loaded.env, before_after, seed, world)
    return [path for path in (strip, before_after) if path is not None]
