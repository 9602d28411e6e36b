"""Progress rows and learning curves."""

import numpy as np
import pytest
from matplotlib.image import imread

from sb3_adaptnet.commands.main import main
from sb3_adaptnet.runs.curve import draw_curves, moving_mean, panels
from sb3_adaptnet.runs.history import append_row, read_rows, write_rows

COLUMNS = ("samples", "goal_reward", "footing_reward", "falls_per_minute", "episode_length", "kl")


def rows(count, goal=0.5):
    return [
        {"samples": 100 * n, "goal_reward": goal, "footing_reward": 0.1, "falls_per_minute": n} for n in range(count)
    ]


def test_rows_come_back_as_they_were_written(tmp_path):
    file = tmp_path / "progress.csv"
    write_rows(file, COLUMNS, rows(3))
    append_row(file, COLUMNS, {"samples": 300, "kl": 0.02})
    assert read_rows(file) == [*rows(3), {"samples": 300, "kl": 0.02}]
    assert read_rows(file, up_to=150) == rows(2)
    assert read_rows(tmp_path / "none.csv") == []


def test_a_row_that_was_cut_short_is_left_out(tmp_path):
    file = tmp_path / "progress.csv"
    write_rows(file, COLUMNS, rows(2))
    with file.open("a") as stream:
        stream.write("200,0.5,0.1,-\n,0.5")
    assert read_rows(file) == rows(2)


def test_a_column_that_no_longer_belongs_is_dropped(tmp_path):
    file = tmp_path / "progress.csv"
    write_rows(file, COLUMNS[:2], rows(2))
    assert read_rows(file) == [{"samples": row["samples"], "goal_reward": 0.5} for row in rows(2)]


def test_every_objective_has_a_panel():
    usual = ["goal_reward", "footing_reward", "falls_per_minute", "episode_length"]
    assert panels({"a": rows(2)}) == usual
    measured = [{**rows(1)[0], "tempo_error_m": 0.1, "discriminator_score_difference": 0.5}]
    assert panels({"a": rows(2), "b": measured}) == [*usual, "discriminator_score_difference", "tempo_error_m"]


def test_the_moving_mean_is_a_mean_of_neighbours():
    values = np.random.default_rng(0).normal(size=40)
    smooth = moving_mean(values, 5)
    assert smooth[20] == pytest.approx(values[18:23].mean())
    assert smooth[0] == pytest.approx(values[:3].mean()) and smooth[-1] == pytest.approx(values[-3:].mean())
    assert len(moving_mean(values[:2], 5)) == 2 and len(moving_mean(values[:0])) == 0


def test_two_runs_differ_in_the_picture(tmp_path):
    for name, goals in (("same", (0.2, 0.2)), ("other", (0.2, 0.8))):
        draw_curves({"a": rows(9, goals[0]), "b": rows(9, goals[1])}, tmp_path / f"{name}.png", "two")
    same, other = (imread(tmp_path / f"{name}.png") for name in ("same", "other"))
    assert same.shape == other.shape and np.abs(same - other).max() > 0.5


def test_the_command_draws_runs_and_names_what_is_wrong(tmp_path, capsys):
    for name in ("a", "b"):
        write_rows(tmp_path / f"{name}.csv", COLUMNS, rows(5))
    picture, words = tmp_path / "both.png", ["curves", str(tmp_path / "a.csv"), f"mine={tmp_path / 'b.csv'}", "-o"]
    assert main([*words, str(picture)]) == 0 and picture.read_bytes().startswith(b"\x89PNG")
    for more, problem in (
        ([f"a={tmp_path / 'b.csv'}", "-o", "x.png"], "two runs are called 'a'"),
        ([str(tmp_path / "none"), "-o", "x.png"], "no training run at"),
        ([__file__, "-o", "x.png"], "holds no rows"),
        (["-o", str(tmp_path / "none" / "x.png")], "the folder .* does not exist"),
    ):
        assert main(["curves", str(tmp_path / "a.csv"), *more]) == 2
        with pytest.raises(AssertionError, match=problem):
            raise AssertionError(capsys.readouterr().err)
