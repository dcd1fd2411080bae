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


class Doubt:
    """Times in seconds. While there is no doubt ask `begins`, else `ends`."""

    def __init__(self, confirm_s: float, agrees_s: float) -> None:
        """``confirm_s``: a disagreement that lasts this long is a doubt. ``agrees_s``: an agreement ends it after."""
        self._confirm_s = confirm_s
        self._agrees_s = agrees_s
        self._beyond, self._agreed = Stopwatch(), Stopwatch()
        self._since: float | None = None

    @property
    def holds(self) -> bool:
        """True while the reading is doubted."""
        return self._since is not None

    def seconds(self, now: float) -> float | None:
        """Return the time since the doubt began; None without one."""
        return None if self._since is None else now - self._since

    def begins(self, now: float, *, is_beyond: bool, is_sure: bool = False) -> bool:
        """Take a look at the disagreement; return True when the doubt begins by it, at once where it ``is_sure``."""
        beyond_s = self._beyond.update(is_beyond, now)
        if beyond_s is None or (beyond_s < self._confirm_s and not is_sure):
            return False
        # the disagreement stays confirmed: one that is back at once, after the end, is a doubt at once
        self._since, self._agreed = now, Stopwatch()
        return True

    def ends(self, now: float, *, agrees: bool) -> bool:
        """Take a look at the agreement; return True when the doubt ends by it."""
        agreed_s = self._agreed.update(agrees, now)
        if agreed_s is None or agreed_s < self._agrees_s:
            return False
        self._since = None
        return True
