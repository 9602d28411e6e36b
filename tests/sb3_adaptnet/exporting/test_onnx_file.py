"""Exported graphs act as the networks do, on real observations of every shipped base and for every kind of part."""

import json
from dataclasses import replace

import numpy as np
import pytest
import torch
from network_cases import SHAPES, SMALL, disturb, make_base

import adapt_envs
from adapt_envs.model import joint_names
from sb3_adaptnet import load_policy
from sb3_adaptnet.exporting import Exported, graph_of, save_onnx, split_weights
from sb3_adaptnet.exporting.graph import Graph
from sb3_adaptnet.modules import Architecture, Backbone
from sb3_adaptnet.modules.adaptation import Adaptation, AdaptedActor
from sb3_adaptnet.modules.observation import read_observation
from sb3_adaptnet.weights import CheckpointError, pretrained_names
from sb3_adaptnet.weights.checkpoint import Base
from sb3_adaptnet.weights.shipped import pretrained_path

pytest.importorskip("onnx", reason="the extra [onnx] is not installed")
onnxruntime = pytest.importorskip("onnxruntime", reason="the extra [onnx] is not installed")

STYLES = {base: [name for name in pretrained_names() if name.startswith(f"{base}-")] for base in ("walk", "run")}
TOLERANCE = 1e-5


@pytest.fixture(scope="session")
def seen():
    """Base -> 300 observations of its own rollouts, 15 worlds for 20 steps; the walk's see hills."""

    def rollouts(base, environment):
        env = adapt_envs.make_vector(environment, num_envs=15, num_threads=1)
        policy, found = load_policy(base, env), []
        observations, _ = env.reset(seed=1)
        for _ in range(20):
            actions, _ = policy.predict(observations, deterministic=True)
            observations = env.step(actions)[0]
            found.append(observations if isinstance(observations, dict) else {"observation": observations})
        return {key: np.concatenate([part[key] for part in found]) for key in found[0]}

    return {
        "walk": rollouts("walk", "AdaptNet/Humanoid-TerrainHills-v0"),
        "run": rollouts("run", "AdaptNet/Humanoid-Run-v0"),
    }


def wanted(exported, observations, strengths):
    """Actions of the torch networks at one strength per adaptation."""
    actor = AdaptedActor(exported.base.backbone, exported.adaptations)
    actor.blend(dict(zip(exported.adaptations, map(float, strengths), strict=True)))
    parts = {key: torch.from_numpy(values) for key, values in observations.items()}
    with torch.no_grad():
        return actor(read_observation(parts, exported.base.backbone.architecture))[0].clamp(-1, 1).numpy()


def session_of(content):
    return onnxruntime.InferenceSession(content, providers=["CPUExecutionProvider"])


def acted(session, observations, strengths):
    given = observations | {"strengths": np.atleast_2d(np.asarray(strengths, np.float32))}
    return session.run(None, {part.name: given[part.name] for part in session.get_inputs()})[0]


@pytest.fixture(scope="module", params=["walk", "run"])
def shipped(request):
    """A base with all its shipped adaptations, its default strengths and its graph running."""
    exported = Exported.read(request.param, STYLES[request.param])
    session = session_of(graph_of(exported, dict.fromkeys(exported.adaptations, 0.5)).SerializeToString())
    return request.param, exported, session


def wanted_rows(exported, observations, strengths):
    """Actions of the torch networks, each row at its own strengths."""
    actions = np.empty((len(strengths), 28), np.float32)
    for mixture in np.unique(strengths, axis=0):
        rows = (strengths == mixture).all(axis=1)
        actions[rows] = wanted(exported, {key: values[rows] for key, values in observations.items()}, mixture)
    return actions


@pytest.mark.parametrize("strength", [0.0, 0.5, 1.0])
def test_adaptations_act_as_in_torch(shipped, seen, strength):
    base, exported, session = shipped
    taken_in_turn = strength * np.eye(len(exported.adaptations))[np.arange(300) % len(exported.adaptations)]
    found = acted(session, seen[base], taken_in_turn)
    np.testing.assert_allclose(found, wanted_rows(exported, seen[base], taken_in_turn), rtol=0, atol=TOLERANCE)


def test_mixtures_act_as_in_torch(shipped, seen):
    base, exported, session = shipped
    some = {key: values[::10] for key, values in seen[base].items()}
    for mixture in np.random.default_rng(0).uniform(-0.3, 0.6, (2, len(exported.adaptations))):
        found = acted(session, some, mixture)
        np.testing.assert_allclose(found, wanted(exported, some, mixture), rtol=0, atol=TOLERANCE)


def test_a_base_alone_needs_no_strengths(seen):
    exported = Exported.read("walk", [])
    session = session_of(graph_of(exported, {}).SerializeToString())
    assert [part.name for part in session.get_inputs()] == ["observation"]
    np.testing.assert_allclose(
        acted(session, seen["walk"], []), wanted(exported, seen["walk"], []), rtol=0, atol=TOLERANCE
    )


