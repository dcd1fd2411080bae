"""Text of files: UTF-8, with or without a byte order mark, and UTF-16 with one."""

from __future__ import annotations

from hawk.lots.values import LotInputError


def text_of(data: bytes) -> str:
    """Return the text of a file. Raises LotInputError."""
    encoding = "utf-16" if data.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        raise LotInputError("file", f"is no text in UTF-8 ({error.reason}): save it again in UTF-8") from None
