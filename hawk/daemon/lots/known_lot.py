"""Follows the plans of the lots that the drone flies over, for the map of its flight. The flight waits for none of it.

While the motors are on, the plan stays as the flight began with it: who changes the store meanwhile steers nothing. A
changed plan is offered, and flown when the one in control takes it.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable, Mapping
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
    from hawk.lots.known_lot import Due
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
    """The question: the lot about a ``place`` (latitude, longitude), or those with the ids ``again``."""

    place: tuple[float, float]
    survey: str
    again: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Found:
    """The plan of a lot in the store as it is now; ``lot`` is None where it has no stalls."""

    stamp: _Stamp
    name: str
    lot: KnownLot | None = field(repr=False)
    author: str = ""
    private: tuple[Ring, ...] = field(default=(), repr=False)


class KnownLotFollower:
    """`current` are the plans to fly with."""

    def __init__(
        self,
        store: LotStore,
        datum: Callable[[], GlobalPose | None],
        survey: Callable[[], str],
        add_message: Callable[[Level, str, str], object],
        look_s: float = LOOK_S,
        tours: TourKeeper | None = None,
        due: Due = lambda *_: False,
    ) -> None:
        """Take the parts; nothing runs before `run`.

        Args:
            store: The lots' store; nothing is read before somebody has opened it.
            datum: Returns the origin of the map, where the drone was armed; None before.
            survey: Returns the name of the survey under way: it is no witness of itself.
            add_message: Adds a message for the operator: level, text, details.
            look_s: Real seconds between two looks.
            tours: Plans the flight over lots that are surveyed again, and knows whether one is under way; None: no lot
                is surveyed again, and nothing flies.
            due: Returns whether a survey of a lot is due.
        """
        self._store = store
        self._datum = datum
        self._survey = survey
        self._add_message = add_message
        self._look_s = look_s
        self._tours = tours
        self._asked: _Asked | None = None
        self._due = due
        self._flown: tuple[_Found, ...] = ()
        self._seen: tuple[_Found, ...] = ()
        self._offers: dict[str, _Found] = {}
        self._offer: PlanOffer | None = None
        self._reported = ""
        self._named: set[str] = set()
        self._woken = asyncio.Event()
        self.current: tuple[KnownLot, ...] = ()

    @property
    def lots(self) -> tuple[str, ...]:
        """Ids of the lots that are flown over, also of those without stalls."""
        return tuple(_lots(self._flown))

    @property
    def private(self) -> tuple[Ring, ...]:
        """Rings of ground on the map that nobody may look at, by the newest plan: they steer nothing."""
        return tuple(ring for each in self._seen for ring in each.private)

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
        """Read the plans of the lots at the map's origin, or asked for, where they are others than before."""
        again = () if self._tours is None else self._tours.asked
        datum = self._datum() or (None if self._tours is None else self._tours.here)
        if datum is None or not (self._store.is_open or again):
            return
        self._take_offer()
        asked = _Asked((datum.latitude, datum.longitude), self._survey(), again)
        kept = self._seen if _is_place_of(asked, self._asked) else ()
        known = {found.stamp: found for found in kept if found.lot is not None or not again}
        has_tours = self._tours is not None

        def read(connection: Connection) -> tuple[tuple[_Found, ...], tuple[LotAhead, ...]]:
            ahead = queries.lots_ahead(connection, asked.place, self._due) if has_tours else ()
            return _found(connection, asked, known), ahead

        try:
            found, ahead = await self._store.read(read)
        except LotStoreError as error:
            _LOG.warning("the plans of the lots cannot be read: %s", error)
            if self._tours is not None:
                self._tours.fail(str(error))
            return
        self._follow(asked, found)
        if self._tours is not None:
            await self._tours.follow(self.current, datum, ahead, self._offer)

    def _follow(self, asked: _Asked, found: tuple[_Found, ...]) -> None:
        """Fly with what the store has; in flight offer it, also where the same lots are asked for again."""
        before, self._asked, self._seen = self._asked, asked, found
        is_same = asked == before or (_is_place_of(asked, before) and _lots(found) == _lots(self._flown))
        if is_same and self._tours is not None and self._tours.is_flying:
            self._offer_plans(found)
        else:
            self._use(found)

    def _use(self, found: tuple[_Found, ...]) -> None:
        self._offers.clear()
        self._offer, self._reported, self._flown = None, "", found
        current = tuple(each.lot for each in found if each.lot is not None)
        if current != self.current:  # frames, and their recording, have the same object until a plan changes
            self.current = current
        for each in found:
            if each.lot is not None and each.lot.stalls and each.lot.id not in self._named:
                self._report(each.name, each.lot)
        self._named = {lot.id for lot in self.current} or self._named

    def _offer_plans(self, found: tuple[_Found, ...]) -> None:
        """Offer the first plan that was changed in flight. One that is gone, and new names alone, change no flight."""
        flown = {each.stamp[0]: each for each in self._flown}
        self._offer = None
        for gone in {*flown} - {*_lots(found)}:
            self._report_change("", flown[gone].name)
        for new in found:
            former = flown.get(new.stamp[0])
            before = None if former is None else former.lot
            if former is not None and former.stamp == new.stamp:
                continue
            if new.lot is None or (former is None and flown):
                self._report_change(new.author, new.name)
            elif before is None or _without_labels(new.lot) != _without_labels(before):
                self._offer = offer = _offer_of(new, new.lot, before)
                self._offers[offer.id] = new
                while len(self._offers) > _OFFERS_KEPT:
                    del self._offers[next(iter(self._offers))]
                self._report_change(new.author, new.name)
                return

    def _report_change(self, author: str, name: str) -> None:
        """Say once of each name that the plan was changed. Who edits a plan signs with any name."""
        person = author or SOME_OPERATOR
        if person == self._reported:
            return
        self._reported = person
        words = say("The plan of {name} was changed, signed as {person}.", name=name, person=person)
        _LOG.info("%s", words)
        details = say("The flight goes on as it began.")
        self._add_message("warning", words, details)

    def _take_offer(self) -> None:
        """Fly with the offer that was taken. What the store has by now may be another one: it is offered next."""
        taken = self._offers.get("" if self._tours is None else self._tours.taken)
        if taken is not None:
            others = [each for each in self._flown if each.stamp[0] != taken.stamp[0]]
            flown = {each.stamp[0]: each for each in (*others, taken)}
            order = [*(each.stamp[0] for each in self._flown), taken.stamp[0]]
            self._use(tuple(flown[lot] for lot in dict.fromkeys(order)))

    def _report(self, name: str, lot: KnownLot) -> None:
        confirmed = sum(stall.is_confirmed for stall in lot.stalls)
        count = say("{confirmed} of {stalls} stalls are confirmed.", confirmed=confirmed, stalls=len(lot.stalls))
        self._add_message("info", say("This is {name}: its plan is known.", name=name), count)


