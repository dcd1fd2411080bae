"""Sends surveys as documents to the desk that collects them: the newest state first, then the oldest, until it has all.

A document is made of the store when it is sent. The desk commits, and then answers: a program that is killed before it
notes the answer sends the document again, and gets the same answer. While the desk is not there, the waits grow to a
minute, and nothing is given up. A document that the desk refuses holds up no other one.
"""

from __future__ import annotations

import asyncio
import logging
import ssl
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar

import aiohttp

from hawk.config.secrets import SecretUrl
from hawk.config.sections import CollectSettings
from hawk.lots.store import FILE_S, LotStore
from hawk.lots.values import LotStoreError, NotFoundError
from hawk.model.operation import Level
from hawk.model.sentences import say
from hawk.runtime.late import late
from hawk.webhooks.delivery import WARNED_AT, SenderTimes, TryOutcome, keep_sending, tried
from hawk.webhooks.sender import target_of

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from hawk.lots.outbox import Message

if TYPE_CHECKING:  # loaded on the store's threads
    from hawk.lots import outbox
    from hawk.lots.documents import source, survey_document
    from hawk.lots.storage import states
    from hawk.lots.survey import pictures, private_ground
else:
    outbox = late("hawk.lots.outbox")
    source = late("hawk.lots.documents.source")
    survey_document = late("hawk.lots.documents.survey_document")
    states = late("hawk.lots.storage.states")
    pictures = late("hawk.lots.survey.pictures")
    private_ground = late("hawk.lots.survey.private_ground")

_LOG = logging.getLogger(__name__)
T = TypeVar("T")
CHUNK_BYTES: Final = 1024
LOOKS: Final = (1, 2, 4, 6)
"""Intervals of looks between tries while the desk is not there; the last one is that of every later try."""
PAUSE_S: Final = 0.5
"""Real seconds between two looks whether the drone has landed."""
TIMES: Final = SenderTimes(try_s=900.0)
_AWAY: Final = (0, HTTPStatus.UNAUTHORIZED, HTTPStatus.TOO_MANY_REQUESTS, HTTPStatus.BAD_GATEWAY,
                HTTPStatus.SERVICE_UNAVAILABLE, HTTPStatus.GATEWAY_TIMEOUT)  # fmt: skip
"""Statuses that say nothing of the document: no other one would get through."""


@dataclass(frozen=True, slots=True)
class PackedSurvey:
    """A document as it is sent: the survey's id, the numbers of the ``states`` that it has, and its bytes."""

    survey: str
    states: tuple[int, ...]
    data: bytes = field(repr=False)


