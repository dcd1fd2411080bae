"""Saves each survey in the lots' store once the drone has landed, and says on the page where it went.

A lot of a round is saved in flight as soon as the round is done with it. The flight waits for none of it. A save that
fails is a message with its remedy and is tried again, while the drone is on the ground; the map and its exports do not
depend on it.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

from hawk.lots.store import LotStore
from hawk.lots.survey.landing import LandingFacts
from hawk.lots.values import Doubtful, KnownGround, LotStoreError, MappedGround, Placed, Registration, Saved
from hawk.model.operation import Level
from hawk.model.plans import PathPlan
from hawk.model.sentences import say

_LOG = logging.getLogger(__name__)

SETTLE_S: Final = 1.0
"""Real seconds after a landing in which the last pictures come into the map."""
RETRY_S: Final = 60.0
"""Real seconds between two tries of a save."""


def find_stalls(known: KnownGround, found: MappedGround) -> Registration | Doubtful:
    """Return which stalls of a lot a survey found, or the doubt. Loads scipy, on the store's thread."""
    from hawk.daemon.lots.registration import registration

    return registration(known, found)


@dataclass(frozen=True, slots=True)
class KeeperTimes:
    """Real seconds: `SETTLE_S` and `RETRY_S`."""

    settle_s: float = SETTLE_S
    retry_s: float = RETRY_S


