"""Reports when a reading of the autopilot begins to be doubted, and when it agrees with its witnesses again."""

from __future__ import annotations

from hawk.ddc.acts import Acts, Log
from hawk.ddc.facts import Facts
from hawk.ddc.states.base import State
from hawk.ddc.witnesses.witness import COMPASS_LOST
from hawk.model.sentences import say


class WitnessReports:
    """Reports each doubt once, and compasses that fail."""

    def __init__(self) -> None:
        self._doubted = False
        self._compass_lost = False

    def tick(self, facts: Facts, state: State) -> Acts:
        """Return the messages of the tick in which something begins or ends. A task that a doubt ends reports it."""
        return self._doubt(facts, state) + self._compass(facts)

    def _doubt(self, facts: Facts, state: State) -> Acts:
        was, self._doubted = self._doubted, bool(facts.witness.doubt)
        if self._doubted and not was and not state.is_task:
            return (Log("warning", facts.witness.doubt),)
        if was and not self._doubted and facts.is_airborne:
            return (Log("ok", say("The position agrees with its witnesses again.")),)
        return ()

    def _compass(self, facts: Facts) -> Acts:
        was, self._compass_lost = self._compass_lost, facts.diagnostics.compass_ok is False
        if self._compass_lost and not was:
            return (Log("warning", COMPASS_LOST),)
        if was and not self._compass_lost:
            return (Log("ok", say("A compass works again.")),)
        return ()
