"""How the playground is served."""

import shlex

from sb3_adaptnet.play.playground import ADDRESS, serving_command


def test_one_that_was_built_is_served_from_its_folder(tmp_path):
    folder = tmp_path / "with space"
    folder.mkdir()
    (folder / "index.html").write_text("<title>AdaptNet playground</title>")
    words = shlex.split(serving_command(folder))
    assert words[:3] == ["python", "-m", "http.server"] and words[words.index("-d") + 1] == str(folder)
    assert f"http://{words[words.index('--bind') + 1]}:{words[-1]}/" == ADDRESS


def test_one_that_was_not_built_is_not_served(tmp_path):
    assert serving_command(tmp_path) is None
