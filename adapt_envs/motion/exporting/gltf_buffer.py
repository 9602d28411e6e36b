"""Arrays in a glTF file: one buffer, a view and an accessor for each."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

_COMPONENTS = {np.dtype(np.uint8): "UNSIGNED_BYTE", np.dtype(np.uint32): "UNSIGNED_INT", np.dtype(np.float32): "FLOAT"}
_SHAPES = {(): "SCALAR", (3,): "VEC3", (4,): "VEC4", (4, 4): "MAT4"}


class GltfBuffer:
    """Collects arrays for a `pygltflib.GLTF2`."""

    def __init__(self, library: Any, document: Any) -> None:
        """Write into `document` with the package `pygltflib`."""
        self._library, self._document = library, document
        self._content = bytearray()

    def add(self, array: NDArray[Any], target: str | None = None) -> int:
        """Add rows of numbers, vectors or matrices (columns first); return the accessor's number.

        Args:
            array: (n, ...) of uint8, uint32 or float32.
            target: "ARRAY_BUFFER" for corners, "ELEMENT_ARRAY_BUFFER" for faces, None for anything else.
        """
        library, document = self._library, self._document
        self._content += b"\0" * (-len(self._content) % 4)  # the format wants views aligned
        content = np.ascontiguousarray(array).tobytes()
        view = library.BufferView(buffer=0, byteOffset=len(self._content), byteLength=len(content))
        view.target = None if target is None else getattr(library, target)
        self._content += content
        document.bufferViews.append(view)
        flat = array.reshape(len(array), -1)
        document.accessors.append(
            library.Accessor(
                bufferView=len(document.bufferViews) - 1, count=len(array), type=_SHAPES[array.shape[1:]],
                componentType=getattr(library, _COMPONENTS[array.dtype]),
                min=flat.min(axis=0).tolist(), max=flat.max(axis=0).tolist(),
            )
        )  # fmt: skip
        return len(document.accessors) - 1

    def close(self) -> None:
        """Hand the bytes to the document."""
        self._content += b"\0" * (-len(self._content) % 4)
        self._document.buffers.append(self._library.Buffer(byteLength=len(self._content)))
        self._document.set_binary_blob(bytes(self._content))
