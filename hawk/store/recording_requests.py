"""Requests at a desk for the recordings of surveys that drones have sent, and what has come of them.

A request is a folder in that of the recordings, ``requests/ID`` by the survey's id: the request itself, and the part of
each recording that is here, which grows. Files and no rows: what grows is a file in any case, and lies beside what is
written of it. A program that is killed leaves both as they were. A whole recording, whose digest is right, lies among
the others, and the request names it.
"""

from __future__ import annotations

import hashlib
import logging
import os
import shutil
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from pydantic import TypeAdapter, ValidationError

from hawk.config.sections import StoreSettings
from hawk.runtime.files import sync_folder, write_atomically
from hawk.store.recording_request import (
    NOTHING,
    Answer,
    ComingRecording,
    OfferedRecording,
    Part,
    PartRefusedError,
    RecordingRequest,
    RequestProgress,
    WholeRecording,
)
from hawk.store.recordings import NAME, SUFFIX, Recordings
from hawk.store.replay import RecordingError, read_metadata

if TYPE_CHECKING:
    from hashlib import _Hash

_LOG = logging.getLogger(__name__)

HEAD_RECORDS: Final = 8
"""First records of a file among which its metadata must be: hawk writes it second."""
_FILE: Final = "request.json"
_PART: Final = ".part"
_REQUEST: Final = TypeAdapter(RecordingRequest)


