"""`adaptnet eval` on tiny policies."""

import argparse
import json
from functools import partial

import cv2
import pytest
from evaluation_cases import STOOP, figures_with, save_tiny_adaptation, save_tiny_base

from sb3_adaptnet.commands import eval as evaluation
from sb3_adaptnet.commands.main import main
from sb3_adaptnet.commands.policy_options import (
    add_options,
    open_from_options,
    open_policy,
    open_worlds_for,
    shared_out,
    styles_of,
)
from sb3_adaptnet.evaluation.alpha import alpha_clips
from sb3_adaptnet.evaluation.recording import open_worlds
from sb3_adaptnet.evaluation.report import paragraph, table, text_table, write_page

FIELDS = {
    "goal_reward", "falls_per_minute", "lost_per_minute", "targets_reached", "imitation_error_m",
    "imitation_error_std_m",
    "slip_median_cm_s", "slip_p90_cm_s", "jerk_ratio", "seconds", "seed",
    "visible", "failed_tests", "speed_m_s", "asked_speed_m_s", "cadence_hz", "clip_cadence_hz",
    "foot_height_m", "clip_foot_height_m", "flight_share", "clip_flight_share",
    "tempo_error_m", "base_tempo_error_m", "world_error_m",
}  # fmt: skip


def frames_of(film):
    reader, count = cv2.VideoCapture(str(film)), 0
    while reader.grab():
        count += 1
    return count


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    base = save_tiny_base(tmp_path_factory.mktemp("tiny"))
    return base, save_tiny_adaptation(base, "one", seed=1), save_tiny_adaptation(base, "two", seed=2)


def test_the_json_has_the_fields_and_pictures_are_drawn(tiny, tmp_path, capsys):
    sheet, film = tmp_path / "sheet.png", tmp_path / "film.gif"
    words = ["--seconds", "40", "--seed", "4", "--threads", "1", "--json", "--sheet", str(sheet), "--video", str(film)]
    assert main(["eval", str(tiny[0]), "--env", STOOP, "--starts", "30", *words]) == 0
    figures = json.loads(capsys.readouterr().out)
    # Stoop never stands, and who has learned nothing falls from every start; 30 are two rounds of 20 worlds.
    assert figures.pop("starts") == {"starts": 40, "falls": 40, "standing": 0, "standing_falls": 0}
    assert set(figures) == FIELDS
    assert figures["seconds"] == 40.0 and figures["seed"] == 4
    assert figures["falls_per_minute"] > 0 and 0 < figures["goal_reward"] < 1
    assert cv2.imread(str(sheet)).shape[2] == 3 and frames_of(film) >= 6


def test_an_adaptation_is_measured_where_it_was_trained(tiny, capsys, monkeypatch):
    monkeypatch.setattr(evaluation, "alpha_clips", partial(alpha_clips, seconds=1.0))
    words = ["--seconds", "1", "--threads", "1", "--json"]
    strip = tiny[1].with_name("strip.png")
    assert main(["eval", str(tiny[1]), *words, "--strip", str(strip)]) == 0
    assert cv2.imread(str(strip)).shape == (2 * 320 + 32, 5 * 230, 3)
    adapted = json.loads(capsys.readouterr().out)
    assert main(["eval", str(tiny[1]), *words, "--alpha", "0"]) == 0
    without = json.loads(capsys.readouterr().out)
    assert main(["eval", str(tiny[0]), *words]) == 0
    base = json.loads(capsys.readouterr().out)
    assert base["base_tempo_error_m"] is None
    assert base | {"base_tempo_error_m": base["tempo_error_m"]} == without != adapted
    assert adapted["base_tempo_error_m"] == base["tempo_error_m"] and adapted["clip_cadence_hz"] == 1.0714


def test_a_base_is_compared_with_the_one_that_is_named(tiny, capsys):
    words = ["eval", str(tiny[0]), "--seconds", "1", "--threads", "1", "--json", "--base", str(tiny[0])]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["base_tempo_error_m"] == found["tempo_error_m"] and found["visible"] is False


def test_another_speed_is_asked_for_straight_ahead_alone(tiny, capsys):
    words, found = ["eval", str(tiny[1]), "--seconds", "1", "--threads", "1", "--json"], []
    for more in ([], ["--speed", "0.4"]):
        assert main([*words, *more]) == 0
        found.append(json.loads(capsys.readouterr().out))
    usual, slow = found
    assert slow["asked_speed_m_s"] == 0.4 != usual["asked_speed_m_s"]
    assert slow["goal_reward"] == usual["goal_reward"] and slow["clip_cadence_hz"] == usual["clip_cadence_hz"]


def test_a_picture_of_an_adaptation_and_its_base(tiny):
    pair = tiny[1].with_name("pair.png")
    assert main(["eval", str(tiny[1]), "--seconds", "2", "--threads", "1", "--before-after", str(pair)]) == 0
    assert cv2.imread(str(pair)).shape == (2 * (300 + 32), 7 * 270, 3)


