"""Motion files that users bring -> clips of this character: read, fit, stand on the ground, keep within limits."""

from pathlib import Path

import numpy as np

from adapt_envs.model.build import plain_model
from adapt_envs.model.humanoid import joint_names
from adapt_envs.motion.clip import MotionClip, MotionError
from adapt_envs.motion.gaits.draft import Draft
from adapt_envs.motion.gaits.gait_cycle import closed, find_cycle
from adapt_envs.motion.gaits.inverse_kinematics import looped, settled
from adapt_envs.motion.gaits.planted_feet import grounded, planted
from adapt_envs.motion.importing.bvh import read_bvh
from adapt_envs.motion.importing.files import read_text
from adapt_envs.motion.importing.foreign_body import is_own
from adapt_envs.motion.importing.official_json import read_official_json
from adapt_envs.motion.importing.resampling import resampled
from adapt_envs.motion.importing.retarget import retarget
from adapt_envs.motion.importing.skeletons import read_map, recognise
from adapt_envs.progress import Progress

SUFFIXES = (".bvh", ".json")
"""Extensions of the files that can be imported."""
_MIN_FRAMES = 6
_GIVE = 0.3
"""How far [rad] angles may lie beyond their limits in a motion of the character's own: the simulation's limits are
springs, and rollouts were seen 0.2 rad beyond them."""


def import_motion(
    path: str | Path, joint_map: str | Path | None = None, style: bool = False, progress: Progress = iter
) -> MotionClip:
    """Fit a motion file to the character.

    Args:
        path: a BVH file of any skeleton, or a JSON file of the paper's authors' format.
        joint_map: YAML file that says which joint is which, for a BVH skeleton that is not recognised.
        style: cut out and close one gait cycle, straight ahead, instead of the whole motion.
        progress: wraps the frame numbers of the long part, for a progress bar.

    Returns:
        A clip at 30 Hz that stands on the ground, its feet held to their place, and keeps within the joint limits. A
        whole motion of the character's own, such as `write_bvh` writes, stays as it is but for where it begins.

    Raises:
        MotionError: naming file, line and problem, if the file cannot be used.
    """
    path = Path(path)
    draft, frame_time, own = _read(path, None if joint_map is None else Path(joint_map))
    draft = resampled(draft, frame_time)
    if len(draft) < _MIN_FRAMES:
        raise MotionError(f"{path}: {len(draft)} frames at 30 Hz are too few, at least {_MIN_FRAMES} are needed")
    origin = f"imported from {path.name}"
    if not style:
        draft = draft.moved(-draft.qpos[0, :3] * (1, 1, 0))
        poses = draft.qpos if own else settled(planted(grounded(draft)), progress)
        return MotionClip(path.stem, poses.astype(np.float64), joint_names(), origin=origin)
    try:
        draft = grounded(draft)
        cycle = find_cycle(draft)
    except MotionError as error:
        raise MotionError(f"{path}: {error}") from None
    origin += f", frames {cycle.first} to {cycle.first + cycle.period} at 30 Hz"
    qpos = looped(closed(draft, cycle), progress).astype(np.float64)
    return MotionClip(path.stem, qpos, joint_names(), cyclic=True, origin=origin)


def _read(path: Path, joint_map: Path | None) -> tuple[Draft, float, bool]:
    """The draft, the time between its frames [s], and whether it is a motion of the character's own.

    What the character itself did needs no repair, also where its feet slide, drag or sink in. The authors' JSON files
    are of its skeleton, too, but hold recordings that were fitted to it.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        read_text(path, SUFFIXES)  # complains
    if suffix == ".json":
        if joint_map is not None:
            raise MotionError(f"{joint_map}: a map is for BVH files; {path.name} needs none")
        return *read_official_json(path), False
    bvh = read_bvh(path)
    joints = recognise(path, bvh.names) if joint_map is None else read_map(joint_map, path, bvh.names)
    if joints.drop is not None and joints.drop >= len(bvh.pos):
        raise MotionError(f"{joint_map}: drop is {joints.drop}, but {path.name} has {len(bvh.pos)} frames")
    draft = retarget(bvh, joints, path)
    return draft, bvh.frame_time, is_own(bvh, joints) and _possible(draft)


def _possible(draft: Draft) -> bool:
    """Whether no angle lies farther beyond its limits than a simulated one may."""
    low, high = plain_model().jnt_range[1:].T
    return bool(((draft.qpos[:, 7:] > low - _GIVE) & (draft.qpos[:, 7:] < high + _GIVE)).all())
