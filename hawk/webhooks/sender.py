"""Sends the messages of the outbox to each receiver, in their order, until it says yes or seven days are over.

One receiver waits for no other one, and the flight for none: nothing is sent while the motors are on.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import logging
from collections.abc import AsyncIterator, Callable
from functools import partial
from typing import TYPE_CHECKING

import aiohttp

from hawk.config.secrets import SecretUrl
from hawk.config.sections import WebhooksSettings
from hawk.lots.store import LotStore
from hawk.model.operation import Level
from hawk.model.sentences import say
from hawk.runtime.late import late
from hawk.webhooks.delivery import WARNED_AT, SenderTimes, keep_sending, tried
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
        send, may_send = partial(self.send_one, session, url), lambda: not self._is_flown()
        await keep_sending(f"webhook {url.host}", may_send, send, self._times.look_s)

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
        except OSError as error:
            return str(error)
        seconds = self._times.try_s
        return (await tried(session, "POST", url, seconds, "webhooks.urls", data=body, headers=headers)).problem

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
