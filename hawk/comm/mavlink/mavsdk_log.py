"""MAVSDK's own lines go into our log, whatever bytes they hold.

MAVSDK's Python package decodes a line as UTF-8 before it asks for it; where that fails it prints the bytes to the
terminal, and a word of its own to the standard output. STATUSTEXT stands in such lines, as the autopilot sent it.
"""

from __future__ import annotations

import contextlib
import logging
from typing import Any, Final

from mavsdk.logging import LogCallback, LogLevel, _cmavsdk_lib, log_unsubscribe

from hawk.runtime.repeated_log import Repeated, plain

_LOG = logging.getLogger("hawk.comm.mavsdk")
_LEVELS: Final = {
    LogLevel.DEBUG: logging.DEBUG,
    LogLevel.INFO: logging.INFO,
    LogLevel.WARN: logging.WARNING,
    LogLevel.ERROR: logging.ERROR,
}


class MavsdkLog:
    """Takes MAVSDK's lines from `subscribe` to `unsubscribe`; it repeats some with every attempt."""

    def __init__(self) -> None:
        self._repeated = Repeated()
        self._callback = LogCallback(self._take)  # MAVSDK keeps no reference

    def subscribe(self) -> None:
        """Take the lines of the process from now on."""
        _cmavsdk_lib.mavsdk_log_subscribe(self._callback, None)

    def unsubscribe(self) -> None:
        """Give the lines back."""
        log_unsubscribe()

    def _take(self, level: int, message: bytes | None, _file: Any, _line: int, _user: Any) -> bool:
        """Log a line; True: MAVSDK prints nothing itself. It is called by native code, so nothing may be raised."""
        with contextlib.suppress(Exception):
            line = self._repeated.due(plain((message or b"").decode("utf-8", "backslashreplace")))
            if line is not None:
                _LOG.log(_LEVELS.get(level, logging.INFO), "%s", line)
        return True
