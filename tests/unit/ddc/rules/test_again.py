"""A known lot that is surveyed again: refusals with field and remedy, the outline, and when an empty map begins."""

from __future__ import annotations

from dataclasses import replace

import pytest
from pydantic import ValidationError

from hawk.comm.protocol.commands import SurveyAgain
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import ring_from_map
from hawk.ddc.fence.outline import OutlineFacts
from hawk.ddc.rules.again import again_outline, again_refusal, lots_of, needs_empty_map
from hawk.ddc.rules.judge import fence_ahead
from hawk.model.known_lot import LotAhead, LotsAhead
from hawk.model.lot_map import Counts
from hawk.model.plans import ExploreStatus, Outline, PathPlan, RoundLot
from hawk.model.poses import Ring
from tests.unit.ddc.written_facts import DATUM, SETTINGS, flying, on_ground

SQUARE: Ring = ((0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (0.0, 40.0))
CROSSED: Ring = ((0.0, 0.0), (50.0, 50.0), (50.0, 0.0), (0.0, 50.0))
ASKED = SurveyAgain(lots=["one"])


def lot(
    ring: Ring = SQUARE, stalls: int = 40, away_m: float = 12.0, *, name: str = "one", is_due: bool = False
) -> LotAhead:
    title = {"one": "Market", "two": "Harbour"}[name]
    outline = Outline((ring_from_map(DATUM, ring),)) if ring else Outline()
    return LotAhead(name, title, stalls, away_m, outline, is_due)


def with_lots(facts: Facts, *lots: LotAhead, problem: str = "") -> Facts:
    return replace(facts, lots=LotsAhead(lots, problem))


def why(facts: Facts, asked: SurveyAgain = ASKED) -> str:
    return again_refusal(asked, facts, fence_ahead(facts, SETTINGS))


def test_a_lot_with_stalls_inside_the_fence_is_surveyed_again_by_its_outline() -> None:
    facts = with_lots(on_ground(flying(1.0)), lot())
    assert why(facts) == ""
    assert why(with_lots(on_ground(flying(1.0)), replace(lot(stalls=0), sections=1))) == ""
    assert lots_of(ASKED, facts, None) == (lot(),)
    assert again_outline([lot()], facts) == replace(lot().outline, lots=(RoundLot("one", "Market"),))


@pytest.mark.parametrize(
    ("lots", "problem", "words"),
    [
        ((), "", "Lots: no lot has this id: open the list of lots, then choose one."),
        ((lot(),), "lots.db: is damaged: restore a backup", "Lots: the lots cannot be read: lots.db: is damaged"),
        ((lot(stalls=0),), "", "Lots: Market has no stalls: survey it first, or draw them in its plan."),
        ((lot((), away_m=812.4),), "", "Lots: Market is 812 m away: bring the drone within 300 m of it."),
        ((lot(CROSSED),), "", "Lots: the outline of Market cannot be used: Polygon 1:"),
        (
            (lot(tuple((north + 500.0, east) for north, east in SQUARE)),),
            "",
            "Lots: nothing of Market lies inside the fence: set another fence.",
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
    assert why(lost).startswith("Lots: the position is not known well enough")


def test_a_map_with_an_earlier_survey_is_refused_before_flight() -> None:
    facts = on_ground(flying(1.0))
    mapped = replace(with_lots(facts, lot()), sight=replace(facts.sight, lot_area=900.0))
    assert why(mapped).startswith("Lots: the map holds an earlier survey: begin a new survey first")


def test_what_an_earlier_survey_saw_is_looked_at_again_on_an_empty_map() -> None:
    empty = on_ground(flying(1.0))
    empty = replace(empty, sight=replace(empty.sight, lot_area=0.0, counts=Counts()))
    mapped = replace(empty, sight=replace(empty.sight, lot_area=900.0))
    assert not needs_empty_map([lot()], empty)
    assert needs_empty_map([lot()], mapped)
    armed = flying(1.0)
    assert not needs_empty_map([lot()], replace(armed, sight=replace(armed.sight, lot_area=900.0)))


def test_after_a_battery_swap_the_survey_of_the_same_lot_goes_on_until_it_is_over() -> None:
    facts = on_ground(flying(1.0))
    same = replace(facts.limits, outline=OutlineFacts(900.0, 0.0, (RoundLot("one", "Market"),)))
    going = replace(facts, limits=same, sight=replace(facts.sight, lot_area=900.0, plan=PathPlan()))
    assert not needs_empty_map([lot()], going)
    over = replace(going, sight=replace(going.sight, plan=PathPlan(explore=ExploreStatus(done=True))))
    assert needs_empty_map([lot()], over)
    other = replace(going, limits=replace(same, outline=OutlineFacts(900.0, 0.0, (RoundLot("two", "Harbour"),))))
    assert needs_empty_map([lot()], other)


BOTH = SurveyAgain(lots=["one", "two"])
BESIDE: Ring = tuple((north - 45.0, east) for north, east in SQUARE)


def moved(north: float, ring: Ring = SQUARE) -> Ring:
    return tuple((each + north, east) for each, east in ring)


def test_lots_of_one_round_have_each_its_own_ground_in_one_outline() -> None:
    facts = with_lots(on_ground(flying(1.0)), lot(), lot(BESIDE, 8, name="two"))
    assert why(facts, BOTH) == ""
    outline = again_outline(lots_of(BOTH, facts, None), facts)
    assert [(each.id, ground.polygons) for each, ground in outline.grounds()] == [
        ("one", lot().outline.polygons),
        ("two", lot(BESIDE).outline.polygons),
    ]


def test_a_lot_that_overlaps_another_is_refused_in_one_round_and_flown_alone() -> None:
    facts = with_lots(on_ground(flying(1.0)), lot(), lot(moved(30.0), name="two"))
    assert why(facts, BOTH) == "Lots: Market and Harbour overlap by 400 m²: merge them, or survey them one by one."
    assert why(facts, SurveyAgain(lots=["two"])) == ""


def test_a_lot_partly_outside_the_fence_is_refused_in_a_round_and_flown_alone() -> None:
    facts = on_ground(flying(1.0))
    ahead = fence_ahead(facts, SETTINGS)
    assert ahead is not None
    edge = max(north for north, _ in ahead[1].autopilot_polygon)
    out = lot(moved(edge - 20.0), name="two")
    both = with_lots(facts, lot(BESIDE), out)
    assert why(both, BOTH).startswith("Lots: ")
    assert why(both, BOTH).endswith(" of Harbour lie outside the fence: set another fence, or survey it alone.")
    assert why(both, SurveyAgain(lots=["two"])) == ""
    beyond = with_lots(facts, lot(BESIDE), lot(moved(edge + 20.0), name="two"))
    assert why(beyond, BOTH) == "Lots: nothing of Harbour lies inside the fence: set another fence."


def test_one_unknown_lot_of_several_is_refused() -> None:
    assert "no lot has this id" in why(with_lots(on_ground(flying(1.0)), lot()), BOTH)


DUE = SurveyAgain(due=True)


def test_the_lots_that_are_due_are_those_that_can_be_flown_inside_the_fence() -> None:
    facts = on_ground(flying(1.0))
    away = lot(moved(500.0), name="two", is_due=True)
    both = with_lots(facts, lot(is_due=True), away)
    assert why(both, DUE) == ""
    assert [each.id for each in lots_of(DUE, both, fence_ahead(facts, SETTINGS))] == ["one"]
    assert why(with_lots(facts, away), DUE) == (
        "Due: no lot that is due can be flown to. Lots: nothing of Harbour lies inside the fence: set another fence."
    )
    assert why(with_lots(facts, lot()), DUE) == "Due: no survey of a lot is due now: choose the lots."


@pytest.mark.parametrize("wrong", [{}, {"Lots": []}, {"Lots": ["one"], "Due": True}, {"Lots": ["x"] * 13}])
def test_a_command_names_lots_or_those_that_are_due(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        SurveyAgain.model_validate(wrong)


def after(facts: Facts, *lots: RoundLot) -> Facts:
    return replace(facts, limits=replace(facts.limits, outline=OutlineFacts(900.0, 0.0, lots)))


def test_lots_that_are_due_and_those_that_were_not_finished_are_first() -> None:
    empty = on_ground(flying(1.0))
    empty = replace(empty, sight=replace(empty.sight, lot_area=0.0, counts=Counts()))
    market, harbour = lot(), lot(BESIDE, name="two")
    begun = after(empty, RoundLot("one", "Market", is_over=True), RoundLot("two", "Harbour"))
    assert [each.is_first for each in again_outline([market, harbour], begun).lots] == [False, True]
    assert [each.is_over for each in again_outline([market, harbour], begun).lots] == [False, False]
    fresh = after(empty, RoundLot("one", "Market"), RoundLot("two", "Harbour"))
    assert [each.is_first for each in again_outline([market, harbour], fresh).lots] == [False, False]
    due = replace(market, is_due=True)
    assert [each.is_first for each in again_outline([due, harbour], empty).lots] == [True, False]


def test_after_a_battery_swap_a_lot_that_is_over_stays_over() -> None:
    facts = on_ground(flying(1.0))
    mapped = replace(facts, sight=replace(facts.sight, lot_area=900.0, plan=PathPlan()))
    begun = after(mapped, RoundLot("one", "Market", is_over=True), RoundLot("two", "Harbour"))
    lots = [lot(), lot(BESIDE, name="two")]
    assert not needs_empty_map(lots, begun)
    assert [each.is_over for each in again_outline(lots, begun).lots] == [True, False]
    assert needs_empty_map(lots[:1], begun)


def test_lots_too_far_apart_for_one_outline_are_no_round() -> None:
    facts = on_ground(flying(1.0))
    unplanned = replace(with_lots(facts, lot(), lot(moved(9_000.0), name="two")))
    assert again_refusal(BOTH, unplanned, None).startswith(
        "Lots: they are no round: Polygons: the outline is 9040 m wide"
    )


def test_lots_that_touch_are_one_round() -> None:
    facts = with_lots(on_ground(flying(1.0)), lot(), lot(moved(-40.0), name="two"))
    assert why(facts, BOTH) == ""
