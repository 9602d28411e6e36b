"""The base and its adaptation in one world, chosen by its number."""

import numpy as np
import pytest
from evaluation_cases import STOOP, save_tiny_adaptation, save_tiny_base

from sb3_adaptnet.evaluation import open_worlds
from sb3_adaptnet.evaluation.pictures import before_after
from sb3_adaptnet.evaluation.pictures.before_after import COLUMNS, first_end
from sb3_adaptnet.policies.loading import load_policy

WIDTH, HEIGHT = 270, 300


@pytest.fixture(scope="module")
def three():
    return open_worlds(STOOP, 3, num_threads=1)


@pytest.fixture(scope="module")
def policy(three, tmp_path_factory):
    base = save_tiny_base(tmp_path_factory.mktemp("tiny"))
    return load_policy(save_tiny_adaptation(base, "one"), three)


def tiles(row):
    """Pictures of a row (332, 7 * 270, 3) without their captions; blank ones are left out."""
    parts = np.split(row, COLUMNS, axis=1)
    return [part[-HEIGHT:] for part in parts if np.ptp(part, axis=(0, 1)).any()]


def test_a_world_ends_as_its_first_episode_does(policy, three):
    ends = [first_end(policy, three, 5, world) for world in range(3)]
    assert len({end.steps for end in ends}) > 1 and {end.reason for end in ends} <= {"fall", "lost", ""}
    observations, _ = three.reset(seed=5)
    for step in range(max(end.steps for end in ends) + 1):
        observations, _, terminated, _, infos = three.step(policy.predict(observations, deterministic=True)[0])
        for world in np.flatnonzero(terminated):
            if step == ends[world].steps:
                assert infos["final_info"]["end"][world] == ends[world].reason
            assert step >= ends[world].steps


def alike(one, other):
    """Whether under a thousandth of the pixels differ: a busy processor draws up to 100 of 1.25 million otherwise."""
    return np.any(one != other, axis=-1).mean() < 0.001


def test_the_world_is_the_one_that_is_named(policy, three):
    one, same, other = (before_after(policy, three, seed=5, world=world) for world in (1, 1, 2))
    assert one.shape == (2 * (HEIGHT + 32), COLUMNS * WIDTH, 3)
    assert alike(one, same) and not alike(one, other)
    assert policy.alpha == 1.0
    above, below = np.split(one, 2)
    # Both start from the same state, whatever becomes of them.
    assert alike(tiles(above)[0], tiles(below)[0])
    for row, alpha in ((above, 0.0), (below, 1.0)):
        policy.alpha = alpha
        steps = first_end(policy, three, 5, 1).steps
        assert len(tiles(row)) == sum(moment < steps for moment in range(0, 180, 30)) + 1


@pytest.mark.parametrize("world", [-1, 3])
def test_a_world_that_does_not_exist_is_refused(policy, three, world):
    with pytest.raises(ValueError, match=f"no world {world}; they are 0 to 2"):
        before_after(policy, three, world=world)
