"""Sends surveys and lots as documents to the desk that collects them: the newest state first, then the oldest, until it
has all; then asks for the lots that have changed there, and sends the recordings that the desk asks for.

A document is made of the store when it is sent. The desk commits, and then answers: a program that is killed before it
notes the answer sends the document again, and gets the same answer. While the desk is not there, the waits grow to a
minute, and nothing is given up. A document that the desk refuses holds up no other one.
"""

from __future__ import annotations

import asyncio
import logging
import math
import ssl
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, TypeVar

import aiohttp

from hawk.config.secrets import SecretUrl
from hawk.config.sections import CollectSettings
from hawk.lots.documents.parts import LARGEST_BYTES
from hawk.lots.store import FILE_S, LotStore
from hawk.lots.values import NEWER_FIELD, FormatVersionError, LotStoreError, NotFoundError
from hawk.model.operation import Level
from hawk.model.sentences import Sentence, say
from hawk.runtime.late import late
from hawk.runtime.process import set_niceness
from hawk.store.recording_request import ASKED
from hawk.store.recordings import Recordings
from hawk.webhooks.delivery import WARNED_AT, SenderTimes, TryOutcome, keep_sending, tried
from hawk.webhooks.recordings import LOOKS, PART_S, RecordingSender, Sent
from hawk.webhooks.sender import target_of

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from hawk.lots.documents.lot_document import LotDue
    from hawk.lots.documents.lot_return import LotQuery
    from hawk.lots.outbox import Message

if TYPE_CHECKING:  # loaded on the store's threads
    from hawk.lots import outbox
    from hawk.lots.documents import lot_return, parts, source
    from hawk.lots.storage import states
    from hawk.lots.survey import pictures, private_ground
else:
    outbox = late("hawk.lots.outbox")
    source = late("hawk.lots.documents.source")
    lot_return = late("hawk.lots.documents.lot_return")
    parts = late("hawk.lots.documents.parts")
    states = late("hawk.lots.storage.states")
    pictures = late("hawk.lots.survey.pictures")
    private_ground = late("hawk.lots.survey.private_ground")

_LOG = logging.getLogger(__name__)
T = TypeVar("T")
CHUNK_BYTES: Final = 16 * 1024
"""Most bytes that are handed over at once."""
CHUNK_S: Final = 0.25
"""In flight a chunk takes the link for so long: the time of the processor is that of chunks, not of bytes."""
LOTS_EVERY: Final = 6
"""Looks between two questions for lots, where nothing is sent."""
NICENESS: Final = 15
"""The thread with files steps back: the SHA-256 of a recording takes seconds."""
PAUSE_S: Final = 0.5
"""Real seconds between two looks whether the drone has landed."""
TIMES: Final = SenderTimes(try_s=900.0)
_AWAY: Final = (0, HTTPStatus.UNAUTHORIZED, HTTPStatus.TOO_MANY_REQUESTS, HTTPStatus.BAD_GATEWAY,
                HTTPStatus.SERVICE_UNAVAILABLE, HTTPStatus.GATEWAY_TIMEOUT,
                HTTPStatus.INSUFFICIENT_STORAGE)  # fmt: skip
"""Statuses that say nothing of the document: no other one would get through."""


