"""Unit quaternions (w, x, y, z) and vectors with the component first and the batch last: (4, ..., B) and (3, ..., B).

This layout keeps every component contiguous, which on a CPU is several times as fast as components last.
"""

from functools import cache

import torch

_TINY = 1e-12
"""Added to squared angles [rad^2], where the derivative of a length would be infinite."""


_HAMILTON = "+00 -11 -22 -33, +01 +10 +23 -32, +02 -13 +20 +31, +03 +12 -21 +30"
"""Components of a quaternion product: +01 is the first factor's component 0 times the second's component 1."""
_CROSS = "+12 -21, +20 -02, +01 -10"
"""The same of a cross product."""


def _bilinear(terms: str, a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
    """Sums of products of components, as `terms` says: (m, ...) from (n, ...) and (n, ...).

    All products at once, then one small matrix product: far fewer kernels than written-out sums, there and on the way
    back. For some hundred characters the time goes into starting kernels.
    """
    signs = _signs(terms, len(a), a.device, a.dtype)
    products = a.unsqueeze(1) * b.unsqueeze(0)
    return torch.mm(signs, products.flatten(0, 1).flatten(1)).view(-1, *products.shape[2:])


@cache
def _signs(terms: str, size: int, device: torch.device, dtype: torch.dtype) -> torch.Tensor:
    """(m, size * size): +1 or -1 where a row of `terms` names the product of two components."""
    rows = [row.split() for row in terms.split(",")]
    signs = torch.zeros(len(rows), size, size)
    for row, parts in enumerate(rows):
        for part in parts:
            signs[row, int(part[1]), int(part[2])] = 1.0 if part[0] == "+" else -1.0
    return signs.flatten(1).to(device, dtype)


def multiply(a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
    """Hamilton product a * b of quaternions (4, ...) each."""
    return _bilinear(_HAMILTON, a, b)


def conjugate(q: torch.Tensor) -> torch.Tensor:
    """Inverse of unit quaternions (4, ...)."""
    return torch.cat((q[:1], -q[1:]))


def cross(a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
    """Cross product of vectors (3, ...) each."""
    return _bilinear(_CROSS, a, b)


def rotate(q: torch.Tensor, v: torch.Tensor) -> torch.Tensor:
    """Vectors (3, ...) turned by unit quaternions (4, ...)."""
    axis = q[1:]
    twice = 2 * cross(axis, v)
    return v + q[:1] * twice + cross(axis, twice)


def normalised(q: torch.Tensor) -> torch.Tensor:
    """Quaternions (4, ...) brought to length 1."""
    return q * torch.rsqrt(q.square().sum(0, keepdim=True))


def from_rotation_vector(vector: torch.Tensor) -> torch.Tensor:
    """Unit quaternions (4, ...) of turns about the vectors (3, ...) by their lengths [rad]."""
    angle = (vector.square().sum(0, keepdim=True) + _TINY).sqrt()
    return torch.cat((torch.cos(angle / 2), torch.sin(angle / 2) / angle * vector))


def to_rotation_vector(q: torch.Tensor) -> torch.Tensor:
    """Axis times angle (3, ...) in radians, at most pi long, of unit quaternions (4, ...)."""
    q = torch.where(q[:1] < 0, -q, q)
    sine = (q[1:].square().sum(0, keepdim=True) + _TINY).sqrt()
    return q[1:] / sine * (2 * torch.atan2(sine, q[:1]))


def about_z(cos: torch.Tensor, sin: torch.Tensor, v: torch.Tensor) -> torch.Tensor:
    """Vectors (3, ..., B) turned about z by the angles whose cosine and sine (B,) are given."""
    x, y, z = v.unbind(0)
    return torch.stack((cos * x - sin * y, sin * x + cos * y, z))
