"""Lines of a log: what stays wrong is logged once a minute at most, and what others sent is shown as plain text."""

from __future__ import annotations

import time
import unicodedata
from collections import OrderedDict
from collections.abc import Callable
from typing import Final

_HIDDEN: Final = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})
"""Unicode categories that are not shown: controls, formats (direction, zero width), halves, private, line ends."""


def plain(text: str) -> str:
    r"""Return a text in one line with ``\x1b``, ``\n``, ``\u202e`` for what is obeyed and not shown."""
    if text.isascii() and text.isprintable():
        return text
    if not any(unicodedata.category(each) in _HIDDEN for each in text):
        return text
    return "".join(_escaped(each) if unicodedata.category(each) in _HIDDEN else each for each in text)


def plain_lines(text: str) -> str:
    """Return a text of several lines, each of them plain; tabs become spaces."""
    return "\n".join(plain(line.replace("\t", "    ")) for line in text.split("\n"))


def _escaped(character: str) -> str:
    if unicodedata.category(character) == "Cs" and "\udc80" <= character <= "\udcff":
        return f"\\x{ord(character) - 0xDC00:02x}"  # a byte that was no text (surrogateescape)
    return character.encode("unicode_escape", "surrogatepass").decode("ascii")


EVERY_S: Final = 60.0
"""Real seconds between two lines of the same words."""
_REMEMBERED: Final = 64
"""Different lines that are remembered; the one that was said longest ago is forgotten first."""


class Repeated:
    """Says which lines are due. Any thread may call it: a line too many is no harm."""

    def __init__(self, monotonic: Callable[[], float] = time.monotonic) -> None:
        self._monotonic = monotonic
        self._said: OrderedDict[str, tuple[float, int]] = OrderedDict()

    def due(self, line: str) -> str | None:
        """Return the line when it is new or was said a minute ago, with how often it came since; else None."""
        now = self._monotonic()
        since, times = self._said.get(line, (-EVERY_S, 0))
        if now - since < EVERY_S:
            self._said[line] = (since, times + 1)
            return None
        self._said[line] = (now, 0)
        self._said.move_to_end(line)
        if len(self._said) > _REMEMBERED:
            self._said.popitem(last=False)
        return f"{line} ({times} times more in the last {now - since:.0f} s)" if times else line

    def ends(self) -> None:
        """Forget all lines: the fault is over, and the next one is logged at once."""
        self._said.clear()
