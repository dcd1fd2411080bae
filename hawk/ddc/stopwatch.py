"""For how long a condition holds."""

from __future__ import annotations


class Stopwatch:
    """Times how long a condition has held."""

    def __init__(self) -> None:
        self._since: float | None = None

    def update(self, holds: bool, now: float) -> float | None:
        """Return the seconds since the condition began to hold; None while it does not."""
        if not holds:
            self._since = None
        elif self._since is None:
            self._since = now
        return self.read(now)

    def read(self, now: float) -> float | None:
        """Return the seconds since the condition began to hold, as of the last update."""
        return None if self._since is None else now - self._since
