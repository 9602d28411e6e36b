"""Body shapes: lengths, masses, heights and symmetry."""

import mujoco
import numpy as np
import pytest

from adapt_envs import SUITE
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import build_character, compile_model
from adapt_envs.model.humanoid import LINKS
from adapt_envs.model.morphology import MORPHOLOGIES, SEGMENTS, Morphology
from adapt_envs.motion.library import reference_motion

PLAIN = compile_model()
SHAPED = {name: compile_model(build_character(shape)) for name, shape in MORPHOLOGIES.items()}


def mass(model, link):
    return float(model.body(link).mass[0])


def capsule_volume(length, radius):
    return np.pi * radius**2 * length + 4 / 3 * np.pi * radius**3


def lowest_point(model):
    """Height of the lowest corner of the feet in the rest pose."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return min(data.geom(foot).xpos[2] - model.geom(foot).size[2] for foot in ("right_foot", "left_foot"))


@pytest.mark.parametrize("name", MORPHOLOGIES)
def test_distances_between_joints_grow_as_asked_and_nothing_else_moves(name):
    shape, model = MORPHOLOGIES[name], SHAPED[name]
    expected = {link: PLAIN.body(link).pos.copy() for link in LINKS[1:]}
    for segment, factor in shape.size.items():
        for carried in SEGMENTS[segment].carries:
            expected[carried] *= factor
    for segment, factor in shape.length.items():
        for carried in SEGMENTS[segment].carries:
            expected[carried][2] *= factor
    for link, offset in expected.items():
        assert np.allclose(model.body(link).pos, offset, atol=1e-12), link


@pytest.mark.parametrize("name", MORPHOLOGIES)
def test_only_the_changed_links_have_another_mass(name):
    shape, model = MORPHOLOGIES[name], SHAPED[name]
    changed = {SEGMENTS[segment].link for segment in {**shape.length, **shape.size}}
    for link in LINKS:
        same = np.isclose(mass(model, link), mass(PLAIN, link), rtol=1e-9)
        assert same == (link not in changed), link


def test_masses_follow_from_the_volumes():
    shin = capsule_volume(0.31 + 0.5 * 0.40987, 0.05) / capsule_volume(0.31, 0.05)
    assert mass(SHAPED["long_shins"], "left_shin") == pytest.approx(shin * mass(PLAIN, "left_shin"))
    arm = [capsule_volume(0.18 + change * 0.274788, 0.045) for change in (0, 0.25, -0.25)]
    model = SHAPED["asymmetric_upper_arms"]
    assert mass(model, "right_upper_arm") == pytest.approx(arm[1] / arm[0] * mass(PLAIN, "right_upper_arm"))
    assert mass(model, "left_upper_arm") == pytest.approx(arm[2] / arm[0] * mass(PLAIN, "left_upper_arm"))
    waist = 2226 * capsule_volume(0.5 * 0.236151, 0.07) - 2226 * 4 / 3 * np.pi * 0.07**3
    assert mass(SHAPED["long_body"], "pelvis") == pytest.approx(mass(PLAIN, "pelvis") + waist)


def test_a_larger_torso_has_its_mass_cubed_and_its_inertia_to_the_fifth():
    model = SHAPED["big_body"]
    assert mass(model, "torso") == pytest.approx(1.5**3 * mass(PLAIN, "torso"))
    assert np.allclose(model.body("torso").inertia, 1.5**5 * PLAIN.body("torso").inertia)
    assert np.allclose(model.body("torso").ipos, 1.5 * PLAIN.body("torso").ipos)


@pytest.mark.parametrize("name", MORPHOLOGIES)
def test_the_rest_pose_stands_on_the_ground(name):
    assert lowest_point(SHAPED[name]) == pytest.approx(0, abs=1e-12)
    grown = SHAPED[name].body("pelvis").pos[2] - PLAIN.body("pelvis").pos[2]
    legs = {"long_thighs": 0.5 * 0.421546, "long_shins": 0.5 * 0.40987, "super_long_legs": 0.5 * (0.421546 + 0.40987)}
    assert grown == pytest.approx(legs.get(name, 0), abs=1e-6)


def test_super_long_legs_are_over_two_metres_tall():
    def height(model):
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        return data.geom("head").xpos[2] + model.geom("head").size[0]

    assert height(PLAIN) < 1.7
    assert height(SHAPED["super_long_legs"]) > 2.0


@pytest.mark.parametrize("name", [name for name in MORPHOLOGIES if "asymmetric" not in name])
def test_left_mirrors_right(name):
    model = SHAPED[name]
    for link in [link for link in LINKS if link.startswith("right_")]:
        other = link.replace("right_", "left_")
        assert mass(model, link) == pytest.approx(mass(model, other))
        assert np.allclose(model.body(link).pos * (1, -1, 1), model.body(other).pos)
        assert np.allclose(model.body(link).inertia, model.body(other).inertia)


@pytest.mark.parametrize("name", MORPHOLOGIES)
def test_start_states_put_the_feet_where_the_clip_has_them(name):
    """Poses are the clip's, only the root's height follows the legs: soles end as high as the plain character's."""
    plain, shaped = (reference_motion("Stoop", shape) for shape in (None, MORPHOLOGIES[name]))
    chosen = np.arange(shaped.num_states)
    ours, theirs = shaped.states(chosen)[0], plain.states(chosen)[0]
    assert np.array_equal(np.delete(ours, 2, axis=1), np.delete(theirs, 2, axis=1))
    assert np.allclose(lowest_soles(SHAPED[name], ours), lowest_soles(PLAIN, theirs), atol=1e-6)


