"""Building a model from a zoo entry and training it in a run folder."""

import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback, CallbackList
from stable_baselines3.common.logger import configure

from sb3_adaptnet.objectives.attribute_ramp import AttributeRamp
from sb3_adaptnet.objectives.callback import DiscriminatorRewardCallback
from sb3_adaptnet.objectives.reward_terms import check_terms
from sb3_adaptnet.policies.from_base import PolicyFromBase
from sb3_adaptnet.runs.curve import draw_curve
from sb3_adaptnet.runs.experiment import ALGORITHMS, Experiment, experiment
from sb3_adaptnet.runs.lock import clear, held, is_locked
from sb3_adaptnet.runs.progress import METRICS, Measuring, RunProgress
from sb3_adaptnet.runs.run_folder import RunFolder, RunSettings, next_path
from sb3_adaptnet.runs.saver import RunSaver, Stateful
from sb3_adaptnet.runs.tracking_metrics import TRACKING_METRICS, TrackingMetrics
from sb3_adaptnet.runs.worlds import make_worlds
from sb3_adaptnet.stacking.joined_worlds import JoinedWorlds
from sb3_adaptnet.vec_env import AdaptVecEnv

DEVICES = ("cpu", "cuda")
"""Where a run may learn; "cuda:1" is the second card."""


@dataclass
class Learner:
    """A model with its worlds and the entry's callbacks.

    Attributes:
        vec_env: the worlds.
        model: PPO or SVG with a policy of this package.
        discriminators: the callback that makes PPO multi-objective; None for SVG.
        others: further callbacks of the entry.
    """

    vec_env: AdaptVecEnv | JoinedWorlds
    model: BaseAlgorithm
    discriminators: DiscriminatorRewardCallback | None
    others: list[BaseCallback]


def build_learner(
    settings: RunSettings, entry: Experiment | None = None, samples_done: int = 0, **overrides: Any
) -> Learner:
    """Make worlds, model and callbacks; nothing is written.

    Args:
        settings: what was asked for.
        entry: what to train with; None for the settings' entry of the zoo.
        samples_done: samples of a resumed run; the worlds restart with another seed.
        **overrides: further arguments of `AdaptVecEnv` (tests hand in `env`).

    Raises:
        ValueError: if anything asked for does not exist or does not fit.
    """
    check_device(settings.device)
    if settings.threads is not None:
        torch.set_num_threads(settings.threads)
    entry = entry or experiment(settings.env_id, settings.base, settings.conf_file, settings.algo, settings.start)
    env = make_worlds(settings, entry, **overrides)
    given = {} if settings.world_model is None else {"world_model": settings.world_model}
    algorithm: Any = ALGORITHMS[entry.algorithm]
    arguments = {**entry.arguments, **given}
    try:
        callbacks = entry.make_callbacks()
        model = algorithm(entry.policy, env, seed=settings.seed, device=settings.device, **arguments)
    except (TypeError, AssertionError) as error:  # Stable-Baselines3's own checks, and values of another type
        env.close()
        raise ValueError(f"{entry.env_id}: its settings cannot be used: {error}") from error
    env.seed(settings.seed + samples_done)
    discriminators = next((c for c in callbacks if isinstance(c, DiscriminatorRewardCallback)), None)
    others = [c for c in callbacks if c is not discriminators]
    if discriminators is None and entry.algorithm == "ppo":
        discriminators = DiscriminatorRewardCallback()
    return Learner(env, model, discriminators, others)


def check_device(name: str) -> None:
    """Refuse a device that is not there: Stable-Baselines3 would take the processor instead, and say nothing.

    Raises:
        ValueError: naming it.
    """
    if name.partition(":")[0] not in DEVICES:
        raise ValueError(f"there is no device {name!r}; the devices are {' and '.join(DEVICES)}")
    if name != "cpu" and not torch.cuda.is_available():
        raise ValueError(f"device {name!r} needs a graphics card that torch can use, and finds none")


