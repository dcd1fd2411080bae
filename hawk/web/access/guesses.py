"""Guesses of the token: each wrong one makes its address wait longer before the next is looked at."""

from __future__ import annotations

import ipaddress
import logging
import time
from collections import OrderedDict
from collections.abc import Callable, MutableMapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from aiohttp import web
from aiohttp.http_exceptions import HttpProcessingError
from aiohttp.web import RequestPayloadError

LINES: Final = 10
PERIOD_S: Final = 60.0
"""`LINES` are logged in each period of this length, real seconds."""

if TYPE_CHECKING:
    _Adapter = logging.LoggerAdapter[logging.Logger]
else:
    _Adapter = logging.LoggerAdapter


class PacedLog(_Adapter):
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


FREE_GUESSES: Final = 5
"""Wrong tokens without a wait: a person mistypes."""
FIRST_WAIT_S: Final = 1.0
LONGEST_WAIT_S: Final = 30.0
"""Real seconds; the wait doubles with each wrong token. An address that guesses on gets two looks a minute."""
FORGOTTEN_S: Final = 600.0
"""Real seconds without a wrong token after which an address begins again."""
ADDRESS_LIMIT: Final = 1024
"""Addresses that are remembered; beyond it the one whose last guess is oldest is forgotten."""


@dataclass(slots=True)
class _Record:
    wrong: int
    last: float
    blocked_until: float


class TokenGuesses:
    """Counts wrong tokens by address. Times are real seconds."""

    def __init__(self, monotonic: Callable[[], float]) -> None:
        self._monotonic = monotonic
        self._records: OrderedDict[str, _Record] = OrderedDict()
        self.total = 0
        """Wrong tokens since the start."""

    def __len__(self) -> int:
        return len(self._records)

    def wait_s(self, address: str) -> float:
        """Return the seconds until a token from this address is looked at; 0 when it is looked at now."""
        record = self._records.get(address)
        return 0.0 if record is None else max(0.0, record.blocked_until - self._monotonic())

    def wrong(self, address: str) -> int:
        """Note a wrong token; return how many have come from this address."""
        now = self._monotonic()
        record = self._records.pop(address, None)
        if record is None or now - record.last > FORGOTTEN_S:
            record = _Record(0, now, now)
        record.wrong += 1
        record.last = now
        over = record.wrong - FREE_GUESSES
        if over > 0:
            record.blocked_until = now + min(LONGEST_WAIT_S, FIRST_WAIT_S * 2.0 ** min(over - 1, 16))
        self._records[address] = record
        self.total += 1
        if len(self._records) > ADDRESS_LIMIT:
            self._records.popitem(last=False)
        return record.wrong

    def right(self, address: str) -> None:
        """Forget the wrong tokens of an address that sent the right one."""
        self._records.pop(address, None)


GUESSES = web.AppKey("guesses", TokenGuesses)


def network_of(host: str | None) -> str:
    """Return the address that counts as one guest: of IPv6 the first 64 bits, which one guest can vary within."""
    address = _address(host)
    if address is None:
        return host or ""
    if isinstance(address, ipaddress.IPv6Address):
        return str(ipaddress.ip_network((address, 64), strict=False).network_address)
    return str(address)


def is_loopback_peer(host: str | None) -> bool:
    """Return True for a request from this computer."""
    address = _address(host)
    return address is not None and address.is_loopback


def _address(host: str | None) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Return the address, of IPv4 where it is mapped into IPv6; None for what is no address."""
    try:
        address = ipaddress.ip_address((host or "").partition("%")[0])
    except ValueError:
        return None
    mapped = address.ipv4_mapped if isinstance(address, ipaddress.IPv6Address) else None
    return mapped or address
