"""The specification of observations says what the environments do."""

import json

import numpy as np

from adapt_envs.env import AdaptEnv
from adapt_envs.features import Kinematics
from adapt_envs.model import LINKS, joint_names
from adapt_envs.portable import observation_specification


def test_an_observation_can_be_read_by_the_specification():
    spec = json.loads(json.dumps(observation_specification()))
    env = AdaptEnv("Walk")
    observation, _ = env.reset(seed=3, options={"goal_heading": 0.5, "goal_speed": 1.1})
    worlds = env.worlds

    def part(link, name):
        row = spec["link"][name]
        at = ((spec["frames"] - 1) * len(spec["links"]) + spec["links"].index(link)) * spec["link_size"] + row["offset"]
        return observation[at : at + row["size"]]

    links = Kinematics(worlds.model).link_states(worlds.physics.qpos, worlds.physics.qvel)[0]
    head = LINKS.index("head")
    np.testing.assert_allclose(part("pelvis", "position"), [0, 0, links[0, 2]], atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(part("head", "velocity")), np.linalg.norm(links[head, 7:10]), atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(part("head", "orientation")), 1, atol=1e-5)
    goal = {name: observation[spec["goal_offset"] + row["offset"]] for name, row in spec["goal"].items()}
    held = spec["bases"]["walk"]["held_seconds"]
    np.testing.assert_allclose([goal["speed"], goal["distance"]], [1.1, 1.1 * held], atol=1e-5)
    env.close()


def test_sizes_and_rates_add_up():
    spec = observation_specification()
    assert spec["size"] == spec["frames"] * len(spec["links"]) * spec["link_size"] + 4 == 784
    assert spec["joints"] == list(joint_names())
    assert (spec["control_hz"], spec["physics_steps"]) == (30, 4)
    assert sum(row["size"] for row in spec["link"].values()) == spec["link_size"]
