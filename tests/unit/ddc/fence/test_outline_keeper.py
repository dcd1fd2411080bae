"""The lots of a round in the journalled outline: those that are over, and those that are first in the next survey."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from hawk.ddc.fence.geometry import ring_from_map
from hawk.ddc.fence.keepers import OutlineKeeper
from hawk.ddc.settings import SurveyMemory
from hawk.model.plans import Outline, RoundLot
from hawk.store.journal import FlightJournal
from hawk.store.journal_state import read_survey, surveys_of
from tests.unit.ddc.written_facts import DATUM

RINGS = tuple(
    ring_from_map(DATUM, ((north, 0.0), (north + 40.0, 0.0), (north + 40.0, 40.0), (north, 40.0)))
    for north in (0.0, 60.0)
)
ROUND = Outline(RINGS, (), (RoundLot("n", "North"), RoundLot("s", "South")))


@dataclass
class Journal:
    kept: list[Outline] = field(default_factory=list)

    def memory(self, outline: Outline | None = None) -> SurveyMemory:
        return SurveyMemory(None, (), lambda _: None, lambda _: None, outline, self.kept.append)


def lots_of(keeper: OutlineKeeper) -> list[tuple[str, bool, bool]]:
    assert keeper.outline is not None
    return [(lot.id, lot.is_first, lot.is_over) for lot in keeper.outline.lots]


def test_a_lot_that_is_over_is_journalled_and_is_known_to_the_next_start() -> None:
    journal = Journal()
    keeper = OutlineKeeper(None, journal.memory())
    keeper.use(ROUND)
    keeper.end_lots(("s",))
    again = OutlineKeeper(None, journal.memory(journal.kept[-1]))
    assert lots_of(again) == [("n", False, False), ("s", False, True)]
    assert keeper.facts(None, None) == again.facts(None, None)
    assert keeper.setup.again == ("n", "s")


def test_a_new_survey_begins_with_every_lot_and_first_those_that_were_not_finished() -> None:
    journal = Journal()
    keeper = OutlineKeeper(None, journal.memory())
    keeper.use(ROUND)
    keeper.begin_survey()
    assert lots_of(keeper) == [("n", False, False), ("s", False, False)], "none was flown"
    keeper.end_lots(("s",))
    for _ in range(2):
        keeper.begin_survey()
        assert lots_of(keeper) == [("n", True, False), ("s", False, False)]
    keeper.end_lots(("n", "s"))
    keeper.begin_survey()
    assert lots_of(keeper) == [("n", False, False), ("s", False, False)]
    assert journal.kept[-1] == keeper.outline


def test_without_a_set_outline_a_new_survey_journals_none() -> None:
    journal = Journal()
    OutlineKeeper(None, journal.memory()).begin_survey()
    assert journal.kept == []


async def test_the_journal_gives_a_round_back_as_it_was(tmp_path: Path) -> None:
    lots = (RoundLot("n", "North", 1, 0, is_first=True, is_over=True), RoundLot("s", "South", 1))
    outline = Outline(RINGS, (), lots)
    journal = FlightJournal(tmp_path)
    journal.set_outline(outline)
    await journal.close()
    (survey,) = surveys_of(tmp_path)
    assert read_survey(survey)[1].outline == outline


def test_a_round_is_divided_into_the_grounds_of_its_lots() -> None:
    holes = (RINGS[1],)
    lots = (RoundLot("a", "A", 2, 0), RoundLot("b", "B", 1, 1))
    whole = Outline((*RINGS, RINGS[0]), holes, lots)
    assert whole.grounds() == ((lots[0], Outline(RINGS)), (lots[1], Outline(RINGS[:1], holes)))
