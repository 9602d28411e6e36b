"""Bad motion files: one clear sentence with file, line and problem, nothing written, whatever the badness."""

import argparse
import copy
import re
from pathlib import Path

import pytest
import yaml
from made_up_motions import STRANGE, bvh_text, json_object, strange_map, write

from adapt_envs.commands import motions

BVH = bvh_text(frames=12)
JSON = json_object(frames=12)
F = next(i for i, line in enumerate(BVH.splitlines(), 1) if line.startswith("Frame Time")) + 1


def _starting(number: int, words: str) -> str:
    """The file with `words` in place of the first number of a line."""
    lines = BVH.splitlines()
    lines[number - 1] = words + lines[number - 1].split(maxsplit=1)[1]
    return "\n".join(lines)


def _frame(number: int, link: str, value: object) -> dict:
    content = copy.deepcopy(JSON)
    content["frames"][number][link] = value
    return content


def _hole(folder: Path, name: str, size: int) -> Path:
    path = folder / name
    with path.open("wb") as file:
        file.truncate(size)
    return path


def _map(**changes: object) -> str:
    return yaml.safe_dump({"joints": strange_map(), **changes})


BVH_CASES = {
    "empty": ("", "the file is empty"),
    "blank": ("\n \n", "the file is empty"),
    "only a word": ("HIERARCHY", "line 1: the file ends"),
    "prose": ("Dear reader,\nthis is no motion.", "line 1: found 'Dear'"),
    "cut in the hierarchy": ("\n".join(BVH.splitlines()[:9]), "line 9: .*"),
    "cut before the frames": (BVH[: BVH.index("Frame Time")], "the file ends where FRAME should follow"),
    "cut after the frame time": ("\n".join(BVH.splitlines()[: F - 1]), "ends before the first of 12 frames"),
    "cut between frames": ("\n".join(BVH.splitlines()[:-4]), f"line {F + 7}: the file ends after 8 of 12"),
    "cut within a frame": (BVH[:-90], "line .*: .* numbers, the hierarchy has .* channels"),
    "more frames than declared": (BVH + BVH.splitlines()[-1], "more lines than the 12 frames"),
    "nan": (_starting(F + 3, "nan "), f"line {F + 3}: channel 1 is nan"),
    "infinite": (_starting(F, "inf "), f"line {F}: channel 1 is inf"),
    "absurd number": (_starting(F, "1e30 "), "channel 1 is 1e30"),
    "a word among the numbers": (_starting(F + 1, "oops "), f"line {F + 1}: 'oops' is not a number"),
    "a number short": (_starting(F + 1, ""), f"line {F + 1}: .* numbers, the hierarchy has"),
    "nan offset": (BVH.replace("OFFSET 0.000000", "OFFSET nan", 1), "line 4: an offset of 'Hips' is nan"),
    "zero frame time": (BVH.replace("Time: 0.0333333", "Time: 0"), f"line {F - 1}: a frame time of 0 s is"),
    "negative frame time": (BVH.replace("Time: 0.0333333", "Time: -0.03"), "a frame time of -0.03 s is absurd"),
    "long frame time": (BVH.replace("Time: 0.0333333", "Time: 33.3"), "a frame time of 33.3 s is absurd"),
    "nan frame time": (BVH.replace("Time: 0.0333333", "Time: nan"), "the frame time is nan"),
    "no frames": (BVH[: BVH.index("Frames:")] + "Frames: 0\nFrame Time: 0.03\n", "0 frames"),
    "a billion frames": (BVH.replace("Frames: 12", "Frames: 1000000"), "the file ends after 12 of 1000000"),
    "two frames": (bvh_text(frames=2), "2 frames at 30 Hz are too few"),
    "unknown joints": (bvh_text(names=STRANGE, frames=12), "line 1: unknown skeleton"),
    "unknown channel": (BVH.replace("Zrotation", "Wrotation", 1), "line 5: joint 'Hips' has a channel 'wrotation'"),
    "too many channels": (BVH.replace("CHANNELS 6", "CHANNELS 60", 1), "line 5: joint 'Hips' declares 60 channels"),
    "a channel twice": (BVH.replace("Xrotation", "Zrotation", 1), "line 5: joint 'Hips' names a channel twice"),
    "two roots": (BVH.replace("MOTION", "ROOT Other {\nOFFSET 0 0 0\nCHANNELS 0\n}\nMOTION"), "a second ROOT"),
    "a joint twice": (BVH.replace("JOINT RightKnee", "JOINT LeftKnee"), "joint 'LeftKnee' stands already in line"),
    "no legs": (BVH.replace("OFFSET 0.000000 -40.000000 0.000000", "OFFSET 0 0 0"), "the bone from .* is 0 units long"),
    "no width": (re.sub("OFFSET -?9.000000", "OFFSET 0", BVH), "joints of the trunk or limbs coincide"),
}  # fmt: skip
JSON_CASES = {
    "json: cut": ('{"fps": 30, "frames": [\n{"pelvis": [[0', "line 2: not whole JSON"),
    "json: a list": ("[1, 2]", "line 1: not a motion of the authors' format"),
    "json: deep": ("[" * 200_000, "line 1: not sane JSON"),
    "json: huge": ('{"fps": 30, "frames": [' + "9" * 10_000 + "]}", "line 1: not sane JSON"),
    "json: no frames": ({**JSON, "frames": []}, "'frames' holds no frames"),
    "json: frames are a word": ('{"fps": 30, "frames": "none"}', "'frames' holds no frames"),
    "json: no fps": ({"frames": JSON["frames"]}, "with 'fps' and 'frames'"),
    "json: zero fps": ({**JSON, "fps": 0}, "'fps' is 0; a number from 5 to 1000"),
    "json: fps a word": ({**JSON, "fps": "thirty"}, "'fps' is 'thirty'"),
    "json: nan": (_frame(3, "pelvis", [[0, float("nan"), 1], [0, 0, 0, 1]]), "line 5: frame 3: 'pelvis' holds"),
    "json: infinite": (_frame(2, "torso", [0, 0, float("inf"), 1]), "line 4: frame 2: 'torso' holds"),
    "json: three numbers": (_frame(4, "head", [0, 0, 1]), "line 6: frame 4: 'head' holds .* where 4 numbers"),
    "json: no quaternion": (_frame(4, "head", [0, 0, 0, 0]), "frame 4: the quaternion of 'head' has length 0"),
    "json: a word": (_frame(4, "head", "up"), "frame 4: 'head' holds 'up'"),
    "json: unknown link": (_frame(1, "tail", [0, 0, 0, 1]), "line 3: frame 1: unknown link 'tail'; the links"),
    "json: a link goes missing": ({**JSON, "frames": [*JSON["frames"][:5], {"pelvis": JSON["frames"][0]["pelvis"]}]},
                                  "line 7: frame 5: link 'head' is missing"),
    "json: pelvis without rotation": (_frame(0, "pelvis", [0, 0, 0]), "frame 0: 'pelvis' is not"),
    "json: a frame is a number": ({**JSON, "frames": [JSON["frames"][0], 3]}, "frame 1: not an object"),
}  # fmt: skip
MAP_CASES = {
    "not yaml": ("joints: [", "line 1: not YAML|line 2: not YAML"),
    "a list": ("- a\n- b\n", "line 1: a map needs 'joints:'"),
    "empty": ("", "the file is empty"),
    "unknown key": (_map(scale=3), "line 19: unknown key 'scale'; the keys are joints, up, drop"),
    "unknown role": (_map(joints={**strange_map(), "tail": "bone_0_"}), "unknown role 'tail'; the roles are hips"),
    "unknown joint": (_map(joints={**strange_map(), "neck": "nacken"}), "has no joint 'nacken'; its joints are"),
    "too few": ("joints:\n  hips: bone_0_\n", "line 1: no joint for right_hip, right_knee"),
    "up of nothing": (_map(up="w"), "up is 'w'; the axes are x, y, z"),
    "drop of half a frame": (_map(drop=0.5), "drop is 0.5; a number of frames"),
    "drop of all": (_map(drop=12), "drop is 12, but motion.bvh has 12 frames"),
    "code": ("joints: !!python/object/apply:os.system ['true']\n", "line 1: not YAML"),
}  # fmt: skip


