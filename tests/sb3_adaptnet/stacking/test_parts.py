"""What adaptations change of their base's world, and which of them are stacked."""

import pytest

from adapt_envs import SUITE
from sb3_adaptnet.stacking import pairs_of, part_of
from sb3_adaptnet.weights.card import amend_card
from sb3_adaptnet.weights.shipped import pretrained_path


@pytest.mark.parametrize(
    "name, kind, changes",
    [
        ("walk-penguin", "style", {"motion": "Penguin", "speed_range": None}),
        ("walk-icewalk", "ground", {"friction": 0.15}),
        ("walk-terrainhills", "ground", {"terrain": "hills", "heightmap": True, "fall_height": 0.15}),
        ("walk-obstacles", "ground", {"obstacles": "blocks", "heightmap": True}),
        ("run-longshins", "body", {"morphology": "long_shins"}),
        ("run-lockedrightknee", "body", {"locked": ("right_knee",)}),
    ],
)
def test_an_adaptation_is_what_it_changes(name, kind, changes):
    part = part_of(name)
    assert (part.name, part.kind, part.changes) == (name, kind, changes)
    assert part.base.stem == name.split("-")[0] and part.row.motion == part.base.stem


def test_a_push_is_its_own_kind():
    assert part_of("walk-pushwalk").kind == "push"
    assert part_of("walk-pushwalk").world.push == SUITE["PushWalk"].push


def test_the_world_of_a_pair_has_the_changes_of_both():
    (pair,) = pairs_of(["walk-terrainhills", "walk-penguin"])
    assert (pair.first.name, pair.second.name, pair.kinds) == ("walk-penguin", "walk-terrainhills", ("style", "ground"))
    assert (pair.world.motion, pair.world.speed_range, pair.world.terrain) == ("Penguin", None, "hills")
    assert pair.world.heightmap and pair.world.friction == 1.0


def test_all_that_ship_are_paired_by_base_and_kind():
    pairs = pairs_of()
    assert {"style + ground", "style + push"} <= {" + ".join(pair.kinds) for pair in pairs}
    assert all(pair.first.base == pair.second.base for pair in pairs)
    names = [(pair.first.name, pair.second.name) for pair in pairs]
    assert len(set(names)) == len(names) and ("walk-stoop", "walk-icewalk") in names


def test_a_base_is_known_by_its_weights(tmp_path):
    for name in ("walk", "walk-stoop"):
        (tmp_path / f"{name}.safetensors").write_bytes(pretrained_path(name).read_bytes())
    copy = tmp_path / "walk-stoop.safetensors"
    (pair,) = pairs_of([copy, "walk-icewalk"])
    assert pair.first.base == tmp_path / "walk.safetensors" and pair.first.base_hash == pair.second.base_hash
    with pytest.raises(ValueError, match="two of these adaptations are named 'walk-stoop'"):
        pairs_of(["walk-stoop", copy, "walk-icewalk"])


def test_worlds_of_another_suite_are_refused(tmp_path):
    (tmp_path / "walk-stoop.safetensors").write_bytes(pretrained_path("walk-stoop").read_bytes())
    amend_card(tmp_path / "walk-stoop.safetensors", environment="CartPole-v1")
    with pytest.raises(ValueError, match="CartPole-v1 is not of this suite"):
        part_of(tmp_path / "walk-stoop.safetensors")


@pytest.mark.parametrize(
    "names, complaint",
    [
        (["walk", "walk-penguin"], "'walk' is a base"),
        (["walk-penguin", "walk-stoop"], "no two of walk-penguin, walk-stoop have one base"),
        (["walk-penguin", "run-longshins"], "no two of"),
        (["walk-moonwalk"], "walk-moonwalk"),
    ],
)
def test_what_cannot_be_stacked_is_named(names, complaint):
    with pytest.raises(ValueError, match=complaint):
        pairs_of(names)
