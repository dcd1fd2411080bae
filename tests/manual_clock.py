from __future__ import annotations

from hawk.comm.clock import Clock


class ManualClock(Clock):
    """A clock that a test moves by hand."""

    def __init__(self, now: float = 0.0) -> None:
        super().__init__(monotonic=lambda: 0.0)
        self.now = now

    def __call__(self) -> float:
        """Return the time that was set."""
        return self.now

    def advance(self, seconds: float) -> None:
        """Move the time forward."""
        if seconds < 0:
            raise ValueError("time does not run backwards")
        self.now += seconds
