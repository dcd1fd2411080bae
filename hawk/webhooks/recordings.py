"""Sends the recordings of surveys that the desk asks for: on the ground, by parts, where the settings allow it.

Arming ends a part within a second. After the landing, a cut or a kill the desk says how much it has, and the next part
begins there. A part takes some seconds: a document waits for no more.
"""

from __future__ import annotations

import base64
import hashlib
import json
import logging
import os
import re
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Mapping
from dataclasses import dataclass, field
from functools import partial
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from pydantic import BaseModel, Field, ValidationError

from hawk.lots.store import LotStore
from hawk.lots.values import NotFoundError
from hawk.runtime.late import late
from hawk.runtime.supervision import done_while
from hawk.store.recording_request import MOST_ASKED, MOST_RECORDINGS
from hawk.store.recordings import NotThatRecordingError, Recordings
from hawk.webhooks.delivery import SenderTimes, TryOutcome

if TYPE_CHECKING:  # loaded on the store's threads
    from hawk.lots import queries
else:
    queries = late("hawk.lots.queries")

_LOG = logging.getLogger(__name__)

LOOKS: Final = (1, 2, 4, 6)
"""Intervals of looks between tries while the desk is not there; the last one is that of every later try."""
REFUSED_LOOKS: Final = 360
"""The same after the desk refused a whole recording for what it is: an hour."""
FIRST_PART: Final = 1_000_000
LEAST_PART: Final = 64_000
LARGEST_PART: Final = 16_000_000
"""Bytes of a part: the first one, and bounds of those that follow at the pace of the link."""
WANTED_S: Final = 4.0
"""Real seconds that a part shall take."""
PART_S: Final = 60.0
"""Real seconds after which a part is given up: what came of it stays."""
DIGEST_S: Final = 0.5
"""Real seconds for which a file is read for its digest before the next look at documents and motors."""
CHUNK_BYTES: Final = 64 * 1024
_ID: Final = re.compile(r"[0-9a-f-]{36}")
_HASHED: Final = 1024 * 1024
_OVER: Final = (HTTPStatus.FORBIDDEN, HTTPStatus.NOT_FOUND, HTTPStatus.GONE)
Sent = bytes | AsyncIterator[bytes]


Put = Callable[[str, Mapping[str, str], Sent], Coroutine[Any, Any, TryOutcome]]
"""Puts data, with headers, at an address below that of the desk's API."""
Elsewhere = Callable[[Callable[[], Any]], Awaitable[Any]]
"""Does work with files on a thread."""


class _Stored(BaseModel):
    name: str
    stored: Annotated[int, Field(ge=0)]


class _Offered(BaseModel):
    recordings: list[_Stored]


@dataclass(slots=True)
class _File:
    """A recording that is sent: the desk has ``received`` of ``size`` bytes."""

    path: Path
    size: int
    received: int = 0


@dataclass(slots=True)
class _Digest:
    """SHA-256 of the first ``at`` bytes of a file, which is that of a name, a size and a time of change."""

    of: tuple[str, int, int]
    at: int = 0
    found: Any = field(default_factory=hashlib.sha256, repr=False)


@dataclass(slots=True)
class _Asked:
    """A survey that is asked for. ``files`` is None before the desk has said what it has; ``next``: monotonic time of
    the next try.
    """

    survey: str
    files: list[_File] | None = None
    tries: int = 0
    next: float = field(default=0.0)


