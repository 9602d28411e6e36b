"""The text of a BVH file as words and rows of numbers; every complaint names file and line."""

from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from adapt_envs.motion.clip import MotionError

_MAX_NUMBER = 1e7
"""Larger numbers, in any unit, are not believed."""


class BvhWords:
    """Words of a text with their lines, one at a time.

    Attributes:
        path: the file, for messages.
        lines: its lines.
        line: number of the line that the last word came from; the first is 1.
    """

    def __init__(self, path: Path, text: str) -> None:
        """Stand before the first word of `text`."""
        self.path, self.lines = path, text.splitlines()
        self.line = 0
        self._words = self._stream()
        self._next: tuple[int, str] | None = None  # read already, and given back

    def _stream(self) -> Iterator[str]:
        for number, line in enumerate(self.lines, start=1):
            for word in line.replace("{", " { ").replace("}", " } ").split():
                self.line = number
                yield word

    def fail(self, problem: str, line: int | None = None) -> NoReturn:
        """Complain about a line, or about the present one.

        Raises:
            MotionError: always.
        """
        raise MotionError(f"{self.path}: line {line or self.line}: {problem}")

    def word(self, wanted: str) -> str:
        """The next word; `wanted` says what for, should the file end here."""
        if self._next is not None:
            (self.line, word), self._next = self._next, None
            return word
        for word in self._words:
            return word
        self.fail(f"the file ends where {wanted} should follow", len(self.lines))

    def expect(self, *choices: str) -> str:
        """The next word in capitals, which must be one of `choices`."""
        word = self.word(" or ".join(choices))
        if word.upper() not in choices:
            self.fail(f"found {word[:40]!r} where {' or '.join(choices)} should stand")
        return word.upper()

    def number(self, wanted: str) -> float:
        """The next word as a finite number of a sane size; `wanted` says of what."""
        word = self.word(wanted)
        try:
            value = float(word)
        except ValueError:
            self.fail(f"found {word[:40]!r} where {wanted} should stand")
        if not np.isfinite(value) or abs(value) > _MAX_NUMBER:
            self.fail(f"{wanted} is {word[:40]}")
        return value

    def name(self) -> str:
        """What is left of this line up to a brace: names may hold spaces."""
        line, words = self.line, list[str]()
        while (word := self.word("a name and {")) != "{" and self.line == line:
            words.append(word)
        self._next, self.line = (self.line, word), line
        if not words:
            self.fail("a joint without a name")
        return " ".join(words)

    def rows(self, count: int, width: int) -> NDArray[np.float64]:
        """The numbers (count, width) of the lines that are left, one frame to a line."""
        first = self.line  # lines before it are read
        numbered = [i for i, line in enumerate(self.lines[first:], start=first + 1) if line and not line.isspace()]
        if len(numbered) > count:
            self.fail(f"more lines than the {count} frames declared", numbered[count])
        if len(numbered) < count and numbered and len(self.lines[numbered[-1] - 1].split()) == width:
            self.fail(f"the file ends after {len(numbered)} of {count} frames", numbered[-1])
        if not numbered:
            self.fail(f"the file ends before the first of {count} frames", len(self.lines))
        numbers = np.empty((len(numbered), width))
        for row, line in zip(numbers, numbered, strict=True):
            row[:] = self._row(line, width)
        return numbers

    def _row(self, line: int, width: int) -> NDArray[np.float64]:
        words = self.lines[line - 1].split()
        if len(words) != width:
            self.fail(f"{len(words)} numbers, the hierarchy has {width} channels", line)
        try:
            values = np.array(words, dtype=np.float64)
        except ValueError:
            word = next(word for word in words if not _is_number(word))
            self.fail(f"{word[:40]!r} is not a number", line)
        sane = np.abs(values) <= _MAX_NUMBER
        if not sane.all():
            channel = int(np.argmin(sane))
            self.fail(f"channel {channel + 1} is {words[channel][:40]}", line)
        return values


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