class RecordingRequests:
    """The requests of a desk. One thread uses it."""

    def __init__(
        self,
        recordings: Recordings,
        settings: StoreSettings,
        free: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
    ) -> None:
        """Nothing is read yet. ``free``: bytes left on the disk of a folder."""
        self._recordings = recordings
        self._folder = recordings.folder / "requests"
        self._most_bytes = int(settings.recordings_gb * 1e9)
        self._least_free = settings.minimum_free_mb * 1_000_000
        self._free = free
        self._hashes: dict[Path, tuple[int, _Hash]] = {}
        self._digests: dict[tuple[str, int], str] = {}
        self._read: dict[str, RecordingRequest] | None = None

    def ask(self, survey: str, drone: str, journal: str, now: float) -> None:
        """Ask a drone for the recordings of a survey; one that waits or is here stays as it is. Raises OSError."""
        known = self._known().get(survey)
        if known is None:
            self._keep(RecordingRequest(survey, drone, journal, now))
        elif self.progress(survey).state not in ("asked", "coming", "here"):
            there = tuple(each for each in known.whole if self._is_there(each))
            self._keep(RecordingRequest(survey, drone, journal, now, whole=there))

    def take_back(self, survey: str) -> None:
        """End a request; what is whole stays, the rest goes. Raises OSError."""
        known = self._known().get(survey)
        if known is None:
            return
        if not known.whole:
            shutil.rmtree(self._folder / survey)
            del self._known()[survey]
            return
        ended = replace(known, coming=(), problem="")
        if ended != known:
            self._keep(ended)
            self._drop_parts(survey, ())

    def progress(self, survey: str) -> RequestProgress:
        """Return how far a survey's request is. Raises OSError."""
        known = self._known().get(survey)
        if known is None:
            return NOTHING
        sizes = [each.bytes for each in known.whole if self._is_there(each)]
        if known.is_waiting:
            if known.coming is None:
                return RequestProgress("asked", problem=known.problem)
            received = sum(self._received(survey, each) for each in known.coming)
            return RequestProgress("coming", sum(sizes) + received, sum(sizes) + known.missing(), known.problem)
        if sizes:
            return RequestProgress("here", sum(sizes), sum(sizes))
        return RequestProgress(known.answer) if known.answer else NOTHING

    def waiting(self, drone: str) -> list[str]:
        """Return the surveys whose recordings a drone is asked for, the one that was asked first at the beginning.

        Raises OSError.
        """
        found = [each for each in self._known().values() if each.drone == drone and each.is_waiting]
        return [each.survey for each in sorted(found, key=lambda each: (each.asked_at, each.survey))]

    def origins(self) -> Mapping[str, Sequence[RecordingRequest]]:
        """Return the requests of each recording that came, by the name that it has here. Raises OSError."""
        found: dict[str, list[RecordingRequest]] = {}
        for each in self._known().values():
            for one in each.whole:
                if self._is_there(one):
                    found.setdefault(one.file, []).append(each)
        return found

    def offer(
        self, survey: str, drone: str, answer: Answer, offered: Sequence[OfferedRecording]
    ) -> dict[str, int]:  # fmt: skip
        """Take in what a drone has of a survey; return how many bytes of each are here, by its name.

        Raises PartRefusedError and OSError.
        """
        kept = known = self._asked(survey, drone)
        if answer or not offered:
            self._keep(replace(known, answer=answer or "gone", coming=(), problem=""))
            self._drop_parts(survey, ())
            return {}
        _check_names(offered)
        known = replace(known, whole=(*known.whole, *self._brought(known, offered)))
        here = {each.name for each in known.whole}
        former = {(each.name, each.bytes): each for each in known.coming or ()}
        new = [each for each in offered if each.name not in here]
        coming = tuple(former.get((each.name, each.bytes), ComingRecording(each.name, each.bytes)) for each in new)
        changed = replace(known, coming=coming, problem="")
        try:
            self._check_room(changed)
        except PartRefusedError as error:
            self._keep(replace(known, problem=error.reason))
            raise
        if changed != kept:
            self._drop_parts(survey, [each.name for each in coming])  # first: the part of a whole one is given its name
            self._keep(changed)
        for each in coming:  # a kill came behind the last part of one
            self.finish(survey, each)
        left = {each.name: self._received(survey, each) for each in self._known()[survey].coming or ()}
        return {each.name: left.get(each.name, each.bytes) for each in offered}

    def begin(self, survey: str, drone: str, name: str, part: Part) -> PartWriter | int:
        """Return what writes a part; for one that is here already how many bytes of the recording are.

        Raises PartRefusedError and OSError.
        """
        known = self._asked(survey, drone)
        if any(each.name == name for each in known.whole):
            return part.size
        coming = next((each for each in known.coming or () if each.name == name), None)
        if coming is None:
            raise PartRefusedError("unasked", "name", "was not offered: say first which recordings there are")
        if part.size != coming.bytes or not 0 <= part.start < part.end <= part.size:
            words = f"must lie in the {coming.bytes} bytes that were offered, as bytes 0-99/{coming.bytes}"
            raise PartRefusedError("wrong", "Content-Range", words)
        if self._take_brought(known, replace(coming, digest=part.digest)):
            return part.size
        path = self._part_of(survey, name)
        if part.digest != coming.digest:
            if part.start > 0:
                raise PartRefusedError("place", "Repr-Digest", "is that of another file than before: begin at byte 0")
            path.unlink(missing_ok=True)
            self._hashes.pop(path, None)
            coming = replace(coming, digest=part.digest)
            self._keep(_with(known, coming))
        received = self._received(survey, coming)
        if part.end <= received:
            return received
        if part.start != received:
            words = f"begins at byte {part.start}, and byte {received} comes next: send from there"
            raise PartRefusedError("place", "Content-Range", words)
        if self._free(self._recordings.folder) - (part.end - part.start) < self._least_free:
            raise PartRefusedError("full", "", self._no_room())
        return PartWriter(self, survey, coming, path, received)

    def finish(self, survey: str, coming: ComingRecording) -> bool:
        """Give a recording its place among the others, once all parts are here; return whether they are.

        Raises OSError, and PartRefusedError for a file that is not what it says it is; it is removed then.
        """
        path, known = self._part_of(survey, coming.name), self._known().get(survey)
        if known is None or self._received(survey, coming) < coming.bytes:
            return False
        try:
            self._check_whole(path, known, coming)
        except PartRefusedError:
            path.unlink(missing_ok=True)
            self._keep(_with(known, replace(coming, digest="")))
            raise
        if self._take_brought(self._known()[survey], coming):
            return True
        file = self._recordings.free_name(coming.name.removesuffix(SUFFIX))
        self._end_notes(file)
        known = self._known()[survey]
        left = tuple(each for each in known.coming or () if each.name != coming.name)
        whole = WholeRecording(coming.name, file, coming.bytes, coming.digest, path.stat().st_mtime_ns)
        self._keep(replace(known, coming=left, whole=(*known.whole, whole)))
        self._settle(survey, whole)
        return True

    def hash_of(self, path: Path, received: int) -> _Hash | None:
        """Return the digest of what is here of a recording; None where this program has not written all of it."""
        at, found = self._hashes.pop(path, (0, hashlib.sha256()))
        return found if at == received else None

    def keep_hash(self, path: Path, received: int, found: _Hash) -> None:
        """Keep the digest of what is here of a recording for its next part."""
        self._hashes[path] = received, found

    def folders_of(self, surveys: Iterable[str]) -> list[Path]:
        """Return the folders of the requests for some surveys."""
        return [self._folder / each for each in surveys if (self._folder / each).is_dir()]

    # --- inside ----------------------------------------------------------------------------------------------------

    def _asked(self, survey: str, drone: str) -> RecordingRequest:
        known = self._known().get(survey)
        if known is None or not known.is_waiting:
            raise PartRefusedError("unasked", "survey", "nobody asks for its recordings: send none")
        if known.drone != drone:
            words = "this survey is another's: a drone sends recordings of its own surveys alone"
            raise PartRefusedError("other", "survey", words)
        return known

    def _brought(self, known: RecordingRequest, offered: Sequence[OfferedRecording]) -> Iterator[WholeRecording]:
        """Yield what is offered and came for another survey of the same flight: a round is over several lots."""
        had, flight = {each.name for each in known.whole}, (known.drone, known.journal)
        others = (each for each in self._known().values() if (each.drone, each.journal) == flight)
        there = {(one.name, one.bytes): one for each in others for one in each.whole}
        for each in offered:
            one = there.get((each.name, each.bytes))
            if one is not None and each.name not in had and self._is_there(one):
                yield one

    def _take_brought(self, known: RecordingRequest, coming: ComingRecording) -> bool:
        """Take a recording that came meanwhile for another survey of the same flight; return whether one did."""
        brought = self._brought(known, [OfferedRecording(coming.name, coming.bytes)])
        whole = next((each for each in brought if each.digest == coming.digest), None)
        if whole is None:
            return False
        left = tuple(each for each in known.coming or () if each.name != coming.name)
        self._drop_parts(known.survey, [each.name for each in left])
        self._keep(replace(known, coming=left, whole=(*known.whole, whole)))
        return True

    def _check_room(self, request: RecordingRequest) -> None:
        wanted, taken = request.missing(), self._recordings.taken()[0]
        others = sum(each.missing() for each in self._known().values() if each.survey != request.survey)
        if taken + others + wanted > self._most_bytes:
            words = (
                f"The desk holds {_gb(taken)} GB of recordings, {_gb(others)} GB are to come, and these are "
                f"{_gb(wanted)} GB; its limit is {_gb(self._most_bytes)} GB: delete some there, or raise "
                "store.recordings_gb"
            )
            raise PartRefusedError("full", "", words)
        rest = wanted - sum(self._received(request.survey, each) for each in request.coming or ())
        if self._free(self._recordings.folder) - rest < self._least_free:
            raise PartRefusedError("full", "", self._no_room())

    def _no_room(self) -> str:
        return f"The desk's disk is full ({self._recordings.folder}): make room there; it is tried again"

    def _check_whole(self, path: Path, request: RecordingRequest, coming: ComingRecording) -> None:
        kept = self.hash_of(path, coming.bytes)
        digest = _digest_of(path) if kept is None else kept.hexdigest()
        if digest != coming.digest:
            words = "is not that of the bytes that came: they are dropped; send the recording again"
            raise PartRefusedError("wrong", "Repr-Digest", words)
        try:
            named = read_metadata(path, HEAD_RECORDS).get("survey", "")
        except RecordingError as error:
            raise PartRefusedError("wrong", "name", "is no recording of hawk: nothing of it is kept") from error
        if named != request.journal:
            raise PartRefusedError("wrong", "name", "is the recording of another survey: nothing of it is kept")

    def _received(self, survey: str, coming: ComingRecording) -> int:
        if not coming.digest:
            return 0
        try:
            return self._part_of(survey, coming.name).stat().st_size
        except FileNotFoundError:
            return 0

    def _is_there(self, whole: WholeRecording) -> bool:
        """Return False also where the file is another one, which has the name of one that was deleted."""
        path = self._recordings.folder / whole.file
        try:
            found = path.stat()
        except FileNotFoundError:
            return False
        if found.st_size != whole.bytes or found.st_mtime_ns == whole.changed_ns:
            return found.st_size == whole.bytes
        known_by = whole.file, found.st_mtime_ns  # a copy of it perhaps, out of a backup
        if known_by not in self._digests:
            self._digests[known_by] = _digest_of(path)
        return self._digests[known_by] == whole.digest

    def _end_notes(self, file: str) -> None:
        """End the notes of a file that was deleted, before another one gets its name."""
        for each in list(self._known().values()):
            if any(one.file == file for one in each.whole):
                self._keep(replace(each, whole=tuple(one for one in each.whole if one.file != file)))

    def _known(self) -> dict[str, RecordingRequest]:
        """Return the requests, by the survey's id. One that is damaged is left out: a person asks again."""
        if self._read is None:
            found = {}
            for path in sorted(self._folder.glob(f"*/{_FILE}")):
                try:
                    found[path.parent.name] = each = _REQUEST.validate_json(path.read_bytes())
                except ValidationError as error:
                    _LOG.warning("%s is damaged: %s", path, error)
                    continue
                for whole in each.whole:  # a kill came between the note and the name
                    if self._part_of(each.survey, whole.name).exists():
                        self._settle(each.survey, whole)
            self._read = found
        return self._read

    def _keep(self, request: RecordingRequest) -> None:
        write_atomically(self._folder / request.survey / _FILE, _REQUEST.dump_json(request).decode())
        self._known()[request.survey] = request

    def _drop_parts(self, survey: str, names: Collection[str]) -> None:
        """Remove the parts of a survey but those of some recordings."""
        for path in (self._folder / survey).glob(f"*{_PART}"):
            if path.name.removesuffix(_PART) not in names:
                path.unlink()

    def _settle(self, survey: str, whole: WholeRecording) -> None:
        self._part_of(survey, whole.name).replace(self._recordings.folder / whole.file)
        sync_folder(self._recordings.folder)

    def _part_of(self, survey: str, name: str) -> Path:
        return self._folder / survey / f"{name}{_PART}"


