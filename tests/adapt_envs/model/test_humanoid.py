"""The character: its mass, its links, its joints and their servos."""

import numpy as np
import pytest

from adapt_envs.model.build import plain_model
from adapt_envs.model.humanoid import LINKS, joint_group, joint_names


def test_character_facts():
    model = plain_model()
    assert model.nu == 28
    assert joint_names() == tuple(model.actuator(i).name for i in range(model.nu))
    assert joint_names() == tuple(model.joint(i).name for i in range(1, model.njnt))
    assert abs(model.body_subtreemass[1] - 48.9) < 0.05
    assert tuple(model.body(i).name for i in range(1, 16)) == LINKS
    assert np.allclose(model.qpos0[2], 0.8814, atol=1e-3)
    for joint in range(1, model.njnt):
        name = model.joint(joint).name
        servo = model.actuator(name)
        low, high = model.jnt_range[joint]
        kp, kd = -servo.biasprm[1], -servo.biasprm[2]
        assert np.isclose(kd, kp / 10)
        # torque(action) = kp (middle + action * width - q) - kd qdot
        assert np.isclose(servo.gainprm[0], kp * (high - low))
        assert np.isclose(servo.biasprm[0], kp * (low + high) / 2)
        mirror = name.replace("left", "@").replace("right", "left").replace("@", "right")
        twin = sorted(np.abs(model.joint(mirror).range))
        assert np.allclose(sorted(np.abs([low, high])), twin)
    with pytest.raises(ValueError, match="'tail_x' belongs to no group; the groups are abdomen"):
        joint_group("tail_x")
