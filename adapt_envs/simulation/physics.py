"""N independent worlds of one model, stepped together on MuJoCo's own thread pool."""

import mujoco
import numpy as np
from mujoco.batch import Batch, SimulationError
from numpy.typing import NDArray

from adapt_envs.features.kinematics import LinkReader
from adapt_envs.model.build import FALL_SENSOR
from adapt_envs.model.humanoid import PHYSICS_STEPS

_STAGE = int(mujoco.mjtStage.mjSTAGE_VEL)
_DIVERGED = [int(getattr(mujoco.mjtWarning, f"mjWARN_BAD{quantity}")) for quantity in ("QPOS", "QVEL", "QACC")]


class PhysicsBatch:
    """N worlds at 120 Hz, controlled at 30 Hz.

    Attributes:
        model: the worlds' model.
        num_worlds: N.
    """

    def __init__(self, model: mujoco.MjModel, num_worlds: int, num_threads: int | None = None) -> None:
        """Make `num_worlds` worlds on `num_threads` threads; None for one per core.

        Raises:
            ValueError: if there is not at least one world and one thread.
        """
        if not isinstance(num_worlds, int | np.integer) or num_worlds < 1:
            raise ValueError(f"the number of worlds must be a whole number of at least 1, not {num_worlds!r}")
        if num_threads is not None and not (isinstance(num_threads, int | np.integer) and num_threads >= 1):
            raise ValueError(f"num_threads must be at least 1, or None for one per core, not {num_threads!r}")
        self.model, self.num_worlds = model, num_worlds
        self._batch = Batch(model, nsim=num_worlds, nthread=num_threads or 0)
        self._links = LinkReader(self._batch, model)
        self._ctrl, self._qpos, self._qvel = (self._batch.bind(field) for field in ("ctrl", "qpos", "qvel"))
        self._warnings = self._batch.warning[:, _DIVERGED, 1]
        fall = [i for i in range(model.nsensor) if model.sensor(i).name.startswith(FALL_SENSOR)]
        self._fall_columns = model.sensor_adr[fall]
        self._sensordata = self._batch.bind("sensordata")
        self._torso = model.body("torso").id

    @property
    def qpos(self) -> NDArray[np.float64]:
        """Generalised positions (N, nq): a live view, to be written through `set_states` only."""
        return self._qpos

    @property
    def qvel(self) -> NDArray[np.float64]:
        """Generalised velocities (N, nv): a live view, to be written through `set_states` only."""
        return self._qvel

    def step(self, actions: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Advance every world by one control step.

        MuJoCo silently resets a world that diverges to the reference pose, whose numbers are finite again: its warning
        counters tell, not the state.

        Args:
            actions: (N, nu) in [-1, 1].

        Returns:
            (N,) bool: worlds that diverged; their state is meaningless until `set_states`.
        """
        self._ctrl[:] = actions
        diverged = np.zeros(self.num_worlds, bool)
        try:
            self._batch.step(nstep=PHYSICS_STEPS, stage=_STAGE)
        except SimulationError as error:
            diverged[error.ids] = True
        counted = self._batch.warning[:, _DIVERGED, 1]
        if not np.array_equal(counted, self._warnings):
            diverged |= (counted != self._warnings).any(axis=1)
            self._warnings = counted.copy()
        # One sum over the state is a tenth of the price of isfinite over it, and a NaN survives it.
        if not np.isfinite(self._qpos.sum() + self._qvel.sum()):
            diverged |= ~(np.isfinite(self._qpos).all(axis=1) & np.isfinite(self._qvel).all(axis=1))
        return diverged

    def read_links(self, out: NDArray[np.float32], ids: NDArray[np.integer] | slice = slice(None)) -> None:
        """Write the link states (n, 15, 13) of the worlds `ids`, world frame, into `out` (see `kinematics`)."""
        self._links.read(out, ids)

    def touching(self) -> NDArray[np.bool_]:
        """(N, 6) bool: which of `FALL_PARTS` touch the ground or another static body."""
        return self._sensordata[:, self._fall_columns] > 0

    def set_states(self, ids: NDArray[np.integer], qpos: NDArray[np.floating], qvel: NDArray[np.floating]) -> None:
        """Restart the worlds `ids` at (n, nq) and (n, nv), with warm starts and pushes cleared."""
        self._batch.reset(ids, stage=0)
        self._qpos[ids] = qpos
        self._qvel[ids] = qvel
        self._batch.forward(ids, stage=_STAGE)
        self._warnings[ids] = self._batch.warning[:, _DIVERGED, 1][ids]  # the reset set them to zero

    def push(self, force: NDArray[np.floating]) -> None:
        """Set the force (N, 3) [N] in the world frame that acts on the torso's centre of mass until it is set again."""
        self._batch.bind("xfrc_applied")[:, self._torso, :3] = force

    def mujoco_data(self, world: int, data: mujoco.MjData, model: mujoco.MjModel | None = None) -> mujoco.MjData:
        """Copy one world's state into `data` and compute what rendering needs; return it.

        `model` is what `data` belongs to, if not the worlds' own: one of the same character on a piece of the ground.
        """
        self._batch.get_data(world, data)
        mujoco.mj_forward(self.model if model is None else model, data)
        return data
