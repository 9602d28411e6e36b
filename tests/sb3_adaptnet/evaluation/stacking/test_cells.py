"""Pairs of tiny adaptations, measured, tabled and drawn by the command."""

import csv
from dataclasses import replace

import cv2
import pytest
from evaluation_cases import save_tiny_adaptation, save_tiny_base

from adapt_envs import env_id
from sb3_adaptnet.commands.main import main
from sb3_adaptnet.evaluation import recording
from sb3_adaptnet.evaluation.stacking import Cell, cells, markdown, read_csv, renewed, write_csv, write_heat_map
from sb3_adaptnet.stacking import pairs_of
from sb3_adaptnet.weights.card import amend_card


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    """A style, a body and two grounds of one base."""
    base = save_tiny_base(tmp_path_factory.mktemp("stacks"))
    amend_card(base, environment=env_id("Walk"))
    made = {}
    for seed, name in enumerate(("Stoop", "LongShinsWalk", "IceWalk")):
        made[name] = save_tiny_adaptation(base, name.lower(), seed=seed)
        amend_card(made[name], environment=env_id(name))
    return made


def cell(acting="both", falls=0.2, visible=True, first="walk-a", kinds="style + ground", weights=(1.0, 1.0)):
    error = None if visible is None else 0.03
    return Cell(first, "walk-b", kinds, acting, weights, "0.5-0.8", 0.5, falls, error, visible, (), 200.0, 0)


def test_the_command_measures_every_pair_and_writes_table_csv_and_picture(tiny, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(recording, "STRAIGHT_SECONDS", 0.2)
    monkeypatch.setattr(cells, "_base_error", lambda *_: 0.1)
    table, picture = tmp_path / "cells.csv", tmp_path / "map.png"
    words = ["--seconds", "20", "--threads", "1", "--seed", "3", "--csv", str(table), "-o", str(picture)]
    assert main(["stack", *map(str, tiny.values()), *words]) == 0
    printed = capsys.readouterr().out
    assert "style + ground: 0 of 1 pairs" in printed and "body + ground: 0 of 1" in printed
    with table.open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["acting"] for row in rows] == ["base", "first", "second", "both"] * 3
    assert {(row["first"], row["second"]) for row in rows} == {
        ("stoop", "icewalk"), ("stoop", "longshinswalk"), ("longshinswalk", "icewalk"),
    }  # fmt: skip
    assert all(row["seed"] == "3" and float(row["seconds"]) == 20 for row in rows)
    for start in (0, 4, 8):
        found = {(row["goal_reward"], row["falls_per_minute"]) for row in rows[start : start + 4]}
        assert len(found) == 4, "base, either and the sum act differently"
    assert [row["speeds"] for row in rows[::4]] == ["0.743-1.114", "0.836-1.254", "1-1.5"]
    assert rows[0]["visible"] == "False" and rows[8]["visible"] == ""
    assert cv2.imread(str(picture)).shape[2] == 3


def test_goals_may_have_the_bases_speeds(tiny, monkeypatch):
    monkeypatch.setattr(recording, "STRAIGHT_SECONDS", 0.2)
    monkeypatch.setattr(cells, "_base_error", lambda *_: 0.1)
    pairs = pairs_of([tiny["Stoop"], tiny["IceWalk"]])
    (found,) = cells.measure_pairs(pairs, 1.0, 0, threads=1, base_speeds=True)
    assert [cell.speeds for cell in found] == ["1-1.5"] * 4


def test_found_weights_are_the_best_with_another_seed_and_measured_with_the_one_asked_for(tiny, monkeypatch):
    monkeypatch.setattr(recording, "STRAIGHT_SECONDS", 0.2)
    monkeypatch.setattr(cells, "_base_error", lambda *_: 0.1)
    tried = ((1.0, 1.0), (1.0, 3.0))
    monkeypatch.setattr(cells, "WEIGHTS", tried)
    pairs = pairs_of([tiny["Stoop"], tiny["IceWalk"]])
    (found,) = cells.measure_pairs(pairs, 40.0, 2, threads=1, find_weights=True)
    asked = {}
    for weights in tried:
        monkeypatch.setattr(cells, "WEIGHTS", (weights,))
        (other,) = cells.measure_pairs(pairs, 40.0, 1002, threads=1, find_weights=True)
        asked[weights] = (len(other[-1].failed_tests), other[-1].falls_per_minute)
        assert other[-1].weights == weights
    assert len(set(asked.values())) > 1 and asked[found[-1].weights] == min(asked.values())
    assert {one.seed for one in found} == {2}
    assert [one.weights for one in found[:3]] == [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]


def test_what_adds_up_at_full_strength_is_left_so(tiny, monkeypatch):
    monkeypatch.setattr(cells, "MOST_FALLS", 1000.0)
    pairs = pairs_of([tiny["LongShinsWalk"], tiny["IceWalk"]])
    (found,) = cells.measure_pairs(pairs, 0.7, 0, threads=1, find_weights=True)  # too short to fall
    assert found[-1].adds_up and found[-1].weights == (1.0, 1.0)


