"""Momentum of whole-body motions: centre of mass, angular momentum, zero-moment point, ground force.

Everything is for motions on flat ground at z = 0, from configurations alone (velocities by central differences).
"""

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.motion.clip import velocities

GRAVITY = 9.81
"""Acceleration of free fall [m/s^2]."""
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Momentum:
    """Momentum of a motion of T frames, less the first and last two, where differences are not central.

    Attributes:
        mass: kg.
        com: (T - 4, 3) centre of mass [m], world.
        com_acc: (T - 4, 3) its acceleration [m/s^2].
        spin_rate: (T - 4, 3) rate of change of the angular momentum about the centre of mass [N m].
    """

    mass: float
    com: Array
    com_acc: Array
    spin_rate: Array

    @cached_property
    def force(self) -> Array:
        """Vertical ground force over weight, (T - 4,)."""
        return 1 + self.com_acc[:, 2] / GRAVITY

    @cached_property
    def zmp(self) -> Array:
        """Zero-moment point on the ground (T - 4, 2) [m]; meaningless where the force is near zero."""
        lift = np.maximum(self.com_acc[:, 2:] + GRAVITY, 0.05 * GRAVITY)
        moment = np.stack([-self.spin_rate[:, 1], self.spin_rate[:, 0]], axis=1) / (self.mass * lift)
        return self.com[:, :2] - self.com[:, 2:] * self.com_acc[:, :2] / lift + moment


def momentum(model: mujoco.MjModel, qpos: Array, dt: float) -> Momentum:
    """Momentum of the motion `qpos` (T, nq), one frame every `dt` seconds; full inertia of every link."""
    qvel = velocities(qpos[:-2], qpos[2:], 2 * dt)
    data = mujoco.MjData(model)
    root = int(model.body_rootid[model.nbody - 1])
    com, spin = np.empty((len(qvel), 3)), np.empty((len(qvel), 3))
    for row, (position, velocity) in enumerate(zip(qpos[1:-1], qvel, strict=True)):
        data.qpos[:], data.qvel[:] = position, velocity
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)
        mujoco.mj_subtreeVel(model, data)
        com[row], spin[row] = data.subtree_com[root], data.subtree_angmom[root]
    acc = (com[2:] - 2 * com[1:-1] + com[:-2]) / dt**2
    return Momentum(float(model.body_subtreemass[root]), com[1:-1], acc, (spin[2:] - spin[:-2]) / (2 * dt))
