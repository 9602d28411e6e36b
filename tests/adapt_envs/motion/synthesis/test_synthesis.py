"""The synthesised motions: the mathematics of their parts, and what the shipped clips show."""

import mujoco
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from adapt_envs.assets import asset_path
from adapt_envs.features import rotations
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import compile_model
from adapt_envs.model.humanoid import LINKS
from adapt_envs.motion.clip import FPS, MotionClip
from adapt_envs.motion.quality import check, foot_corners
from adapt_envs.motion.synthesis import GAITS, Arm, Gait, Kick, Wave, make_clip, synthesize
from adapt_envs.motion.synthesis.balance import centre_of_mass
from adapt_envs.motion.synthesis.body import Course, hips, pelvis_frame, poses
from adapt_envs.motion.synthesis.feet import FootPath, bump, hermite
from adapt_envs.motion.synthesis.legs import REACH, euler_xyz, rot_x, rot_y, rot_z, soften

STYLES = [name for name, gait in GAITS.items() if gait.frames]
PAPER_FRAMES = {
    "swaggering": 32, "goosestep": 66, "stomp": 37, "kicking": 61, "stoop": 28, "jauntyskip": 48, "sashay": 32,
    "limp": 57, "pace": 51, "penguin": 23, "strutting": 42, "joyful": 36,
}  # fmt: skip


@pytest.fixture(scope="module")
def clips():
    return {name: MotionClip.load(asset_path(f"motions/{name}.npz")) for name in GAITS}


@pytest.fixture(scope="module")
def model():
    return compile_model()


def course_rates(clip):
    """Speed [m/s] and turning rate [degrees/s], left positive, of the course, without the sway of half a step."""
    velocity = gaussian_filter1d(np.gradient(clip.qpos[:, :2], 1 / FPS, axis=0), 0.27 * FPS, axis=0, mode="nearest")
    heading = np.unwrap(rotations.heading(clip.qpos[:, 3:7]))
    turning = gaussian_filter1d(np.gradient(heading, 1 / FPS), 0.27 * FPS, mode="nearest")
    return np.linalg.norm(velocity, axis=1), np.degrees(turning)


def states(model, clip):
    return Kinematics(model).link_states(clip.qpos)


def column(clip, joint):
    return np.degrees(clip.qpos[:, 7 + clip.joint_names.index(joint)])


@pytest.mark.parametrize("name", ["stoop", "jauntyskip"])
def test_generator_makes_the_shipped_file(name, clips):
    made = synthesize(name)
    assert made.name == clips[name].name and made.cyclic
    np.testing.assert_allclose(made.qpos, clips[name].qpos, atol=1e-4)


def test_unknown_gait_lists_the_valid_ones():
    with pytest.raises(ValueError, match="no gait 'moonwalk'.*stoop"):
        synthesize("moonwalk")


def test_styles_have_the_papers_lengths(clips):
    assert {name: clips[name].period for name in STYLES} == PAPER_FRAMES


@pytest.mark.parametrize("name", STYLES)
def test_style_goes_straight_ahead_and_repeats_smoothly(name, clips):
    clip = clips[name]
    yaw, shift = clip.cycle_transform
    gait = GAITS[name]
    assert abs(yaw) < 1e-6 and abs(shift[1]) < 1e-5
    assert shift[0] == pytest.approx(sum(gait.length) * gait.cycles, abs=1e-5)
    np.testing.assert_allclose(clip.qpos[0, 0], 0, atol=1e-6)
    assert abs(np.mean(rotations.heading(clip.qpos[:-1, 3:7]))) < np.radians(6)
    # Across the seam the joints bend no harder than within the period: the motion is periodic, not cut.
    joints = clip.at(range(-3, clip.period + 4))[:, 7:]
    bend = np.abs(np.diff(joints, 2, axis=0)).max(axis=1)
    seam = [2, clip.period + 2]
    assert bend[seam].max() <= 1.05 * np.delete(bend, seam).max() + 1e-4


def test_a_new_style_is_a_row():
    row = Gait(
        "Tiptoe", frames=34, length=(0.4, 0.4), strike=(-12, -12), crouch=0.03,
        torso_pitch=Wave(12), kick=((Kick(up=0.08),),) * 2, arms=(Arm(flexion=Wave(20, -8), elbow=Wave(70)),) * 2,
    )  # fmt: skip
    quality = check(make_clip(row), row.kind)
    assert quality.zmp_in_support >= 0.9 and quality.penetration_cm <= 1 and quality.limit_violation_deg == 0