@pytest.mark.parametrize(
    "words, complaint",
    [
        (["nothing"], "nothing"),
        (["BASE", "--env", "AdaptNet/Humanoid-Nowhere-v0"], "Nowhere"),
        (["BASE", "--alpha", "0.5"], "need an adaptation"),
        (["BASE", "--sheet", "sheet.jpg"], "the extension must be .png"),
        (["BASE", "--push-scale", "0.5"], "no pushes to scale"),
        (["BASE", "--strip", "strip.png"], "--strip needs an adaptation"),
        (["BASE", "--before-after", "pair.png"], "--before-after needs an adaptation"),
        (["BASE", "--video", "no/such/folder/film.mp4"], "does not exist"),
        (["BASE", "--seconds", "0.01"], "one step of 20 worlds"),
        (["BASE", "--clip", "Stoop", "--motion", "Limp"], "--clip Stoop and --motion Limp both name a reference"),
        (["BASE", "--clip", "Stupor"], "Stupor"),
        (["BASE", "--env", "CartPole-v1"], "'CartPole-v1' is not of this suite"),
        (["BASE", "--env", "nomodule:Foo-v0"], "nomodule:Foo-v0: No module named 'nomodule'"),
        (["BASE", "--clip", "Stoop", "--write-card"], "leave out --alpha, --styles, --push-scale, --clip and --speed"),
    ],
)
def test_bad_input_is_one_sentence(tiny, capsys, words, complaint):
    assert main(["eval", *(str(tiny[0]) if word == "BASE" else word for word in words)]) == 2
    printed = capsys.readouterr()
    assert complaint in printed.err and printed.err.count("\n") == 1 and not printed.out


@pytest.mark.parametrize(
    "words",
    [
        ["--seconds", "-1"],
        ["--seconds", "soon"],
        ["--speed", "0"],
        ["--speed", "inf"],
        ["--threads", "0"],
        ["--styles", "a=much"],
    ],
)
def test_unreadable_numbers_are_refused(tiny, words):
    with pytest.raises(SystemExit, match="2"):
        main(["eval", str(tiny[0]), *words])


def test_a_clip_brings_its_motion_and_its_speeds_to_any_ground(tiny):
    ice = "AdaptNet/Humanoid-IceWalk-v0"
    spec = open_worlds_for(str(tiny[0]), ice, num_worlds=1, threads=1, clip="Penguin").worlds.spec
    assert (spec.friction, spec.motion, spec.speed_range) == (0.15, "Penguin", (0.51, 0.765))
    plain = open_worlds_for(str(tiny[0]), ice, "Penguin", 1, 1).worlds.spec
    assert (plain.motion, plain.speed_range) == ("Penguin", (1.0, 1.5))


def test_styles_of_a_base_are_blended_alone_and_share_what_is_left(tiny):
    base, one, two = map(str, tiny)
    env = open_worlds(STOOP, 1, num_threads=1)
    assert open_policy(base, env, styles={one: None, two: None}).weights == {"main": 0.5, "two": 0.5}
    assert open_policy(base, env, styles={one: 0.2, two: None}).weights == pytest.approx({"main": 0.2, "two": 0.8})
    blended = open_policy(one, env, alpha=0.7, styles={two: None})
    assert blended.alpha == 0.7 and blended.weights == {"main": 0.5, "two": 0.5}
    assert open_policy(one, env).weights == {"main": 1.0}


@pytest.mark.parametrize("words, title", [
    (["BASE"], "base"),
    (["ONE"], "one"),
    (["ONE", "--alpha", "0.5"], "one, alpha 0.5"),
    (["BASE", "--styles", "ONE=0.3,TWO"], "0.3 one + 0.7 two"),
    (["ONE", "--styles", "TWO=1.0"], "two"),
])  # fmt: skip
def test_figures_and_sheets_are_headed_by_what_acts(tiny, words, title):
    files = dict(zip(("BASE", "ONE", "TWO"), map(str, tiny), strict=True))
    for word, file in files.items():
        words = [text.replace(word, file) for text in words]
    parser = argparse.ArgumentParser()
    add_options(parser)
    loaded = open_from_options(parser.parse_args([*words, "--env", STOOP, "--threads", "1"]), 1)
    assert loaded.title == title.replace("base", tiny[0].stem)


def test_words_of_a_blend():
    assert styles_of("a,b=0.25") == {"a": None, "b": 0.25}
    assert shared_out({"a": None, "b": 0.25, "c": None}) == {"a": 0.375, "b": 0.25, "c": 0.375}
    assert shared_out({"a": 0.9, "b": 0.8, "c": None}) == {"a": 0.9, "b": 0.8, "c": 0.0}


def test_tables_and_page(tmp_path):
    complaints = ("cadence none", "tempo error 0.1 m")
    figures = {"base <1>": figures_with(goal_reward=0.81234, visible=False, failed_tests=complaints)}
    text = text_table(figures)
    assert "0.812" in text and text.splitlines()[4].split()[-1] == "-"
    assert text.splitlines()[18].split() == ["style", "visible", "no"]
    assert text.splitlines()[-2:] == [
        "base <1> is not visible: cadence none",
        "base <1> is not visible: tempo error 0.1 m",
    ]
    assert "base &lt;1&gt;" in table(figures) and "<td>0.812</td>" in table(figures)
    write_page(tmp_path / "page.html", "T & S", [("", [paragraph("a < b")]), ("Figures", [table(figures)])])
    page = (tmp_path / "page.html").read_text()
    assert "<h1>T &amp; S</h1>" in page and "<p>a &lt; b</p>" in page and "<h2>Figures</h2>" in page
