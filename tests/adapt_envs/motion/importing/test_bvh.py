"""The BVH reader: the order of turns, and the same places as another reader's."""

import numpy as np
import pytest
from made_up_motions import bvh_text, write

from adapt_envs.motion.clip import MotionError
from adapt_envs.motion.importing.bvh import read_bvh


def test_bvh_channels_turn_in_the_order_they_stand(tmp_path):
    """R = Rz Rx Ry for channels Z X Y: a quarter turn about z, then one about the turned x."""
    text = """HIERARCHY
ROOT a {
  OFFSET 0 0 0
  CHANNELS 6 Zrotation Xrotation Yrotation Xposition Yposition Zposition
  JOINT b c {
    OFFSET 1 0 0
    CHANNELS 1 Xrotation
    End Site {
      OFFSET 0 2 0
    }
  }
}
MOTION
Frames: 2
Frame Time: .04
0 0 0 1 2 3 0
90 90 0 0 0 0 90
"""
    bvh = read_bvh(write(tmp_path, "x.bvh", text))
    assert bvh.names == ("a", "b c", "b c end")
    pos, quat = bvh.world()
    np.testing.assert_allclose(pos[0], [[1, 2, 3], [2, 2, 3], [2, 4, 3]], atol=1e-12)
    np.testing.assert_allclose(pos[1, 1], [0, 1, 0], atol=1e-12)
    # Rz(90) Rx(180) takes y to x.
    np.testing.assert_allclose(pos[1, 2], [2, 1, 0], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(quat, axis=-1), 1, atol=1e-12)


def test_words_stand_on_any_line(tmp_path):
    """BVH is a stream of words: lines matter in the frames alone."""
    text = """HIERARCHY ROOT a b { OFFSET 0 0 0 CHANNELS 3 Zrotation Xrotation Yrotation JOINT c
{ OFFSET 1 0 0 CHANNELS 1 Xrotation End Site { OFFSET 0 2 0 } } JOINT d { OFFSET 2 0 0 CHANNELS 0 } }
MOTION Frames: 1 Frame Time: .04
0 0 0 0
"""
    assert read_bvh(write(tmp_path, "x.bvh", text)).names == ("a b", "c", "c end", "d")
    with pytest.raises(MotionError, match="line 1: a joint without a name"):
        read_bvh(write(tmp_path, "y.bvh", text.replace("ROOT a b {", "ROOT {")))


def test_bvh_agrees_with_pybvh(tmp_path):
    """Another reader finds the joints in the same places."""
    pybvh = pytest.importorskip("pybvh")
    path = write(tmp_path, "x.bvh", bvh_text(order="YXZ"))
    other = pybvh.read_bvh_file(path, world_up="+y")
    mine = read_bvh(path)
    theirs = other.node_positions()
    index = [other.node_index[name] for name in mine.names if not name.endswith(" end")]
    own = [i for i, name in enumerate(mine.names) if not name.endswith(" end")]
    np.testing.assert_allclose(mine.world()[0][:, own], theirs[:, index], atol=1e-6)