def test_walk_covers_speeds_turns_and_stops(clips):
    clip = clips["walk"]
    speed, turning = course_rates(clip)
    assert clip.seconds >= 334
    assert speed.min() < 0.1 and speed.max() > 1.55
    assert np.mean((speed > 0.8) & (speed < 1.5)) > 0.75
    assert turning.max() > 110 and turning.min() < -110
    heading = np.unwrap(rotations.heading(clip.qpos[:, 3:7]))
    change = np.degrees(heading[2 * FPS :] - heading[: -2 * FPS])
    assert change.max() > 160 and change.min() < -160


def test_run_covers_speeds_turns_and_flies(clips, model):
    clip = clips["run"]
    speed, turning = course_rates(clip)
    assert clip.seconds >= 282.9
    assert speed.min() < 1.1 and speed.max() > 3.4
    assert turning.max() > 100 and turning.min() < -100
    airborne = (foot_corners(model, clip.qpos[:1500])[..., 2] > 0.015).all(axis=1)
    assert 0.08 < airborne.mean() < 0.4


def test_no_two_strides_of_the_walk_are_alike(clips, model):
    right = foot_corners(model, clips["walk"].qpos[:3000])[:, :4, 2].min(axis=1) < 1e-3
    strikes = np.flatnonzero(~right[:-1] & right[1:])
    places = clips["walk"].qpos[strikes, :2]
    lengths = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert len(np.unique(lengths.round(6))) == len(lengths) > 50


def test_words_of_the_styles_can_be_measured(clips, model):
    trunk = {name: np.degrees(np.arcsin(_axis(states(model, clips[name]), "torso")[:, 0])).mean() for name in GAITS}
    assert trunk["stoop"] > 45 > 20 > max(angle for name, angle in trunk.items() if name != "stoop")
    for name, sides in {"goosestep": 2, "pace": 2, "swaggering": 1, "walk": 0}.items():
        assert _hands_on_hips(states(model, clips[name])) == sides, name
    assert check(clips["jauntyskip"], "hopping").flight_g_error < 0.2
    step = {name: clips[name].cycle_transform[1][0] / 2 / GAITS[name].cycles for name in STYLES}
    assert step["penguin"] < 0.3 < 0.38 < min(length for name, length in step.items() if name != "penguin")
    highest = {name: states(model, clips[name])[:, LINKS.index("left_foot"), 2].max() for name in STYLES}
    assert min(highest["goosestep"], highest["kicking"]) > 0.35 and highest["pace"] < 0.2
    knees = np.minimum(column(clips["goosestep"], "left_knee"), 90)
    foot = states(model, clips["goosestep"])[:, LINKS.index("left_foot"), 2]
    assert knees[foot.argmax()] < 25


def test_limp_spares_the_right_leg(clips, model):
    heights = foot_corners(model, clips["limp"].qpos[:-1])[..., 2]
    right, left = heights[:, :4].min(axis=1) < 0.005, heights[:, 4:].min(axis=1) < 0.005
    assert right.sum() < 0.9 * left.sum()


def _axis(link_states, link):
    """Up axis of a link (T, 3)."""
    return rotations.rotate(link_states[:, LINKS.index(link), 3:7], np.array([0.0, 0.0, 1.0]))


def _hands_on_hips(link_states):
    pelvis, rest = link_states[:, 0, :3], 0
    for hand in ("right_hand", "left_hand"):
        offset = link_states[:, LINKS.index(hand), :3] - pelvis
        rest += bool(
            (np.linalg.norm(offset[:, :2], axis=1) < 0.26).all() and (np.abs(offset[:, 2] - 0.14) < 0.08).all()
        )
    return rest


