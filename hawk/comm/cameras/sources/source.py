"""The face of every camera source to `hawk.comm.cameras.drone_camera`."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import AsyncGenerator
from dataclasses import dataclass, field
from typing import Final
from urllib.parse import urlsplit

_USER: Final = re.compile(r"://[^/\s@]+@")
_PASSWORD: Final = re.compile(r"(?i)\b([\w-]*(?:pw|passw(?:or)?d|pwd|token|secret)\s*=\s*)(\"[^\"]*\"|[^\s&]+)")


class CameraError(Exception):
    """The source cannot give pictures; the text names the source, the problem and the remedy."""


@dataclass(frozen=True, slots=True)
class SourceFrame:
    """A whole JPEG picture. The source gives ``captured``, or ``stamp``, or neither."""

    jpeg: bytes = field(repr=False)
    arrival: float
    """Seconds of the daemon's clock."""
    stamp: float | None = None
    """Capture time in seconds of the source's own clock, when it sends one."""
    captured: float | None = None
    """Capture time in seconds of the daemon's clock, where the source knows it."""


class CameraSource(ABC):
    """A source of pictures."""

    torn: int = 0
    """Pictures that were damaged or cut and dropped."""

    @abstractmethod
    def frames(self) -> AsyncGenerator[SourceFrame, None]:
        """Open the source and give its pictures until it ends. Raises CameraError. May be called again afterwards."""

    async def close(self) -> None:  # noqa: B027 - most sources need nothing beyond the end of `frames`
        """Release the source; its threads and processes have ended on return."""


def without_secrets(url: str) -> str:
    """Return an address without user, password and query, to show and to log."""
    try:
        parts = urlsplit(url)
        port = f":{parts.port}" if parts.port else ""
    except ValueError:
        return "an address that cannot be read"
    return f"{parts.scheme}://{parts.hostname or ''}{port}{parts.path}"


def without_passwords(text: str) -> str:
    """Return a program's words without the users of addresses and without values that are named as passwords."""
    return _PASSWORD.sub(r"\1***", _USER.sub("://", text))
