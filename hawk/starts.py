"""The starts of this program in the air, as the journal counts them over its crashes."""

from __future__ import annotations

import time
from collections.abc import Callable

from hawk.ddc.restart import RESTART_WINDOW_S, RestartRule, flight_goes_on, restart_rule
from hawk.store.journal import FlightJournal
from hawk.store.journal_state import JournalState


class Starts:
    """This start among those before it.

    It counts from its beginning when the journal knows of a flight under way, else once the drone is found in the air.
    A start on the ground and one that ended in order are taken back.
    """

    def __init__(
        self, journal: FlightJournal, kept: JournalState, speed: float, wall: Callable[[], float] = time.time
    ) -> None:
        """``kept``: the journal of the survey that goes on. ``speed``: seconds of the clock per real second."""
        self._journal = journal
        self._kept = kept
        self._wall = wall
        self._speed = speed
        self._found_in_air = False
        if self.flew_lately:
            journal.add_start_in_air()  # now: a crash before the link is found counts too

    @property
    def flew_lately(self) -> bool:
        """True when an earlier run was in the air a moment ago."""
        return flight_goes_on(self._kept.flight, self._wall(), self._speed) is not None

    @property
    def rule(self) -> RestartRule:
        """The action at this start if the drone is in the air."""
        now = self._wall()
        before = sum(1 for start in self._kept.starts_in_air if now - start < RESTART_WINDOW_S)
        return restart_rule(before + 1)

    def found_in_air(self) -> int:
        """Count this start; return the number of those within the restart window, this one included."""
        self._found_in_air = True
        starts = self._journal.add_start_in_air()
        return sum(1 for start in starts if starts[-1] - start < RESTART_WINDOW_S)

    def found_disarmed(self) -> None:
        """Take this start back, unless it began in the air."""
        if not self._found_in_air:
            self._journal.withdraw_start()

    def ended_in_order(self) -> None:
        """Take this start back: it did not crash."""
        self._journal.withdraw_start()
