"""A performance as a binary glTF file: a skeleton, a skin that follows it, and one animation.

The document is the package pygltflib's, which knows all of glTF 2.0; trimesh, which makes the triangles, writes no
animations.
"""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from adapt_envs.motion.exporting.extra import gltf_packages
from adapt_envs.motion.exporting.gltf_buffer import GltfBuffer
from adapt_envs.motion.exporting.performance import Performance
from adapt_envs.motion.exporting.skin import Patch, patches
from adapt_envs.motion.whole_file import write_whole

_SRGB = 2.2
"""Exponent from a colour as screens show it to the amount of light that glTF asks for."""
_ROUGHNESS = 0.6


def write_glb(performed: Performance, model: mujoco.MjModel, path: str | Path, name: str = "motion") -> None:
    """Write a performance as a `.glb` file, whole or not at all.

    Args:
        performed: skeleton and motion.
        model: the character that it was made from, for its shape and colours.
        path: the file.
        name: of the animation.

    Raises:
        ValueError: if an optional package is not installed.
        OSError: if the file cannot be written.
    """
    library, trimesh = gltf_packages()
    document = library.GLTF2(asset=library.Asset(generator="adaptnet-gym"))
    buffer = GltfBuffer(library, document)
    _add_bones(library, document, performed)
    _add_skin(library, document, buffer, performed, patches(trimesh, model, performed))
    _add_motion(library, document, buffer, performed, name)
    buffer.close()
    write_whole(Path(path), b"".join(document.save_to_bytes()))


def _add_bones(library: Any, document: Any, performed: Performance) -> None:
    """A node for each bone, at rest; their numbers are the bones'."""
    for bone, name in enumerate(performed.names):
        children = [child for child, parent in enumerate(performed.parents) if parent == bone]
        place = performed.offsets[bone].tolist()
        document.nodes.append(library.Node(name=name, translation=place, children=children))


def _add_skin(
    library: Any, document: Any, buffer: GltfBuffer, performed: Performance, skin: list[Patch]
) -> None:  # fmt: skip
    """The mesh in a node of its own beside the skeleton, as the format wants skins."""
    bones = len(performed.names)
    to_bone = np.tile(np.eye(4, dtype=np.float32), (bones, 1, 1))
    to_bone[:, 3, :3] = -performed.rest  # columns first
    document.skins.append(library.Skin(inverseBindMatrices=buffer.add(to_bone), skeleton=0, joints=list(range(bones))))
    primitives = [_primitive(library, document, buffer, patch) for patch in skin]
    document.meshes.append(library.Mesh(name="humanoid", primitives=primitives))
    document.nodes.append(library.Node(name="humanoid", mesh=0, skin=0))
    document.scenes.append(library.Scene(nodes=[0, bones]))
    document.scene = 0


def _primitive(library: Any, document: Any, buffer: GltfBuffer, patch: Patch) -> Any:
    joints, weights = np.zeros((len(patch.bones), 4), np.uint8), np.zeros((len(patch.bones), 4), np.float32)
    joints[:, 0], weights[:, 0] = patch.bones, 1.0
    light = [*(value**_SRGB for value in patch.colour), 1.0]
    surface = library.PbrMetallicRoughness(baseColorFactor=light, metallicFactor=0.0, roughnessFactor=_ROUGHNESS)
    document.materials.append(library.Material(pbrMetallicRoughness=surface, alphaMode="OPAQUE", alphaCutoff=None))
    return library.Primitive(
        attributes=library.Attributes(
            POSITION=buffer.add(patch.points, "ARRAY_BUFFER"), NORMAL=buffer.add(patch.normals, "ARRAY_BUFFER"),
            JOINTS_0=buffer.add(joints, "ARRAY_BUFFER"), WEIGHTS_0=buffer.add(weights, "ARRAY_BUFFER"),
        ),
        indices=buffer.add(patch.faces.ravel(), "ELEMENT_ARRAY_BUFFER"),
        material=len(document.materials) - 1,
    )  # fmt: skip


def _add_motion(library: Any, document: Any, buffer: GltfBuffer, performed: Performance, name: str) -> None:
    """One animation: where the root goes, and how every bone turns."""
    times = buffer.add((np.arange(len(performed.root)) / performed.fps).astype(np.float32))
    curves = [(0, "translation", performed.root)]
    curves += [(bone, "rotation", performed.quats[:, bone, [1, 2, 3, 0]]) for bone in range(len(performed.names))]
    animation = library.Animation(name=name)
    for node, path, values in curves:
        output = buffer.add(values.astype(np.float32))
        target = library.AnimationChannelTarget(node=node, path=path)
        animation.channels.append(library.AnimationChannel(sampler=len(animation.samplers), target=target))
        animation.samplers.append(library.AnimationSampler(input=times, output=output, interpolation="LINEAR"))
    document.animations.append(animation)
