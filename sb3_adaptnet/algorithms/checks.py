"""What numbers and choices of SVG must be."""

from numbers import Integral

from sb3_adaptnet.objectives.schedule import Schedule, highest


def check_positive(**numbers: int) -> None:
    """Refuse numbers of things of which there must be one.

    Raises:
        ValueError: for one below 1, with its name.
    """
    for name, number in numbers.items():
        if number < 1:
            raise ValueError(f"{name} is {number}, expected at least 1")


def check_window(window: int, steps: int) -> None:
    """Refuse a window that a rollout of so many steps does not have.

    Raises:
        ValueError: for one below 1 or above `steps`.
    """
    if not 0 < window <= steps:
        raise ValueError(f"window is {window}, expected 1 to n_steps, which is {steps}")


def check_batch(batch_size: int | None, worlds: int | None) -> int | None:
    """The batch size itself.

    Raises:
        ValueError: for one below 1, or above the number of worlds where that is known.
    """
    number = isinstance(batch_size, Integral) and not isinstance(batch_size, bool)
    if batch_size is not None and not (number and 0 < batch_size <= (worlds or batch_size)):
        most = "the number of worlds" if worlds is None else f"{worlds}, the number of worlds"
        raise ValueError(f"batch_size is {batch_size!r}, expected 1 to {most}, or None for all")
    return batch_size


def check_symmetry(symmetry: Schedule, mirror: bool) -> None:
    """Refuse a loss of what is done in a mirror without one.

    Raises:
        ValueError: for a weight that is not always 0, unless there is a mirror.
    """
    if highest(symmetry) > 0 and not mirror:
        raise ValueError(f"symmetry {symmetry!r} is of what is done in the mirror, so mirror must be True")


def flag(name: str, value: bool) -> bool:
    """The value itself.

    Raises:
        ValueError: if it is neither True nor False: "no" would count as yes.
    """
    if not isinstance(value, bool):
        raise ValueError(f"{name} is {value!r}, expected True or False")
    return value
