"""Which joint of a foreign skeleton is which."""

from pathlib import Path

import pytest
from made_up_motions import CMU, LAFAN, bvh_text, write

from adapt_envs.motion.importing.bvh import read_bvh
from adapt_envs.motion.importing.skeletons import FAMILIES, SIDES, recognise


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_every_family_recognises_its_own_names(family):
    names = [family.hips[0], family.neck[0], family.head[0]]
    for role in ("hip", "knee", "ankle", "toe", "shoulder", "elbow", "wrist"):
        names += [getattr(family, role)[0].format(side) for side in family.sides]
    found = recognise(Path("x.bvh"), tuple(names)).joints
    for side, word in zip(SIDES, family.sides, strict=True):
        assert found[f"{side}_knee"] == family.knee[0].format(word)
        assert found[f"{side}_shoulder"] == family.shoulder[0].format(word)


@pytest.mark.parametrize(
    ("shoulder", "upper"), [("LeftArm", LAFAN["arm"].format("Left")), ("LeftShoulder", CMU["arm"].format("Left"))]
)
def test_a_shoulder_is_an_arm_only_where_no_other_joint_is(shoulder, upper, tmp_path):
    """`LeftShoulder` is the upper arm in CMU files, a collar bone in LAFAN1's."""
    names = LAFAN if shoulder == "LeftArm" else CMU
    path = write(tmp_path, "x.bvh", bvh_text(names=names, frames=6))
    present = (*read_bvh(path).names, *(["LeftShoulder", "RightShoulder"] if names is LAFAN else []))
    assert recognise(path, present).joints["left_shoulder"] == upper


def test_a_shoulder_beside_an_upper_arm_is_a_collar_bone():
    """As in skeletons with Unity's names."""
    sides = ("Shoulder", "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "Toe")
    names = ("Hips", "Spine", "Neck", "Head", *(side + part for side in ("Left", "Right") for part in sides))
    found = recognise(Path("x.bvh"), names).joints
    assert (found["left_shoulder"], found["right_shoulder"]) == ("LeftUpperArm", "RightUpperArm")
    assert (found["left_elbow"], found["left_hip"]) == ("LeftLowerArm", "LeftUpperLeg")