class RecordingSender:
    """Belongs to the loop; what reads files runs elsewhere."""

    def __init__(
        self,
        store: LotStore,
        recordings: Recordings | None,
        allowed: Literal["never", "asked"],
        is_flown: Callable[[], bool],
        elsewhere: Elsewhere,
        times: SenderTimes,
    ) -> None:
        """``recordings``: None: there are none here. ``allowed``: `CollectSettings.recordings`."""
        self._store = store
        self._recordings = recordings
        self._allowed = allowed
        self._is_flown = is_flown
        self._elsewhere = elsewhere
        self._times = times
        self._asked: dict[str, _Asked] = {}
        self._part = FIRST_PART
        self._digest = _Digest(("", 0, 0))

    def ask(self, header: str) -> None:
        """Take in what the desk asks for now: ids of surveys, as the header has them."""
        ids = [each for each in header.replace(",", " ").split() if _ID.fullmatch(each)][:MOST_ASKED]
        self._asked = {each: self._asked.get(each) or _Asked(each) for each in ids}

    async def send_one(self, put: Put) -> bool:
        """Send what comes next: what there is of a survey, or a part; return False when nothing is due.

        Raises LotStoreError.
        """
        if self._is_flown():
            return False
        asked = next((each for each in self._asked.values() if each.next <= time.monotonic()), None)
        if asked is None:
            return False
        if asked.files is None:
            return await self._offer(asked, put)
        file = next((each for each in asked.files if each.received < each.size), None)
        if file is None:
            self._forget(asked)
            return True
        return await self._send_part(asked, file, put)

    async def _offer(self, asked: _Asked, put: Put) -> bool:
        """Say which recordings there are of a survey, and learn what the desk has of them."""
        found = [] if self._allowed == "never" else await self._files_of(asked.survey)
        body: dict[str, object] = {"recordings": [{"name": each.path.name, "bytes": each.size} for each in found]}
        if not found:
            body["answer"] = "never" if self._allowed == "never" else "gone"
        data, address = json.dumps(body).encode(), f"surveys/{asked.survey}/recordings"
        outcome = await put(address, {"Content-Type": "application/json"}, data)
        if outcome.problem:
            return self._failed(asked, outcome)
        try:
            received = {each.name: each.stored for each in _Offered.model_validate_json(outcome.data).recordings}
        except ValidationError as error:
            return self._failed(asked, TryOutcome(0, f"answered what is no state of recordings: {error}"))
        if not found:
            self._forget(asked)
            return True
        for each in found:
            each.received = received.get(each.path.name, 0)
        asked.files = found
        return True

    async def _files_of(self, survey: str) -> list[_File]:
        """Return the recordings of a survey that are not under way, the oldest first. Raises LotStoreError."""
        folder = self._recordings
        if folder is None:
            return []
        try:
            journal = await self._store.read(lambda connection: queries.journal_of_survey(connection, survey))
        except NotFoundError:
            return []

        def read() -> list[_File]:
            found = []
            for one in folder.listed():
                try:
                    if not one.is_under_way and folder.contents(one.name).survey == journal:
                        found.append(_File(folder.complete(one.name), one.bytes))
                except NotThatRecordingError:  # deleted meanwhile
                    continue
            return found[:MOST_RECORDINGS]

        files: list[_File] = await self._elsewhere(read)
        return files

    async def _send_part(self, asked: _Asked, file: _File, put: Put) -> bool:
        try:
            digest = await self._elsewhere(partial(self._digest_of, file))
        except OSError as error:
            return self._failed(asked, TryOutcome(0, str(error)))
        if digest is None:
            return True
        start, end = file.received, min(file.received + self._part, file.size)
        headers = {
            "Content-Type": "application/octet-stream",
            "Content-Length": str(end - start),
            "Content-Range": f"bytes {start}-{end - 1}/{file.size}",
            "Repr-Digest": f"sha-256=:{base64.b64encode(digest).decode()}:",
        }
        address, began = f"surveys/{asked.survey}/recordings/{file.path.name}", time.monotonic()
        sending = put(address, headers, self._bytes(file.path, start, end))
        outcome = await done_while(lambda: not self._is_flown(), sending)
        if outcome is None:  # armed: after the landing the desk says what it has
            asked.files = None
            return False
        if outcome.problem:
            return self._failed(asked, outcome)
        try:
            file.received = _Stored.model_validate_json(outcome.data).stored
        except ValidationError as error:
            return self._failed(asked, TryOutcome(0, f"answered what is no state of a recording: {error}"))
        if file.received >= file.size:
            _LOG.info("collect: recording %s of survey %s is at the desk", file.path.name, asked.survey)
        asked.tries = 0
        paced = (end - start) * WANTED_S / max(time.monotonic() - began, 0.01)
        self._part = round(min(max(paced, LEAST_PART), 2 * self._part, LARGEST_PART))
        return True

    async def _bytes(self, path: Path, start: int, end: int) -> AsyncIterator[bytes]:
        """Yield bytes of a file. Raises OSError."""
        for at in range(start, end, CHUNK_BYTES):
            yield await self._elsewhere(partial(_read, path, at, min(CHUNK_BYTES, end - at)))

    def _digest_of(self, file: _File) -> bytes | None:
        """Read on for `DIGEST_S`, on the thread; return the SHA-256 of the whole file, None before its end.

        Raises OSError.
        """
        about = file.path.stat()
        key = file.path.name, about.st_size, about.st_mtime_ns
        if self._digest.of != key:
            self._digest = _Digest(key)
        digest, until = self._digest, time.monotonic() + DIGEST_S
        with file.path.open("rb") as stream:
            stream.seek(digest.at)
            while digest.at < file.size and time.monotonic() < until:
                data = stream.read(min(_HASHED, file.size - digest.at)) or _cut(file.path)
                digest.found.update(data)
                digest.at += len(data)
        return digest.found.digest() if digest.at == file.size else None

    def _failed(self, asked: _Asked, outcome: TryOutcome) -> bool:
        """Note that a try failed; return False: nothing more is tried before the next look."""
        asked.files, asked.tries = None, asked.tries + 1
        level = logging.WARNING if asked.tries == 1 else logging.DEBUG
        _LOG.log(level, "collect: recordings of survey %s: %s %s", asked.survey, outcome.problem, outcome.said)
        if outcome.status in _OVER:
            self._forget(asked)
        is_wrong = outcome.status == HTTPStatus.UNPROCESSABLE_ENTITY
        looks = REFUSED_LOOKS if is_wrong else LOOKS[min(asked.tries, len(LOOKS)) - 1]
        asked.next = time.monotonic() + looks * self._times.look_s
        return False

    def _forget(self, asked: _Asked) -> None:
        self._asked.pop(asked.survey, None)


def _read(path: Path, start: int, count: int) -> bytes:
    """Return bytes of a file. Raises OSError where it ends before."""
    with path.open("rb") as file:
        data = os.pread(file.fileno(), count, start)
    return data if len(data) == count else _cut(path)


def _cut(path: Path) -> bytes:
    raise OSError(f"{path}: is shorter than it was")
