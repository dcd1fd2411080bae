"""Reports when a reading of the autopilot begins to be doubted, and when it agrees with its witnesses again."""

from __future__ import annotations

from hawk.ddc.acts import Acts, Log
from hawk.ddc.facts import Facts
from hawk.ddc.states.base import State
from hawk.model.sentences import say


class WitnessReports:
    """Reports each doubt once."""

    def __init__(self) -> None:
        self._doubted = False

    def tick(self, facts: Facts, state: State) -> Acts:
        """Return the message of the tick in which a doubt begins or ends. A task that it ends reports it itself."""
        was, self._doubted = self._doubted, bool(facts.witness.doubt)
        if self._doubted and not was and not state.is_task:
            return (Log("warning", facts.witness.doubt),)
        if was and not self._doubted and facts.is_airborne:
            return (Log("ok", say("The position agrees with the camera again.")),)
        return ()
