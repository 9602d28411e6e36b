"""The world model that ships foresees what the shipped walk does, disturbed as it was when the model was fitted."""

from sb3_adaptnet.runs.world_fit import FitPlan, record_transitions
from sb3_adaptnet.world_model.fitting.error_table import error_table
from sb3_adaptnet.world_model.world_file import beside_base, has_world, read_world


def test_the_walks_model_foresees_a_second_as_its_card_says():
    assert has_world("walk")
    found = read_world(beside_base("walk"))
    plan = FitPlan("AdaptNet/Humanoid-Walk-v0", ("walk",), worlds=32, steps=70, seed=123, threads=1)
    data, character = record_transitions(plan)
    assert found.model.character == character
    found_here = error_table(found.model, data, samples=400).world
    for here, stated in zip(found_here, found.card["errors"]["world"], strict=True):
        assert here < 1.5 * stated
