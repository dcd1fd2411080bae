"""The folder of recordings: listing, the mark "keep", deletion, and room for new ones.

A mark is a file beside the recording, ``NAME.keep``. The caller makes sure that no drone flies: removing a large file
takes a disk long, and the recording under way is never touched.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from mcap.exceptions import McapError

from hawk.config.sections import StoreSettings
from hawk.store.mcap_records import statistics_of
from hawk.store.replay import ZERO_UTC, RecordingError, read_metadata

SUFFIX: Final = ".mcap"
MARK: Final = ".keep"
NAME: Final = re.compile(r"\d{8}T\d{6}Z(-\d{1,3})?\.mcap")
DAY_S: Final = 86_400.0
CLOCK_SET: Final = datetime(2025, 1, 1, tzinfo=UTC).timestamp()
"""An earlier time is that of a computer whose clock was not set: nothing is old by it, Unix seconds."""


class NotThatRecordingError(Exception):
    """A recording that is not there, or must stay; the text says why, and the remedy."""


@dataclass(frozen=True, slots=True)
class Stored:
    """One recording on the disk. ``began``: UTC, Unix seconds, by its name; None where the clock was not set."""

    name: str
    bytes: int
    began: float | None
    is_kept: bool
    is_under_way: bool = False


@dataclass(frozen=True, slots=True)
class Contents:
    """A recording's length, seconds of its clock, and the name of the survey that was flown.

    ``seconds`` is None where a crash left the file without its end. ``began``: by the clock of the surveys, Unix
    seconds; None where the autopilot had no time.
    """

    seconds: float | None = None
    survey: str = ""
    began: float | None = None


class Recordings:
    """The folder. ``under_way``: the file that is written now, None when none is."""

    def __init__(
        self,
        settings: StoreSettings,
        under_way: Callable[[], Path | None] = lambda: None,
        wall: Callable[[], float] = lambda: datetime.now(UTC).timestamp(),
    ) -> None:
        """``wall``: UTC, Unix seconds. The folder need not be there."""
        self.folder = settings.directory / "recordings"
        self._most_bytes = settings.recordings_gb * 1e9
        self._most_age_s = None if settings.recordings_days is None else settings.recordings_days * DAY_S
        self._under_way = under_way
        self._wall = wall

    def listed(self) -> list[Stored]:
        """Return every recording, the oldest first. Raises OSError.

        Files with names of others are a person's: they are not shown, not counted, and never removed for room.
        """
        under_way = self._under_way()
        found = []
        for path in self.folder.glob(f"*{SUFFIX}") if self.folder.is_dir() else ():
            if NAME.fullmatch(path.name) is None:
                continue
            try:
                one = Stored(path.name, path.stat().st_size, _began(path), _mark(path).exists(), path == under_way)
            except FileNotFoundError:  # deleted meanwhile
                continue
            found.append(one)
        return sorted(found, key=lambda one: (one.began is None, one.began or 0.0, one.name))

    def contents(self, name: str) -> Contents:
        """Read head and end of a recording. Raises NotThatRecordingError; a damaged one has unknown contents."""
        path = self._path(name)
        about = _about(path)
        return Contents(_seconds(path), _survey_in(about), _moment_in(about))

    def complete(self, name: str) -> Path:
        """Return the file of a recording that is not under way. Raises NotThatRecordingError."""
        path = self._path(name)
        if path == self._under_way():
            raise NotThatRecordingError(f"{name}: is being written: it can be shown after the landing")
        return path

    def ends(self, one: Stored) -> float | None:
        """Return when a recording may be removed for its age, Unix seconds; None: not for its age."""
        if one.is_kept or self._most_age_s is None or one.began is None:
            return None
        return one.began + self._most_age_s

    def keep(self, name: str, *, is_kept: bool) -> None:
        """Set or take away the mark. Raises NotThatRecordingError and OSError."""
        mark = _mark(self._path(name))
        if is_kept:
            mark.touch()
        else:
            mark.unlink(missing_ok=True)

    def delete(self, name: str) -> None:
        """Delete a recording. Raises NotThatRecordingError for one that is kept or under way, and OSError."""
        path = self._path(name)
        if path == self._under_way():
            raise NotThatRecordingError(f"{name}: is being written: delete it after the landing")
        if _mark(path).exists():
            raise NotThatRecordingError(f'{name}: is marked "keep": take the mark away first')
        path.unlink()

    def tidy(self) -> list[str]:
        """Remove what is beyond the limits of size and age, the oldest first; return the names. Raises OSError."""
        found = self.listed()
        now = self._wall()
        aged = [one for one in found if self._is_old(one, now)]
        removed = self._remove(aged)
        over = sum(one.bytes for one in found if one.name not in removed) - self._most_bytes
        rest = [one for one in found if one.name not in removed]
        return removed + self._remove(_oldest(rest, over))

    def make_room(self, missing: float) -> list[str]:
        """Remove the oldest for this number of bytes, as far as there are some; return the names. Raises OSError."""
        return self._remove(_oldest(self.listed(), missing))

    def taken(self) -> tuple[int, int]:
        """Return the bytes of all recordings, and of those that are kept. Raises OSError."""
        found = self.listed()
        return sum(one.bytes for one in found), sum(one.bytes for one in found if one.is_kept)

    def free_name(self, stem: str) -> str:
        """Return a name for a new recording that no file has: the stem's, with a number behind it where needed."""
        numbered = (f"{stem.partition('-')[0]}-{number}{SUFFIX}" for number in range(2, 1000))
        return next(name for name in (f"{stem}{SUFFIX}", *numbered) if not (self.folder / name).exists())

    def _path(self, name: str) -> Path:
        path = self.folder / name
        if NAME.fullmatch(name) is None or not path.is_file():
            raise NotThatRecordingError(f"{name}: there is no recording of this name; the list has all")
        return path

    def _is_old(self, one: Stored, now: float) -> bool:
        if self._most_age_s is None or one.began is None or now < CLOCK_SET:
            return False
        return now - one.began > self._most_age_s

    def _remove(self, found: Iterable[Stored]) -> list[str]:
        removed = []
        for one in found:
            if not (one.is_kept or one.is_under_way):
                (self.folder / one.name).unlink(missing_ok=True)
                removed.append(one.name)
        return removed


