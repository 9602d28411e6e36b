"""`adaptnet motions`: list, check, render and import reference motions."""

import argparse
import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TypeVar

from tqdm import tqdm

from adapt_envs.commands.output import check_output
from adapt_envs.drawing.film import video_frames, write_video
from adapt_envs.drawing.motion_sheet import write_sheet
from adapt_envs.motion.clip import MotionClip
from adapt_envs.motion.importing.pipeline import SUFFIXES, import_motion
from adapt_envs.motion.library import CLIPS, load_clip, ships
from adapt_envs.motion.quality import THRESHOLDS, Quality, check
from adapt_envs.motion.synthesis.styles import GAITS

VIDEO_SUFFIXES = (".mp4", ".gif")
_DEFAULT_KIND = "quiet"
_COLUMNS = (
    ("slip median", "slip_median_cm_s"), ("slip p90", "slip_p90_cm_s"), ("sinks cm", "penetration_cm"),
    ("limits deg", "limit_violation_deg"), ("zmp inside", "zmp_in_support"), ("force min", "force_min"),
    ("force max", "force_max"), ("flight err", "flight_g_error"),
)  # fmt: skip
_Item = TypeVar("_Item")


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the subcommand `motions` with its own subcommands."""
    parser = subparsers.add_parser("motions", help="list, check, render and import reference motions")
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    actions.add_parser("list", help="list the motions that ship").set_defaults(run=run_list)
    _add_check(actions)
    _add_render(actions)
    _add_import(actions)


def _add_check(actions: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = actions.add_parser("check", help="measure sliding, sinking, limits, balance and forces")
    parser.add_argument("motions", nargs="*", metavar="NAME|FILE", help="motions to measure; default: all that ship")
    parser.add_argument("--json", action="store_true", help="print a JSON list of objects")
    kinds = ", ".join(THRESHOLDS)
    words = f"thresholds to hold the motions to: {kinds}; default: the shipped motion's own, else {_DEFAULT_KIND}"
    parser.add_argument("--kind", choices=THRESHOLDS, metavar="KIND", help=words)
    parser.set_defaults(run=run_check)


def _add_render(actions: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = actions.add_parser("render", help="draw a contact sheet (.png) or a video (.mp4, .gif)")
    parser.add_argument("motion", metavar="NAME|FILE", help="a motion that ships, a clip (.npz), or a file to import")
    parser.add_argument("-o", "--output", required=True, type=Path, help="picture or video to write")
    parser.set_defaults(run=run_render)


def _add_import(actions: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = actions.add_parser("import", help="fit a BVH file or a JSON file of the paper's authors to the character")
    parser.add_argument("file", type=Path, metavar="FILE", help="a .bvh or .json file")
    parser.add_argument("-o", "--output", required=True, type=Path, help="clip to write (.npz)")
    parser.add_argument("--map", type=Path, metavar="MAP.YML", help="which joint is which, for an unknown skeleton")
    parser.add_argument("--style", action="store_true", help="cut out and close one gait cycle that repeats")
    parser.set_defaults(run=run_import)


def run_list(options: argparse.Namespace) -> int:
    """Print name, length, speed and kind of every shipped motion."""
    del options
    print(f"{'name':<14}{'seconds':>9}{'m/s':>7}  kind")
    for name in CLIPS:
        clip = load_clip(name)
        form = "cycle" if clip.cyclic else "clip"
        print(f"{name:<14}{clip.seconds:9.2f}{clip.mean_speed:7.2f}  {form}, {kind_of(name)}")
    return 0


def run_check(options: argparse.Namespace) -> int:
    """Measure motions; 1 if one of them misses the thresholds of its kind."""
    names = options.motions or list(CLIPS)
    clips = [_opened(name) for name in names]
    asked = zip(names, clips, strict=True)
    results = [check(clip, options.kind or kind_of(name)) for name, clip in _bar(list(asked), "measuring")]
    if options.json:
        print(json.dumps([result.as_dict() for result in results], indent=2, allow_nan=False))
    else:
        _print_table(results)
    return 0 if all(result.ok for result in results) else 1


def run_render(options: argparse.Namespace) -> int:
    """Draw a motion."""
    output: Path = options.output
    check_output(output, ".png", *VIDEO_SUFFIXES)
    clip = _opened(options.motion)
    if output.suffix.lower() == ".png":
        write_sheet(clip, output)
    else:
        write_video(_bar(video_frames(clip), "drawing"), output)
    print(f"wrote {output}")
    return 0


def run_import(options: argparse.Namespace) -> int:
    """Fit a motion file to the character and write the clip; nothing is written unless all went well."""
    output: Path = options.output
    check_output(output, ".npz")
    clip = import_motion(options.file, options.map, options.style, lambda frames: _bar(frames, "fitting"))
    clip.save(output)
    measured = check(clip, _DEFAULT_KIND)
    kind = "cycle" if clip.cyclic else "clip"
    print(f"wrote {output}: {kind} of {clip.seconds:.2f} s, {clip.mean_speed:.2f} m/s, {clip.origin}")
    sliding = "none" if measured.slip_median_cm_s is None else f"{measured.slip_median_cm_s:.1f} cm/s"
    sinking, excess = measured.penetration_cm, measured.limit_violation_deg
    print(f"sliding (median) {sliding}, sinking {sinking:.1f} cm, past joint limits {excess:.1f} deg")
    return 0


def kind_of(name_or_file: str) -> str:
    """The kind whose quality thresholds hold: the table's for the name of a motion that ships, else `quiet`."""
    return GAITS[name_or_file.lower()].kind if ships(name_or_file) else _DEFAULT_KIND


def _opened(name_or_file: str) -> MotionClip:
    """A shipped motion, a clip file, or a motion file imported on the fly."""
    if Path(name_or_file).suffix.lower() in SUFFIXES:
        return import_motion(name_or_file, progress=lambda frames: _bar(frames, "fitting"))
    return load_clip(name_or_file)


def _bar(items: Iterable[_Item], title: str) -> Iterable[_Item]:
    """A progress bar on the terminal, for work of more than a second."""
    return tqdm(items, desc=title, delay=1.0, leave=False, disable=not sys.stderr.isatty())


def _print_table(results: list[Quality]) -> None:
    print(f"{'name':<16}{'seconds':>9}" + "".join(f"{title:>12}" for title, _ in _COLUMNS) + "  verdict")
    for result in results:
        values = result.as_dict()
        cells = ("-" if values[key] is None else f"{values[key]:.2f}" for _, key in _COLUMNS)
        row = "".join(f"{cell:>12}" for cell in cells)
        print(f"{result.name[:15]:<16}{result.seconds:9.2f}{row}  {'ok' if result.ok else 'MISSES'}")
