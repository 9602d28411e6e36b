"""The authors' own format: poses come back as they were written."""

import numpy as np
from made_up_motions import json_object, write

from adapt_envs.model.humanoid import joint_names
from adapt_envs.motion.gaits.draft import angles_within
from adapt_envs.motion.importing.pipeline import import_motion


def test_official_json_poses_come_back(tmp_path):
    content = json_object()
    clip = import_motion(write(tmp_path, "walk.json", content))
    assert len(clip.qpos) == 40
    quats = np.roll([frame["right_upper_arm"] for frame in content["frames"]], 1, axis=1)
    wanted = angles_within(quats, "right_shoulder")
    columns = [7 + joint_names().index(f"right_shoulder_{axis}") for axis in "xyz"]
    np.testing.assert_allclose(clip.qpos[:, columns], wanted, atol=0.02)
