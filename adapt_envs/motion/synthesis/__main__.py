"""Make the shipped motions again: `python -m adapt_envs.motion.synthesis [NAME...]`; without a name, all of them."""

import argparse

from adapt_envs.assets import asset_path
from adapt_envs.motion.synthesis import GAITS, synthesize


def main() -> None:
    """Write the clips into the folder of motions."""
    parser = argparse.ArgumentParser(description="Synthesise the motions that ship.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(GAITS)}; all by default")
    folder = asset_path("motions")
    names = parser.parse_args().names
    unknown = [name for name in names if name.lower() not in GAITS]
    if unknown:
        parser.error(f"there is no motion {unknown[0]!r}; there are {', '.join(GAITS)}")
    for name in names or GAITS:
        clip = synthesize(name)
        clip.save(folder / f"{name.lower()}.npz")
        print(f"{clip.name}: {clip.seconds:.2f} s, {clip.mean_speed:.2f} m/s -> {folder / name.lower()}.npz")


if __name__ == "__main__":
    main()