class DocumentSender:
    """`run` belongs to the loop."""

    def __init__(
        self,
        store: LotStore,
        settings: CollectSettings,
        wall: Callable[[], float],
        is_flown: Callable[[], bool],
        add_message: Callable[[Level, str, str], object],
        times: SenderTimes = TIMES,
    ) -> None:
        """Take the parts, as those of `hawk.webhooks.sender.WebhookSender`; nothing runs before `run`."""
        self._store = store
        self._settings = settings
        self._wall = wall
        self._is_flown = is_flown
        self._add_message = add_message
        self._times = times
        self._failed = 0
        self._files = ThreadPoolExecutor(1, thread_name_prefix="collect")

    async def run(self) -> None:
        """Send until cancelled; without an address wait for that."""
        url = self._settings.url
        if url is None:
            await asyncio.Event().wait()
            return
        context = await self._elsewhere(lambda: ssl.create_default_context(cafile=self._settings.certificate))
        connector = aiohttp.TCPConnector(limit_per_host=1, force_close=True, ssl=context)
        limits = aiohttp.ClientTimeout(total=self._times.try_s, sock_connect=20.0)
        jar = aiohttp.DummyCookieJar()
        async with aiohttp.ClientSession(
            connector=connector, timeout=limits, trust_env=False, cookie_jar=jar
        ) as session:

            async def send() -> bool:
                return await self.send_one(session, url)

            await keep_sending(f"collect {url.host}", self._may_send, send, self._times.look_s)

    async def _elsewhere(self, work: Callable[[], T]) -> T:
        """Do work with files on a thread."""
        return await asyncio.get_running_loop().run_in_executor(self._files, work)

    async def send_one(self, session: aiohttp.ClientSession, url: SecretUrl) -> bool:
        """Try the next state that is due; return False where there is none, or the desk is not there.

        Raises LotStoreError.
        """
        await self._store.open()
        try:
            token = await self._elsewhere(lambda: _token(self._settings.token_file))
        except (OSError, ValueError) as error:
            words = f"collect.token_file: {error}; write the token that the desk gave into it"
            await self._wait_for_link(url, TryOutcome(0, words))
            return False
        # a desk whose store was lost gives new tokens: then all is sent again
        target, now = target_of(SecretUrl(f"{url.get_secret_value()}#{token}")), self._wall()
        message = await self._store.read(lambda c: outbox.due_state(c, target, now))
        if message is None:
            return False
        try:
            packed = await self._store.read(lambda c: self._packed(c, message), FILE_S)
        except NotFoundError:  # nothing of it is left to send
            await self._store.write(lambda c: outbox.note_sent(c, message, target, now))
            return True
        except LotStoreError as error:
            await self._note_failed(url, message, target, TryOutcome(0, str(error)))
            return True
        outcome = await self._put(session, url, packed, token)
        if not outcome.problem:
            sent_at, self._failed = self._wall(), 0
            sent = (*packed.states, message.seq)
            await self._store.write(lambda c: outbox.note_states_sent(c, sent, target, sent_at))
            return True
        if outcome.status in _AWAY:
            await self._wait_for_link(url, outcome)
            return False
        await self._note_failed(url, message, target, outcome)
        return True

    def _packed(self, connection: Connection, message: Message) -> PackedSurvey:
        """Return the document of a state, on a thread of the store. Raises NotFoundError, LotStoreError."""
        named: str | None = message.body
        if message.kind == states.LOT_STATE:
            named = source.newest_about(connection, message.body)
        if named is None:
            raise NotFoundError("lot: no survey has seen it")
        try:
            hidden = private_ground.hidden_in(connection, named)
            mosaic = pictures.pictures_of(self._store.path).read(named, hidden)
        except LotStoreError as error:  # of a broken file: the survey goes without it
            _LOG.warning("collect: %s", error)
            mosaic = {}
        document = source.document_of(connection, named, mosaic)
        numbers = (document.survey.state, *(lot.state for lot in document.lots))
        return PackedSurvey(named, numbers, survey_document.packed(document))

    async def _put(
        self, session: aiohttp.ClientSession, url: SecretUrl, packed: PackedSurvey, token: str
    ) -> TryOutcome:
        headers = {"Authorization": f"Bearer {token}", "Content-Type": "application/gzip"}
        place = SecretUrl(f"{url.get_secret_value().rstrip('/')}/api/v1/surveys/{packed.survey}/document")
        body = self._paced(packed.data)
        return await tried(session, "PUT", place, self._times.try_s, "collect.url", data=body, headers=headers)

    async def _paced(self, data: bytes) -> AsyncIterator[bytes]:
        """Yield the bytes as fast as they may go: in flight at `collect.kbit_s`, without that after the landing."""
        for start in range(0, len(data), CHUNK_BYTES):
            chunk = data[start : start + CHUNK_BYTES]
            while not self._may_send():  # noqa: ASYNC110 - the autopilot says it
                await asyncio.sleep(PAUSE_S)
            yield chunk
            if self._is_flown():
                await asyncio.sleep(len(chunk) * 8 / (max(self._settings.kbit_s, 1) * 1000))

    def _may_send(self) -> bool:
        return self._settings.kbit_s > 0 or not self._is_flown()

    async def _wait_for_link(self, url: SecretUrl, outcome: TryOutcome) -> None:
        """Wait before the next try of anything; a message says once that the desk is not there."""
        self._failed += 1
        _LOG.log(logging.WARNING if self._failed == 1 else logging.DEBUG, "collect %s: %s", url.host, outcome.problem)
        is_refused = outcome.status == HTTPStatus.UNAUTHORIZED
        if self._failed == (1 if is_refused else WARNED_AT):
            words = say("The desk {name} takes no survey; it is tried on.", name=url.host)
            self._add_message("warning", words, _details(outcome))
        looks = LOOKS[min(self._failed, len(LOOKS)) - 1]
        await asyncio.sleep((looks - 1) * self._times.look_s)

    async def _note_failed(self, url: SecretUrl, message: Message, target: str, outcome: TryOutcome) -> None:
        """Note that the desk refused a document, or that none can be made; one of what it erased is sent no more."""
        now = self._wall()
        is_over = outcome.status == HTTPStatus.GONE
        note = outbox.give_up if is_over else outbox.note_failed
        await self._store.write(lambda c: note(c, message, target, now))
        _LOG.warning("collect %s: try %d of %s %s: %s", url.host, message.tries + 1, message.kind, message.body,
                     _details(outcome))  # fmt: skip
        if is_over or message.tries + 1 == WARNED_AT:
            words = say("The desk {name} does not take a survey.", name=url.host)
            self._add_message("warning", words, _details(outcome))


def _details(outcome: TryOutcome) -> str:
    if outcome.status == HTTPStatus.UNAUTHORIZED:
        return say("The desk does not know the token of collect.token_file: make a new one there for this drone.")
    return f"{outcome.problem}: {outcome.said}" if outcome.said else outcome.problem


def _token(file: Path | None) -> str:
    """Return the token of a file. Raises OSError, ValueError."""
    if file is None:
        raise ValueError("is missing")
    text = file.read_text("utf-8").strip()
    if not text or not text.isprintable() or len(text) > 200:
        raise ValueError(f"{file} holds no token")
    return text
