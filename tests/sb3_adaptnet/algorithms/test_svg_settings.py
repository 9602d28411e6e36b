"""Settings come in groups that refuse what they do not know."""

import pytest
import torch

from sb3_adaptnet.algorithms.checks import check_positive
from sb3_adaptnet.algorithms.svg_loss import LossSchedules, LossWeights, smoothness_loss
from sb3_adaptnet.algorithms.svg_settings import (
    CostToGo,
    Episodes,
    Exploration,
    ModelRefresh,
    grouped,
)


def test_smoothness_is_the_squared_change():
    assert torch.equal(smoothness_loss(torch.ones(2, 3), None), torch.zeros(2))
    assert torch.equal(smoothness_loss(torch.ones(2, 3), torch.zeros(2, 3)), torch.full((2,), 3.0))


def test_settings_come_in_groups():
    assert grouped(Exploration, None) == Exploration()
    assert grouped(Exploration, {"std": 0.1}) == Exploration(std=0.1)
    assert grouped(LossWeights, {"position": 2, "facing": 0}).travel == 0.4
    with pytest.raises(ValueError, match="Exploration has no 'noise'; it has std, share"):
        grouped(Exploration, {"noise": 1})
    with pytest.raises(ValueError, match="episodes of 9 to 3 steps"):
        Episodes(steps=(9, 3))
    with pytest.raises(ValueError, match="episodes of 9 to 3 steps"):
        Episodes(loose_steps=(9, 3))
    with pytest.raises(ValueError, match="goal_spread"):
        Episodes(goal_spread={0: -1.0})
    with pytest.raises(ValueError, match=r"partial_share is a share, at most 1, not \{0: 0.0, 9: 1.5\}"):
        Episodes(partial_share={0: 0.0, 9: 1.5})
    with pytest.raises(ValueError, match="discount"):
        CostToGo(discount=1.0)


def test_weights_of_the_loss_may_change_with_the_samples():
    schedules = LossSchedules.of({"footing": {0: 0.2, 1000: 1.0}, "goal": 2})
    assert [schedules.at(samples).footing for samples in (0, 500, 2000)] == pytest.approx([0.2, 0.6, 1.0])
    assert schedules.at(0).goal == 2
    assert schedules.at(0).travel == LossWeights().travel
    assert LossSchedules.of(LossWeights(goal=3)).at(7) == LossWeights(goal=3)
    assert LossSchedules.of(None).at(0) == LossWeights()
    with pytest.raises(ValueError, match="LossWeights has no 'gaol'; it has "):
        LossSchedules.of({"gaol": 1.0})
    with pytest.raises(ValueError, match="footing must be a number or"):
        LossSchedules.of({"footing": {0: -1.0}})


@pytest.mark.parametrize(
    ("kind", "wrong", "words"),
    [
        (Exploration, {"std": -1}, "exploration.std must be a number that is not negative, not -1"),
        (Exploration, {"std": "5e-2"}, "exploration.std must be a number .* not '5e-2'"),
        (Exploration, {"share": 7}, "exploration.share is a share, at most 1, not 7"),
        (Episodes, {"calm_seconds": {0: 1.5}}, "calm_seconds must be a number"),
        (Episodes, {"steps": 100}, "steps must be two values, .* not 100"),
        (Episodes, {"steps": (5, 7.5)}, "episodes of 5 to 7.5 steps"),
        (CostToGo, {"updates": [300]}, r"cost_to_go.updates must be two values, .* not \[300\]"),
    ],
)
def test_what_is_no_such_number_is_refused(kind, wrong, words):
    with pytest.raises(ValueError, match=words):
        kind(**wrong)


def test_of_updates_and_rollouts_there_must_be_one():
    with pytest.raises(ValueError, match="later_updates is 0"):
        CostToGo(updates=(300, 0))
    with pytest.raises(ValueError, match="recent_rollouts is 0"):
        check_positive(gradient_steps=1, recent_rollouts=0)
    with pytest.raises(ValueError, match="gradient_steps is 1.5, expected a whole number"):
        check_positive(gradient_steps=1.5)
    for name in ("updates", "batch", "rollouts"):
        with pytest.raises(ValueError, match=f"model_refresh.{name} is 0, expected a whole number of at least 1"):
            ModelRefresh(**{name: 0})
    with pytest.raises(ValueError, match="model_refresh.learning_rate is 0, expected one above 0"):
        ModelRefresh(learning_rate=0)
