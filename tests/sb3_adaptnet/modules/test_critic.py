"""One value per objective."""

import pytest
import torch
from network_cases import SMALL, observation

from sb3_adaptnet.modules.architecture import CriticShape
from sb3_adaptnet.modules.critic import Critic


@pytest.mark.parametrize("objectives", [1, 2, 3])
@pytest.mark.parametrize("heightmap", [False, True])
def test_critic_has_one_value_per_objective(objectives, heightmap):
    critic = Critic(SMALL, heightmap, objectives)
    assert critic(observation(5, heightmap)).shape == (5, objectives)
    critic.set_objectives(4)
    assert critic(observation(5, heightmap)).shape == (5, 4)


@pytest.mark.parametrize("heightmap", [False, True])
def test_values_depend_on_the_base_code_alone_where_it_is_read(heightmap):
    critic = Critic(SMALL, heightmap, 2, CriticShape("base", (12, 8)))
    seen = observation(5, heightmap)._replace(base_code=torch.randn(5, SMALL.gru_size))
    values = critic(seen)
    assert values.shape == (5, 2)
    assert torch.equal(critic(seen._replace(frames=seen.frames + 1)), values)
    assert not torch.allclose(critic(seen._replace(base_code=seen.base_code + 1)), values)
    assert critic.normalizers() == []
    with pytest.raises(ValueError, match="base's code"):
        critic(seen._replace(base_code=None))


@pytest.mark.parametrize(
    ("choice", "words"), [({"encoder": "other"}, "own.*base.*other"), ({"hidden_sizes": ()}, "hidden_sizes")]
)
def test_impossible_critics_are_refused(choice, words):
    with pytest.raises(ValueError, match=words):
        CriticShape(**choice)
