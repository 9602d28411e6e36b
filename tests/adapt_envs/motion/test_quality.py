"""The measures of quality on motions whose answers are known, and on every clip that ships."""

import numpy as np
import pytest

from adapt_envs.assets import asset_path
from adapt_envs.model.build import compile_model
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.motion.clip import MotionClip
from adapt_envs.motion.dynamics import momentum
from adapt_envs.motion.quality import THRESHOLDS, check, foot_corners, slip_speeds, support_distance
from adapt_envs.motion.synthesis import GAITS

STANDING = 0.881416
"""Height of the pelvis when the soles touch the ground [m]."""


@pytest.fixture(scope="module")
def model():
    return compile_model()


def still(model, frames=40):
    """Configurations of the character standing with straight legs."""
    qpos = np.zeros((frames, model.nq))
    qpos[:, 2], qpos[:, 3] = STANDING, 1.0
    return qpos


def clip_of(model, qpos):
    names = tuple(model.joint(j).name for j in range(1, model.njnt))
    return MotionClip("test", qpos, names)


@pytest.mark.parametrize("name", GAITS)
def test_shipped_clip_keeps_the_thresholds_of_its_kind(name):
    quality = check(MotionClip.load(asset_path(f"motions/{name}.npz")), GAITS[name].kind)
    assert quality.ok, quality


def test_standing_is_perfect(model):
    quality = check(clip_of(model, still(model)), "walk")
    assert quality.ok
    assert quality.slip_median_cm_s == 0 and quality.penetration_cm < 1e-3 and quality.zmp_in_support == 1
    assert quality.force_min == pytest.approx(1) and quality.force_max == pytest.approx(1)
    assert quality.flight_g_error is None


def test_slip_is_the_speed_of_a_sliding_stand(model):
    qpos = still(model)
    qpos[:, 0] = 0.2 * np.arange(len(qpos)) * CONTROL_DT
    quality = check(clip_of(model, qpos), "walk")
    assert quality.slip_median_cm_s == pytest.approx(20) and quality.slip_p90_cm_s == pytest.approx(20)
    assert not quality.ok


def test_slip_ignores_feet_above_the_ground(model):
    qpos = still(model)
    qpos[:, 0], qpos[:, 2] = 0.2 * np.arange(len(qpos)) * CONTROL_DT, STANDING + 0.02
    assert len(slip_speeds(foot_corners(model, qpos))) == 0


def test_penetration_and_limits_are_what_was_put_in(model):
    qpos = still(model)
    qpos[10, 2] -= 0.03
    names = [model.joint(j).name for j in range(1, model.njnt)]
    qpos[20, 7 + names.index("right_elbow")] = np.radians(12)
    quality = check(clip_of(model, qpos), "quiet")
    assert quality.penetration_cm == pytest.approx(3, abs=0.01)
    assert quality.limit_violation_deg == pytest.approx(12)
    assert not quality.ok


def test_free_fall_has_no_flight_error_and_floating_has_all_of_it(model):
    qpos = still(model)
    t = np.arange(len(qpos)) * CONTROL_DT
    qpos[:, 2] = STANDING + 0.3 + 4 * t - 9.81 / 2 * t**2
    assert check(clip_of(model, qpos[:25]), "run").flight_g_error == pytest.approx(0, abs=1e-6)
    qpos[:, 2] = STANDING + 0.3
    assert check(clip_of(model, qpos), "run").flight_g_error == pytest.approx(1)


def test_zero_moment_point_of_a_braking_body(model):
    """A rigid body that brakes by a: p = x + z a / g, here a = 1 m/s^2; and the force is the weight."""
    qpos = still(model)
    t = np.arange(len(qpos)) * CONTROL_DT
    qpos[:, 0] = 2 * t - t**2 / 2
    motion = momentum(model, qpos, CONTROL_DT)
    np.testing.assert_allclose(motion.zmp[:, 0], motion.com[:, 0] + motion.com[:, 2] / 9.81, atol=1e-6)
    np.testing.assert_allclose(motion.zmp[:, 1], motion.com[:, 1], atol=1e-9)
    np.testing.assert_allclose(motion.force, 1, atol=1e-9)


def test_spinning_up_an_arm_moves_the_zero_moment_point(model):
    """Both arms speed up forward with q'' = k: the moment they need about y moves the point back, and only back."""
    qpos = still(model)
    names = [model.joint(j).name for j in range(1, model.njnt)]
    t = np.arange(len(qpos)) * CONTROL_DT
    for side in ("right", "left"):
        qpos[:, 7 + names.index(f"{side}_shoulder_y")] = -0.5 * t**2
    motion = momentum(model, qpos, CONTROL_DT)
    assert (motion.spin_rate[:5, 1] != 0).all() and np.abs(motion.spin_rate[:5, [0, 2]]).max() < 1e-6
    moment = motion.com[:, 2] * motion.com_acc[:, 0] * motion.mass + motion.spin_rate[:, 1]
    expected = motion.com[:, 0] - moment / (motion.mass * (9.81 + motion.com_acc[:, 2]))
    np.testing.assert_allclose(motion.zmp[:, 0], expected, atol=1e-9)


def test_distance_to_the_support_polygon_by_hand():
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), *[(5, 5, 1)] * 4], dtype=float)
    points = np.array([(0.5, 0.5), (0.2, 0.9), (1.3, 0.5), (2, 2), (-0.3, -0.4)])
    expected = [0, 0, 0.3, np.sqrt(2), 0.5]
    np.testing.assert_allclose(support_distance(points, np.broadcast_to(square, (5, 8, 3))), expected, atol=1e-12)
    line = np.array([(0, 0, 0), (1, 0, 0), *[(5, 5, 1)] * 6], dtype=float)
    np.testing.assert_allclose(support_distance(np.array([(0.5, 0.2)]), line[None]), [0.2], atol=1e-12)
    assert np.isinf(support_distance(np.zeros((1, 2)), line[None] + (0, 0, 1))).all()


def test_unknown_kind_lists_the_valid_ones(model):
    with pytest.raises(ValueError, match="'crawl'.*walk"):
        check(clip_of(model, still(model)), "crawl")
    assert {gait.kind for gait in GAITS.values()} <= set(THRESHOLDS)