class PartWriter:
    """A part that is being written; `close` ends it, and what came stays."""

    def __init__(
        self, requests: RecordingRequests, survey: str, coming: ComingRecording, path: Path, received: int
    ) -> None:  # fmt: skip
        """``path``: file that it is added to, which has ``received`` bytes. Raises OSError."""
        self.survey = survey
        self.coming = coming
        self.received = received
        self._path = path
        self._requests = requests
        self._file = path.open("ab")
        self._hash = requests.hash_of(path, received)

    def write(self, data: bytes) -> None:
        """Add the next bytes. Raises OSError."""
        self._file.write(data)
        self.received += len(data)
        if self._hash is not None:
            self._hash.update(data)

    def close(self) -> None:
        """Put what came on the disk. Raises OSError."""
        if self._file.closed:
            return
        try:
            self._file.flush()
            os.fsync(self._file.fileno())
        finally:
            self._file.close()
        if self._hash is not None:
            self._requests.keep_hash(self._path, self.received, self._hash)


def _with(request: RecordingRequest, changed: ComingRecording) -> RecordingRequest:
    found = (changed if each.name == changed.name else each for each in request.coming or ())
    return replace(request, coming=tuple(found))


def _check_names(offered: Sequence[OfferedRecording]) -> None:
    """Raise PartRefusedError for what is no name of a recording, and for one that is there twice."""
    for one in offered:
        if NAME.fullmatch(one.name) is None or one.bytes < 1:
            words = "must be a name of a recording, as 20260504T103000Z.mcap, with its size"
            raise PartRefusedError("wrong", "recordings", words)
    twice = [name for name, count in Counter(one.name for one in offered).items() if count > 1]
    if twice:
        raise PartRefusedError("wrong", "recordings", f"has {twice[0]} twice: offer each recording once")


def _digest_of(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _gb(size: int) -> str:
    return f"{size / 1e9:.3g}"
