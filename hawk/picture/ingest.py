"""A survey by pictures in the store of lots, as one after a landing is."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from hawk.daemon.lots.keeper import find_stalls
from hawk.lots.store import LotStore, lots_file
from hawk.lots.survey.landing import LandingFacts
from hawk.lots.values import PLACED, LotStoreError, Placed, Saved, fitting_name
from hawk.picture.values import NO_STALLS, PictureError, PictureSurvey

_WORDS: Final = {
    Placed.FIRST: "the first survey of {lot}",
    Placed.REGISTERED: "a survey of {lot}, with {known} of its stalls",
    Placed.UNREGISTERED: "a survey of {lot}, whose place is not certain: {doubt}",
    Placed.UNDECIDED: "a survey that may be of several lots: choose one on the page, under Lots",
    Placed.NOTHING: f"a survey without a lot: {NO_STALLS}",
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
    try:
        folder.mkdir(parents=True, exist_ok=True)
        saved = asyncio.run(_save(landed, folder))
    except (LotStoreError, OSError) as error:
        raise PictureError(f"--store: {error}") from error
    words = _WORDS[saved.placed].format(lot=saved.lot_name, known=saved.known, doubt=saved.doubt)
    kept = ""
    is_known = saved.lot is not None and saved.placed is not Placed.FIRST
    if name is not None and is_known and saved.lot_name != fitting_name(name):
        kept = (
            f". The lot keeps its name {saved.lot_name}, --name {name} is not used: rename it on the page, under Lots"
        )
    doubt = "" if saved.placed in PLACED else f"{saved.placed}: its place among the lot's stalls is not certain"
    return StoredSurvey(f"Stored in {folder} as {words}{kept}", saved.lot, saved.survey, doubt)


async def _save(landed: LandingFacts, folder: Path) -> Saved:
    store = LotStore(lots_file(folder), find_stalls)
    try:
        return await store.save(landed)
    finally:
        await store.close()
