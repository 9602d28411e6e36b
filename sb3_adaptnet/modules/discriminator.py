"""Ensemble of discriminators that tell simulated motion from reference motion (the paper's eqs. 10 and 11)."""

from collections.abc import Sequence

import torch
from torch import nn
from torch.nn import functional

from sb3_adaptnet.modules.normalizer import RunningNormalizer, moments_of


def unroll_gru(cell: nn.GRUCell, inputs: torch.Tensor) -> torch.Tensor:
    """Run a GRU cell over a short sequence from a zero state and return the last state.

    Written out because cuDNN's GRU has no second derivative, which the gradient penalty needs, and because one
    product projects the inputs of all frames at once.

    Args:
        cell: The weights.
        inputs: (B, frames, input size), oldest frame first.

    Returns:
        Last hidden state (B, hidden size).
    """
    projected = functional.linear(inputs, cell.weight_ih, cell.bias_ih)
    state = projected.new_zeros(len(inputs), cell.hidden_size)
    for frame in range(inputs.shape[1]):
        reset_in, update_in, new_in = projected[:, frame].chunk(3, dim=-1)
        hidden = functional.linear(state, cell.weight_hh, cell.bias_hh)
        reset_h, update_h, new_h = hidden.chunk(3, dim=-1)
        reset, update = torch.sigmoid(reset_in + reset_h), torch.sigmoid(update_in + update_h)
        candidate = torch.tanh(new_in + reset * new_h)
        state = candidate + update * (state - candidate)
    return state


def hinge_loss(simulated: torch.Tensor, reference: torch.Tensor) -> torch.Tensor:
    """Hinge loss, the first two terms of eq. 10, averaged over samples and heads.

    Args:
        simulated: Scores (B, heads) of simulated windows, pushed below -1.
        reference: Scores (B, heads) of reference windows, pushed above 1.

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
        normalizer: Running statistics of the numbers of one frame, shared by the frames.
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
            links: Links in a frame.
            numbers: Numbers per link (position 3 m, orientation quaternion wxyz 4).
            heads: Size of the ensemble (32 in the paper, sec. 7).
            gru: Size of the GRU's state (256 in the paper).
            hidden: Fully connected layers between the GRU and the heads, ReLU after each.
        """
        super().__init__()
        self.frame_size = links * numbers
        self.normalizer = RunningNormalizer(self.frame_size)
        self.cell = nn.GRUCell(self.frame_size, gru)
        sizes = [gru, *hidden]
        self.layers = nn.ModuleList(nn.Linear(a, b) for a, b in zip(sizes[:-1], sizes[1:], strict=True))
        self.heads = nn.Linear(sizes[-1], heads)

    def observe(self, windows: torch.Tensor) -> None:
        """Take windows (B, frames, links, numbers) into the normaliser's statistics, effective at once."""
        self.normalizer.observe(moments_of(windows.flatten(2)))
        self.normalizer.apply_statistics()

    def normalize(self, windows: torch.Tensor) -> torch.Tensor:
        """Pose windows (B, frames, links, numbers) to normalised frames (B, frames, links * numbers)."""
        return self.normalizer(windows.flatten(2))

    def scores(self, frames: torch.Tensor) -> torch.Tensor:
        """Score normalised frames (B, frames, links * numbers): (B, heads)."""
        features = unroll_gru(self.cell, frames)
        for layer in self.layers:
            features = functional.relu(layer(features))
        return self.heads(features)

    def forward(self, windows: torch.Tensor) -> torch.Tensor:
        """Score pose windows (B, frames, links, numbers): (B, heads)."""
        return self.scores(self.normalize(windows))

    def gradient_norms(self, simulated: torch.Tensor, reference: torch.Tensor) -> torch.Tensor:
        """Gradient norms of eq. 10's last term, at points drawn between simulated and reference frames.

        Every point takes one head drawn at random: an unbiased estimate of the mean over the N heads at the price
        of one gradient instead of N.

        Args:
            simulated: Normalised frames (B, frames, links * numbers).
            reference: The same of reference windows.

        Returns:
            Norms (B,), differentiable; zero (not NaN) with a zero gradient where the network is flat.
        """
        mix = torch.rand(len(simulated), 1, 1, device=simulated.device)
        points = torch.lerp(reference, simulated, mix).detach().requires_grad_()
        scores = self.scores(points)
        chosen = torch.randint(scores.shape[1], (len(scores), 1), device=scores.device)
        (gradient,) = torch.autograd.grad(scores.gather(1, chosen).sum(), points, create_graph=True)
        return torch.linalg.vector_norm(gradient.float().flatten(1), dim=1)
