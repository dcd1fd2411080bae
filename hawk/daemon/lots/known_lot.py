"""Follows the plan of the lot at which the drone stands, for the map of its flight. The flight waits for none of it.

While the motors are on, the plan stays as the flight began with it: who changes the store meanwhile steers nothing. A
changed plan is offered, and flown when the one in control takes it.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from hawk.daemon.lots.tour import TourKeeper
from hawk.ddc.readings.operator import SOME_OPERATOR
from hawk.lots.store import LotStore
from hawk.lots.values import LotStoreError
from hawk.model.known_lot import KnownLot, LotAhead, PlanOffer
from hawk.model.operation import Level
from hawk.model.poses import GlobalPose, Ring
from hawk.model.sentences import say
from hawk.runtime.late import late

if TYPE_CHECKING:  # loaded on the store's thread
    from sqlalchemy import Connection

    from hawk.lots import known_lot as queries
else:
    queries = late("hawk.lots.known_lot")

_LOG = logging.getLogger(__name__)

LOOK_S: Final = 2.0
"""Real seconds between two looks for a changed plan."""
_OFFERS_KEPT: Final = 8
"""Offers that may still be taken: one is answered while the next change is read."""

_Stamp = tuple[str, int, int]


@dataclass(frozen=True, slots=True)
class _Asked:
    """The question: the lot about a ``place`` (latitude, longitude), or the one with the id ``again``."""

    place: tuple[float, float]
    survey: str
    again: str


@dataclass(frozen=True, slots=True)
class _Found:
    """The plan in the store as it is now; ``lot`` is None where it has no stalls, or where there is none."""

    stamp: _Stamp | None = None
    name: str = ""
    lot: KnownLot | None = field(default=None, repr=False)
    author: str = ""
    private: tuple[Ring, ...] = field(default=(), repr=False)


class KnownLotFollower:
    """`current` is the plan to fly with."""

    def __init__(
        self,
        store: LotStore,
        datum: Callable[[], GlobalPose | None],
        survey: Callable[[], str],
        add_message: Callable[[Level, str, str], object],
        look_s: float = LOOK_S,
        tours: TourKeeper | None = None,
    ) -> None:
        """Take the parts; nothing runs before `run`.

        Args:
            store: The lots' store; nothing is read before somebody has opened it.
            datum: Returns the origin of the map, where the drone was armed; None before.
            survey: Returns the name of the survey under way: it is no witness of itself.
            add_message: Adds a message for the operator: level, text, details.
            look_s: Real seconds between two looks.
            tours: Plans the flight over a lot that is surveyed again, and knows whether one is under way; None: no lot
                is surveyed again, and nothing flies.
        """
        self._store = store
        self._datum = datum
        self._survey = survey
        self._add_message = add_message
        self._look_s = look_s
        self._tours = tours
        self._asked: _Asked | None = None
        self._stamp: _Stamp | None = None
        self._seen = _Found()
        self._offers: dict[str, _Found] = {}
        self._offer: PlanOffer | None = None
        self._reported = ""
        self._named = ""
        self._name = ""
        self._woken = asyncio.Event()
        self.current: KnownLot | None = None

    @property
    def lot(self) -> str:
        """Id of the lot at which the drone is, also of one without stalls; "" where none is known."""
        return _lot_of(self._stamp) or ""

    @property
    def private(self) -> tuple[Ring, ...]:
        """Rings of ground on the map that nobody may look at, by the newest plan: they steer nothing."""
        return self._seen.private

    def wake(self) -> None:
        """Look now: a lot that the page lists can be surveyed again at once."""
        self._woken.set()

    async def run(self) -> None:
        """Follow the plan until cancelled."""
        while True:
            self._woken.clear()
            await self.look()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(self._look_s):
                    await self._woken.wait()

    async def look(self) -> None:
        """Read the plan of the lot at the map's origin where it is another one than before."""
        again = "" if self._tours is None else self._tours.asked
        datum = self._datum() or (None if self._tours is None else self._tours.here)
        if datum is None or not (self._store.is_open or again):
            return
        self._take_offer()
        asked = _Asked((datum.latitude, datum.longitude), self._survey(), again)
        known = self._seen if asked == self._asked else _Found()
        has_tours = self._tours is not None

        def read(connection: Connection) -> tuple[_Found, tuple[LotAhead, ...]]:
            return _found(connection, asked, known), queries.lots_ahead(connection, asked.place) if has_tours else ()

        try:
            found, ahead = await self._store.read(read)
        except LotStoreError as error:
            _LOG.warning("the plan of the lot cannot be read: %s", error)
            if self._tours is not None:
                self._tours.fail(str(error))
            return
        self._follow(asked, found)
        if self._tours is not None:
            await self._tours.follow(self.current, datum, ahead, self._offer)

    def _follow(self, asked: _Asked, found: _Found) -> None:
        """Fly with what the store has; in flight offer it, also where the same lot is asked for again."""
        before, self._asked, self._seen = self._asked, asked, found
        is_same = asked == before or (_is_place_of(asked, before) and _lot_of(found.stamp) == _lot_of(self._stamp))
        if not (is_same and self._tours is not None and self._tours.is_flying):
            self._use(found)
        elif found.stamp == self._stamp:
            self._offer = None  # it was changed back
        else:
            self._offer_plan(found)

    def _use(self, found: _Found) -> None:
        self._offers.clear()
        self._offer, self._reported = None, ""
        self.current, self._stamp, self._name = found.lot, found.stamp, found.name
        if found.lot is not None and found.lot.id != self._named:
            self._named = found.lot.id
            self._report(found.name, found.lot)

    def _offer_plan(self, found: _Found) -> None:
        """Offer a plan that was changed in flight. One that is gone, and other names alone, change no flight."""
        lot, flown = found.lot, self.current
        if found.stamp is None or lot is None or (flown is not None and lot.id != flown.id):
            self._offer = None
            self._report_change(found.author)
        elif flown is not None and _without_labels(lot) == _without_labels(flown):
            self._offer = None
        else:
            self._name = found.name
            self._offer = offer = _offer_of(found, lot, flown)
            self._offers[offer.id] = found
            while len(self._offers) > _OFFERS_KEPT:
                del self._offers[next(iter(self._offers))]
            self._report_change(found.author)

    def _report_change(self, author: str) -> None:
        """Say once of each name that the plan was changed. Who edits a plan signs with any name."""
        person = author or SOME_OPERATOR
        if person == self._reported:
            return
        self._reported = person
        words = say("The plan of {name} was changed, signed as {person}.", name=self._name, person=person)
        _LOG.info("%s", words)
        details = say("The flight goes on as it began.")
        self._add_message("warning", words, details)

    def _take_offer(self) -> None:
        """Fly with the offer that was taken. What the store has by now may be another one: it is offered next."""
        taken = self._offers.get("" if self._tours is None else self._tours.taken)
        if taken is not None:
            self._use(taken)

    def _report(self, name: str, lot: KnownLot) -> None:
        confirmed = sum(stall.is_confirmed for stall in lot.stalls)
        count = say("{confirmed} of {stalls} stalls are confirmed.", confirmed=confirmed, stalls=len(lot.stalls))
        self._add_message("info", say("This is {name}: its plan is known.", name=name), count)