def test_leg_angles_put_the_foot_where_mujoco_says(model):
    rng = np.random.default_rng(0)
    n = 50
    feet = []
    for side in (-1, 1):
        ankle = np.column_stack(
            [rng.uniform(-0.3, 0.4, n), side * 0.09 + rng.uniform(-0.05, 0.05, n), rng.uniform(0.05, 0.3, n)]
        )
        feet.append(FootPath(ankle, rng.uniform(-0.4, 0.4, n), rng.uniform(-0.3, 0.6, n), np.zeros(n)))
    flat = np.zeros(n)
    course = Course(flat, flat, rng.uniform(0, 6, n), np.ones(n), np.zeros((n, 2)), (feet[0], feet[1]))
    root = np.column_stack([flat, flat, np.full(n, 0.8)])
    gait = GAITS["walk"]
    qpos = poses(gait, course, root)
    data = mujoco.MjData(model)
    for row in range(n):
        data.qpos[:] = qpos[row]
        mujoco.mj_kinematics(model, data)
        for side, name in enumerate(("right_foot", "left_foot")):
            hip = hips(pelvis_frame(gait, course), root)[side][row]
            if np.linalg.norm(feet[side].ankle[row] - hip) < REACH - 0.02:
                np.testing.assert_allclose(data.body(name).xpos, feet[side].ankle[row], atol=1e-4)
            expected = rot_z(feet[side].yaw[row]) @ rot_y(feet[side].pitch[row])
            np.testing.assert_allclose(data.body(name).xmat.reshape(3, 3), expected, atol=1e-6)


def test_euler_angles_undo_their_rotation():
    angles = np.random.default_rng(1).uniform(-1.4, 1.4, (100, 3))
    matrix = rot_x(angles[:, 0]) @ rot_y(angles[:, 1]) @ rot_z(angles[:, 2])
    np.testing.assert_allclose(euler_xyz(matrix), angles, atol=1e-12)


def test_softened_reach_never_exceeds_the_leg():
    far = np.linspace(0.3, 1.5, 200)
    assert (soften(far) <= REACH).all()
    np.testing.assert_allclose(soften(far[far < REACH - 0.05]), far[far < REACH - 0.05], atol=1e-5)


def test_hermite_meets_its_ends():
    start, end = np.array([1.0, -2.0, 3.0]), np.array([0.5, 4.0, -1.0])
    h = 1e-4
    for u, wanted in ((0.0, start), (1.0, end)):
        value, before, after = (hermite(np.array([x]), start, end)[0] for x in (u, u - h, u + h))
        assert value == pytest.approx(wanted[0], abs=1e-9)
        assert (after - before) / (2 * h) == pytest.approx(wanted[1], abs=1e-4)
        assert (after - 2 * value + before) / h**2 == pytest.approx(wanted[2], abs=1e-2)


def test_bump_is_one_at_its_peak_and_flat_at_its_ends():
    for peak in (0.3, 0.5, 0.7):
        assert bump(np.array([0.0, peak, 1.0]), peak) == pytest.approx([0, 1, 0])
        assert bump(np.linspace(0, 1, 101), peak).max() <= 1 + 1e-12


def test_centre_of_mass_obeys_the_inverted_pendulum_and_is_ballistic_in_flight():
    dt, n = 1 / 60, 600
    t = np.arange(n) * dt
    zmp = np.column_stack([np.floor(t / 0.5) * 0.6, 0.05 * np.sign(np.sin(2 * np.pi * t))])
    height = np.full(n, 0.9)
    com = centre_of_mass(zmp, height, dt)
    acc = (com[2:] - 2 * com[1:-1] + com[:-2]) / dt**2
    np.testing.assert_allclose(acc, 9.81 / 0.9 * (com - zmp)[1:-1], atol=1e-8)
    assert np.abs(com - zmp).max() < 0.5
    falling = np.arange(300, 312)
    height[falling] = 0.9 - 9.81 / 2 * (t[falling] - t[300]) ** 2
    com = centre_of_mass(zmp, height, dt)
    acc = (com[2:] - 2 * com[1:-1] + com[:-2]) / dt**2
    assert np.abs(acc[falling[1:-1] - 1]).max() < 1e-8


def test_course_rates_of_a_circle():
    t = np.arange(300) / FPS
    qpos = np.zeros((len(t), 7))
    qpos[:, 0], qpos[:, 1] = 2 * np.sin(0.5 * t), 2 - 2 * np.cos(0.5 * t)
    qpos[:, 3:7] = rotations.from_yaw(0.5 * t)
    clip = MotionClip("circle", qpos, ())
    speed, turning = course_rates(clip)
    assert speed[50:-50] == pytest.approx(1.0, abs=0.02)
    assert turning[50:-50] == pytest.approx(np.degrees(0.5), abs=1e-6)
