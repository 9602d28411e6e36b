"""`adaptnet demo`, as small as it gets."""

import json
import re
import shlex

import numpy as np
import pytest
from evaluation_cases import STOOP, save_tiny_adaptation, save_tiny_base

from adapt_envs.motion.library import load_clip
from sb3_adaptnet.commands import demo
from sb3_adaptnet.commands.main import main
from sb3_adaptnet.evaluation.alpha import alpha_clips
from sb3_adaptnet.evaluation.pictures import pose_strip, side_by_side
from sb3_adaptnet.evaluation.recording import open_worlds
from sb3_adaptnet.play.playground import ADDRESS
from sb3_adaptnet.policies.loading import load_policy


def files_on(page):
    return re.findall(r'src="([^"]+)"', page.read_text())


def test_adapts_measures_draws_and_says_where(tmp_path, capsys):
    base, output = save_tiny_base(tmp_path), tmp_path / "demo"
    words = ["--samples", "128", "--n-envs", "8", "--seconds", "2", "--film", "0.2", "-o", str(output)]
    assert main(["demo", "--base", str(base), *words]) == 0
    printed = capsys.readouterr().out
    assert str(output / "index.html") in printed and "goal reward" in printed
    figures = json.loads((output / "figures.json").read_text())
    assert list(figures) == ["base tiny", "own, 0 k samples"]
    shown = files_on(output / "index.html")
    assert "curve.png" in shown and "sheet_0.png" in shown
    assert all((output / file).stat().st_size > 1000 for file in shown)
    card = json.loads((output / "own.json").read_text())["evaluation"]
    assert {**card["figures"], "seconds": card["seconds"], "seed": card["seed"]} == figures["own, 0 k samples"]
    words = shlex.split(card["command"].replace("own.", f"{output / 'own'}.").replace("tiny.", f"{tmp_path / 'tiny'}."))
    assert main([*words[1:], "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == figures["own, 0 k samples"]


def test_time_too_short_for_one_rollout_is_one_sentence(tmp_path, capsys):
    base, output = save_tiny_base(tmp_path), tmp_path / "demo"
    assert main(["demo", "--base", str(base), "--n-envs", "8", "--minutes", "0", "-o", str(output)]) == 2
    assert "0 minutes are too few" in capsys.readouterr().err and not (output / "index.html").exists()


def test_a_refusal_leaves_no_folder(tmp_path, capsys):
    assert main(["demo", "--base", "nobody", "-o", str(tmp_path / "demo")]) == 2
    assert "nobody" in capsys.readouterr().err and not (tmp_path / "demo").exists()


def test_an_earlier_training_stays_until_the_next_one_can_begin(tmp_path, capsys):
    base, output = save_tiny_base(tmp_path), tmp_path / "demo"
    earlier, other = output / demo.TRAINING, output / "training"
    for folder in (earlier, other):
        folder.mkdir(parents=True)
        (folder / "run.json").write_text("{}")
    words = ["--n-envs", "8", "--seconds", "2", "--film", "0.2", "-o", str(output)]
    assert main(["demo", "--base", "nobody", *words]) == 2
    assert "nobody" in capsys.readouterr().err and (earlier / "run.json").read_text() == "{}"
    assert main(["demo", "--base", str(base), "--minutes", "0", *words]) == 2
    assert (earlier / "run.json").read_text() != "{}" and (other / "run.json").read_text() == "{}"


def test_without_a_walk_the_motions_are_shown(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(demo, "pretrained_names", lambda: [])
    assert main(["demo", "--style", "Penguin", "--film", "0.1", "-o", str(tmp_path)]) == 0
    assert "there is no pretrained walk yet" in capsys.readouterr().out
    assert demo.playground()[0] in (tmp_path / "index.html").read_text()
    assert files_on(tmp_path / "index.html") == ["walk.png", "penguin.png", "style.mp4"]
    assert all((tmp_path / file).stat().st_size > 1000 for file in files_on(tmp_path / "index.html"))


def test_the_page_leads_to_the_playground(monkeypatch):
    monkeypatch.setattr(demo, "serving_command", lambda: None)
    (words,) = demo.playground()
    assert "make web" in words and "href" not in words
    monkeypatch.setattr(demo, "serving_command", lambda: "serve it")
    page = "".join(demo.playground())
    assert "<pre>serve it</pre>" in page and f'<a href="{ADDRESS}">' in page


def test_a_folder_that_is_no_run_is_left_alone(tmp_path, capsys):
    base = save_tiny_base(tmp_path)
    (tmp_path / demo.TRAINING).mkdir()
    (tmp_path / demo.TRAINING / "thesis.txt").write_text("mine")
    assert main(["demo", "--base", str(base), "-o", str(tmp_path)]) == 2
    assert "in the way" in capsys.readouterr().err and (tmp_path / demo.TRAINING / "thesis.txt").exists()


def test_pictures_side_by_side(tmp_path):
    clip = load_clip("Stoop")
    frame = next(side_by_side({"left": clip, "right": clip}, (80, 96)))
    assert frame.shape[1:] == (160, 3) and (frame[:, :80][40:] == frame[:, 80:][40:]).all()


def test_a_strip_of_alphas(tmp_path):
    base = save_tiny_base(tmp_path)
    env = open_worlds(STOOP, 3, num_threads=1)
    policy = load_policy(save_tiny_adaptation(base, "one"), env)
    clips = alpha_clips(policy, env, alphas=(0.0, 1.0), seconds=1.0)
    assert list(clips) == ["alpha = 0", "alpha = 1"] and policy.alpha == 1.0
    strip = pose_strip(clips)
    assert strip.shape == (2 * 320 + 32, 2 * 230, 3) and strip.dtype == np.uint8


@pytest.mark.parametrize("minutes, over", [(0.0, True), (10.0, False)])
def test_the_time_limit_ends_training(minutes, over):
    limit = demo.TimeLimit(minutes)
    limit._on_training_start()
    assert limit._on_step() is not over
