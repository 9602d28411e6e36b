"""Each rollout is kept once, or twice with one half of the worlds in the mirror each time."""

import numpy as np
import pytest
from rollout_cases import quiet

from sb3_adaptnet import SVG
from sb3_adaptnet.algorithms.rollouts.recent_rollouts import RecentRollouts
from sb3_adaptnet.algorithms.rollouts.reflection import Reflection


@pytest.fixture
def svg(make_svg):
    model = make_svg(6, "AdaptNet/Humanoid-GooseStep-v0", mirror=True)
    model.learn(48)
    return model


@pytest.fixture
def rollouts(svg):
    found = []
    for _ in range(3):
        svg.collect_rollout(quiet())
        found.append(svg._rollouts.latest(1)[0])
    return found


def test_without_a_reflection_the_latest_are_kept_as_they_are(rollouts):
    recent = RecentRollouts(2, None, np.random.default_rng(0))
    for rollout in rollouts:
        recent.add(rollout, 0.0)
    assert recent.latest(5) == rollouts[1:]
    chosen = list(recent.chosen(40, 2))
    assert recent.latest(1) == rollouts[2:]
    assert set(chosen[::2]) == {rollouts[2]}
    assert set(chosen[1::2]) == set(rollouts[1:])


def test_a_batch_is_of_worlds_that_are_drawn_anew(rollouts):
    recent = RecentRollouts(1, None, np.random.default_rng(0))
    recent.add(rollouts[0], 0.0)
    whole = [tuple(positions.ravel()) for positions in rollouts[0].transitions.qpos.swapaxes(0, 1)]
    drawn = []
    for part in recent.chosen(30, 1, 4):
        worlds = [whole.index(tuple(one.ravel())) for one in part.transitions.qpos.swapaxes(0, 1)]
        drawn.append(tuple(sorted(worlds)))
        for name in ("noise", "frames", "targets", "speeds", "phases", "headings", "turn_rates", "style", "failed"):
            assert np.array_equal(getattr(part, name), getattr(rollouts[0], name)[:, worlds])
        assert np.array_equal(part.strengths, rollouts[0].strengths[worlds])
        assert np.array_equal(part.mirrored, rollouts[0].mirrored[worlds])
        assert np.array_equal(part.transitions.ended, rollouts[0].transitions.ended[:, worlds])
    assert all(len(set(worlds)) == 4 for worlds in drawn)
    assert len(set(drawn)) > 5


def test_both_halves_see_the_mirror(svg, rollouts):
    reflection = Reflection.of(svg.world_model.character, svg.motion)
    recent = RecentRollouts(2, reflection, np.random.default_rng(0))
    for rollout in rollouts:
        recent.add(rollout, 0.0)
    assert len(recent.latest(5)) == 4
    one, other = recent.latest(1)
    same = [(form.headings == rollouts[-1].headings).all(axis=0) for form in (one, other)]
    assert same[0].sum() == 3
    assert np.array_equal(same[0], ~same[1])
    chosen = list(recent.chosen(4, 2))
    assert chosen[0] is other
    assert chosen[2] is one


def test_svg_learns_from_the_mirror_only_where_the_motion_is_symmetric(svg, make_svg):
    assert len(svg._rollouts.latest(1)) == 2
    plain = make_svg(6, "AdaptNet/Humanoid-Limp-v0", mirror=True).learn(48)
    assert len(plain._rollouts.latest(1)) == 1


def test_a_mirror_is_there_or_not(make_svg):
    with pytest.raises(ValueError, match="mirror is 'no', expected True or False"):
        make_svg(mirror="no")


def test_a_saved_model_still_knows_that_it_shall_look_into_the_mirror(svg, tmp_path):
    svg.save(tmp_path / "model")
    loaded = type(svg).load(tmp_path / "model", env=svg.env, device="cpu")
    loaded.learn(48, reset_num_timesteps=False)
    assert len(loaded._rollouts.latest(1)) == 2


def test_svg_learns_from_a_batch_of_the_worlds(make_svg, monkeypatch):
    sizes, improve = [], SVG._improve

    def seen(self, model, rollout, *rest):
        sizes.append(rollout.transitions.num_worlds)
        return improve(self, model, rollout, *rest)

    monkeypatch.setattr(SVG, "_improve", seen)
    make_svg(6, "AdaptNet/Humanoid-GooseStep-v0", batch_size=np.int64(3)).learn(48)
    assert sizes == [3, 3]


def test_a_model_that_is_loaded_for_fewer_worlds_says_that_its_batch_is_too_large(make_svg, tmp_path):
    make_svg(6, batch_size=5).save(tmp_path / "model")
    loaded = SVG.load(tmp_path / "model", env=make_svg(4).env, device="cpu", force_reset=True)
    with pytest.raises(ValueError, match="batch_size is 5, expected 1 to 4"):
        loaded.learn(32)


@pytest.mark.parametrize("size", [0, 7, "3", 2.0, True])
def test_a_batch_is_some_of_the_worlds(make_svg, size):
    with pytest.raises(ValueError, match=f"batch_size is {size!r}, expected 1 to 6, the number of worlds, or None"):
        make_svg(6, batch_size=size)
