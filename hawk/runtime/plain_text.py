"""Text from outside, as it may be shown: what a link, a camera, a program or a file name says is never printed raw.

Terminals and journals obey control characters: an escape sequence recolours, erases or retitles, a line break forges a
line, an override of the writing direction turns words around. They are shown as the escapes that Python writes.
"""

from __future__ import annotations

import unicodedata
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