class OneRecording(Recordings):
    """A single file, wherever it lies, as a folder of recordings: it is shown, and nothing is changed."""

    def __init__(self, path: Path) -> None:
        """The file may have any name: it gets one that recordings have, by when it began."""
        super().__init__(StoreSettings(directory=path.parent))
        self._file = path
        self.name = path.name if NAME.fullmatch(path.name) else f"{_named(path):%Y%m%dT%H%M%SZ}{SUFFIX}"
        """Name under which it is shown."""

    def listed(self) -> list[Stored]:
        """Return the file. Raises OSError."""
        began = _named(self._file).timestamp()
        return [Stored(self.name, self._file.stat().st_size, began if began >= CLOCK_SET else None, True)]

    def keep(self, name: str, *, is_kept: bool) -> None:  # noqa: ARG002 - nothing is marked
        """Raise NotThatRecordingError."""
        raise NotThatRecordingError(f"{name}: {_SHOWN_ALONE}")

    def delete(self, name: str) -> None:
        """Raise NotThatRecordingError."""
        raise NotThatRecordingError(f"{name}: {_SHOWN_ALONE}")

    def _path(self, name: str) -> Path:
        if name != self.name:
            raise NotThatRecordingError(f"{name}: there is no recording of this name; the list has all")
        return self._file


_SHOWN_ALONE: Final = "is shown alone, and nothing is changed: open its store by hawk-drone desk --store DIR"


def _named(path: Path) -> datetime:
    """Return when a file began, by what it says, else by its name or time of change."""
    with suppress(RecordingError, LookupError, ValueError):
        return datetime.fromisoformat(read_metadata(path)["utc"]).astimezone(UTC)
    return datetime.fromtimestamp(_began(path) or 0.0, UTC)


def survey_of(path: Path) -> str:
    """Return the name of the survey that a recording holds; "" where it names none, or cannot be read."""
    return _survey_in(_about(path))


def _about(path: Path) -> Mapping[str, str]:
    """Return what a recording says of itself; nothing where it cannot be read."""
    try:
        return read_metadata(path)
    except RecordingError:
        return {}


def _survey_in(about: Mapping[str, str]) -> str:
    return about.get("survey", "")


def _moment_in(about: Mapping[str, str]) -> float | None:
    """Return when a recording began by the autopilot's GNSS, Unix seconds; None where it does not say that."""
    try:
        return datetime.fromisoformat(about[ZERO_UTC]).timestamp() + float(about["clock"])
    except (LookupError, ValueError, OverflowError):
        return None


def _oldest(found: Sequence[Stored], missing: float) -> list[Stored]:
    """Return the oldest that may be removed, until they are this number of bytes."""
    chosen = []
    for one in found:
        if missing <= 0:
            break
        if not (one.is_kept or one.is_under_way):
            chosen.append(one)
            missing -= one.bytes
    return chosen


def _seconds(path: Path) -> float | None:
    """Return the length by the counts at the end; None where they cannot be read."""
    try:
        counted = statistics_of(path)
    except (McapError, OSError, ValueError, struct.error):
        return None
    return None if counted is None else (counted.message_end_time - counted.message_start_time) / 1e9


def _mark(path: Path) -> Path:
    return path.with_suffix(MARK)


def _began(path: Path) -> float | None:
    try:
        began = datetime.strptime(path.name[:16], "%Y%m%dT%H%M%SZ").replace(tzinfo=UTC).timestamp()
    except ValueError:
        began = path.stat().st_mtime
    return began if began >= CLOCK_SET else None
