"""Sends the messages of the outbox to each receiver, in their order, until it says yes or seven days are over.

One receiver waits for no other one, and the flight for none: nothing is sent while the motors are on. A receiver
that hangs, redirects or answers without end costs a try.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import logging
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import aiohttp

from hawk.config.secrets import SecretUrl, without
from hawk.config.sections import WebhooksSettings
from hawk.lots.store import LotStore
from hawk.lots.values import LotStoreError
from hawk.model.operation import Level
from hawk.model.sentences import say
from hawk.runtime.late import late
from hawk.webhooks.network import PublicResolver, check_literal

if TYPE_CHECKING:
    from hawk.lots.outbox import Message

if TYPE_CHECKING:  # loaded on the store's thread
    from hawk.lots import outbox
    from hawk.webhooks import signature
else:
    outbox = late("hawk.lots.outbox")
    signature = late("hawk.webhooks.signature")

_LOG = logging.getLogger(__name__)
WARNED_AT: Final = 6
"""Failed tries of a message at which the operator hears of it: twenty minutes."""
LARGEST_ANSWER: Final = 64 * 1024
"""Bytes of an answer that are read; the connection is closed then."""


@dataclass(frozen=True, slots=True)
class SenderTimes:
    """Real seconds: between two looks into the outbox, and for a whole try."""

    look_s: float = 10.0
    try_s: float = 20.0


class WebhookSender:
    """`run` belongs to the loop."""

    def __init__(
        self,
        store: LotStore,
        settings: WebhooksSettings,
        wall: Callable[[], float],
        is_flown: Callable[[], bool],
        add_message: Callable[[Level, str, str], object],
        times: SenderTimes | None = None,
    ) -> None:
        """Take the parts; nothing runs before `run`.

        Args:
            store: The store whose outbox is sent.
            settings: Receivers and secret.
            wall: UTC, Unix seconds.
            is_flown: Returns True while the motors are on.
            add_message: Adds a message for the operator: level, text, details.
            times: Intervals.
        """
        self._store = store
        self._settings = settings
        self._wall = wall
        self._is_flown = is_flown
        self._add_message = add_message
        self._times = times or SenderTimes()

    async def run(self) -> None:
        """Send until cancelled; without receivers wait for that."""
        if not self._settings.urls:
            await asyncio.Event().wait()
        async with _session(self._settings, self._times) as session, asyncio.TaskGroup() as group:
            for url in self._settings.urls:
                group.create_task(self._serve(session, url), name="webhook")

    async def _serve(self, session: aiohttp.ClientSession, url: SecretUrl) -> None:
        while True:
            try:
                while not self._is_flown() and await self.send_one(session, url):
                    pass
            except LotStoreError as error:
                _LOG.warning("webhooks: the outbox cannot be read: %s", error)
            except Exception:  # an error with one receiver must not end the others
                _LOG.exception("webhook %s failed", url.host)
            await asyncio.sleep(self._times.look_s)

    async def send_one(self, session: aiohttp.ClientSession, url: SecretUrl) -> bool:
        """Try the next message that is due for a receiver; return False when there was none. Raises LotStoreError."""
        await self._store.open()
        target, now = target_of(url), self._wall()
        message = await self._store.read(lambda c: outbox.due(c, target, now))
        if message is None:
            return False
        try:
            body = signature.body_of(message)
        except (ValueError, OverflowError, OSError) as error:  # a damaged row must not hold up what follows
            await self._store.write(lambda c: outbox.give_up(c, message, target, now))
            self._report_damaged(url, message, str(error))
            return True
        headers = signature.headers_of(message, body, signature.key_of(self._key()), now)
        problem = await self._tried(session, url, body, headers)
        now = self._wall()
        if not problem:
            await self._store.write(lambda c: outbox.note_sent(c, message, target, now))
            return True
        is_over = await self._store.write(lambda c: outbox.note_failed(c, message, target, now))
        self._report(url, message, problem, is_over=is_over)
        return True

    async def _tried(self, session: aiohttp.ClientSession, url: SecretUrl, body: bytes, headers: dict[str, str]) -> str:
        """Return why a try failed; nothing when the receiver said yes."""
        try:
            if not self._settings.allow_private:
                check_literal(url.get_secret_value())
            async with asyncio.timeout(self._times.try_s):
                async with session.post(
                    url.get_secret_value(), data=body, headers=headers, allow_redirects=False
                ) as answer:
                    await answer.content.read(LARGEST_ANSWER)
                    answer.close()  # whatever more it says
                    return "" if 200 <= answer.status < 300 else _refused(answer)
        except TimeoutError:
            return f"gave no answer within {self._times.try_s:g} s"
        except (aiohttp.ClientError, OSError, ValueError) as error:
            cause = error.__cause__ if isinstance(error.__cause__, OSError) else error
            return without(str(cause), url.secrets()) or type(error).__name__

    def _key(self) -> str:
        return "" if self._settings.secret is None else self._settings.secret.get_secret_value()

    def _report_damaged(self, url: SecretUrl, message: Message, problem: str) -> None:
        name = url.host
        _LOG.error("webhook %s: message %d is damaged in the store: %s", name, message.seq, problem)
        words = say("A report to the receiver {name} is damaged in the store: it is left out.", name=name)
        self._add_message("warning", words, problem)

    def _report(self, url: SecretUrl, message: Message, problem: str, *, is_over: bool) -> None:
        name = url.host
        _LOG.warning("webhook %s: try %d of message %d: %s", name, message.tries + 1, message.seq, problem)
        if is_over:
            words = say("The receiver {name} got no message for seven days: a report to it is given up.", name=name)
            self._add_message("warning", words, problem)
        elif message.tries + 1 == WARNED_AT:
            self._add_message(
                "warning", say("The receiver {name} takes no report; it is tried on.", name=name), problem
            )


def _refused(answer: aiohttp.ClientResponse) -> str:
    if 300 <= answer.status < 400:
        return f"redirects (HTTP {answer.status}): write its final address into webhooks.urls"
    return f"answered HTTP {answer.status}"


def target_of(url: SecretUrl) -> str:
    """Return the name of a receiver in the store, which does not show its address."""
    return hashlib.sha256(url.get_secret_value().encode()).hexdigest()[:16]


@contextlib.asynccontextmanager
async def _session(settings: WebhooksSettings, times: SenderTimes) -> AsyncIterator[aiohttp.ClientSession]:
    resolver = None if settings.allow_private else PublicResolver()
    connector = aiohttp.TCPConnector(resolver=resolver, limit_per_host=1, force_close=True)
    timeout = aiohttp.ClientTimeout(total=times.try_s)
    async with aiohttp.ClientSession(
        connector=connector,
        timeout=timeout,
        auto_decompress=False,
        trust_env=False,
        cookie_jar=aiohttp.DummyCookieJar(),
    ) as session:
        yield session
