"""Folders for the Hub: what they hold, what the Hub's own library reads of them, and that nothing is half written."""

import cv2
import pytest
from evaluation_cases import STOOP, figures_with, save_tiny_adaptation, save_tiny_base
from hub_cases import huggingface_hub

from adapt_envs.drawing.scene import RenderingError
from sb3_adaptnet import load_policy
from sb3_adaptnet.evaluation.card import write_evaluation
from sb3_adaptnet.evaluation.recording import open_worlds
from sb3_adaptnet.hub import base_model_beside
from sb3_adaptnet.publishing import Publication, write_folder
from sb3_adaptnet.weights.card import amend_card
from sb3_adaptnet.weights.weight_file import read_weights


@pytest.fixture
def adapted(tmp_path):
    file = save_tiny_adaptation(save_tiny_base(tmp_path), "one")
    figures = figures_with(goal_reward=0.625, cadence_hz=1.25, clip_cadence_hz=1.5, seconds=20.0, seed=3, visible=False)
    write_evaluation(file, figures, "adaptnet eval one.safetensors --seed 3")
    return file


def metadata(folder):
    return huggingface_hub.ModelCard.load(folder / "README.md").data


def test_weights_cards_picture_and_film(adapted, tmp_path):
    env = open_worlds(STOOP, 1, num_threads=1)
    acting = (load_policy(adapted, env), env)
    folder = write_folder(Publication(adapted, "me/one", None, "mit"), tmp_path / "out" / "one", acting, seconds=0.2)
    names = {file.name for file in folder.iterdir()}
    assert names == {"README.md", "one.safetensors", "one.json", "picture.png", "replay.mp4"}
    assert read_weights(folder / "one.safetensors")[1] == read_weights(adapted)[1]
    assert cv2.imread(str(folder / "picture.png")).std() > 10
    assert cv2.VideoCapture(str(folder / "replay.mp4")).get(cv2.CAP_PROP_FRAME_COUNT) == 6
    assert [file.name for file in folder.parent.iterdir()] == ["one"]


def test_the_hubs_library_reads_the_metadata(adapted, tmp_path):
    folder = write_folder(Publication(adapted, "me/one", None, "mit"), tmp_path / "one")
    data = metadata(folder)
    assert (data.library_name, data.base_model, data.license) == ("adaptnet-gym", "me/tiny", "mit")
    assert data.pipeline_tag == "reinforcement-learning" and STOOP in data.tags
    found = {result.metric_type: result.metric_value for result in data.eval_results}
    assert found == {"goal_reward": 0.625, "cadence_hz": 1.25}  # not the clip's, not what is no number
    assert {result.dataset_type for result in data.eval_results} == {STOOP}
    assert base_model_beside(folder / "one.safetensors") == "hf://me/tiny"
    text = (folder / "README.md").read_text()
    assert "| goal reward | 0.625 |" in text and 'load_policy("hf://me/one", env)' in text
    assert "picture.png" not in text and read_weights(adapted)[1]["hash"] in text


def test_a_base_names_no_base_and_no_licence_is_made_up(tmp_path):
    folder = write_folder(Publication(save_tiny_base(tmp_path), "me/tiny"), tmp_path / "out")
    assert (metadata(folder).base_model, metadata(folder).license, metadata(folder).eval_results) == (None, None, None)
    assert "Not measured" in (folder / "README.md").read_text()


def test_the_base_may_lie_with_another_owner(adapted, tmp_path):
    folder = write_folder(Publication(adapted, "me/one", "others/walk"), tmp_path / "out")
    assert metadata(folder).base_model == "others/walk"


@pytest.mark.parametrize("motion", ["one.motion.npz", "runs/out/one.motion.npz"])
def test_a_clip_that_does_not_ship_comes_along(adapted, tmp_path, motion):
    amend_card(adapted, motion=motion)
    with pytest.raises(ValueError, match=r"its clip 'one.motion.npz' does not lie beside it"):
        write_folder(Publication(adapted, "me/one"), tmp_path / "out")
    assert not list(tmp_path.glob("*out*"))
    adapted.with_name("one.motion.npz").write_bytes(b"clip")
    folder = write_folder(Publication(adapted, "me/one"), tmp_path / "out")
    assert (folder / "one.motion.npz").read_bytes() == b"clip"
    assert (
        f'gym.make("{STOOP}", motion=hf_hub_download("me/one", \'one.motion.npz\'))'
        in (folder / "README.md").read_text()
    )
    amend_card(adapted, motion=None)
    write_folder(Publication(adapted, "me/one"), folder)  # the clip of before is no file of somebody's own
    assert not (folder / "one.motion.npz").exists()


def test_weights_that_nobody_could_try_are_refused(adapted, tmp_path):
    amend_card(adapted, environment=None)
    with pytest.raises(ValueError, match="its card names no environment"):
        write_folder(Publication(adapted, "me/one"), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_an_earlier_publication_is_replaced_and_anything_else_is_left_alone(adapted, tmp_path):
    folder = write_folder(Publication(adapted, "me/one"), tmp_path / "out")
    write_folder(Publication(adapted, "me/two"), folder)
    assert "hf://me/two" in (folder / "README.md").read_text()
    own = tmp_path / "own"
    own.mkdir()
    (own / "thesis.txt").write_text("x")
    with pytest.raises(ValueError, match="is in the way, and holds no one.safetensors"):
        write_folder(Publication(adapted, "me/one"), own)
    (own / "one.safetensors").write_bytes(adapted.read_bytes())
    with pytest.raises(ValueError, match=r"also holds thesis.txt, which would be lost"):
        write_folder(Publication(adapted, "me/one"), own)
    with pytest.raises(ValueError, match=r"is where one.safetensors itself lies"):
        write_folder(Publication(own / "one.safetensors", "me/one"), own)
    assert (own / "thesis.txt").read_text() == "x"
    (folder / "my_recording.npz").write_bytes(b"mine")
    with pytest.raises(ValueError, match=r"also holds my_recording.npz, which would be lost"):
        write_folder(Publication(adapted, "me/one"), folder)


def test_what_was_measured_elsewhere_is_published_as_that(adapted, tmp_path):
    figures, hills = figures_with(goal_reward=0.5, seconds=20.0, seed=0), "AdaptNet/Humanoid-TerrainHills-v0"
    write_evaluation(adapted, figures, f"adaptnet eval one.safetensors --env {hills}")
    (result,) = metadata(write_folder(Publication(adapted, "me/one"), tmp_path / "out")).eval_results[:1]
    assert result.dataset_name == hills


def test_a_film_that_fails_leaves_what_was_there(adapted, tmp_path, monkeypatch):
    folder = write_folder(Publication(adapted, "me/one"), tmp_path / "out")

    def broken(*_):
        raise RenderingError("no OpenGL")

    monkeypatch.setattr("sb3_adaptnet.publishing.folder.write_picture", broken)
    with pytest.raises(RenderingError):
        write_folder(Publication(adapted, "me/two"), folder, (None, None))
    assert "hf://me/one" in (folder / "README.md").read_text() and not list(tmp_path.glob(".out*"))