def test_a_sum_adds_up_if_it_seldom_falls_and_its_style_is_visible():
    assert cell().adds_up and cell(falls=0.5).adds_up
    assert not cell(falls=0.6).adds_up and not cell(visible=False).adds_up
    assert cell(visible=None, kinds="body + ground").adds_up


def test_table_and_picture_say_which_add_up(tmp_path):
    pairs = [
        [
            cell(acting, falls, acting == "both", name, weights=(1.0, 1.2))
            for acting, falls in zip(cells.ACTING, found, strict=True)
        ]
        for name, found in (("walk-a", (33.0, 4.0, 0.9, 0.2)), ("walk-c", (33.0, 4.0, 0.9, 2.0)))
    ]
    text = markdown(pairs).splitlines()
    bar = "fall at most 0.5 times a minute with the style visible"
    assert text[0] == f"style + ground: 1 of 2 pairs {bar}: walk-a + walk-b."
    assert text[4].startswith("| walk-a + walk-b | 1 + 1.2 | 33.0 / 4.0 / 0.9 / 0.2 | ") and text[4].endswith(
        "| **yes** |"
    )
    assert text[5].endswith("| no / no / no / yes | no |")
    write_heat_map(pairs, tmp_path / "map.png")
    picture = cv2.imread(str(tmp_path / "map.png")).reshape(-1, 3)
    assert (abs(picture.astype(int) - (155, 112, 66)).max(axis=1) < 12).any(), "the frame of what adds up"


def test_a_table_is_read_as_it_was_written(tmp_path):
    pair = [replace(cell(acting, weights=(0.9, 1.2)), failed_tests=("cadence", "error")) for acting in cells.ACTING]
    blind = [cell(acting, visible=None, kinds="body + ground", first="walk-c") for acting in cells.ACTING]
    write_csv([pair, blind], tmp_path / "cells.csv")
    assert read_csv(tmp_path / "cells.csv") == [pair, blind]


def test_pairs_measured_again_replace_those_of_before_where_they_stood():
    old = [[cell(acting, falls, first=name) for acting in cells.ACTING] for name, falls in (("a", 3.0), ("b", 2.0))]
    new = [[cell(acting, 0.1, first=name) for acting in cells.ACTING] for name in ("c", "a")]
    assert renewed(old, new) == [new[1], old[1], new[0]]


def test_a_pair_goes_into_a_table_of_before(tiny, tmp_path, capsys):
    table, picture = tmp_path / "cells.csv", tmp_path / "map.png"
    kept = [cell(acting, first="walk-a") for acting in cells.ACTING]
    stale = [replace(cell(acting, first="longshinswalk"), second="icewalk") for acting in cells.ACTING]
    write_csv([stale, kept], table)
    words = ["--seconds", "0.7", "--threads", "1", "--into", str(table), "-o", str(picture)]
    assert main(["stack", str(tiny["LongShinsWalk"]), str(tiny["IceWalk"]), *words]) == 0
    measured, other = read_csv(table)
    assert other == kept and measured[0].kinds == "body + ground" and measured[0].seconds == pytest.approx(0.7, abs=0.1)
    assert "walk-a + walk-b" in capsys.readouterr().out and picture.is_file()


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (None, "cannot be read"),
        ("a,b\n1,2\n", "its columns are not first, second, kinds"),
        ("a,b\n", "its columns are not first, second, kinds"),
        ("", "its columns are not first, second, kinds"),
        ("maybe", "visible is 'Maybe', and not True, False or empty"),
        ("torn", "walk-a + walk-b has not the rows base, first, second, both"),
        ("word", "could not convert string to float: 'many'"),
    ],
)
def test_a_table_of_before_that_is_none_is_one_sentence(text, complaint, tmp_path, capsys):
    table = tmp_path / "cells.csv"
    write_csv([[cell(acting, 0.25) for acting in cells.ACTING]], table)
    if text is None:
        table.unlink()
    elif text == "torn":
        table.write_text("".join(table.read_text().splitlines(keepends=True)[:-1]))
    else:
        old, new = {"word": ("0.25", "many"), "maybe": (",True,", ",Maybe,")}.get(text, (table.read_text(), text))
        table.write_text(table.read_text().replace(old, new))
    before = table.read_bytes() if table.exists() else None
    assert main(["stack", "walk-stoop", "walk-icewalk", "--into", str(table)]) == 2
    printed = capsys.readouterr()
    assert complaint in printed.err and printed.err.count("\n") == 1 and not printed.out
    assert (table.read_bytes() if table.exists() else None) == before


@pytest.mark.parametrize(
    "words, complaint",
    [
        (["walk-penguin"], "no two of walk-penguin"),
        (["--csv", "cells.txt"], "the extension must be .csv"),
        (["-o", "map.jpg"], "the extension must be .png"),
        (["walk-penguin", "walk-icewalk", "--seconds", "0.01"], "one step of 20 worlds"),
    ],
)
def test_bad_input_is_one_sentence(capsys, words, complaint):
    assert main(["stack", *words]) == 2
    printed = capsys.readouterr()
    assert complaint in printed.err and printed.err.count("\n") == 1 and not printed.out
