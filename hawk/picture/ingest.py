"""A survey by pictures in the store of lots, as one after a landing is."""

from __future__ import annotations

import asyncio
import contextlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, Self

from hawk.daemon.lots.keeper import find_stalls
from hawk.lots.store import LotStore, lots_file
from hawk.lots.survey.landing import LandingFacts
from hawk.lots.values import PLACED, LotStoreError, Placed, Saved, fitting_name
from hawk.picture.values import NO_STALLS, LotSurvey, PictureError, PictureSurvey
from hawk.runtime.late import late

if TYPE_CHECKING:  # loaded on the store's thread
    from shapely import Polygon

    from hawk.lots import queries
    from hawk.lots.survey import private_ground
else:
    queries = late("hawk.lots.queries")
    private_ground = late("hawk.lots.survey.private_ground")

_WORDS: Final = {
    Placed.FIRST: "the first survey of {lot}",
    Placed.REGISTERED: "a survey of {lot}, with {known} of its stalls",
    Placed.UNREGISTERED: "a survey of {lot}, whose place is not certain: {doubt}",
    Placed.UNDECIDED: "a survey that may be of several lots: choose one on the page, under Lots",
    Placed.NOTHING: f"a survey without a lot: {NO_STALLS}",
}
_MANY: Final = {
    Placed.FIRST: "new lots",
    Placed.REGISTERED: "surveys of known lots",
    Placed.UNREGISTERED: "surveys of known lots whose place is not certain",
    Placed.UNDECIDED: "surveys that may be of several lots: choose one on the page, under Lots",
    Placed.NOTHING: "surveys without stalls",
}


@dataclass(frozen=True, slots=True)
class StoredSurvey:
    """A survey in the store: what it is there, in ``words``, the ids of its ``lot``, None without one, and its own.

    ``doubt``: why its place among the stalls of a lot is not certain, "" where it is.
    """

    words: str
    lot: str | None
    survey: str
    doubt: str = ""

    def said_of(self, mapped: PictureSurvey) -> PictureSurvey:
        """Return a survey with the store's doubt, as its files say it; one that says a doubt of its own keeps that."""
        doubt = mapped.survey.doubt or self.doubt
        return replace(mapped, survey=replace(mapped.survey, doubt=doubt))


def store_survey(landed: LandingFacts, folder: Path, name: str | None = None) -> StoredSurvey:
    """Store a survey among the lots of a folder. Raises PictureError.

    ``name``: that a person gave its lot, None without one. A lot that is there keeps its own, and the words say so.
    """
    with opened_store(folder) as store:
        saved = store.save(landed)
    words = placed_words(saved)
    kept = ""
    is_known = saved.lot is not None and saved.placed is not Placed.FIRST
    if name is not None and is_known and saved.lot_name != fitting_name(name):
        kept = (
            f". The lot keeps its name {saved.lot_name}, --name {name} is not used: rename it on the page, under Lots"
        )
    return StoredSurvey(f"Stored in {folder} as {words}{kept}", saved.lot, saved.survey, doubt_of(saved))


def has_survey(folder: Path, survey: str) -> bool:
    """Return whether the store of a folder has the survey of an id. Raises PictureError."""
    if not lots_file(folder).exists():
        return False
    with opened_store(folder) as store:
        return store.has(survey)


def placed_words(saved: Saved) -> str:
    """Return what a survey is in the store."""
    return _WORDS[saved.placed].format(lot=saved.lot_name, known=saved.known, doubt=saved.doubt)


def doubt_of(saved: Saved) -> str:
    """Return why the place of a survey among the stalls of a lot is not certain, "" where it is."""
    return "" if saved.placed in PLACED else f"{saved.placed}: its place among the lot's stalls is not certain"


class OpenedStore:
    """A store into which surveys are saved one after the other."""

    def __init__(self, store: LotStore, runner: asyncio.Runner) -> None:
        """``runner``: runs the store's calls."""
        self._store = store
        self._runner = runner

    def save(self, landed: LandingFacts) -> Saved:
        """Save a survey. Raises PictureError; nothing is written then."""
        try:
            return self._runner.run(self._store.save(landed))
        except (LotStoreError, OSError) as error:
            raise PictureError(f"--store: {error}") from error

    def has(self, survey: str) -> bool:
        """Return whether the store has the survey of an id. Raises PictureError."""
        try:
            return self._runner.run(self._store.read(lambda connection: queries.is_stored(connection, survey)))
        except (LotStoreError, OSError) as error:
            raise PictureError(f"--store: {error}") from error

    def private_areas(self) -> tuple[Polygon, ...]:
        """Return the private ground of the store's lots, (longitude, latitude). Raises PictureError."""
        try:
            return self._runner.run(self._store.read(private_ground.private_areas))
        except (LotStoreError, OSError) as error:
            raise PictureError(f"--store: {error}") from error


def private_areas(folder: Path | None) -> tuple[Polygon, ...]:
    """Return the private ground of a store that is there; none of another one. Raises PictureError."""
    if folder is None or not lots_file(folder).exists():
        return ()
    with opened_store(folder) as store:
        return store.private_areas()


@contextlib.contextmanager
def opened_store(folder: Path) -> Iterator[OpenedStore]:
    """Open the store of a folder, which is made. Raises PictureError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PictureError(f"--store: {error}") from error
    store = LotStore(lots_file(folder), find_stalls)
    with asyncio.Runner() as runner:
        try:
            yield OpenedStore(store, runner)
        finally:
            runner.run(store.close())


class LotsStore:
    """Takes the surveys of several lots, or nothing without a folder. A failure ends the storing, not the work.

    ``failure``: the error of the first survey that could not be stored; None: all were.
    """

    def __init__(self, folder: Path | None) -> None:
        """``folder``: of the store; None: nothing is stored."""
        self.failure: PictureError | None = None
        self._folder = folder
        self._stack = contextlib.ExitStack()
        self._store: OpenedStore | None = None
        self._placed: Counter[Placed] = Counter()

    def __enter__(self) -> Self:
        """Open the store. Raises PictureError."""
        if self._folder is not None:
            self._store = self._stack.enter_context(opened_store(self._folder))
        return self

    def __exit__(self, *_: object) -> None:
        """Close the store."""
        self._stack.close()

    def keep(self, survey: LotSurvey) -> tuple[LotSurvey, str]:
        """Store the survey of a lot; return it with the store's doubt, and the words on what it is there."""
        if self._store is None or self.failure is not None:
            return survey, ""
        try:
            saved = self._store.save(survey.mapped.landed)
        except PictureError as error:
            self.failure = error
            return survey, ""
        self._placed[saved.placed] += 1
        record = survey.mapped.survey
        doubt = record.doubt or doubt_of(saved)
        mapped = replace(survey.mapped, survey=replace(record, doubt=doubt))
        doubts = (
            (*survey.doubts, f"In the store: {doubt}.") if doubt_of(saved) and len(record.stalls) else survey.doubts
        )
        return replace(survey, mapped=mapped, doubts=doubts), placed_words(saved)

    @property
    def words(self) -> str:
        """Number of surveys of each kind in the store, "" where nothing is stored."""
        if self._folder is None:
            return ""
        parts = [f"{count} {_MANY[placed]}" for placed in _MANY if (count := self._placed[placed])]
        return f"Stored in {self._folder}: {', '.join(parts) or 'nothing'}"
