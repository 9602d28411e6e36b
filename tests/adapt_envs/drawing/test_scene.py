"""Several scenes in one process do not draw into each other."""

from contextlib import closing

import numpy as np

from adapt_envs import env_id, make_vector
from adapt_envs.drawing.world_view import SceneRenderer


def test_a_scene_that_is_closed_leaves_the_others():
    """MuJoCo frees in the context that is current, whoever's it is; the other scene then drew what was left there."""
    worlds = [make_vector(env_id(name), 1, num_threads=1) for name in ("TerrainHills", "Obstacles")]
    for env in worlds:
        env.reset(seed=0)
    with closing(SceneRenderer(worlds[1].worlds, (96, 96))) as stays:
        before = stays.picture().astype(int)
        for _ in range(2):
            with closing(SceneRenderer(worlds[0].worlds, (96, 96))) as goes:
                goes.picture()
                stays.picture()
            assert np.abs(stays.picture() - before).max() < 8


def test_worlds_far_apart_on_uneven_ground_keep_their_scenes():
    """Each has its own piece of the ground; cut anew for every picture, each took a second."""
    env = make_vector(env_id("TerrainHills"), 3, num_threads=1)
    env.reset(seed=0)
    with closing(SceneRenderer(env.worlds, (48, 48))) as renderer:
        first = [renderer.picture(world) for world in range(3)]
        scenes = dict(renderer._scenes)
        assert [np.array_equal(renderer.picture(world), first[world]) for world in range(3)] == [True] * 3
        assert renderer._scenes == scenes and len(scenes) == 3
    assert not renderer._scenes
