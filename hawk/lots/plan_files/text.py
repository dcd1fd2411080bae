"""Text of files: UTF-8, with or without a byte order mark, and UTF-16 with one."""

from __future__ import annotations

from hawk.formats.text import decoded
from hawk.lots.values import LotInputError


def text_of(data: bytes) -> str:
    """Return the text of a file. Raises LotInputError."""
    try:
        return decoded(data)
    except UnicodeDecodeError as error:
        raise LotInputError("file", f"is no text in UTF-8 ({error.reason}): save it again in UTF-8") from None
