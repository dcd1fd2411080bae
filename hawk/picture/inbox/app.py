"""The inbox: drops of a folder become flights, flights become surveys, one after the other.

Every step is written in the journal before it is done, and can be done twice: the next start goes on where the last one
was cut off. The store takes a flight's survey by the flight's id: mapped again, it replaces itself.
"""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import sqlite3
import uuid
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Final, Protocol

from hawk.picture.inbox import report
from hawk.picture.inbox.flights import FlightReader, Part, continues, plain_name
from hawk.picture.inbox.folder import REPORT, SURVEY, Drop, Folder, is_returned
from hawk.picture.inbox.journal import AGAIN, PICTURES, Flight, Journal, Move, State
from hawk.picture.inbox.map_process import MapResult
from hawk.picture.values import PictureError
from hawk.picture.work_folder import WINDOWS, WORK
from hawk.runtime.files import replace_whole, sync_folder
from hawk.store.inbox import DONE, FAILED, LEAST_FREE, MAPPING, PLACES

MOST_TRIES: Final = 3
"""Mappings of one flight that may end by a signal."""
_OF_STORE: Final = ("--store:", "--model", "--out:")
"""Beginnings of words on what no other flight would change."""


class Mapper(Protocol):
    """Maps the pictures in a flight's folder into the store."""

    def __call__(self, flight: Flight, home: Path) -> MapResult:
        """Return how it ended. Raises OSError where it cannot begin."""
        ...


