"""From generalised coordinates to the states of the links, by MuJoCo itself.

A *link state* is 13 numbers: position of the link frame's origin [m], orientation (w, x, y, z), linear velocity of that
origin [m/s] and angular velocity [rad/s], all absolute and in world axes (paper, sec. 7).
"""

import copy
from functools import cached_property

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from adapt_envs.model.humanoid import LINKS

LINK_STATE = 13
"""Numbers per link: position 3, quaternion 4, linear velocity 3, angular velocity 3."""
_FIELDS = ("xpos", "xquat", "cvel", "subtree_com")
_CHUNK = 1024
_OFF = mujoco.mjtDisableBit
_NO_FORCES = int(
    _OFF.mjDSBL_CONSTRAINT | _OFF.mjDSBL_ACTUATION | _OFF.mjDSBL_SENSOR
    | _OFF.mjDSBL_SPRING | _OFF.mjDSBL_DAMPER | _OFF.mjDSBL_GRAVITY
)  # fmt: skip


class LinkReader:
    """Reads the 15 links' states from a batch whose position and velocity stages are current."""

    def __init__(self, batch: Batch, model: mujoco.MjModel) -> None:
        """Bind the fields of `batch`; they are refreshed by each of its calls."""
        self._links = np.array([model.body(name).id for name in LINKS])
        self._root = int(model.body_rootid[self._links[0]])
        self._contiguous = slice(int(self._links[0]), int(self._links[-1]) + 1)
        if not np.array_equal(self._links, np.arange(self._contiguous.start, self._contiguous.stop)):
            raise ValueError(f"the model's links must be {', '.join(LINKS)} in this order")
        self._xpos, self._xquat, self._cvel, self._com = (batch.bind(field) for field in _FIELDS)

    def read(self, out: NDArray[np.float32], ids: NDArray[np.integer] | slice = slice(None)) -> NDArray[np.float32]:
        """Write the link states of the worlds `ids` into `out`, (n, 15, 13), world frame; return it.

        MuJoCo's `cvel` is the velocity at the character's centre of mass, so the origin's adds omega x offset.
        """
        links = self._contiguous
        pos, cvel = self._xpos[ids, links], self._cvel[ids, links]
        offset = pos - self._com[ids, None, self._root]
        omega, linear = cvel[..., :3], cvel[..., 3:]
        out[..., 0:3] = pos
        out[..., 3:7] = self._xquat[ids, links]
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            out[..., 7 + i] = linear[..., i] + omega[..., j] * offset[..., k] - omega[..., k] * offset[..., j]
        out[..., 10:13] = omega
        return out


class Kinematics:
    """Link states of any number of (qpos, qvel) rows of one model."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Keep the model; the batch that computes is made at first use."""
        self.model = model

    @cached_property
    def _worlds(self) -> tuple[Batch, LinkReader]:
        # Without contacts and forces, which move no link here, the same numbers come in half the time.
        still = copy.copy(self.model)
        still.opt.disableflags |= _NO_FORCES
        # Bound together: a field bound after a call would read zero until the next one.
        batch = Batch(still, nsim=_CHUNK, nthread=1)
        return batch, LinkReader(batch, self.model)

    def link_states(self, qpos: NDArray[np.floating], qvel: NDArray[np.floating] | None = None) -> NDArray[np.float32]:
        """Link states of configurations.

        Args:
            qpos: (T, nq): root position, root quaternion, joint angles in the model's order.
            qvel: (T, nv): root velocity in the world, root angular velocity in its own frame, joint velocities; or None
                for zero.

        Returns:
            (T, 15, 13) in the world frame, links in `LINKS` order.
        """
        batch, reader = self._worlds
        states = np.empty((len(qpos), len(LINKS), LINK_STATE), np.float32)
        for start in range(0, len(qpos), _CHUNK):
            rows = slice(start, min(start + _CHUNK, len(qpos)))
            ids = np.arange(rows.stop - rows.start)
            batch.qpos[ids] = qpos[rows]
            batch.qvel[ids] = 0 if qvel is None else qvel[rows]
            batch.forward(ids, stage=int(mujoco.mjtStage.mjSTAGE_VEL))
            reader.read(states[rows], ids)
        return states
