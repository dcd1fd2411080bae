"""A moment that outlives this program, and that a step of the wall clock does not move."""

from __future__ import annotations

import ctypes
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

BOOT_ID: Final = Path("/proc/sys/kernel/random/boot_id")
"""A name that the kernel draws at each boot (random(4))."""


@dataclass(frozen=True, slots=True)
class Moment:
    """A moment on this computer's clocks. Within one boot ``seconds`` decides; ``utc`` is a second witness only."""

    boot_id: str = ""
    """The kernel's name of this boot; empty when it is not known."""
    seconds: float = 0.0
    """Seconds since this boot, suspended time included (CLOCK_BOOTTIME); below 0 for a moment before it."""
    utc: float = 0.0
    """Wall clock, Unix seconds. It may be wrong, and it steps."""

    def since(self, earlier: Moment) -> float | None:
        """Return the seconds since another moment of the same boot; None when it is of another boot, or unknown."""
        if not self.boot_id or self.boot_id != earlier.boot_id:
            return None
        return self.seconds - earlier.seconds

    def before(self, seconds: float) -> Moment:
        """Return the moment that many seconds earlier."""
        return replace(self, seconds=self.seconds - seconds, utc=self.utc - seconds)


_CLOCK_ERROR: Final = 5  # TIME_ERROR of adjtimex(2): nothing keeps the clock right
_TIMEX_BYTES: Final = 512
"""More than struct timex; all zero it asks for the state alone."""


def is_wall_clock_kept() -> bool:
    """Return False when the kernel knows that no time server and no GNSS receiver keeps its clock right."""
    try:
        state = ctypes.CDLL(None).adjtimex(ctypes.create_string_buffer(_TIMEX_BYTES))
    except (OSError, AttributeError):
        return True
    return bool(state != _CLOCK_ERROR)


UNKNOWN_MOMENT: Final = Moment()


def this_moment() -> Moment:
    """Return the moment now, by the kernel's clocks."""
    try:
        boot_id = BOOT_ID.read_text("ascii").strip()
    except (OSError, ValueError):
        boot_id = ""  # no moment of it is taken for one of the same boot
    return Moment(boot_id, time.clock_gettime(time.CLOCK_BOOTTIME), time.time())