@dataclass(frozen=True, slots=True)
class InboxNotice:
    """State of a flight, or the reason for which the inbox waits. ``flight``: name, "" for the inbox itself."""

    flight: str
    outcome: str
    words: str


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Parts that the inbox works with.

    ``has_survey``: whether the store has the survey of an id; raises PictureError. ``free``: bytes left for a folder.
    ``now``: Unix seconds.
    """

    mapper: Mapper
    has_survey: Callable[[str], bool]
    say: Callable[[InboxNotice], None]
    now: Callable[[], float]
    free: Callable[[Path], int] = field(default=lambda folder: shutil.disk_usage(folder).free)


class Inbox:
    """Maps what arrives in a folder. `step` is called again and again."""

    def __init__(
        self, folder: Folder, store: Path, journal: Journal, reader: FlightReader, around: Surroundings
    ) -> None:
        """Make the inbox's own folders. ``store``: folder of the store. Raises OSError."""
        self._folder = folder
        self._root = folder.path
        self._store = store
        self._journal = journal
        self._reader = reader
        self._around = around
        self._waits: set[InboxNotice] = set()
        if not (self._root / MAPPING).is_dir() and (names := journal.names()):
            words = (
                f"holds no {', '.join(sorted(names))}, which the store's journal has as under way: is the disk mounted?"
            )
            raise OSError(errno.ENOENT, words, str(self._root))
        for name in PLACES:
            place = self._root / name
            if place.is_symlink():
                raise OSError(errno.ELOOP, "is a link, perhaps to where others may not write: remove it", str(place))
            place.mkdir(exist_ok=True)
        self._return_unknown()

    def step(self, now: float) -> bool:
        """Take what has settled, map one flight; return whether one was mapped or failed.

        ``now``: monotonic seconds. Raises sqlite3.DatabaseError of a damaged journal; other failures are said and
        tried again.
        """
        try:
            os.stat(self._root / MAPPING)  # a disk that is not mounted looks like an empty folder
            for drop in self._folder.settled(now):
                self._take(drop)
            return any(self._is_ended(flight) for flight in self._journal.unfinished())
        except PictureError as error:  # of the store or the disk: no other flight would fare better
            self._say("", "waits", str(error))
        except OSError as error:
            self._say("", "waits", _words(error, self._root))
        except sqlite3.OperationalError as error:  # the journal's disk is full, or busy
            self._say("", "waits", f"{self._store}: {error}; see that there is room, and that hawk may write there")
        return False

    def _is_ended(self, flight: Flight) -> bool:
        """Bring a flight to its end; return whether it is there. Raises PictureError."""
        try:
            if self._bring(flight) and (current := self._journal.flight(flight.id)) is not None:
                return self._finish(current)
        except OSError as error:  # of this flight: the next one goes on
            self._say(flight.name, "waits", _words(error, self._root))
        return False

    # -- from the inbox to a flight -----------------------------------------------------------------------------------

    def _return_unknown(self) -> None:
        """Put the pictures of flights that the journal does not have, because it was lost, back into the inbox."""
        for home in [*(self._root / MAPPING).iterdir()]:
            if home.name in self._journal.names() or not (home / PICTURES).is_dir():
                continue
            for inner in (PICTURES, AGAIN):
                if (home / inner).is_dir():
                    (home / inner).rename(self._root / plain_name(home.name, lambda name: (self._root / name).exists()))
            shutil.rmtree(home / SURVEY, ignore_errors=True)
            (home / REPORT).unlink(missing_ok=True)
            with contextlib.suppress(OSError):  # a person's files are in it
                home.rmdir()

    def _take(self, drop: Drop) -> None:
        """Note a drop's files as those of flights, and move them."""
        stuck = {move.source for flight in self._journal.unfinished() for move in self._journal.moves(flight)}
        files = tuple(one for one in drop.files if one.path not in stuck)
        for part in self._reader.parts(Drop(drop.name, files)) if files else ():
            flight = self._claim(part)
            if flight is not None:
                self._bring(flight)
        self._folder.forget(drop.name)

    def _claim(self, part: Part) -> Flight | None:
        """Return the flight of a part: a new one, or one that is known."""
        owners = self._journal.owners(one.digest for one in part.pictures)
        known = self._known(part, owners)
        if known is None:
            name = plain_name(part.title, self._is_name)
            moves = self._moves(part, name)
            self._journal.add(part, name, moves)
            return self._journal.flight(part.id)
        has_all = all(owners.get(one.digest) == known.id for one in part.pictures)
        if has_all and known.state is State.DONE:
            if self._around.has_survey(known.survey):
                return self._claim_copy(part, known)
            self._journal.map_again(known)
        is_here = self._is_here(known)
        mine = {digest for digest, owner in owners.items() if owner == known.id} if is_here else set()
        moves = self._moves(part, known.name, mine, self._journal.moves(known))
        self._journal.join(known, part, moves, has_others=is_here)
        return self._journal.flight(known.id)

    def _known(self, part: Part, owners: dict[str, str]) -> Flight | None:
        """Return the flight that a part is of, None for a new one."""
        for number, count in Counter(owners.values()).most_common():
            flight = self._journal.flight(number)
            if flight is not None and (count == len(part.pictures) or self._is_here(flight)):
                return flight
        for number, moments in self._journal.near(part.moments).items():
            flight = self._journal.flight(number)
            if flight is not None and self._is_here(flight) and continues(part.moments, moments):
                return flight
        return None

    def _claim_copy(self, part: Part, of: Flight) -> Flight | None:
        name, copy = plain_name(part.title, self._is_name), uuid.uuid4().hex
        self._journal.add_copy(copy, name, of, self._moves(part, name))
        return self._journal.flight(copy)

    def _is_here(self, flight: Flight) -> bool:
        """Return whether a flight's pictures are in one of the inbox's folders, or about to be."""
        return flight.state is State.MAPPING or any(self._homes(flight))

    def _homes(self, flight: Flight) -> list[Path]:
        homes = [self._root / place / flight.name for place in PLACES]
        return [home for home in homes if (home / PICTURES).is_dir() and any((home / PICTURES).iterdir())]

    def _is_name(self, name: str) -> bool:
        folded = {each.casefold() for each in self._journal.names()}
        for place in PLACES:
            folded |= {each.casefold() for each in os.listdir(self._root / place)}
        return name.casefold() in folded

    def _moves(self, part: Part, name: str, known: Collection[str] = (), planned: Sequence[Move] = ()) -> list[Move]:
        """Return where each file of a part goes. ``known``: digests that the flight has; ``planned``: moves before."""
        used = {PICTURES: set[str](), AGAIN: set[str]()}
        for move in planned:
            folder, _, target = move.target.partition("/")
            used[folder].add(target.casefold())
        for place in PLACES:
            for folder, names in used.items():
                with contextlib.suppress(OSError):
                    names |= {each.casefold() for each in os.listdir(self._root / place / name / folder)}
        moves, seen = [], set(known)
        digests = {one.file.path: one.digest for one in part.pictures}
        for path in (*digests, *(other.path for other in part.others)):
            digest = digests.get(path)
            folder = AGAIN if digest in seen else PICTURES
            within = "" if part.is_known else _inner(path)
            name = plain_name(Path(path).name, partial(_is_used, used[folder], within))
            used[folder].add(f"{within}{name}".casefold())
            moves.append(Move(path, f"{folder}/{within}{name}", digest if folder == PICTURES else None))
            if digest is not None:
                seen.add(digest)
        return moves

    def _bring(self, flight: Flight) -> bool:
        """Move a flight's files into its folder; return whether all are there."""
        moves = self._journal.moves(flight)
        home = self._root / MAPPING / flight.name
        if not moves and (home.is_dir() or flight.known_as or self._journal.is_mapped(flight)):
            return True
        if not home.is_dir() and (homes := self._homes(flight)):
            homes[0].rename(home)
            sync_folder(homes[0].parent)
        for inner in {Path(PICTURES), *(Path(move.target).parent for move in moves)}:
            (home / inner).mkdir(parents=True, exist_ok=True)
        vanished = []
        for move in moves:
            target = home / move.target
            if target.exists():
                continue
            try:
                (self._root / move.source).rename(target)
            except FileNotFoundError:
                if move.digest is not None:
                    vanished.append(move.digest)
            except OSError as error:
                self._say(
                    flight.name, "waits", f"{move.source} cannot be moved ({error.strerror}): let hawk write its folder"
                )
                return False
        for folder in (home, self._root / MAPPING):
            sync_folder(folder)
        self._journal.end_moves(flight, vanished)
        self._clear({move.source.partition("/")[0] for move in moves if "/" in move.source})
        return True

    def _clear(self, drops: set[str]) -> None:
        """Remove folders that are empty now, and the old report and survey of a flight that was moved back."""
        for drop in drops:
            folder = self._root / drop
            if is_returned(folder):
                rest = set(os.listdir(folder)) - {REPORT, SURVEY, PICTURES, AGAIN}
                if not rest and not any(files for each in (PICTURES, AGAIN) for _, _, files in os.walk(folder / each)):
                    shutil.rmtree(folder, ignore_errors=True)
            for inner, _, _ in os.walk(folder, topdown=False):
                with contextlib.suppress(OSError):
                    Path(inner).rmdir()

    # -- from a flight to a survey ------------------------------------------------------------------------------------

    def _finish(self, flight: Flight) -> bool:
        """Map a flight and put its folder where it belongs; return whether that was done."""
        home = self._root / MAPPING / flight.name
        if flight.known_as:
            words = report.known(flight, self._around.now())
            return self._end(flight, State.DONE, words, f"already mapped as survey {flight.survey}")
        if self._journal.is_mapped(flight):
            text = "" if (home / REPORT).exists() else report.finished(flight, self._around.now())
            return self._end(flight, State.DONE, text, f"survey {flight.survey}")
        if not self._journal.count(flight):
            return self._lose(flight, home)
        if words := self._full():
            raise PictureError(words)
        self._say(flight.name, "begins", f"pictures: {self._journal.count(flight)}")
        result = self._around.mapper(flight, home)
        if result.is_stopped:
            return False
        if result.report is not None:
            text = report.mapped(flight, result.report, self._journal.count(flight), self._around.now())
            _write(home / REPORT, text)  # before it is noted: a cut between leaves no report of fewer pictures
            self._journal.note_survey(flight, result.report.stored_survey)
            return self._end(flight, State.DONE, "", result.report.store)
        return self._failed(flight, result)

    def _failed(self, flight: Flight, result: MapResult) -> bool:
        """End a flight that cannot be mapped. Raises PictureError where store or disk are why."""
        if words := self._full() or (result.words if result.words.startswith(_OF_STORE) else ""):
            raise PictureError(words)
        if result.signal and flight.tries + 1 < MOST_TRIES:
            self._journal.note_try(flight)
            self._say(flight.name, "waits", f"{result.words}; it is tried again")
            return False
        folder = self._root / FAILED / flight.name
        words = result.words.replace(str(self._root / MAPPING / flight.name), str(folder))
        text = report.failed(flight, words, folder, self._store, self._around.now())
        return self._end(flight, State.FAILED, text, words)

    def _lose(self, flight: Flight, home: Path) -> bool:
        """Forget a flight whose pictures were taken away before they were moved; other files of it are kept."""
        if any(files for _, _, files in os.walk(home)):
            return self._failed(
                flight, MapResult(None, "Its pictures were taken out of the inbox: put them there again")
            )
        shutil.rmtree(home, ignore_errors=True)
        self._journal.forget(flight)
        return False

    def _end(self, flight: Flight, state: State, text: str, words: str) -> bool:
        """Move a flight's folder to the place of its state, with the report's text, and note it."""
        home = self._root / MAPPING / flight.name
        place = self._root / (DONE if state is State.DONE else FAILED)
        name = flight.name
        if home.is_dir():
            if text:
                _write(home / REPORT, text)
            for steps in (WORK, WINDOWS):
                shutil.rmtree(home / SURVEY / steps, ignore_errors=True)
            if (place / name).exists():  # a person has made it meanwhile
                name = plain_name(name, self._is_name)
            home.rename(place / name)
            for folder in (place, home.parent):
                sync_folder(folder)
        self._journal.end(flight, state, name)
        self._say(flight.name, state.value, words)
        return True

    # -- what is said -------------------------------------------------------------------------------------------------

    def _full(self) -> str:
        """Return words on a disk without room, "" where there is."""
        for folder in (self._root, self._store):
            if (free := self._around.free(folder)) < LEAST_FREE:
                return (
                    f"{folder}: {free / 1e6:.0f} MB are free, {LEAST_FREE / 1e6:.0f} MB are needed: make room; nothing "
                    "is lost, and the inbox goes on by itself"
                )
        return ""

    def _say(self, flight: str, outcome: str, words: str) -> None:
        """Say an event; why something waits is said once until a flight ends."""
        event = InboxNotice(flight, outcome, words)
        if event in self._waits:
            return
        if outcome == "waits":
            self._waits.add(event)
        elif outcome != "begins":
            self._waits.clear()
        self._around.say(event)


def _is_used(folded: set[str], within: str, name: str) -> bool:
    return f"{within}{name}".casefold() in folded


def _inner(path: str) -> str:
    """Return the folders below that of a drop in which a file lies, "" or with a slash behind: no camera made them."""
    inner = [each for each in Path(path).parts[1:-1] if each != PICTURES]
    return "".join(f"{plain_name(each, set[str]().__contains__)}/" for each in inner)


def _write(path: Path, text: str) -> None:
    """Write a report; without room, or without its folder, the flight goes on all the same."""
    with contextlib.suppress(OSError):
        replace_whole(path, text.encode())


def _words(error: OSError, folder: Path) -> str:
    return f"{error.filename or folder}: {error.strerror or error}; see that hawk may read and write it"
