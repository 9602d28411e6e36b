"""The state encoder: a GRU over the frames of the history (paper, sec. 7)."""

import torch
from torch import nn

from sb3_adaptnet.modules.layers.gru import last_state


class StateEncoder(nn.Module):
    """GRU over normalised frames; its code is the last hidden state.

    Attributes:
        gru: weights: input frame_size, hidden gru_size, one layer, batch first.
    """

    def __init__(self, frame_size: int, gru_size: int) -> None:
        super().__init__()
        self.gru = nn.GRU(frame_size, gru_size, batch_first=True)

    def forward(self, frames: torch.Tensor) -> torch.Tensor:
        """Encode normalised frames (B, frame_count, frame_size), oldest first, as (B, gru_size), float32."""
        if frames.is_cuda:  # cuDNN's own is the fast one there
            return self.gru(frames)[1][0].float()
        return last_state(frames, self.gru)
