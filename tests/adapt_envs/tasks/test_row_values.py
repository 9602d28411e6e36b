"""Values that a row of the table, `gym.make` and `reset` refuse, each with one sentence that names it."""

from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

from adapt_envs import AdaptEnv, TaskSpec, env_id, make_vector
from adapt_envs.model import Morphology, ObstacleField
from adapt_envs.motion.clip import MotionError
from adapt_envs.motion.library import load_clip
from adapt_envs.tasks import PushSchedule

REFUSED = [
    ({"motion": 5}, "motion is 5, expected a clip's name or file"),
    ({"speed_range": (1.5, 1.0)}, r"speed_range is \(1.5, 1.0\), expected 0 < low <= high"),
    ({"speed_range": (-1.5, -1.0)}, "speed_range is .*, expected 0 < low <= high"),
    ({"speed_range": (1.0, np.inf)}, "speed_range is .*, expected 0 < low <= high"),
    ({"speed_range": "12"}, "speed_range is '12', expected two numbers"),
    ({"timer_range": None}, "timer_range is None, expected two numbers"),
    ({"friction": True}, "friction is True, expected a positive number"),
    ({"friction": "ice"}, "friction is 'ice', expected a positive number"),
    ({"morphology": 5}, "morphology is 5, expected a name, a Morphology, or None"),
    ({"locked": None}, "locked is None, expected names of joints"),
    ({"locked": (1,)}, r"locked is \(1,\), expected names of joints"),
    ({"terrain": 5}, r"terrain is 5, expected a name, a function \(rng, size\) -> heights, or None"),
    ({"terrain_seed": None}, "terrain_seed is None, expected a whole number from 0"),
    ({"terrain_seed": -1}, "terrain_seed is -1, expected a whole number from 0"),
    ({"terrain_scale": 0}, "terrain_scale is 0, expected a positive number"),
    ({"obstacles": True}, "obstacles is True, expected a name, an ObstacleField, or None"),
    ({"heightmap": "no"}, "heightmap is 'no', expected True or False"),
    ({"fall_height": 0}, "fall_height is 0, expected a positive number of metres, or None"),
    ({"fall_height": "low"}, "fall_height is 'low', expected a positive number of metres, or None"),
    ({"push": 1000}, "push is 1000, expected a PushSchedule"),
    ({"push": {"newtons": 5}}, "push has 'newtons', expected force, seconds, interval"),
    ({"push": {"interval": 5}}, "interval 5, expected 0 < seconds <= low <= high"),
    ({"push": {"force": -5}}, "force is -5, expected a positive number of newtons"),
    ({"morphology": {"length": 2}}, "morphology is {'length': 2}, expected values of Morphology"),
    ({"obstacles": {"height": 1}}, "obstacles is {'height': 1}, expected values of ObstacleField"),
    ({"clip_on_body": 1}, "clip_on_body is 1, expected True or False"),
]


@pytest.mark.parametrize("values, complaint", REFUSED)
def test_a_row_and_an_argument_are_refused_alike(values, complaint):
    with pytest.raises(ValueError, match=complaint):
        TaskSpec(**{"motion": "walk", **values})
    with pytest.raises(ValueError, match=complaint):
        gym.make(env_id("Walk"), **values)


def test_values_are_kept_in_one_form():
    row = TaskSpec(Path("a") / "b.npz", locked="right_knee", speed_range=[1, 2], friction=1, terrain_seed=np.int64(3))
    assert row == TaskSpec("a/b.npz", locked=("right_knee",), speed_range=(1.0, 2.0), terrain_seed=3)


def test_parts_may_be_written_as_a_yaml_file_does():
    row = TaskSpec(
        "walk",
        push={"force": 200.0, "interval": [2.0, 4.0]},
        obstacles={"density": 0.4, "height": [1.0, 1.0]},
        morphology={"length": {"right_shin": 1.2}},
    )
    assert row == TaskSpec(
        "walk",
        push=PushSchedule(force=200.0, interval=(2.0, 4.0)),
        obstacles=ObstacleField(density=0.4, height=(1.0, 1.0)),
        morphology=Morphology(length={"right_shin": 1.2}),
    )
    env = make_vector(env_id("Walk"), num_envs=2, push={"force": 200.0})
    assert env.worlds.pushes.schedule == PushSchedule(force=200.0)
    env.close()