def tiny(shape=None, architecture=SMALL):
    """A small base, with an adaptation of a shape, on joints that the character has."""
    architecture = replace(architecture, joints=joint_names()[:6])
    torch.manual_seed(0)
    base = Backbone(architecture)
    base.load_state_dict(make_base().state_dict(), strict=False)
    disturb(base)
    parts = {} if shape is None else {"part": Adaptation(architecture, shape)}
    for part in parts.values():
        part.start_from(base)
        disturb(part)
    return Exported(Base(base, "tiny", "0" * 64, {}), parts)


def random_observations(count, architecture: Architecture = SMALL):
    rng = np.random.default_rng(0)
    flat = rng.normal(size=(count, architecture.observation_size)).astype(np.float32)
    return {"observation": flat, "heightmap": rng.normal(size=(count, 1, 35, 35)).astype(np.float32)}


@pytest.mark.parametrize("name", SHAPES)
def test_every_kind_of_adaptation_can_be_exported(name):
    exported, observations = tiny(SHAPES[name]), random_observations(7)
    session = session_of(graph_of(exported, {"part": 1.0}).SerializeToString())
    assert ("heightmap" in [part.name for part in session.get_inputs()]) == (name == "heightmap")
    found = acted(session, observations, [0.7])
    np.testing.assert_allclose(found, wanted(exported, observations, [0.7]), rtol=0, atol=TOLERANCE)
    assert np.abs(found - acted(session, observations, [0.0])).max() > 1e-3


def test_a_base_that_reads_a_heightmap_can_be_exported():
    architecture = replace(SMALL, heightmap=True)
    exported, observations = tiny(architecture=architecture), random_observations(5)
    found = acted(session_of(graph_of(exported, {}).SerializeToString()), observations, [])
    np.testing.assert_allclose(found, wanted(exported, observations, []), rtol=0, atol=TOLERANCE)


def test_the_file_says_what_it_needs(shipped):
    base, exported, session = shipped
    about = {key: json.loads(text) for key, text in session.get_modelmeta().custom_metadata_map.items()}
    assert about["base"] == base and about["base_hash"] == exported.base.hash
    assert about["adaptations"] == STYLES[base] and set(about["default_strengths"]) == {0.5}
    assert about["joints"] == list(joint_names()) and about["control_hz"] == 30 and about["physics_hz"] == 120
    knee = next(row for row in about["servos"] if row["joint"] == "right_knee")
    degrees = {"middle": 80, "range": 160}
    assert (knee["kp"], knee["kd"]) == (300.0, 30.0)
    assert {key: round(np.rad2deg(knee[key]), 6) for key in degrees} == degrees


def test_half_precision_halves_the_file_and_changes_actions_little(seen, tmp_path):
    exported = Exported.read("walk", ["walk-stoop"])
    whole, half = (save_onnx(exported, tmp_path / f"{h}.onnx", {"walk-stoop": 1.0}, half=h) for h in (False, True))
    assert half.stat().st_size < 0.51 * whole.stat().st_size
    actions = [acted(session_of(str(file)), seen["walk"], [1.0]) for file in (whole, half)]
    assert 0 < np.abs(actions[0] - actions[1]).max() < 5e-3


def test_weights_can_lie_beside_the_graph(seen, tmp_path):
    exported = Exported.read("walk", ["walk-stoop"])
    whole = session_of(graph_of(exported, {"walk-stoop": 1.0}).SerializeToString())
    graph, parts = split_weights(graph_of(exported, {"walk-stoop": 1.0}))
    assert list(parts) == ["walk", "walk-stoop"] and len(graph) < 50_000
    (tmp_path / "graph.onnx").write_bytes(graph)
    for part, content in parts.items():
        (tmp_path / f"{part}.bin").write_bytes(content)
    beside = session_of(str(tmp_path / "graph.onnx"))
    few = {key: values[:9] for key, values in seen["walk"].items()}
    np.testing.assert_array_equal(acted(whole, few, [0.3]), acted(beside, few, [0.3]))


def test_only_adaptations_of_the_base_fit(tmp_path):
    with pytest.raises(CheckpointError, match="adapts base 'run'"):
        Exported.read("walk", ["run-longshins"])
    with pytest.raises(ValueError, match="must be a finite number, not nan"):
        save_onnx(Exported.read("walk", ["walk-stoop"]), tmp_path / "x.onnx", {"walk-stoop": float("nan")})
    assert not list(tmp_path.iterdir())


def test_no_two_parts_have_one_name(tmp_path):
    for name in ("walk", "walk-stoop"):
        copy = tmp_path / f"{name}.safetensors"
        copy.write_bytes(pretrained_path("walk-stoop").read_bytes())
    with pytest.raises(ValueError, match="the base is named 'walk', too; rename the file"):
        Exported.read("walk", [tmp_path / "walk.safetensors"])
    with pytest.raises(ValueError, match="another adaptation is named 'walk-stoop', too; rename the file"):
        Exported.read("walk", ["walk-stoop", tmp_path / "walk-stoop.safetensors"])
    graph = Graph(part="walk")
    graph.weight("bias", np.zeros(3))
    graph.weight("bias", np.zeros(3))
    with pytest.raises(ValueError, match="two different weights are named 'walk/bias'"):
        graph.weight("bias", np.ones(3))
