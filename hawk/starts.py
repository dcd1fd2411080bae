"""The starts of this program: the survey that goes on, and the starts in the air as the journal counts them."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Final

from hawk.ddc.restart import RESTART_WINDOW_S, RestartRule, flight_goes_on, restart_rule
from hawk.store.journal import FlightJournal
from hawk.store.journal_state import JournalState

CONTINUE_S: Final = 1800.0
"""A daemon that starts on the ground continues a survey younger than this, wall clock seconds."""


def survey_at_start(
    journal: FlightJournal, *, is_new_world: bool, wall: Callable[[], float] = time.time
) -> JournalState:
    """Return the journalled survey where it goes on, else another one that is empty.

    It goes on while it is young. ``is_new_world``: the drone starts over another simulated world, and nothing goes on.
    """
    kept = journal.state
    is_begun = kept.datum is not None or kept.outline is not None
    if is_begun and not is_new_world and wall() - kept.last_written < CONTINUE_S:
        return kept
    if kept.datum is None and not kept.map_parts:
        return replace(kept, arm_place=None)
    return JournalState(survey_id=journal.new_survey(), starts_in_air=kept.starts_in_air, drains=kept.drains)


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
