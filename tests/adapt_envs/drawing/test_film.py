"""Films: how long they are, and what their files hold."""

import cv2
import numpy as np
import pytest

from adapt_envs.drawing.clip_scene import LOOK_HEIGHT
from adapt_envs.drawing.film import _followed, video_frames, write_video
from adapt_envs.motion.library import load_clip


def ramp(count=12, size=(96, 64)):
    """Pictures whose red grows from the left to the right and whose blue grows in time."""
    pictures = np.zeros((count, size[1], size[0], 3), np.uint8)
    pictures[..., 0] = np.linspace(0, 200, size[0])
    pictures[..., 2] = np.linspace(0, 220, count)[:, None, None]
    return pictures


def read(path):
    """Frames (count, height, width, 3), frames per second, and the codec's four letters."""
    film = cv2.VideoCapture(str(path))
    frames = []
    while (found := film.read())[0]:
        frames.append(found[1][..., ::-1])
    codec = int(film.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little").decode("latin-1").lower()
    return np.array(frames), film.get(cv2.CAP_PROP_FPS), codec


def test_a_film_is_h264_with_every_picture_at_30_hertz(tmp_path):
    pictures = ramp()
    write_video(iter(pictures), tmp_path / "film.mp4")
    frames, rate, codec = read(tmp_path / "film.mp4")
    assert codec in ("h264", "avc1") and rate == 30
    assert frames.shape == pictures.shape
    assert np.abs(frames.astype(float) - pictures).mean() < 6


def test_an_animation_keeps_its_colours(tmp_path):
    pictures = ramp()
    write_video(pictures, tmp_path / "film.gif")
    frames, _, _ = read(tmp_path / "film.gif")
    assert frames.shape == pictures.shape
    assert np.abs(frames.astype(float) - pictures).max() < 12


def test_a_camera_follows_a_single_frame():
    assert _followed(np.array([[1.0, 2.0, 0.0]])) == pytest.approx(np.array([[1.0, 2.0, LOOK_HEIGHT]]))


def test_what_cannot_be_a_film_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"no pictures.*film\.mp4"):
        write_video([], tmp_path / "film.mp4")
    with pytest.raises(ValueError, match=r"film\.avi.*\.mp4, \.gif"):
        write_video(ramp(), tmp_path / "film.avi")
    with pytest.raises(OSError):
        write_video(ramp(), tmp_path / "nowhere" / "film.mp4")


def test_a_film_or_picture_that_fails_leaves_what_was_there(tmp_path):
    film = tmp_path / "film.mp4"
    film.write_bytes(b"earlier")

    def broken():
        yield np.zeros((32, 32, 3), np.uint8)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_video(broken(), film)
    assert film.read_bytes() == b"earlier" and list(tmp_path.iterdir()) == [film]


def test_a_cycle_repeats_until_the_seconds_are_full_and_reaches_the_file(tmp_path):
    clip = load_clip("Stoop")
    pictures = list(video_frames(clip, (96, 96), min_seconds=1.0))
    assert len(pictures) == clip.period * np.ceil(30 / clip.period)
    write_video(pictures, tmp_path / "film.mp4")
    frames, _, _ = read(tmp_path / "film.mp4")
    assert np.abs(frames[9].astype(float) - pictures[9]).mean() < 6
