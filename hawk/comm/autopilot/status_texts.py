"""The autopilot's words: STATUSTEXT, put together from its chunks."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any, Final

from hawk.model.vehicle import StatusText
from hawk.runtime.repeated_log import plain

_WARNING: Final = 4  # MAV_SEVERITY_WARNING
_CHUNK: Final = 50  # bytes of a STATUSTEXT
_TEXTS_KEPT: Final = 50
_REASONS: Final = ("arm:", "prearm:")


class StatusTexts:
    """Assembles texts from their chunks (MAVLink: id, chunk_seq, 50 bytes each) and keeps the last ones."""

    def __init__(self) -> None:
        self._recent: deque[StatusText] = deque(maxlen=_TEXTS_KEPT)
        self._chunks: dict[int, dict[int, str]] = {}

    def take(self, fields: Mapping[str, Any], time: float) -> StatusText | None:
        """Take a STATUSTEXT; return the whole text with its last chunk, else None."""
        text = str(fields.get("text") or "").rstrip("\0")
        number = int(fields.get("id") or 0)
        if number:
            chunks = self._chunks.setdefault(number, {})
            chunks[int(fields.get("chunk_seq") or 0)] = text
            if _size(text) >= _CHUNK:
                if len(self._chunks) > _TEXTS_KEPT:
                    self._chunks.pop(next(iter(self._chunks)))
                return None
            text = "".join(chunk for _, chunk in sorted(self._chunks.pop(number).items()))
        found = StatusText(time, int(fields.get("severity") or 0), plain(text.strip()))
        self._recent.append(found)
        return found

    def reason_since(self, time: float) -> str | None:
        """Return the words since then that explain a refusal: arming reasons, else any warning, else None."""
        recent = [text for text in self._recent if text.time >= time]
        reasons = [text.text for text in recent if text.text.lower().startswith(_REASONS)]
        if not reasons:
            reasons = [text.text for text in recent if text.severity <= _WARNING]
        return "; ".join(dict.fromkeys(reasons)) or None


def _size(text: str) -> int:
    """Return the bytes that a chunk had. MAVSDK gives U+FFFD for each byte that was no UTF-8."""
    return sum(1 if each == "\ufffd" else len(each.encode("utf-8", "surrogatepass")) for each in text)
