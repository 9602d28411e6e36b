"""Changes to entries of the zoo."""

import pytest

from sb3_adaptnet.sweeps.changes import merged

ENTRY = {
    "n_steps": 16,
    "policy_kwargs": {"base": "walk", "beta": 0.01},
    "learning_rate": {0: 1.0e-4, 500: 1.0e-5},
    "callback": [{"a.Discriminators": {"weights": {"goal": 0.6, "imitation": 0.4}, "range": [0.1, 0.2]}}, "b.Style"],
}


def test_mappings_change_key_by_key_and_the_rest_is_replaced():
    found = merged(ENTRY, {"policy_kwargs": {"beta": 0.0}, "n_steps": 8, "gamma": 0.9})
    assert found["policy_kwargs"] == {"base": "walk", "beta": 0.0} and found["n_steps"] == 8 and found["gamma"] == 0.9
    assert ENTRY["policy_kwargs"]["beta"] == 0.01 and found["callback"] is ENTRY["callback"]


def test_a_schedule_is_replaced_as_a_whole():
    assert merged(ENTRY, {"learning_rate": {0: 1.0e-3}})["learning_rate"] == {0: 1.0e-3}


def test_callbacks_change_by_their_names():
    changes = {"a.Discriminators": {"weights": {"goal": 0.8}, "range": None}, "b.Style": {"every": 2}}
    first, second = merged(ENTRY, {"callback": changes})["callback"]
    assert first == {"a.Discriminators": {"weights": {"goal": 0.8, "imitation": 0.4}, "range": None}}
    assert second == {"b.Style": {"every": 2}}
    with pytest.raises(ValueError, match="no 'c.Other' to change; there are: a.Discriminators, b.Style"):
        merged(ENTRY, {"callback": {"c.Other": {}}})


def test_callbacks_of_the_same_class_stay_and_cannot_be_changed_by_their_name():
    twice = {"callback": [{"a.Ramp": {"last": 1}}, "b.Plain", {"a.Ramp": {"last": 2}}]}
    changed = merged(twice, {"callback": {"b.Plain": {"every": 3}}})["callback"]
    assert changed == [{"a.Ramp": {"last": 1}}, {"b.Plain": {"every": 3}}, {"a.Ramp": {"last": 2}}]
    with pytest.raises(ValueError, match="'a.Ramp' stands there 2 times"):
        merged(twice, {"callback": {"a.Ramp": {"last": 3}}})