class LotKeeper:
    """`note` and `run` belong to the loop."""

    def __init__(
        self,
        store: LotStore,
        landed: Callable[[], LandingFacts | None],
        add_message: Callable[[Level, str, str], object],
        times: KeeperTimes | None = None,
        *,
        is_restored: bool = False,
        stored: Callable[[], object] = lambda: None,
    ) -> None:
        """Take the parts; nothing runs before `run`.

        Args:
            store: The lots' store.
            landed: Returns the survey as it is now; None before there is a map with a place on Earth.
            add_message: Adds a message for the operator: level, text, details.
            times: Intervals.
            is_restored: The map of an earlier run comes back: it is saved once it is there.
            stored: Called when a survey is stored, before the operator hears of it.
        """
        self._store = store
        self._landed = landed
        self._add_message = add_message
        self._times = times or KeeperTimes()
        self._is_awaited = is_restored
        self._stored = stored
        self._armed: bool | None = None
        self._armed_at: float | None = None
        self._due = asyncio.Event()
        self._kept: dict[str, tuple[str, int]] = {}
        """Survey and version of the map that was saved, by the lot of a round; "": the whole flight."""
        self._doubtful: set[str] = set()
        self._over: frozenset[str] = frozenset()
        self._ahead: frozenset[str] = frozenset()
        """Lots of the round that this flight has not begun: stalls seen beyond another lot are no survey of them."""
        self._begun: set[str] = set()
        """Lots that any flight of this run has begun."""
        self._knows_all = not is_restored
        self._left_of: tuple[str, float | None] = ("", None)
        self._failure = ""
        self._lock = asyncio.Lock()
        self._flying: set[asyncio.Task[None]] = set()

    @property
    def is_armed(self) -> bool:
        """True while the motors are on, as far as known."""
        return bool(self._armed)

    def note(self, *, armed: bool) -> None:
        """Note whether the motors are on: each landing is a save, and no backup is restored in flight."""
        if armed is self._armed:
            return
        if armed:
            self._armed_at, self._ahead = time.monotonic(), frozenset()
        if armed or self._armed:
            task = asyncio.create_task(self._store.fly(is_flown=armed), name="lots-flight")
            self._flying.add(task)
            task.add_done_callback(self._flying.discard)
        self._armed = armed
        if not armed:
            self._due.set()  # at the first word too: an earlier run may have ended in the air

    def note_plan(self, plan: PathPlan) -> None:
        """Note with which lots the round is done: each is saved at once; and which ones it has not begun."""
        if looks := plan.explore.lots:
            self._begun |= {look.lot for look in looks if look.is_over or look.seen > 0.0}
            self._ahead = frozenset(look.lot for look in looks) - self._begun
        over = frozenset(look.lot for look in plan.explore.lots if look.is_over)
        if over - self._over:
            self._due.set()
        self._over = over

    async def run(self) -> None:
        """Open the store, and save each survey that has landed, until cancelled."""
        if self._armed:
            await self._due.wait()  # loading SQLAlchemy delays a tick by tens of milliseconds: not in flight
        await self._open()
        while True:
            await self._due.wait()
            self._due.clear()
            await asyncio.sleep(self._times.settle_s)
            while not await self.keep() and not self._armed:
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(self._times.retry_s):
                        await self._due.wait()
                        self._due.clear()  # one that stays set would never let another task run

    async def keep(self) -> bool:
        """Save the survey as it is now, lot by lot in a round, unless it was saved; return False when that failed.

        In flight only lots are saved with which a round is done.
        """
        async with self._lock:
            landed, is_armed = self._landed(), bool(self._armed)
            if landed is None:
                return is_armed or not self._is_awaited
            self._is_awaited = self._is_awaited and is_armed
            return await self._save(landed, self._lots_due(landed, is_armed=is_armed))

    def _lots_due(self, landed: LandingFacts, *, is_armed: bool) -> list[str]:
        """Return the lots of a round that are to be saved, by their ids; "" for the whole of any other flight."""
        lots = () if landed.outline is None else landed.outline.lots
        if len(lots) < 2:
            return [] if is_armed else [""]
        if is_armed and not self._store.is_open:
            return []  # loading its libraries delays a tick
        done = {lot.id for lot in lots if lot.is_over and self._kept.get(lot.id, ("",))[0] == landed.name}
        if not is_armed:
            done -= self._doubtful  # the map has shown more since
            done |= self._ahead if self._knows_all else set()  # an earlier run may have begun any lot
        return [lot.id for lot in lots if lot.id not in done and (lot.is_over or not is_armed)]

    async def _save(self, landed: LandingFacts, lots: Sequence[str]) -> bool:
        state, flown = (landed.name, landed.current.version), replace(landed, flown_s=self._flown_s())
        for lot in lots:
            if self._kept.get(lot) == state:
                continue
            try:
                saved = await (self._store.save_share(flown, lot) if lot else self._store.save(flown))
            except LotStoreError as error:
                self._fail(str(error))
                return False
            self._kept[lot], self._failure = state, ""
            self._doubtful.discard(lot)
            if saved is not None:
                if saved.doubt:
                    self._doubtful.add(lot)
                self._stored()
                self._report(saved)
        if not self._armed and self._armed_at is not None:
            self._report_left(landed)
        return True

    def _flown_s(self) -> float:
        """Return the real seconds since the last take-off that this run has seen."""
        return 0.0 if self._armed_at is None else time.monotonic() - self._armed_at

    async def _open(self) -> None:
        try:
            if notice := await self._store.open():
                self._add_message("warning", say("The store of lots."), notice)
        except LotStoreError as error:
            self._fail(str(error))

    def _fail(self, words: str) -> None:
        if words == self._failure:
            return
        self._failure = words
        _LOG.error("the store of lots: %s", words)
        self._add_message("error", say("The survey is not in the store of lots; its map and files are whole."), words)

    def _report_left(self, landed: LandingFacts) -> None:
        """Say once a flight which lots of a round were not finished."""
        lots = () if landed.outline is None else landed.outline.lots
        left = ", ".join(lot.name for lot in lots if not lot.is_over)
        if left and len(lots) > 1 and self._left_of != (landed.name, self._armed_at):
            self._left_of = (landed.name, self._armed_at)
            words = say("Fly on, or survey them again: they are first then.")
            self._add_message("warning", say("Not finished: {lots}.", lots=left), words)

    def _report(self, saved: Saved) -> None:
        if saved.placed is Placed.UNDECIDED:
            self._add_message(
                "warning",
                say("Which lot is it? The survey is stored without one."),
                say("{count} lots may be meant: choose one under Lots.", count=len(saved.candidates)),
            )
        elif saved.placed is Placed.FIRST:
            self._add_message("info", say("The survey is stored as the first one of {name}.", name=saved.lot_name), "")
        elif saved.placed is Placed.REGISTERED:
            count = say("{known} of {stalls} stalls are known ones.", known=saved.known, stalls=saved.stalls)
            self._add_message("info", say("The survey is stored as one of {name}.", name=saved.lot_name), count)
        elif saved.doubt:
            words = say("Not certain where it lies on {name}: {doubt}.", name=saved.lot_name, doubt=saved.doubt)
            stored = say("The survey is stored as one of {name}.", name=saved.lot_name)
            self._add_message("warning", stored, words)
        elif saved.placed is not Placed.NOTHING:
            self._add_message("info", say("The survey is stored as one of {name}.", name=saved.lot_name), "")