@pytest.mark.parametrize("interval", [(3, np.inf), 3, (3,), (6, 3), (0.1, 3), ("3", 6), None])
def test_a_push_has_an_interval(interval):
    with pytest.raises(ValueError, match="expected 0 < seconds <= low <= high, all of them finite"):
        PushSchedule(interval=interval)


@pytest.mark.parametrize("force", [0, -5, np.nan, np.inf, "5", True])
def test_a_push_has_a_force(force):
    with pytest.raises(ValueError, match="force is .*, expected a positive number of newtons"):
        PushSchedule(force=force)


@pytest.mark.parametrize(
    "values, complaint",
    [
        ({"density": 2}, "density is 2, expected a share"),
        ({"density": -1}, "density is -1, expected a share"),
        ({"cell": 0}, "cell is 0 m, expected a divisor"),
        ({"side": (1.6, 0.6)}, r"side is \(1.6, 0.6\) m, expected 0 < low <= high"),
        ({"height": (-1, 1)}, r"height is \(-1, 1\) m, expected 0 < low <= high"),
    ],
)
def test_obstacles_that_cannot_be_are_refused(values, complaint):
    with pytest.raises(ValueError, match=complaint):
        ObstacleField(**values)


def test_a_motion_that_stands_still_needs_speeds(tmp_path):
    clip = load_clip("Stoop")
    qpos = clip.qpos.copy()
    qpos[:, :2] = 0
    file = tmp_path / "idle.npz"
    type(clip)("idle", qpos, clip.joint_names, cyclic=True).save(file)
    with pytest.raises(MotionError, match=r"clip 'idle' goes nowhere \(0.00 m/s\); give speed_range"):
        make_vector(env_id("Style"), 1, motion=str(file))
    env = make_vector(env_id("Style"), 1, motion=file, speed_range=(0.5, 1.0))
    env.reset(seed=0)
    with pytest.raises(MotionError, match="'idle' holds no gait cycle: it stands still"):
        _ = env.tracking


@pytest.mark.parametrize(
    "options, complaint",
    [
        ({"start": "a"}, "start state 'a' does not exist"),
        ({"start": 1.5}, "start state 1.5 does not exist"),
        ({"start": True}, "start state True does not exist"),
        ({"goal_heading": "east", "goal_speed": 1.0}, "reset option goal_heading is 'east', expected a number"),
        ({"goal_heading": 0.0, "goal_speed": None}, "by heading and speed together"),
    ],
)
def test_options_of_a_wrong_kind_are_refused(options, complaint):
    env = AdaptEnv("Walk")
    with pytest.raises(ValueError, match=complaint):
        env.reset(options=options)
    assert np.isnan(env.worlds.goals.held_heading).all()


@pytest.mark.parametrize("shape", [(28,), (2, 1), (), (3, 28)])
def test_actions_of_another_shape_are_refused(shape):
    env = make_vector(env_id("Walk"), 2)
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"actions have the shape .*, expected \(2, 28\)"):
        env.step(np.zeros(shape, np.float32))


def test_a_world_whose_actions_are_no_numbers_diverges_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    env = make_vector(env_id("Walk"), 3)
    env.reset(seed=0)
    actions = np.tile(env.single_action_space.mean_pose, (3, 1))
    actions[1, 4] = np.nan
    observations, rewards, terminated, _, infos = env.step(actions)
    assert terminated.tolist() == [False, True, False] and infos["final_info"]["end"][1] == "diverged"
    assert rewards[1] == 0 and np.isfinite(observations).all() and env.diverged_worlds == 1
    assert not list(tmp_path.iterdir())  # MuJoCo leaves a log where it is given numbers that are none
