"""What all tests share."""

import pytest

from adapt_envs.drawing.scene import Scene
from sb3_adaptnet.evaluation import recording


@pytest.fixture(autouse=True, scope="session")
def _short_straight_walks():
    """What is measured straight ahead takes 3.5 s here, not 10: the first two do not count, and a stretch needs one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recording, "STRAIGHT_SECONDS", 3.5)
        yield


@pytest.fixture(autouse=True, scope="session")
def _one_sample_a_pixel():
    """Edges are not smooth in pictures of tests: where a processor draws, that is twice as fast."""
    begin = Scene.__init__

    def begin_rough(scene, model, *size):
        model.vis.quality.offsamples = 0
        begin(scene, model, *size)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Scene, "__init__", begin_rough)
        yield
