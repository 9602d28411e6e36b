"""The world models that ship foresee what the shipped bases do, disturbed as they were when the models were fitted."""

import pytest

from adapt_envs import env_id
from sb3_adaptnet.runs.world_fit import FitPlan, record_transitions
from sb3_adaptnet.world_model.fitting.error_table import error_table
from sb3_adaptnet.world_model.world_file import beside_base, has_world, read_world


@pytest.mark.parametrize("base", ["walk", "run"])
def test_the_model_of_a_base_foresees_a_second_as_its_card_says(base):
    assert has_world(base)
    found = read_world(beside_base(base))
    plan = FitPlan(env_id(base.capitalize()), (base,), worlds=32, steps=70, seed=123, threads=1)
    data, character = record_transitions(plan)
    assert found.model.character == character
    found_here = error_table(found.model, data, samples=400).world
    for here, stated in zip(found_here, found.card["errors"]["world"], strict=True):
        assert here < 1.5 * stated
