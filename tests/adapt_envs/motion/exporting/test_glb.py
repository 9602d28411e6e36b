"""glTF files: what two libraries read from them is the character, moving as it did."""

import sys

import mujoco
import numpy as np
import pytest
from scipy.spatial import cKDTree

from adapt_envs.features import rotations
from adapt_envs.model.build import build_character, compile_model, plain_model
from adapt_envs.model.geom_mesh import geom_mesh
from adapt_envs.model.humanoid import LINKS
from adapt_envs.motion import load_clip
from adapt_envs.motion.exporting import perform, write_glb
from adapt_envs.motion.exporting.performance import BONES, y_up

WHY = "glTF needs optional packages: pip install 'adaptnet-gym[motion]'"
pygltflib = pytest.importorskip("pygltflib", reason=WHY)
trimesh = pytest.importorskip("trimesh", reason=WHY)
TYPES = {5121: np.uint8, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}
FRAME = 11


class Read:
    """A glTF file as pygltflib reads it, with its arrays."""

    def __init__(self, file):
        self.document = pygltflib.GLTF2.load(str(file))
        self.content = self.document.binary_blob()

    def array(self, number):
        accessor = self.document.accessors[number]
        view = self.document.bufferViews[accessor.bufferView]
        assert view.byteOffset % 4 == 0
        rows = np.frombuffer(self.content, TYPES[accessor.componentType], accessor.count * WIDTHS[accessor.type],
                             view.byteOffset).reshape(accessor.count, -1)  # fmt: skip
        assert rows.nbytes == view.byteLength
        assert rows.min(axis=0).tolist() == accessor.min and rows.max(axis=0).tolist() == accessor.max
        return rows

    def bones(self, frame):
        """Matrices (J, 4, 4) from bones to the world in a frame of the animation."""
        nodes, animation = self.document.nodes, self.document.animations[0]
        moved = {}
        for channel in animation.channels:
            values = self.array(animation.samplers[channel.sampler].output)
            moved[channel.target.node, channel.target.path] = values[frame].astype(float)
        made = {}

        def place(node, above):
            x, y, z, w = moved[node, "rotation"]
            local = np.eye(4)
            local[:3, :3] = rotations.rotate(np.array([w, x, y, z]), np.eye(3)).T
            local[:3, 3] = moved.get((node, "translation"), nodes[node].translation)
            made[node] = above @ local
            for child in nodes[node].children:
                place(child, made[node])

        place(self.document.skins[0].skeleton, np.eye(4))
        return np.array([made[joint] for joint in self.document.skins[0].joints])


@pytest.fixture(scope="module", params=[(), ("right_knee",)], ids=["plain", "stiff"])
def case(request, tmp_path_factory):
    """Model, configurations and the file written of them."""
    model = compile_model(build_character(None, request.param))
    clip = load_clip("GooseStep")
    columns = [*range(7), *(7 + clip.joint_names.index(model.actuator(i).name) for i in range(model.nu))]
    qpos = clip.qpos[:30][:, columns]
    file = tmp_path_factory.mktemp("glb") / "out.glb"
    write_glb(perform(model, qpos, 30.0), model, file, "goose step")
    data = mujoco.MjData(model)
    data.qpos[:] = qpos[FRAME]
    mujoco.mj_kinematics(model, data)
    return model, data, np.array([*qpos[0, :2], 0]), Read(file), file


def test_the_animation_puts_the_bones_where_they_were(case):
    _, data, start, read, _ = case
    bones = read.bones(FRAME)
    for bone, link in enumerate(LINKS):
        assert read.document.nodes[bone].name == BONES[link]
        assert bones[bone, :3, 3] == pytest.approx(y_up(data.body(link).xpos - start), abs=1e-5)
    animation = read.document.animations[0]
    times = read.array(animation.samplers[0].input)[:, 0]
    assert times == pytest.approx(np.arange(30) / 30, abs=1e-6) and animation.name == "goose step"


def test_the_skin_follows_the_bones(case):
    """Corner for corner it is MuJoCo's geoms in that frame, and the colours are the model's."""
    model, data, start, read, _ = case
    bones, skin = read.bones(FRAME), read.document.skins[0]
    to_bone = read.array(skin.inverseBindMatrices).reshape(-1, 4, 4).transpose(0, 2, 1)
    shown = []
    for primitive in read.document.meshes[0].primitives:
        names = primitive.attributes
        points, joints = read.array(names.POSITION), read.array(names.JOINTS_0)[:, 0]
        assert (read.array(names.WEIGHTS_0) == [1, 0, 0, 0]).all()
        assert np.linalg.norm(read.array(names.NORMAL), axis=1) == pytest.approx(1, abs=1e-5)
        assert read.array(primitive.indices).max() < len(points)
        four = np.concatenate([points, np.ones((len(points), 1))], axis=1)
        shown.append(np.einsum("vij,vj->vi", (bones @ to_bone)[joints], four)[:, :3])
    wanted = []
    for geom in range(model.ngeom):
        mesh = geom_mesh(trimesh, model, geom) if model.geom_bodyid[geom] else None
        if mesh is not None:
            points = mesh.vertices @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
            wanted.append(y_up(points - start))
    shown, wanted = np.concatenate(shown), np.concatenate(wanted)
    assert cKDTree(shown).query(wanted)[0].max() < 1e-5 and cKDTree(wanted).query(shown)[0].max() < 1e-5


def test_another_library_reads_it_strictly(case):
    file = case[-1]
    scene = trimesh.load_scene(file)
    low, high = scene.bounds
    assert low[1] == pytest.approx(0, abs=0.01) and 1.5 < high[1] < 1.8  # it stands at rest
    colours = {tuple(mesh.visual.material.baseColorFactor[:3]) for mesh in scene.geometry.values()}
    assert len(colours) >= 6
    assert all(mesh.volume > 0 for mesh in scene.geometry.values())  # faces look outward


def test_the_missing_package_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pygltflib", None)
    model = plain_model()
    with pytest.raises(ValueError, match=r"pip install 'adaptnet-gym\[motion\]'"):
        write_glb(perform(model, model.qpos0[None], 30.0), model, tmp_path / "out.glb")
    assert not list(tmp_path.iterdir())
