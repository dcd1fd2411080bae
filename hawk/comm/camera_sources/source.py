"""The face that every source of pictures shows to `hawk.comm.drone_camera`."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from typing import Protocol
from urllib.parse import urlsplit


class CameraError(Exception):
    """The source cannot give pictures; the text names the source, what is wrong and the remedy."""


@dataclass(frozen=True, slots=True)
class SourceFrame:
    """A whole JPEG picture. ``arrival`` on our clock; ``stamp`` is the source's own capture time, if it tells one."""

    jpeg: bytes = field(repr=False)
    arrival: float
    stamp: float | None = None


class CameraSource(Protocol):
    """A source of pictures."""

    def frames(self) -> AsyncIterator[SourceFrame]:
        """Open the source and give its pictures until it ends. Raises CameraError. May be called again afterwards."""
        ...

    @property
    def torn(self) -> int:
        """Pictures that came in pieces and were dropped."""
        ...

    async def close(self) -> None:
        """Let go of the source; what runs for it has ended on return."""
        ...


def without_secrets(url: str) -> str:
    """Return an address without user, password and query: it is shown and logged."""
    try:
        parts = urlsplit(url)
        port = f":{parts.port}" if parts.port else ""
    except ValueError:
        return "an address that cannot be read"
    return f"{parts.scheme}://{parts.hostname or ''}{port}{parts.path}"
