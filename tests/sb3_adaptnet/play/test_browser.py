"""The view in the browser: the character stands on the ground, the sliders steer."""

import math
from importlib.util import find_spec

import numpy as np
import pytest
from evaluation_cases import STOOP, save_tiny_adaptation, save_tiny_base

from adapt_envs.features import rotations
from adapt_envs.model.humanoid import FEET
from adapt_envs.model.soles import sole_corners
from sb3_adaptnet.commands.policy_options import open_policy
from sb3_adaptnet.evaluation.recording import open_worlds
from sb3_adaptnet.play import Browser, Controls, play
from sb3_adaptnet.play.ground_mesh import TILE
from sb3_adaptnet.play.landscape import ROOT


def soles_shown(scene, model):
    """Corners (8, 3) of the soles, where the browser shows them."""
    shown = []
    for foot, corners in zip(FEET, sole_corners(model), strict=True):
        body = scene.nodes[f"/body_{model.geom(foot).bodyid[0]}"]
        shown.append(body.position + rotations.rotate(np.asarray(body.wxyz)[None], corners))
    return np.concatenate(shown)


@pytest.mark.parametrize("name", ["Walk", "TerrainHills", "TerrainRocky", "Obstacles"])
def test_the_soles_are_neither_above_nor_below_the_ground_that_is_shown(fakes, name):
    env = open_worlds(f"AdaptNet/Humanoid-{name}-v0", 1, num_threads=1)
    ground, view = env.worlds.ground, Browser(env.worlds, Controls())
    scene = view._server.scene
    for seed in range(8):
        env.reset(seed=seed)
        view.show()
        middle = -scene.nodes[ROOT].position
        soles = soles_shown(scene, env.worlds.model) + middle
        # Start states are those of the clip: one foot is down, and neither is under the ground.
        assert -0.02 < (soles[:, 2] - ground.height_at(soles[:, :2])).min() < 0.05
        tiles = [scene.world(node) + middle for node in scene.nodes if "tile" in node]
        assert bool(tiles) == ("Terrain" in name)
        for vertices in tiles:
            assert vertices[:, 2] == pytest.approx(ground.floor_at(vertices[:, :2]), abs=1e-4)
        below = np.floor(env.worlds.root_xy[0] / TILE).astype(int)
        assert not tiles or f"{ROOT}/tile_{below[0]}_{below[1]}" in scene.nodes
    view.close()
    assert not view.running


def test_the_sliders_write_into_the_controls(fakes, tmp_path):
    env = open_worlds(STOOP, 1, num_threads=1)
    controls = Controls(speed=1.0, alpha=2.0, weights={"main": 0.5, "two": 0.5}, labels={"main": "stroll"})
    sliders = Browser(env.worlds, controls).sliders
    assert set(sliders) == {"speed", "heading", "random goals", "restart", "alpha", "blend main", "blend two"}
    assert sliders["blend main"].label == "blend stroll" and sliders["alpha"].initial_value == sliders["alpha"].max == 2
    for name, value in (("heading", 90), ("blend two", 0.25), ("alpha", 0.5), ("restart", True), ("speed", 0.7)):
        sliders[name].set(value)
    sliders["random goals"].set(True)
    assert (sliders["speed"].min, sliders["speed"].max) == (0.1, 3.5)
    sprint = Browser(env.worlds, Controls(speed=4.2)).sliders["speed"]
    assert sprint.max == sprint.initial_value == 4.2
    assert controls.heading == pytest.approx(math.pi / 2) and controls.alpha == 0.5 and controls.speed == 0.7
    assert controls.weights == {"main": 0.5, "two": 0.25} and controls.restart and controls.random_goals


@pytest.mark.skipif(find_spec("viser") is None, reason="viser is optional")
@pytest.mark.parametrize("name", ["Stoop", "TerrainHills", "Obstacles"])
def test_viser_shows_it(tmp_path, name):
    base = save_tiny_base(tmp_path)
    env = open_worlds(STOOP if name == "Stoop" else f"AdaptNet/Humanoid-{name}-v0", 1, num_threads=1)
    env.reset(seed=0)
    policy = open_policy(str(save_tiny_adaptation(base, "one")), open_worlds(STOOP, 1, num_threads=1))
    view = Browser(env.worlds, Controls(), port=8971)
    try:
        if name == "Stoop":
            assert play(policy, env, view, Controls.of(policy, env), steps=3) == 3
        for _ in range(3):
            view.show()
        assert view.address.startswith("http://127.0.0.1:")
    finally:
        view.close()
