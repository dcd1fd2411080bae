"""Messages about the survey: that an earlier one goes on, and that the battery will not last for the rest."""

from __future__ import annotations

from typing import Final

from hawk.ddc.acts import Acts, Log
from hawk.ddc.battery.survey import tens
from hawk.ddc.facts import Facts
from hawk.ddc.states.base import State
from hawk.model.operation import StateName
from hawk.model.sentences import say

SHORT_CONFIRM_S: Final = 10.0
"""Seconds for which the battery must be too low for the rest of the survey: plans and drain waver."""


class SurveyNotice:
    """Says each once: the earlier survey once a run of the program, the battery once a flight."""

    def __init__(self, *, continues_survey: bool) -> None:
        """``continues_survey``: the map of an earlier run was restored."""
        self._is_earlier_untold = continues_survey
        self._is_short_told = False

    def tick(self, facts: Facts, state: State) -> Acts:
        """Return the messages of this tick."""
        if not facts.vehicle.armed:
            self._is_short_told = False
            return self._earlier(facts)
        if state.identity is StateName.AUTONOMOUS_EXPLORE:
            return self._short(facts)
        return ()

    def _earlier(self, facts: Facts) -> Acts:
        sight = facts.sight
        if not self._is_earlier_untold or sight.lot_area <= 0.0:
            return ()
        self._is_earlier_untold = False
        need = facts.battery.survey
        is_done = need is not None and need.basis == "map" and need.seconds <= 0.0
        rest = say("It was seen whole.") if is_done else say("Explore flies the rest.")
        total = sight.counts.total
        text = say("An earlier survey goes on: {total} stalls are on its map. {rest}", total=total, rest=rest)
        return (Log("info", text),)

    def _short(self, facts: Facts) -> Acts:
        battery = facts.battery
        is_certain = battery.short_s is not None and battery.short_s >= SHORT_CONFIRM_S
        if self._is_short_told or battery.survey is None or not is_certain:
            return ()
        self._is_short_told = True
        share = tens(battery.survey.whole_share)
        text = say("The battery will not last for the whole survey: about {share} % of it.", share=share)
        return (
            Log("warning", text, say("It explores on and returns in time. Explore continues after a battery swap.")),
        )