def start(
    settings: RunSettings, run_dir: str | Path | None = None, callbacks: Sequence[BaseCallback] = (),
    anew: bool = False, **options: Any,
) -> RunFolder:  # fmt: skip
    """Train from the beginning in a new folder.

    Args:
        settings: what was asked for.
        run_dir: the folder; None for the next one under `runs/`.
        callbacks: further callbacks.
        anew: whether what is in the folder is removed, once nothing speaks against the training.
        **options: `learn`'s.
    """
    named = None if run_dir is None else Path(run_dir)
    if named is not None and not (anew or is_locked(named)):  # so that a refusal leaves no lock there
        RunFolder(named, settings).check_free()
    learner = build_learner(settings)
    learner.others.extend(callbacks)
    if isinstance(learner.model.policy, PolicyFromBase):
        learner.model.policy.check_files_found()
    if learner.discriminators is not None:
        check_terms(learner.discriminators.objectives, learner.vec_env)
    path = named or next_path(settings.env_id)
    with held(path):
        if anew:
            clear(path)
        return learn(learner, RunFolder.new(settings, path), **options)


def resume(
    run: str | Path, samples: int | None = None, device: str | None = None, threads: int | None = None, **options: Any
) -> RunFolder:
    """Go on with a run from its last checkpoint, by its own `config.yml`; all states as they were."""
    folder = RunFolder.open(run)
    with held(folder.path):
        folder.remove_parts()
        state = folder.load()
        changes: dict[str, Any] = {"samples": samples, "device": device, "threads": threads}
        settings = replace(folder.settings, **{name: new for name, new in changes.items() if new is not None})
        learner = build_learner(settings, folder.experiment, int(state["samples"]))
        folder.write_settings(settings)
        return learn(learner, folder, state=state, **options)


def learn(
    learner: Learner,
    folder: RunFolder,
    state: dict[str, Any] | None = None,
    minutes: float = 3.0,
    quiet: bool = False,
) -> RunFolder:
    """Train until the folder's number of samples, Ctrl-C or SIGTERM, then save.

    Args:
        learner: what to train.
        folder: where checkpoint, progress.csv, curve.png and TensorBoard's events go.
        state: checkpoint to go on from.
        minutes: time between checkpoints.
        quiet: show no progress.

    Returns:
        The folder.
    """
    model, discriminators = learner.model, learner.discriminators
    ramps = [callback for callback in learner.others if isinstance(callback, AttributeRamp)]
    kept = [callback for callback in learner.others if isinstance(callback, Stateful)]
    saver = RunSaver(folder, discriminators, minutes, state, kept)
    measuring = [callback for callback in learner.others if isinstance(callback, Measuring)]
    metrics = discriminators or TrackingMetrics()
    names = METRICS if discriminators is not None else TRACKING_METRICS
    progress = RunProgress(folder, metrics, ramps, measuring, saver.seconds, quiet, names)
    done = int(state["samples"]) if state else 0
    model.num_timesteps = done
    model.set_logger(configure(str(folder.path), ["tensorboard"]))
    callbacks = CallbackList([metrics, *learner.others, CurveDrawer(progress), progress, saver])
    model.verbose = 0 if quiet else 1
    with stopping(saver):
        model.learn(max(folder.settings.samples - done, 0), callback=callbacks, reset_num_timesteps=False)
        saver.save()
    learner.vec_env.close()
    return folder


class CurveDrawer(BaseCallback):
    """Redraws the learning curve every 25 rollouts."""

    def __init__(self, progress: RunProgress, rollouts: int = 25) -> None:
        """Draw `progress`'s rows every `rollouts` rollouts."""
        super().__init__()
        self.progress, self.rollouts, self._count = progress, rollouts, 0

    def _on_step(self) -> bool:
        return True

    def _on_rollout_start(self) -> None:
        self._count += 1
        if self._count % self.rollouts == 0:
            draw_curve(self.progress.rows, self.progress.folder)


@contextmanager
def stopping(saver: RunSaver) -> Iterator[None]:
    """Ctrl-C and SIGTERM ask the run to save and leave; a second Ctrl-C ends it as usual.

    A second SIGTERM does not: at a shutdown a sweep's run gets one from the system and one from its attendant's end.
    """
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def ask(number: int, frame: Any) -> None:
        del frame
        if number == signal.SIGINT:
            signal.signal(signal.SIGINT, before[signal.SIGINT])
        saver.ask_to_stop()

    for number in before:
        signal.signal(number, ask)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
