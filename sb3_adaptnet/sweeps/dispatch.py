"""Which run when and where: one after the other here, or by Ray Tune. What a run is, both leave to `attend`."""

import os
from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sb3_adaptnet.sweeps.attendant import RunDiedError, attend

TUNE_FOLDER = ".ray"
"""Folder in a sweep's, for what Ray Tune writes down."""


def run_in_order(folders: Sequence[Path], retries: int) -> None:
    """Attend to runs one after the other; one that died is taken up again up to `retries` times, then left."""
    for folder in folders:
        for _ in range(retries + 1):
            try:
                attend(folder)
                break
            except RunDiedError:
                continue


def run_by_ray(
    folders: Sequence[Path], retries: int, cpus: float, gpus: float, cores: int, address: str | None = None
) -> None:
    """Attend to runs by Ray Tune, as many at once as there is room for.

    Args:
        folders: of the runs; on a cluster, where all its machines see them.
        retries: how often a run that died is taken up again, elsewhere if its machine is gone.
        cpus: processor cores of one run.
        gpus: graphics cards of one run.
        cores: of this machine, that all runs together may take where there is no cluster.
        address: of a cluster; None starts Ray on this machine, and ends it.

    Raises:
        ValueError: if Ray is not installed.
    """
    ray, tune = ray_libraries()
    # Trials must not move into Ray's folders: what a sweep names may lie beside the working directory.
    os.environ.setdefault("RAY_CHDIR_TO_TRIAL_DIR", "0")
    # Ray's workers let all else go first; a run shall be as quick as without Ray.
    os.environ.setdefault("RAY_worker_niceness", "0")
    # Tune would take Ctrl-C for itself, and the sweep would go on with what comes next.
    os.environ.setdefault("TUNE_DISABLE_SIGINT_HANDLER", "1")
    if address is None:
        ray.init(address="local", num_cpus=cores, include_dashboard=False)
    else:
        ray.init(address=address)
    try:
        tuner = tune.Tuner(
            tune.with_resources(_attend_trial, {"cpu": cpus, "gpu": gpus}),
            param_space={"run": tune.grid_search([str(folder) for folder in folders])},
            tune_config=tune.TuneConfig(trial_name_creator=_name, trial_dirname_creator=_name, reuse_actors=False),
            run_config=tune.RunConfig(
                name=TUNE_FOLDER,
                storage_path=str(folders[0].parent),
                failure_config=tune.FailureConfig(max_failures=retries),
                verbose=0,
            ),
        )
        tuner.fit()
    finally:
        ray.shutdown()


def check_room(there: Mapping[str, float], cpus: float, gpus: float) -> None:
    """Refuse runs that would wait for ever.

    Raises:
        ValueError: if one run takes more than there is.
    """
    for name, asked in (("CPU", cpus), ("GPU", gpus)):
        if asked > there.get(name, 0.0):
            raise ValueError(f"a run takes {asked:g} {name}s, this machine has {there.get(name, 0.0):g}")


def has_ray() -> bool:
    """Whether Ray is installed; it is not imported."""
    return find_spec("ray") is not None


def ray_libraries() -> tuple[Any, Any]:
    """The packages `ray` and `ray.tune`; imported when they are needed, because that takes seconds.

    Raises:
        ValueError: if they are not installed.
    """
    try:
        return import_module("ray"), import_module("ray.tune")
    except ImportError as error:
        raise ValueError(f"this needs an optional package ({error}): pip install 'adaptnet-gym[sweep]'") from error


def _attend_trial(config: Mapping[str, str]) -> None:
    attend(config["run"])


def _name(trial: Any) -> str:
    return Path(trial.config["run"]).name