def lowest_soles(model, qpos):
    data, lowest = mujoco.MjData(model), []
    corners = np.stack(np.meshgrid(*[[-1, 1]] * 3), -1).reshape(-1, 3)
    for row in qpos:
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        feet = [data.geom(foot) for foot in ("right_foot", "left_foot")]
        points = [foot.xpos + (corners * model.geom(foot.id).size) @ foot.xmat.reshape(3, 3).T for foot in feet]
        lowest.append(np.concatenate(points)[:, 2].min())
    return np.array(lowest)


def test_the_reference_windows_are_the_unmodified_characters():
    plain, shaped = (reference_motion("Stoop", shape) for shape in (None, MORPHOLOGIES["long_shins"]))
    rngs = [np.random.default_rng(0) for _ in range(2)]
    assert np.array_equal(plain.sample_windows(64, rngs[0]), shaped.sample_windows(64, rngs[1]))


def test_other_factors_shrink_a_ball_and_enlarge_hands_and_feet():
    model = compile_model(build_character(Morphology({"abdomen": 0.5, "torso": 1.2}, {"right_foot": 1.5, "head": 0.8})))
    assert lowest_point(model) == pytest.approx(0, abs=1e-12)
    assert mass(model, "head") == pytest.approx(0.8**3 * mass(PLAIN, "head"))
    assert mass(model, "right_foot") == pytest.approx(1.5**3 * mass(PLAIN, "left_foot"))
    assert model.geom("waist").type == mujoco.mjtGeom.mjGEOM_SPHERE
    links = Kinematics(model).link_states(model.qpos0[None])
    assert np.isfinite(links).all()


def test_wrong_names_and_factors_are_named():
    with pytest.raises(ValueError, match=r"'thigh'.*right_thigh"):
        Morphology(length={"thigh": 1.5})
    with pytest.raises(ValueError, match=r"'head'.*abdomen"):
        Morphology(length={"head": 1.5})
    with pytest.raises(ValueError, match="-1"):
        Morphology(size={"head": -1})


def test_every_shape_runs_and_walks():
    for name in MORPHOLOGIES:
        rows = [row for row, spec in SUITE.items() if spec.morphology == name]
        assert [SUITE[row].base for row in rows] == ["run", "walk"]
        assert rows[1] == rows[0] + "Walk"
