"""A known lot that is surveyed again: refusals with field and remedy, the outline, and when an empty map begins."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import SurveyAgain
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import ring_from_map
from hawk.ddc.fence.outline import OutlineFacts
from hawk.ddc.rules.again import again_outline, again_refusal, lot_of, needs_empty_map
from hawk.ddc.rules.judge import fence_ahead
from hawk.model.known_lot import LotAhead, LotsAhead
from hawk.model.lot_map import Counts
from hawk.model.plans import ExploreStatus, Outline, PathPlan
from hawk.model.poses import Ring
from tests.unit.ddc.written_facts import DATUM, SETTINGS, flying, on_ground

SQUARE: Ring = ((0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (0.0, 40.0))
CROSSED: Ring = ((0.0, 0.0), (50.0, 50.0), (50.0, 0.0), (0.0, 50.0))
ASKED = SurveyAgain(lot="one")


def lot(ring: Ring = SQUARE, stalls: int = 40, away_m: float = 12.0) -> LotAhead:
    outline = Outline((ring_from_map(DATUM, ring),)) if ring else Outline()
    return LotAhead("one", "Market", stalls, away_m, outline)


def with_lots(facts: Facts, *lots: LotAhead, problem: str = "") -> Facts:
    return replace(facts, lots=LotsAhead(lots, problem))


def why(facts: Facts) -> str:
    return again_refusal(ASKED, facts, fence_ahead(facts, SETTINGS))


def test_a_lot_with_stalls_inside_the_fence_is_surveyed_again_by_its_outline() -> None:
    facts = with_lots(on_ground(flying(1.0)), lot())
    assert why(facts) == ""
    assert lot_of(ASKED, facts) == lot()
    assert again_outline(lot()) == replace(lot().outline, again="one")


@pytest.mark.parametrize(
    ("lots", "problem", "words"),
    [
        ((), "", "Lot: no lot has this id: open the list of lots, then choose one."),
        ((lot(),), "lots.db: is damaged: restore a backup", "Lot: the lots cannot be read: lots.db: is damaged"),
        ((lot(stalls=0),), "", "Lot: Market has no stalls: survey it first, or draw them in its plan."),
        ((lot((), away_m=812.4),), "", "Lot: Market is 812 m away: bring the drone within 300 m of it."),
        ((lot(CROSSED),), "", "Lot: the outline of Market cannot be used: Polygon 1:"),
        (
            (lot(tuple((north + 500.0, east) for north, east in SQUARE)),),
            "",
            "Lot: nothing of Market lies inside the fence: set another fence.",
        ),
    ],
)
def test_a_lot_that_cannot_be_surveyed_is_refused_with_the_remedy(
    lots: tuple[LotAhead, ...], problem: str, words: str
) -> None:
    assert why(with_lots(on_ground(flying(1.0)), *lots, problem=problem)).startswith(words)


def test_without_a_position_no_lot_can_be_found() -> None:
    facts = flying(1.0)
    lost = replace(facts, position=replace(facts.position, pose=None))
    assert why(lost).startswith("Lot: the position is not known well enough")


def test_a_map_with_an_earlier_survey_is_refused_before_flight() -> None:
    facts = on_ground(flying(1.0))
    mapped = replace(with_lots(facts, lot()), sight=replace(facts.sight, lot_area=900.0))
    assert why(mapped).startswith("Lot: the map holds an earlier survey: begin a new survey first")


def test_what_an_earlier_survey_saw_is_looked_at_again_on_an_empty_map() -> None:
    empty = on_ground(flying(1.0))
    empty = replace(empty, sight=replace(empty.sight, lot_area=0.0, counts=Counts()))
    mapped = replace(empty, sight=replace(empty.sight, lot_area=900.0))
    assert not needs_empty_map(lot(), empty)
    assert needs_empty_map(lot(), mapped)
    armed = flying(1.0)
    assert not needs_empty_map(lot(), replace(armed, sight=replace(armed.sight, lot_area=900.0)))


def test_after_a_battery_swap_the_survey_of_the_same_lot_goes_on_until_it_is_over() -> None:
    facts = on_ground(flying(1.0))
    same = replace(facts.limits, outline=OutlineFacts(900.0, 0.0, "one"))
    going = replace(facts, limits=same, sight=replace(facts.sight, lot_area=900.0, plan=PathPlan()))
    assert not needs_empty_map(lot(), going)
    over = replace(going, sight=replace(going.sight, plan=PathPlan(explore=ExploreStatus(done=True))))
    assert needs_empty_map(lot(), over)
    other = replace(going, limits=replace(same, outline=OutlineFacts(900.0, 0.0, "two")))
    assert needs_empty_map(lot(), other)
