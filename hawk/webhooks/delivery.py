"""Delivery of what the outbox holds: one try with its outcome, and the loop of tries.

A receiver that hangs, redirects or answers without end costs a try.
"""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import aiohttp

from hawk.config.secrets import SecretUrl, without
from hawk.lots.values import LotStoreError

_LOG = logging.getLogger(__name__)
WARNED_AT: Final = 6
"""Failed tries of a message at which the operator hears of it: twenty minutes."""
PROBLEM: Final = "application/problem+json"
LONGEST_SAID: Final = 300
"""Characters of a receiver's words that are shown."""
LARGEST_ANSWER: Final = 64 * 1024
"""Bytes of an answer that are read; the connection is closed then."""


@dataclass(frozen=True, slots=True)
class SenderTimes:
    """Real seconds: between two looks into the outbox, and for a whole try."""

    look_s: float = 10.0
    try_s: float = 20.0


@dataclass(frozen=True, slots=True)
class TryOutcome:
    """Outcome of a try. ``status``: of the answer, 0 without one; ``problem``: why it failed, "" for a yes.

    ``said``: the receiver's own words, of a problem as RFC 9457 has it, and ``named``, the field that is wrong.
    ``data``: the answer, of a yes, and its ``headers``.
    """

    status: int
    problem: str = ""
    said: str = ""
    named: str = ""
    data: bytes = field(default=b"", repr=False)
    headers: Mapping[str, str] = field(default_factory=dict, repr=False)


async def tried(
    session: aiohttp.ClientSession, method: str, url: SecretUrl, seconds: float, setting: str,
    largest: int = LARGEST_ANSWER, **request: Any
) -> TryOutcome:  # fmt: skip
    """Send a request once.

    Args:
        session: Sends it.
        method: Its method.
        url: Its address.
        seconds: Real seconds after which it is given up.
        setting: The setting that names the address.
        largest: Bytes of the answer that are read.
        request: Further arguments of aiohttp's.
    """
    try:
        async with asyncio.timeout(seconds):
            async with session.request(method, url.get_secret_value(), allow_redirects=False, **request) as answer:
                data = await _start_of(answer.content, largest)
                answer.close()  # whatever more it says
                if 200 <= answer.status < 300:
                    return TryOutcome(answer.status, data=data, headers=answer.headers)
                return TryOutcome(answer.status, _refused(answer, setting), *_said(answer, data))
    except TimeoutError:
        return TryOutcome(0, f"gave no answer within {seconds:g} s")
    except (aiohttp.ClientError, OSError, ValueError) as error:
        cause = error.__cause__ if isinstance(error.__cause__, OSError) else error
        return TryOutcome(0, without(str(cause), url.secrets()) or type(error).__name__)


async def _start_of(content: aiohttp.StreamReader, largest: int) -> bytes:
    """Return what an answer says, up to a number of bytes."""
    found = bytearray()
    async for part in content.iter_chunked(LARGEST_ANSWER):
        found += part
        if len(found) >= largest:
            break
    return bytes(found[:largest])


async def keep_sending(
    name: str, may_send: Callable[[], bool], send_one: Callable[[], Awaitable[bool]], look_s: float
) -> None:
    """Send what is due until cancelled. ``send_one`` returns False when nothing is, or the receiver is not there."""
    while True:
        try:
            while may_send() and await send_one():
                pass
        except LotStoreError as error:
            _LOG.warning("%s: the outbox cannot be read: %s", name, error)
        except Exception:  # an error with one receiver must not end the others
            _LOG.exception("%s failed", name)
        await asyncio.sleep(look_s)


def _said(answer: aiohttp.ClientResponse, data: bytes) -> tuple[str, str]:
    """Return what a problem says, in one line, and the field that it means; "" for another answer."""
    if answer.content_type != PROBLEM:
        return "", ""
    try:
        found = json.loads(data)
        named = str(found.get("field", ""))
        return " ".join(f"{named} {found['detail']}".split())[:LONGEST_SAID], named
    except (ValueError, KeyError, AttributeError, RecursionError):
        return "", ""


def _refused(answer: aiohttp.ClientResponse, setting: str) -> str:
    if 300 <= answer.status < 400:
        return f"redirects (HTTP {answer.status}): write its final address into {setting}"
    return f"answered HTTP {answer.status}"
