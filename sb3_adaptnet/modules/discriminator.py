"""Ensemble of discriminators that tell simulated motion from reference motion (the paper's eqs. 10 and 11)."""

import math
from collections.abc import Sequence

import torch
from torch import nn
from torch.nn import functional

from sb3_adaptnet.modules.encoder import StateEncoder
from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer, moments_of


def unroll_gru(gru: nn.GRU, inputs: torch.Tensor) -> torch.Tensor:
    """Run a GRU over a short sequence from a zero state and return the last state, twice differentiable.

    Written out because neither cuDNN's GRU nor `StateEncoder`'s fast one has the second derivative that the gradient
    penalty needs. Gates in torch's order: reset, update, new.

    Args:
        gru: the weights, one layer.
        inputs: (B, frames, input size), oldest frame first.

    Returns:
        Last hidden state (B, hidden size), float32.
    """
    size, (w_ih, w_hh, b_ih, b_hh) = gru.hidden_size, gru.parameters()
    projected = functional.linear(inputs, w_ih, b_ih).unbind(1)
    state = projected[0].new_zeros(len(inputs), size)
    for frame, gates in enumerate(projected):
        first = frame == 0  # the state is zero: only the bias counts
        hidden = b_hh.to(state.dtype) if first else functional.linear(state, w_hh, b_hh)
        both, new = gates.split((2 * size, size), dim=-1)
        both_h, new_h = hidden.split((2 * size, size), dim=-1)
        reset, update = torch.sigmoid(both + both_h).split(size, dim=-1)
        candidate = torch.tanh(torch.addcmul(new, reset, new_h))
        state = torch.lerp(candidate, state, update)
    return state.float()


def hinge_loss(simulated: torch.Tensor, reference: torch.Tensor) -> torch.Tensor:
    """Hinge loss, the first two terms of eq. 10, averaged over samples and heads.

    Args:
        simulated: scores (B, heads) of simulated windows, pushed below -1.
        reference: scores (B, heads) of reference windows, pushed above 1.

    Returns:
        Scalar.
    """
    return functional.relu(1.0 + simulated).mean() + functional.relu(1.0 - reference).mean()


def imitation_reward(scores: torch.Tensor) -> torch.Tensor:
    """Reward of eq. 11: every head clipped to [-1, 1], then averaged; (B, heads) to (B,)."""
    return scores.clamp(-1.0, 1.0).mean(dim=-1)


class Discriminator(nn.Module):
    """Multi-head network of the paper's fig. (c): pose windows -> GRU -> fully connected layers -> N heads.

    Attributes:
        normalizer: running statistics of the numbers of one frame, shared by the frames.
    """

    def __init__(
        self,
        links: int = 15,
        numbers: int = 7,
        heads: int = 32,
        gru: int = 256,
        hidden: Sequence[int] = (256, 128),
    ) -> None:
        """Build the network with fresh weights.

        Args:
            links: links in a frame.
            numbers: numbers per link (position 3 m, orientation quaternion wxyz 4).
            heads: size of the ensemble (32 in the paper, sec. 7).
            gru: size of the GRU's state (256 in the paper).
            hidden: fully connected layers between the GRU and the heads, ReLU after each.
        """
        super().__init__()
        self.frame_size = links * numbers
        self.normalizer = RunningNormalizer(self.frame_size)
        self.encoder = StateEncoder(self.frame_size, gru)
        sizes = [gru, *hidden]
        self.layers = nn.ModuleList(nn.Linear(a, b) for a, b in zip(sizes[:-1], sizes[1:], strict=True))
        self.heads = nn.Linear(sizes[-1], heads)
        self._initialise()

    def _initialise(self) -> None:
        """Orthogonal layers, zero biases: slopes near those that the penalty asks for, from the start."""
        for layer in (*self.layers, self.heads):
            nn.init.orthogonal_(layer.weight, gain=1.0 if layer is self.heads else math.sqrt(2.0))
            nn.init.zeros_(layer.bias)

    def observe(self, windows: torch.Tensor) -> None:
        """Take windows (B, frames, links, numbers) into the normaliser's statistics, effective at once."""
        self.normalizer.observe(moments_of(windows.flatten(2)))
        self.normalizer.apply_statistics()

    def normalize(self, windows: torch.Tensor) -> torch.Tensor:
        """Pose windows (B, frames, links, numbers) to normalised frames (B, frames, links * numbers)."""
        return self.normalizer(windows.flatten(2))

    def scores(self, frames: torch.Tensor) -> torch.Tensor:
        """Score normalised frames (B, frames, links * numbers): (B, heads)."""
        return self._head_scores(self.encoder(frames))

    def _head_scores(self, features: torch.Tensor) -> torch.Tensor:
        for layer in self.layers:
            features = functional.relu(layer(features))
        return self.heads(features)

    def forward(self, windows: torch.Tensor) -> torch.Tensor:
        """Score pose windows (B, frames, links, numbers): (B, heads)."""
        return self.scores(self.normalize(windows))

    def gradient_norms(self, simulated: torch.Tensor, reference: torch.Tensor) -> torch.Tensor:
        """Gradient norms of eq. 10's last term, at points sampled between simulated and reference frames.

        The gradient is that of the heads' sum, as in the authors' released code: one gradient instead of 32. Asking
        a norm of 1 of every head, as eq. 10 is written, lets scores leave [-1, 1] within a few frames of a start
        state, where the reward's clipping (eq. 11) takes all slope away; the sum keeps them within.

        Args:
            simulated: normalised frames (B, frames, links * numbers).
            reference: the same of reference windows.

        Returns:
            Norms (B,), differentiable; zero with a zero gradient (not NaN) where the network is flat.
        """
        mix = torch.rand(len(simulated), 1, 1, device=simulated.device)
        points = torch.lerp(reference, simulated, mix).detach().requires_grad_()
        scores = self._head_scores(unroll_gru(self.encoder.gru, points))
        (gradient,) = torch.autograd.grad(scores.float().sum(), points, create_graph=True)
        return torch.linalg.vector_norm(gradient.float().flatten(1), dim=1)