def _refused(*arguments: str) -> str:
    """The sentence with which the command line's parser and the subcommand refuse."""
    parser = argparse.ArgumentParser()
    motions.add_parser(parser.add_subparsers())
    options = parser.parse_args(["motions", *arguments])
    with pytest.raises(ValueError) as refusal:
        options.run(options)
    return str(refusal.value)


def _imported(tmp_path: Path, path: Path, *options: str) -> str:
    output = tmp_path / "out" / "clip.npz"
    output.parent.mkdir()
    sentence = _refused("import", str(path), "-o", str(output), *options)
    assert "\n" not in sentence and "Traceback" not in sentence
    assert list(output.parent.iterdir()) == []
    return sentence


@pytest.mark.parametrize("case", [*BVH_CASES, *JSON_CASES])
def test_bad_files(case, tmp_path):
    content, words = {**BVH_CASES, **JSON_CASES}[case]
    path = write(tmp_path, "motion.json" if case.startswith("json") else "motion.bvh", content)
    sentence = _imported(tmp_path, path)
    assert sentence.startswith(f"{path}: ")
    assert re.search(words, sentence), sentence


@pytest.mark.parametrize("role", ["neck", "head"])
def test_a_trunk_without_length(role, tmp_path):
    joints = {key: name for key, name in strange_map().items() if key not in ("neck", "head")}
    joint_map = write(tmp_path, "map.yml", _map(joints={**joints, role: joints["hips"]}))
    motion = write(tmp_path, "motion.bvh", bvh_text(names=STRANGE, frames=12))
    assert f"{role} and hips are the same joint; is the joint map right?" in _imported(
        tmp_path, motion, "--map", str(joint_map)
    )


