"""One value per objective."""

import pytest
from network_cases import SMALL, observation

from sb3_adaptnet.modules.critic import Critic


@pytest.mark.parametrize("objectives", [1, 2, 3])
@pytest.mark.parametrize("heightmap", [False, True])
def test_critic_has_one_value_per_objective(objectives, heightmap):
    critic = Critic(SMALL, heightmap, objectives)
    assert critic(observation(5, heightmap)).shape == (5, objectives)
    critic.set_objectives(4)
    assert critic(observation(5, heightmap)).shape == (5, 4)
