"""A log that a stranger cannot fill: a few lines a minute, and how many were left out."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, MutableMapping
from typing import Any, Final

from aiohttp.http_exceptions import HttpProcessingError
from aiohttp.web import RequestPayloadError

LINES: Final = 10
PERIOD_S: Final = 60.0
"""`LINES` are logged in each period of this length, real seconds."""


class PacedLog(logging.LoggerAdapter[logging.Logger]):
    """Logger for what any client on the network can cause. Lines beyond the pace are counted."""

    def __init__(self, logger: logging.Logger, monotonic: Callable[[], float] = time.monotonic) -> None:
        super().__init__(logger, {})
        self._monotonic = monotonic
        self._begun = float("-inf")
        self._lines = 0
        self._left_out = 0

    def process(self, msg: Any, kwargs: MutableMapping[str, Any]) -> tuple[Any, MutableMapping[str, Any]]:
        """Leave the line as it is."""
        return msg, kwargs

    def log(self, level: int, msg: Any, *args: Any, **kwargs: Any) -> None:
        """Log the line, or count it. A malformed request is named without its traceback and without its content."""
        if not self.isEnabledFor(level) or not self._is_due(level):
            return
        error = kwargs.get("exc_info")
        if isinstance(error, HttpProcessingError | RequestPayloadError):
            kwargs = {**kwargs, "exc_info": None}
            msg, args = f"{msg}: %s", (*args, type(error).__name__)
        super().log(level, msg, *args, **kwargs)

    def _is_due(self, level: int) -> bool:
        now = self._monotonic()
        if now - self._begun >= PERIOD_S:
            if self._left_out:
                super().log(level, "%d more lines of this kind were left out", self._left_out)
            self._begun, self._lines, self._left_out = now, 0, 0
        if self._lines >= LINES:
            self._left_out += 1
            return False
        self._lines += 1
        return True
