"""Guesses of tokens: each wrong one makes its address wait longer before the next is looked at.

A guess is another value each time. A program that goes on with one that is not right any more guesses nothing.
"""

from __future__ import annotations

import hashlib
import ipaddress
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from aiohttp import web

FREE_GUESSES: Final = 5
"""Wrong tokens without a wait: a person mistypes."""
FIRST_WAIT_S: Final = 1.0
LONGEST_WAIT_S: Final = 30.0
"""Real seconds; the wait doubles with each wrong token. An address that guesses on gets two looks a minute."""
FORGOTTEN_S: Final = 600.0
"""Real seconds without a wrong token after which an address begins again."""
SEEN: Final = 16
"""Wrong values of an address that are known again, as hashes; more than it may send before it waits."""
ADDRESS_LIMIT: Final = 1024
"""Addresses that are remembered; beyond it the one whose last guess is oldest is forgotten."""


@dataclass(slots=True)
class _Record:
    wrong: int
    last: float
    blocked_until: float
    seen: list[bytes] = field(default_factory=list)
    passed_over: int = 0


class TokenGuesses:
    """Counts wrong values of one kind of token by address. Times are real seconds."""

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

    def wrong(self, address: str, value: str) -> int:
        """Note a wrong token; return how many have come from this address, each counted once."""
        now = self._monotonic()
        record = self._records.pop(address, None)
        if record is None or now - record.last > FORGOTTEN_S:
            record = _Record(0, now, now)
        self._records[address] = record
        digest = hashlib.sha256(value.encode("utf-8", "surrogatepass")).digest()
        if digest in record.seen:
            return record.wrong
        record.seen = [*record.seen, digest][-SEEN:]
        record.wrong += 1
        record.last = now
        over = record.wrong - FREE_GUESSES
        if over > 0:
            record.blocked_until = now + min(LONGEST_WAIT_S, FIRST_WAIT_S * 2.0 ** min(over - 1, 16))
        self.total += 1
        if len(self._records) > ADDRESS_LIMIT:
            self._records.popitem(last=False)
        return record.wrong

    def pass_over(self, address: str) -> None:
        """Count what came from an address that waits, and was not looked at."""
        if (record := self._records.get(address)) is not None:
            record.passed_over += 1

    def take_passed_over(self, address: str) -> int:
        """Return how many were passed over since the last call."""
        record = self._records.get(address)
        if record is None:
            return 0
        count, record.passed_over = record.passed_over, 0
        return count

    def right(self, address: str) -> None:
        """Forget the wrong tokens of an address that sent the right one."""
        self._records.pop(address, None)


GUESSES = web.AppKey("guesses", TokenGuesses)
"""Of tokens of a role."""
LINK_GUESSES = web.AppKey("link guesses", TokenGuesses)
"""Of links: they hold up no token, and tokens no link."""


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
