"""A user's own environments: registered, pickled, documented."""

import re
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common.vec_env import SubprocVecEnv

import adapt_envs
from adapt_envs import SUITE, TaskSpec, env_id, make_vector, register
from adapt_envs.model import TERRAINS, Morphology, ObstacleField
from adapt_envs.tasks import PushSchedule

ROOT = Path(__file__).resolve().parents[2]


def slope(rng, size):
    """A plane of slope 0.1 along x."""
    return np.tile(0.01 * np.arange(size), (size, 1))


@pytest.fixture
def clean_table():
    """The table and the registry as they were."""
    names, ids = set(SUITE), set(gym.registry)
    yield
    for name in set(SUITE) - names:
        del SUITE[name]
    for name in set(gym.registry) - ids:
        del gym.registry[name]


def test_everything_at_once_registers_makes_and_steps(clean_table):
    spec = TaskSpec(
        "Stoop", morphology=Morphology(length={"right_shin": 1.1, "left_shin": 1.1}), locked=("neck",), friction=0.5,
        terrain=slope, obstacles=ObstacleField(density=0.3), heightmap=True, push=PushSchedule(force=200.0),
    )  # fmt: skip
    name = register(spec, name="EverythingAtOnce")
    assert name == "AdaptNet/Humanoid-EverythingAtOnce-v0"
    check_env(gym.make(name).unwrapped, skip_render_check=True)
    env = make_vector(name, 3)
    env.reset(seed=0)
    assert env.single_action_space.shape == (25,)
    assert env.worlds.model.geom("floor").friction[0] == 0.5
    assert np.isclose(env.worlds.model.body("right_foot").pos[2], -1.1 * 0.40987)
    places = env.worlds.root_xy[:, 0] - env.worlds.ground.patches.centres_1d[0]
    assert np.allclose(env.worlds.ground.floor_at(env.worlds.root_xy), 0.1 * ((places + 12) % 27), atol=1e-4)
    env.step(env.action_space.sample())


def test_a_row_may_be_registered_twice_but_a_name_is_not_given_away(clean_table):
    first, second = (register(TaskSpec("walk", friction=0.7), name="Waxed") for _ in range(2))
    assert first == second
    with pytest.raises(ValueError, match="'Waxed' already"):
        register(TaskSpec("walk", friction=0.6), name="Waxed")
    with pytest.raises(ValueError, match="'Walk' already"):
        register(TaskSpec("run"), name="Walk")
    with pytest.raises(ValueError, match="letters and digits"):
        register(TaskSpec("walk"), name="My Walk")


def test_other_processes_make_registered_environments(clean_table):
    """The row travels with the environment's maker; a worker need not have seen the registration."""
    spec = gym.spec(register(TaskSpec("Stoop", terrain=TERRAINS["hills"], heightmap=True), name="Travels"))
    env = SubprocVecEnv([lambda: gym.make(spec)], start_method="forkserver")
    assert env.reset()["heightmap"].shape == (1, 1, 35, 35)
    env.close()


def test_every_field_is_an_argument_of_every_environment():
    env = gym.make(env_id("Run"), locked=("right_knee",), terrain="rugged", terrain_seed=3, heightmap=True)
    assert env.action_space.shape == (27,)
    assert env.reset(seed=0)[0]["heightmap"].std() > 0.01


@pytest.mark.parametrize(
    ("wrong", "words"),
    [({"morphology": "giant"}, "'giant'.*long_shins"), ({"locked": ("tail",)}, "'tail'.*right_knee"),
     ({"terrain": "sea"}, "'sea'.*hills"), ({"bodies": 2}, "'bodies'.*morphology.*terrain_seed")],
)  # fmt: skip
def test_wrong_fields_are_named_with_the_valid_ones(wrong, words):
    with pytest.raises(ValueError, match=words):
        gym.make(env_id("Walk"), **wrong)


def test_the_documentation_runs(clean_table):
    text = (ROOT / "docs" / "extending.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) >= 3
    space = {}
    for block in blocks:
        exec(block, space)
    assert {"Ape", "Dunes", "RinkRun"} <= set(SUITE)
    made = make_vector(env_id("RinkRun"), 2)
    made.reset(seed=0)
    made.step(made.action_space.sample())


def test_the_documentation_lists_every_field_and_every_environment():
    extending, environments = ((ROOT / "docs" / name).read_text() for name in ("extending.md", "environments.md"))
    for field in TaskSpec.__dataclass_fields__:
        assert f"`{field}`" in extending, field
    for name, spec in SUITE.items():
        assert f"`{env_id(name)}`" in environments
        assert spec.summary.rstrip(".") in environments, name


def test_the_public_names_are_there():
    for name in ("register", "make_vector", "env_id", "TaskSpec", "SUITE", "AdaptEnv", "AdaptVectorEnv"):
        assert name in adapt_envs.__all__
        assert hasattr(adapt_envs, name)
