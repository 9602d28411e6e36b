"""Stand-ins for viser and trimesh, which are optional: they keep what they are given."""

from types import SimpleNamespace

import numpy as np
import pytest

from sb3_adaptnet.play import browser, figure, landscape


class FakeScene:
    """Nodes by name, each with what it was made of."""

    def __init__(self):
        self.nodes = {}

    def _add(self, name, **made):
        place = {"position": np.zeros(3), "wxyz": np.array([1.0, 0, 0, 0])}
        self.nodes[name] = SimpleNamespace(**{**place, **made}, remove=lambda: self.nodes.pop(name))
        return self.nodes[name]

    def add_frame(self, name, show_axes):
        return self._add(name)

    def add_mesh_simple(self, name, vertices, faces, color):
        return self._add(name, vertices=vertices, faces=faces, color=color)

    def add_mesh_trimesh(self, name, mesh):
        return self._add(name, vertices=mesh.vertices, faces=mesh.faces, color=mesh.visual.material.picture)

    def add_box(self, name, color, dimensions):
        return self._add(name, color=color, dimensions=dimensions)

    def add_grid(self, name, width, height, cell_size):
        return self._add(name)

    def world(self, name):
        """The vertices of a mesh that hangs on the frame of the ground, as they are shown."""
        node, frame = self.nodes[name], self.nodes[landscape.ROOT]
        return frame.position + node.position + node.vertices


class FakeGui:
    """Sliders whose `set` does what a person does."""

    def _add(self, label, **made):
        handle = SimpleNamespace(label=label, **made)

        def register(function):
            handle.set = lambda value: function(SimpleNamespace(target=SimpleNamespace(value=value)))

        handle.on_update = handle.on_click = register
        return handle

    add_slider = add_checkbox = add_button = _add


class FakeServer:
    """A server that serves nobody."""

    def __init__(self, host, port, verbose):
        self.scene, self.gui, self.port = FakeScene(), FakeGui(), port
        self.initial_camera, self.stopped = SimpleNamespace(), False

    def get_port(self):
        return self.port

    def atomic(self):
        return self

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def stop(self):
        self.stopped = True


def shape(**sizes):
    return SimpleNamespace(vertices=np.zeros((3, 3)), faces=np.array([(0, 1, 2)]), sizes=sizes)


def painted_mesh(vertices, faces, visual, process):
    return SimpleNamespace(vertices=vertices, faces=faces, visual=visual)


@pytest.fixture
def scene():
    return FakeScene()


@pytest.fixture
def fakes(monkeypatch):
    """Put the stand-ins in place."""
    material = SimpleNamespace(
        PBRMaterial=lambda baseColorTexture, **_: SimpleNamespace(picture=baseColorTexture)  # noqa: N803 (trimesh's)
    )
    kinds = ("icosphere", "capsule", "cylinder", "box")
    trimesh = SimpleNamespace(
        creation=SimpleNamespace(**dict.fromkeys(kinds, shape)),
        visual=SimpleNamespace(
            material=material, TextureVisuals=lambda uv, material: SimpleNamespace(material=material)
        ),
        Trimesh=painted_mesh,
    )
    monkeypatch.setattr(browser, "viser", SimpleNamespace(ViserServer=FakeServer))
    monkeypatch.setattr(figure, "trimesh", trimesh)
    monkeypatch.setattr(landscape, "trimesh", trimesh)
    monkeypatch.setattr(landscape, "pil_image", SimpleNamespace(fromarray=lambda picture: picture))