def _found(connection: Connection, asked: _Asked, known: _Found) -> _Found:
    """Return what the store has; ``known`` again where that did not change."""
    near = queries.lot_near(connection, asked.place, asked.again)
    if near is None:
        return _Found()
    stamp, name = near
    if stamp == known.stamp:
        return replace(known, name=name)
    lot = queries.known_lot(connection, stamp[0], asked.place, asked.survey)
    author, private = (
        queries.last_author(connection, stamp[0]),
        queries.private_ground(connection, stamp[0], asked.place),
    )
    return _Found(stamp, name, lot if lot.stalls else None, author, private)


def _is_place_of(asked: _Asked, before: _Asked | None) -> bool:
    return before is not None and (asked.place, asked.survey) == (before.place, before.survey)


def _lot_of(stamp: _Stamp | None) -> str | None:
    return None if stamp is None else stamp[0]


def _offer_of(found: _Found, lot: KnownLot, flown: KnownLot | None) -> PlanOffer:
    assert found.stamp is not None  # noqa: S101 - a plan has one
    number = "-".join(map(str, found.stamp))
    before = 0 if flown is None else len(flown.stalls)
    return PlanOffer(number, found.name, found.author, len(lot.stalls), before)


def _without_labels(lot: KnownLot) -> KnownLot:
    """Return a plan without what steers nothing."""
    return replace(lot, stalls=tuple(replace(stall, label="") for stall in lot.stalls))