def _found(connection: Connection, asked: _Asked, known: Mapping[_Stamp, _Found]) -> tuple[_Found, ...]:
    """Return what the store has; what is ``known`` again where that did not change."""
    found = []
    for stamp, name in queries.lots_flown(connection, asked.place, asked.again):
        if stamp in known:
            found.append(replace(known[stamp], name=name))
            continue
        lot = queries.known_lot(connection, stamp[0], asked.place, asked.survey)
        author = queries.last_author(connection, stamp[0])
        private = queries.private_ground(connection, stamp[0], asked.place)
        is_flown = lot.has_plan if asked.again else bool(lot.stalls)
        found.append(_Found(stamp, name, lot if is_flown else None, author, private))
    return tuple(found)


def _is_place_of(asked: _Asked, before: _Asked | None) -> bool:
    return before is not None and (asked.place, asked.survey) == (before.place, before.survey)


def _lots(found: tuple[_Found, ...]) -> list[str]:
    return [each.stamp[0] for each in found]


def _offer_of(found: _Found, lot: KnownLot, flown: KnownLot | None) -> PlanOffer:
    before = 0 if flown is None else len(flown.stalls)
    return PlanOffer("-".join(map(str, found.stamp)), found.name, found.author, len(lot.stalls), before)


def _without_labels(lot: KnownLot) -> KnownLot:
    """Return a plan without what steers nothing."""
    return replace(lot, stalls=tuple(replace(stall, label="") for stall in lot.stalls))
