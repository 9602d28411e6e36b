"""The imitation objective: discriminators, their optimiser, one pass of training per rollout."""

import inspect
from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from sb3_adaptnet.modules.discriminator import Discriminator, hinge_loss, imitation_reward
from sb3_adaptnet.modules.layers.precision import autocast, chosen_precision
from sb3_adaptnet.policies.optimizer_groups import restore_moments

GRADIENT_PENALTY = 10.0
"""Coefficient of eq. 10's last term; the paper's Table 4."""
BATCH_SIZE = 512
"""Windows in one update, half simulated, half reference; the paper's Table 4."""
SCORE_CHUNK = 4096
"""Windows scored at once, to bound memory."""
STATISTICS = (
    "loss",
    "gradient_norm",
    "score_reference",
    "score_simulated",
    "score_difference",
    "update_norm",
)
"""What an update reports, in the order of `ImitationObjective._step`."""


class ImitationObjective:
    """Discriminators, fresh for every adaptation, with the optimiser that trains them.

    Attributes:
        discriminator: the network.
        optimizer: adam over its weights.
    """

    def __init__(
        self,
        learning_rate: float = 5e-5,
        batch_size: int = BATCH_SIZE,
        gradient_penalty: float = GRADIENT_PENALTY,
        max_grad_norm: float = 1.0,
        share: float = 1.0,
        precision: str = "fp32",
        device: torch.device | str = "cpu",
        network: Mapping[str, Any] | None = None,
    ) -> None:
        """Build fresh discriminators.

        Args:
            learning_rate: adam's step size.
            batch_size: windows in one update, half simulated, half reference.
            gradient_penalty: coefficient of eq. 10's last term.
            max_grad_norm: gradients are clipped to this norm.
            share: share of the rollout's windows that the one pass sees, sampled at random, in (0, 1].
            precision: "fp32", "medium", "bf16" or "auto", as in `use_precision`.
            device: where the network lives.
            network: arguments of `Discriminator` (heads, gru, hidden).

        Raises:
            ValueError: if `batch_size` or `share` is out of range, or for an unknown precision.
        """
        if batch_size < 2 or batch_size % 2:
            raise ValueError(f"the discriminators' batch_size must be even and at least 2, not {batch_size}")
        if not 0.0 < share <= 1.0:
            raise ValueError(f"share must lie in (0, 1], not {share}")
        self.half = batch_size // 2
        self.gradient_penalty = gradient_penalty
        self.max_grad_norm = max_grad_norm
        self.share = share
        self.device = torch.device(device)
        self.precision = chosen_precision(precision, self.device)
        self.discriminator = Discriminator(**(network or {})).to(self.device)
        self.optimizer = torch.optim.Adam(self.discriminator.parameters(), lr=learning_rate, fused=True)

    def update(
        self, simulated: NDArray[np.float32], reference: NDArray[np.float32], rng: np.random.Generator
    ) -> dict[str, float]:
        """Train for one pass over a rollout.

        Args:
            simulated: pose windows (M, frames, links, 7) of the rollout; rows that are not finite are left out.
            reference: as many of the clips'.
            rng: orders and pairs the rows.

        Returns:
            Means over the pass: loss, gradient norm, scores of each kind and their difference.
        """
        simulated, reference = simulated[finite_rows(simulated)], reference[finite_rows(reference)]
        pairs = int(min(len(simulated), len(reference)) * self.share)
        if pairs == 0:
            return {}
        rows_s, rows_r = rng.permutation(len(simulated))[:pairs], rng.permutation(len(reference))[:pairs]
        fake, real = self._tensor(simulated[rows_s]), self._tensor(reference[rows_r])
        self.discriminator.observe(torch.cat([fake, real]))
        fake, real = self.discriminator.normalize(fake), self.discriminator.normalize(real)
        steps = [self._step(f, r) for f, r in zip(fake.split(self.half), real.split(self.half), strict=True)]
        means = torch.stack(steps).mean(dim=0).tolist()
        return dict(zip(STATISTICS, means, strict=True))

    def _step(self, fake: torch.Tensor, real: torch.Tensor) -> torch.Tensor:
        """One update on normalised frames (half a batch each); returns STATISTICS."""
        with autocast(self.device, self.precision):
            scores = self.discriminator.scores(torch.cat([fake, real])).float()
            norms = self.discriminator.gradient_norms(fake, real)
        fake_scores, real_scores = scores[: len(fake)], scores[len(fake) :]
        hinge = hinge_loss(fake_scores, real_scores)
        loss = hinge + self.gradient_penalty * (norms - 1.0).square().mean()
        self.optimizer.zero_grad()
        loss.backward()
        total = torch.nn.utils.clip_grad_norm_(self.discriminator.parameters(), self.max_grad_norm)
        if torch.isfinite(total):  # a batch that overflows is skipped: weights never become NaN
            self.optimizer.step()
        real_score, fake_score = real_scores.mean(), fake_scores.mean()
        row = [loss, norms.mean(), real_score, fake_score, real_score - fake_score, total]
        return torch.stack([x.detach() for x in row])

    @torch.no_grad()
    def rewards(self, windows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Imitation reward (eq. 11) of pose windows (M, frames, links, 7): (M,); -1 where a window is not finite."""
        finite = finite_rows(windows)
        chunks = []
        for start in range(0, len(windows), SCORE_CHUNK):
            with autocast(self.device, self.precision):
                frames = self._tensor(np.nan_to_num(windows[start : start + SCORE_CHUNK]))
                chunks.append(imitation_reward(self.discriminator(frames).float()).cpu())
        return np.where(finite, torch.cat(chunks).numpy(), -1.0).astype(np.float32)

    def state_dict(self) -> dict[str, Any]:
        """Weights, normaliser and optimiser."""
        return {"network": self.discriminator.state_dict(), "optimizer": self.optimizer.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Restore what `state_dict` gave; the learning rate stays this one's.

        Raises:
            ValueError: if the network had other sizes.
        """
        try:
            self.discriminator.load_state_dict(state["network"])
        except RuntimeError as error:
            raise ValueError("the discriminators that learned before had another network; leave its sizes") from error
        restore_moments(self.optimizer, state["optimizer"])

    def _tensor(self, array: NDArray[np.float32]) -> torch.Tensor:
        return torch.from_numpy(np.ascontiguousarray(array, np.float32)).to(self.device)


def finite_rows(windows: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Which rows of (M, ...) hold finite numbers alone: (M,) bool."""
    return np.isfinite(windows.reshape(len(windows), -1)).all(axis=1)


def check_imitation(arguments: Mapping[str, Any]) -> None:
    """Refuse what neither `ImitationObjective` nor its network has an argument for.

    Raises:
        ValueError: naming the argument and the valid ones; the callback says the device and the frames' size itself.
    """
    _check("the discriminators'", arguments, ImitationObjective, ("device",))
    _check("the discriminators' network's", arguments.get("network") or {}, Discriminator, ("links", "numbers"))


def _check(whose: str, given: Mapping[str, Any], cls: type, own: tuple[str, ...]) -> None:
    known = [name for name in inspect.signature(cls).parameters if name not in own]
    for name in given:
        if name not in known:
            raise ValueError(f"{whose} arguments are {', '.join(known)}, not {name!r}")
