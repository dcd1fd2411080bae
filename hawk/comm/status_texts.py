"""STATUSTEXT: long texts put together again, and the words that explain a refusal found."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

from hawk.model import StatusText

_CHUNK = 50
_KEEP = 50
_REASONS = ("arm:", "prearm:")
_ERROR = 4  # MAV_SEVERITY_WARNING and worse


class StatusTexts:
    """Puts texts together from their chunks (MAVLink: id, chunk_seq, 50 characters each) and keeps the last ones."""

    def __init__(self) -> None:
        self._recent: deque[StatusText] = deque(maxlen=_KEEP)
        self._chunks: dict[int, dict[int, str]] = {}

    def take(self, fields: Mapping[str, Any], time: float) -> StatusText | None:
        """Return the whole text when its last chunk came."""
        text = str(fields.get("text") or "").rstrip("\0")
        number = int(fields.get("id") or 0)
        if number:
            chunks = self._chunks.setdefault(number, {})
            chunks[int(fields.get("chunk_seq") or 0)] = text
            if len(text) >= _CHUNK:
                if len(self._chunks) > _KEEP:
                    self._chunks.pop(next(iter(self._chunks)))
                return None
            text = "".join(chunk for _, chunk in sorted(self._chunks.pop(number).items()))
        found = StatusText(time, int(fields.get("severity") or 0), text.strip())
        self._recent.append(found)
        return found

    def reason_since(self, time: float) -> str | None:
        """Return the autopilot's words since then that explain a refusal: arming reasons first, else any warning."""
        recent = [text for text in self._recent if text.time >= time]
        reasons = [text.text for text in recent if text.text.lower().startswith(_REASONS)]
        if not reasons:
            reasons = [text.text for text in recent if text.severity <= _ERROR]
        return "; ".join(dict.fromkeys(reasons)) or None
