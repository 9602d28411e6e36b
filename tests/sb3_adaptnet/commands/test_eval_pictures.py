"""Pictures of `adaptnet eval`: they show the body that walked, on the ground that it walked on."""

import cv2
import numpy as np
import pytest
from evaluation_cases import figures_with

from adapt_envs import env_id
from adapt_envs.drawing.clip_scene import LOOK_HEIGHT
from adapt_envs.drawing.film import rollout_frames, video_frames
from adapt_envs.drawing.motion_sheet import contact_sheet
from adapt_envs.drawing.scene import QUARTER, Scene
from adapt_envs.model.build import compile_model
from sb3_adaptnet.commands.eval import draw
from sb3_adaptnet.commands.policy_options import LoadedPolicy
from sb3_adaptnet.evaluation.figures import Evaluation
from sb3_adaptnet.evaluation.pictures import pose_strip
from sb3_adaptnet.evaluation.recording import open_worlds, record
from sb3_adaptnet.evaluation.rollout_clips import clip_of, longest

SIZE = (96, 96)
STEPS = 5


class Still:
    """A policy that holds the middle of every joint's range."""

    def __init__(self, env):
        self.actions = np.zeros(env.action_space.shape)

    def predict(self, observation, state=None, episode_start=None, deterministic=False):
        return self.actions, state


def rolled(name):
    """Worlds, a rollout of theirs, and it as a clip."""
    env = open_worlds(env_id(name), 1, num_threads=1)
    free = record(Still(env), env, STEPS, seed=0)
    return env, free, clip_of(free, longest(free, 1.0), env.worlds.reference.joint_names, "still")


def far_from(picture, other):
    """Mean difference of two pictures, up to 255."""
    return np.abs(picture.astype(float) - other).mean()


def test_a_film_shows_the_body_that_walked():
    env, free, _ = rolled("LongShins")
    qpos = np.repeat(free.qpos[:1, 0], 2, axis=0)
    film, _ = rollout_frames(env.worlds, qpos, SIZE)
    lookat = np.array([*qpos[0, :2], LOOK_HEIGHT])
    with Scene(env.worlds.model, *SIZE) as own, Scene(compile_model(), *SIZE) as plain:
        assert np.array_equal(film, own.picture(qpos[0], QUARTER, lookat))
        assert far_from(film, plain.picture(qpos[0], QUARTER, lookat)) > 0.3


def test_a_sheet_and_a_strip_show_it_too():
    env, _, clip = rolled("LongShins")
    model = env.worlds.model
    assert far_from(contact_sheet(clip, 1, model), contact_sheet(clip, 1)) > 1
    assert far_from(pose_strip({"": clip}, model), pose_strip({"": clip})) > 1


def test_a_body_that_lacks_a_joint_is_drawn_with_its_lock(tmp_path):
    env, free, _ = rolled("LockedRightKnee")
    files = tmp_path / "sheet.png", tmp_path / "film.mp4"
    assert draw(LoadedPolicy(Still(env), env, "a", "a"), Evaluation(figures_with(), free, free), *files) == list(files)
    for picture in (cv2.imread(str(files[0])), cv2.VideoCapture(str(files[1])).read()[1]):
        blue, green, red = picture.astype(int).transpose(2, 0, 1)
        assert ((red > 200) & (green > 100) & (green < 180) & (blue < 90)).sum() > 100  # orange beside the lock


def test_on_hills_a_film_shows_hills_and_a_clip_is_set_down():
    env, free, clip = rolled("TerrainHills")
    floor, qpos = free.floor[:, 0], free.qpos[:, 0]
    assert np.abs(floor).min() > 0.02
    assert clip.qpos[:, 2] == pytest.approx(qpos[:, 2] - floor)
    hills, flat = next(iter(rollout_frames(env.worlds, qpos, SIZE))), next(iter(video_frames(clip, SIZE)))
    body = slice(24, 64), slice(42, 54)
    assert far_from(hills[body], flat[body]) < far_from(hills[80:], flat[80:])