@pytest.mark.parametrize("case", MAP_CASES)
def test_bad_maps(case, tmp_path):
    content, words = MAP_CASES[case]
    joint_map = write(tmp_path, "map.yml", content)
    motion = write(tmp_path, "motion.bvh", bvh_text(names=STRANGE, frames=12))
    sentence = _imported(tmp_path, motion, "--map", str(joint_map))
    assert sentence.startswith(f"{joint_map}: ")
    assert re.search(words, sentence), sentence


@pytest.mark.parametrize("name", ["motion.bvh", "motion.json"])
@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"\x7fELF\x02\x01\x01" + bytes(range(256)) * 50, "line 1: a zero byte; this is a binary file"),
        (b"HIERARCHY\n" + b"\xff\xfe\xfa" * 100, "line 2: byte 0xff is not text"),
        (bytes(1000), "line 1: a zero byte"),
    ],
)
def test_binaries(name, content, words, tmp_path):
    assert words in _imported(tmp_path, write(tmp_path, name, content))


@pytest.mark.parametrize("name", ["motion.bvh", "motion.json"])
def test_a_gigabyte_of_zeros_is_not_even_read(name, tmp_path):
    assert "too large, 1024 MiB" in _imported(tmp_path, _hole(tmp_path, name, 2**30))


def test_files_that_are_none(tmp_path):
    folder = tmp_path / "folder.bvh"
    folder.mkdir()
    assert "not a regular file" in _refused("import", str(folder), "-o", str(tmp_path / "a.npz"))
    assert "no such file" in _refused("import", str(tmp_path / "none.bvh"), "-o", str(tmp_path / "a.npz"))
    fbx = write(tmp_path, "walk.fbx", "Kaydara")
    assert "extension .fbx is not among .bvh, .json" in _refused("import", str(fbx), "-o", str(tmp_path / "a.npz"))
    assert not (tmp_path / "a.npz").exists()


def test_a_map_for_json_is_refused(tmp_path):
    joint_map = write(tmp_path, "map.yml", "joints: {}\n")
    assert "a map is for BVH files" in _imported(tmp_path, write(tmp_path, "m.json", JSON), "--map", str(joint_map))


def test_outputs_that_cannot_be(tmp_path):
    motion = str(write(tmp_path, "motion.bvh", BVH))
    assert "extension must be .npz, not .bvh" in _refused("import", motion, "-o", motion)
    assert "does not exist" in _refused("import", motion, "-o", str(tmp_path / "no" / "a.npz"))
    (tmp_path / "a.npz").mkdir()
    assert "is a folder" in _refused("import", motion, "-o", str(tmp_path / "a.npz"))