@dataclass(frozen=True, slots=True)
class PackedState:
    """A document as it is sent: its ``address`` below the API's, the ``states`` that it has, and its bytes."""

    address: str
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
        take_due: Callable[[Sequence[LotDue]], object] = lambda _: None,
        recordings: Recordings | None = None,
    ) -> None:
        """Take the parts, as those of `hawk.webhooks.sender.WebhookSender`; nothing runs before `run`.

        ``take_due``: takes what is due at the desk, also what it said in an earlier run. ``recordings``: those of this
        drone; None: it has none.
        """
        self._store = store
        self._settings = settings
        self._wall = wall
        self._is_flown = is_flown
        self._add_message = add_message
        self._times = times
        self._take_due = take_due
        self._has_due = False
        self._failed = 0
        self._said: set[str] = set()
        self._next_query = 0.0
        self._files = ThreadPoolExecutor(
            1, thread_name_prefix="collect", initializer=set_niceness, initargs=(NICENESS,)
        )
        self._recordings = RecordingSender(store, recordings, settings.recordings, is_flown, self._elsewhere, times)

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
                if await self.send_one(session, url):
                    return True
                if self._failed:
                    return False
                put = partial(self._put_at, session, url)
                return await self.ask_for_lots(session, url) or await self._recordings.send_one(put)

            await keep_sending(f"collect {url.host}", self._may_send, send, self._times.look_s)

    async def _elsewhere(self, work: Callable[[], T]) -> T:
        """Do work with files on a thread."""
        return await asyncio.get_running_loop().run_in_executor(self._files, work)

    async def ask_for_lots(self, session: aiohttp.ClientSession, url: SecretUrl) -> bool:
        """Take in the lots that have changed at the desk; return whether there were any. Nothing is asked in flight.

        Raises LotStoreError.
        """
        if self._is_flown() or time.monotonic() < self._next_query:
            return False
        self._next_query = time.monotonic() + LOTS_EVERY * self._times.look_s
        token = await self._elsewhere(lambda: _token(self._settings.token_file))
        target = desk_target(url, token)
        asked: LotQuery | None = await self._store.read(lambda c: lot_return.first_query(c, target))
        is_any = False
        while asked is not None and not self._is_flown():
            outcome = await self._get(session, url, asked, token)
            if outcome.problem or self._is_flown():
                _LOG.log(logging.WARNING if outcome.problem else logging.DEBUG, "collect %s: lots: %s", url.host,
                         _details(outcome))  # fmt: skip
                return False
            self._recordings.ask(outcome.headers.get(ASKED, ""))
            try:
                returned = await self._store.take_back(outcome.data, asked)
            except FormatVersionError as error:
                words = say(
                    "The desk {name} is of a newer hawk-drone: upgrade this one. Lots wait there.", name=url.host
                )
                self._say_once("newer", words, str(error))
                return False
            self._said.discard("newer")
            self._take_due(returned.due)
            for name in returned.replaced:
                words = say("The plan of {name} is the desk's now; some of your changes are not in it.", name=name)
                self._add_message("info", words, "")
            asked, is_any = returned.next, is_any or returned.next is not None
        return is_any

    async def _get(self, session: aiohttp.ClientSession, url: SecretUrl, asked: LotQuery, token: str) -> TryOutcome:
        seen = "&seen=true" if self._settings.lots == "seen" else ""
        place = SecretUrl(f"{_root(url)}/lots/documents?after={asked.after}{seen}")
        headers = {"Authorization": f"Bearer {token}"}
        limits = self._times.try_s, "collect.url", LARGEST_BYTES
        return await tried(session, "GET", place, *limits, headers=headers)

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
        target, now = desk_target(url, token), self._wall()
        if not self._has_due:
            self._take_due(await self._store.read(lambda c: lot_return.due_there(c, target)))
            self._has_due = True
        message = await self._store.read(lambda c: outbox.due_state(c, target, now))
        if message is None:
            return False
        try:
            packed = await self._store.read(lambda c: self._packed(c, message), FILE_S)
        except LotStoreError as error:
            await self._note_failed(url, message, target, TryOutcome(0, str(error)))
            return True
        if packed is None:
            await self._store.write(lambda c: outbox.note_sent(c, message, target, now))
            return True
        outcome = await self._put(session, url, packed, token)
        if not outcome.problem:
            sent_at, self._failed, self._next_query = self._wall(), 0, 0.0
            self._said.discard("older")
            sent = (*packed.states, message.seq)
            await self._store.write(lambda c: outbox.note_states_sent(c, sent, target, sent_at))
            return True
        if outcome.status in _AWAY:
            await self._wait_for_link(url, outcome)
            return False
        self._failed = 0  # the desk is there
        await self._note_failed(url, message, target, outcome)
        return True

    def _packed(self, connection: Connection, message: Message) -> PackedState | None:
        """Return the document of a state, None where nothing of it is to be sent, on a thread of the store.

        Raises LotStoreError.
        """
        named = message.body
        if message.kind == states.LOT_STATE:
            lots = source.document_of_lot(connection, named)
            if lots is None:
                return None
            of_lots = tuple(lot.state for lot in lots.lots)
            return PackedState(f"lots/{named}/document", of_lots, parts.packed(lots))
        try:
            hidden = private_ground.hidden_in(connection, named)
            mosaic = pictures.pictures_of(self._store.path).read(named, hidden)
        except LotStoreError as error:  # of a broken file: the survey goes without it
            _LOG.warning("collect: %s", error)
            mosaic = {}
        try:
            document = source.document_of(connection, named, mosaic)
        except NotFoundError:
            return None
        numbers = (document.survey.state, *(lot.state for lot in document.lots))
        return PackedState(f"surveys/{named}/document", numbers, parts.packed(document))

    async def _put(self, session: aiohttp.ClientSession, url: SecretUrl, packed: PackedState, token: str) -> TryOutcome:
        headers = {"Authorization": f"Bearer {token}", "Content-Type": "application/gzip"}
        place = SecretUrl(f"{_root(url)}/{packed.address}")
        body = self._paced(packed.data)
        return await tried(session, "PUT", place, self._times.try_s, "collect.url", data=body, headers=headers)

    async def _put_at(
        self, session: aiohttp.ClientSession, url: SecretUrl, address: str, headers: Mapping[str, str], data: Sent
    ) -> TryOutcome:  # fmt: skip
        """Put data of a recording at an address below the API's."""
        try:
            token = await self._elsewhere(lambda: _token(self._settings.token_file))
        except (OSError, ValueError) as error:
            return TryOutcome(0, f"collect.token_file: {error}")
        given = {"Authorization": f"Bearer {token}", **headers}
        place, seconds = SecretUrl(f"{_root(url)}/{address}"), min(self._times.try_s, PART_S)
        return await tried(session, "PUT", place, seconds, "collect.url", data=data, headers=given)

    async def _paced(self, data: bytes) -> AsyncIterator[bytes]:
        """Yield the bytes as fast as they may go: in flight at `collect.kbit_s`, without that after the landing."""
        bytes_s, sent = max(self._settings.kbit_s, 1) * 125.0, 0
        while sent < len(data):
            while not self._may_send():  # noqa: ASYNC110 - the autopilot says it
                await asyncio.sleep(PAUSE_S)
            most = min(math.ceil(bytes_s * CHUNK_S), CHUNK_BYTES) if self._is_flown() else CHUNK_BYTES
            chunk = data[sent : sent + most]
            yield chunk
            sent += len(chunk)
            if self._is_flown():
                await asyncio.sleep(len(chunk) / bytes_s)

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
        if outcome.named == NEWER_FIELD:
            words = say("The desk {name} is of an older hawk-drone: upgrade it. Surveys wait here.", name=url.host)
            self._say_once("older", words, _details(outcome))
        elif is_over or message.tries + 1 == WARNED_AT:
            words = say("The desk {name} does not take a survey.", name=url.host)
            self._add_message("warning", words, _details(outcome))

    def _say_once(self, desk: Literal["older", "newer"], words: Sentence, details: str) -> None:
        """Say that the desk is older or newer: not again for each document, until one was taken."""
        if desk not in self._said:
            self._said.add(desk)
            _LOG.warning("collect: %s %s", words, details)
            self._add_message("warning", words, details)


def _root(url: SecretUrl) -> str:
    """Return the address of the desk's API."""
    return f"{url.get_secret_value().rstrip('/')}/api/v1"


def desk_target(url: SecretUrl, token: str) -> str:
    """Return the name of a desk in deliveries: one whose store was lost gives new tokens, and gets everything again."""
    return target_of(SecretUrl(f"{url.get_secret_value()}#{token}"))


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
