"""Numeric precision of the networks' products: fp32, fp32 with short products, bf16."""

from contextlib import AbstractContextManager, nullcontext

import torch

PRECISIONS = ("fp32", "medium", "bf16")
"""Names of the precisions, most exact first; what each does stands at `use_precision`."""


def has_bf16(device: torch.device | str = "cpu") -> bool:
    """Whether the device multiplies bfloat16 matrices in hardware (AMX or AVX512-BF16 on a CPU)."""
    if torch.device(device).type == "cuda":
        return torch.cuda.is_bf16_supported()
    capabilities = torch.cpu.get_capabilities() if hasattr(torch.cpu, "get_capabilities") else {}
    return bool(capabilities.get("amx_bf16") or capabilities.get("avx512_bf16"))


def chosen_precision(name: str, device: torch.device | str = "cpu") -> str:
    """The precision that a name stands for on a device; nothing is set.

    Args:
        name: "fp32", "medium" (fp32 whose products may use bfloat16 inside), "bf16" (bfloat16 autocast around the
            trunk; heads and log-probabilities stay fp32) or "auto" (bf16 where the device has it, else fp32).
        device: where the networks live.

    Returns:
        "fp32", "medium" or "bf16": "bf16" falls back to "fp32" where the device lacks it.

    Raises:
        ValueError: if the name is none of these.
    """
    if name not in (*PRECISIONS, "auto"):
        raise ValueError(f"unknown precision {name!r}; choose one of: {', '.join((*PRECISIONS, 'auto'))}")
    chosen = "bf16" if name == "auto" else name
    return "fp32" if chosen == "bf16" and not has_bf16(device) else chosen


def use_precision(name: str, device: torch.device | str = "cpu") -> str:
    """`chosen_precision`, after the process's products were set to it."""
    chosen = chosen_precision(name, device)
    torch.set_float32_matmul_precision("medium" if chosen == "medium" else "highest")
    return chosen


def autocast(device: torch.device | str, precision: str) -> AbstractContextManager:
    """Context in which the products of a network run in `precision`."""
    if precision != "bf16":
        return nullcontext()
    return torch.autocast(torch.device(device).type, dtype=torch.bfloat16)
