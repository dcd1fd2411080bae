"""Explore by facts alone: plans, progress, the lot out of sight, and what is reported."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import Hold
from hawk.ddc.acts import (
    STAY,
    EndLots,
    SetMode,
)
from hawk.ddc.battery.energy import SAFETY_FACTOR, Reserve
from hawk.ddc.facts import Facts
from hawk.ddc.fence.outline import OutlineFacts
from hawk.ddc.motion import Goal
from hawk.ddc.orders import (
    Cause,
    CauseKind,
    ToExplore,
    ToHover,
    ToReturn,
)
from hawk.ddc.readings.wind import Wind
from hawk.ddc.states.explore import Travelling, outline_words
from hawk.model.lot_map import Counts
from hawk.model.operation import UserError
from hawk.model.plans import ExploreStatus, LeftOut, LotLook, PathPlan, RoundLot
from hawk.model.poses import MapPoint
from hawk.model.vehicle import CopterMode
from tests.unit.ddc.by_facts import (
    answered,
    at,
    made,
    requests,
    targets,
    texts,
    without_pose,
)
from tests.unit.ddc.written_facts import SETTINGS, flying, pose


def planned(facts: Facts, north: float = 30.0, done: bool = False, time: float = 5.0, known: bool = True) -> Facts:
    plan = PathPlan(MapPoint(north, 0.0), 35.0, 0.0, explore=ExploreStatus(done, 0.5, lot_known=known))
    return replace(facts, sight=replace(facts.sight, plan=plan, plan_time=time))


def test_explore_sends_nothing_without_a_young_position() -> None:
    state = made(ToExplore())
    assert state.process(without_pose(planned(flying(0.05)))) == ()
    assert state.goal is None


def test_a_lot_may_be_out_of_sight_for_the_limit() -> None:
    state = made(ToExplore())
    unseen = planned(flying(SETTINGS.flight.explore_lost_lot_s))
    unseen = replace(unseen, sight=replace(unseen.sight, lot=False))
    assert state.transition_next_state(unseen) == STAY
    step = state.transition_next_state(replace(unseen, now=unseen.now + 0.05))
    assert isinstance(step.transition, ToHover)
    assert [act.error for act in step.acts if hasattr(act, "error")] == [UserError.NO_LOT_DETECTED]


@pytest.mark.parametrize(("time", "ends"), [(0.49, False), (0.5, True)])
def test_done_counts_from_half_a_second_after_the_beginning(time: float, ends: bool) -> None:
    step = made(ToExplore()).transition_next_state(planned(flying(1.0), done=True, time=time))
    assert (step.transition is not None) is ends


def test_the_next_place_is_reported_when_it_is_far_and_not_too_often() -> None:
    state = made(ToExplore())
    assert texts(state.process(planned(flying(0.05), 30.0))) == ["Next: to the north, 30 m away."]
    assert texts(state.process(planned(flying(4.0), 60.0))) == []
    assert texts(state.process(planned(flying(5.1), 37.9))) == []
    assert texts(state.process(planned(flying(5.1), 60.0))) == ["Next: to the north, 60 m away."]
    assert texts(state.process(planned(flying(20.0), 7.9))) == [], "it is there already"


def test_hold_ends_explore() -> None:
    assert made(ToExplore()).transition_next_state(flying(0.1), Hold()).transition == ToHover(
        "Stopped by the operator."
    )


PLACE = Goal(30.0, 0.0, 30.0, 0.0)


def test_the_refusal_of_a_target_of_before_hinders_nothing_and_one_of_its_own_is_reported() -> None:
    travelling = Travelling(SETTINGS)
    assert len(targets(travelling.process(replace(flying(0.05), target_refusal="too high"), PLACE))) == 1
    assert travelling.obstacle == ""
    travelling.process(replace(flying(0.1), target_refusal="too far"), PLACE)
    assert travelling.obstacle == "too far"
    travelling.process(flying(0.15), PLACE)
    assert travelling.obstacle == ""


def test_no_target_is_sent_without_guided_a_place_and_a_free_path_and_the_reason_is_reported() -> None:
    travelling = Travelling(SETTINGS)
    assert requests(travelling.process(flying(0.0, CopterMode.LOITER), PLACE)) == [SetMode(CopterMode.GUIDED)]
    assert (travelling.obstacle, travelling.refusal) == ("Waiting for GUIDED.", "")
    refused = answered(flying(0.1, CopterMode.LOITER), ("mode GUIDED", 0.0, "failed"), words="no GPS")
    assert travelling.process(refused, PLACE) == ()
    assert (travelling.obstacle, travelling.refusal) == ("no GPS", "no GPS")
    assert travelling.process(without_pose(flying(0.2)), PLACE) == ()
    assert (travelling.obstacle, travelling.refusal) == ("The drone's position is too old.", "")
    facts = flying(0.3)
    assert travelling.process(replace(facts, limits=replace(facts.limits, fence=None)), PLACE) == ()
    assert travelling.obstacle == "The path there leaves the fence."
    assert travelling.process(facts, replace(PLACE, north=200.0)) == ()
    assert travelling.obstacle == "The path there leaves the fence."
    assert len(targets(travelling.process(facts, PLACE))) == 1


def test_guided_that_is_not_answered_counts_as_refused() -> None:
    travelling = Travelling(SETTINGS)
    travelling.process(flying(0.0, CopterMode.LOITER), PLACE)
    travelling.process(answered(flying(0.1, CopterMode.LOITER), ("mode GUIDED", 0.0, "failed")), PLACE)
    assert travelling.refusal == "no answer"


@pytest.mark.parametrize(
    ("north", "east", "height", "there"),
    [
        (40.0, 20.0, 30.0, True),
        (41.5, 20.0, 30.0, True),
        (40.0, 18.5, 31.5, True),
        (41.51, 20.0, 30.0, False),
        (40.0, 21.51, 30.0, False),
        (40.0, 20.0, 28.49, False),
        (40.0, 20.0, 31.51, False),
    ],
)
def test_the_place_is_reached_within_the_radius_across_and_in_height(
    north: float, east: float, height: float, there: bool
) -> None:
    here = pose(0.0, north, east, height).map
    assert here is not None
    assert Travelling(SETTINGS).has_arrived(Goal(40.0, 20.0, 30.0, 0.0), here) is there


@pytest.mark.parametrize(
    ("unseen", "outside", "words"),
    [
        (0.0, None, "Explored: the outline is seen whole."),
        (None, 0.99, "Explored: the outline is seen whole."),
        (0.0, 1.0, "Explored: the outline is seen whole. 1 m² outside the fence were left out."),
        (0.6, None, "Explored: the rest cannot be reached. 899 m² of 900 m² seen, 1 m² not reached."),
        (
            100.0,
            50.0,
            "Explored: the rest cannot be reached. 800 m² of 900 m² seen, 100 m² not reached. "
            "50 m² outside the fence were left out.",
        ),
    ],
)
def test_what_was_seen_of_an_outline_is_reported_with_what_was_left_out(
    unseen: float | None, outside: float | None, words: str
) -> None:
    explore = ExploreStatus(done=True, asked_m2=900.0, unseen_m2=unseen)
    assert outline_words(explore, None if outside is None else OutlineFacts(900.0, outside)) == words


def test_explore_shows_the_planners_route_and_what_was_seen() -> None:
    state, facts = made(ToExplore()), flying(0.05)
    assert state.route(facts) == ()
    assert state.detail(facts) == "Waiting for a plan."
    route = (MapPoint(1.0, 2.0), MapPoint(3.0, 4.0))

    def shown(explore: ExploreStatus) -> Facts:
        return replace(facts, sight=replace(facts.sight, plan=PathPlan(route=route, explore=explore)))

    assert state.route(shown(ExploreStatus())) == route
    assert state.detail(shown(ExploreStatus(seen=0.5))) == "50 % seen of the lot found so far."
    assert state.detail(shown(ExploreStatus(seen=0.5, asked_m2=900.0))) == "50 % seen of the outline."
    assert state.detail(shown(ExploreStatus(lot_known=False))) == "Looking for the lot."


def unseen(facts: Facts, lot: bool | None = False) -> Facts:
    return replace(facts, sight=replace(facts.sight, lot=lot))


def test_the_time_out_of_sight_counts_from_when_the_lot_was_last_seen_and_not_over_an_outline() -> None:
    state, limit = made(ToExplore()), SETTINGS.flight.explore_lost_lot_s
    state.process(flying(5.0))
    state.process(unseen(flying(6.0)))
    assert state.transition_next_state(unseen(flying(5.0 + limit))) == STAY
    assert state.transition_next_state(unseen(flying(5.05 + limit))).transition is not None
    outlined = unseen(at(flying(20.0), 50.0))
    state.process(replace(outlined, limits=replace(outlined.limits, outline=OutlineFacts(900.0, 0.0))))
    assert state.transition_next_state(unseen(flying(20.0 + limit))) == STAY


@pytest.mark.parametrize(
    ("explore", "words", "level"),
    [
        (ExploreStatus(True, asked_m2=9.0), "Explored: the outline is seen whole.", "ok"),
        (
            ExploreStatus(True, 1.0),
            "Explored: the lot found is seen whole, 100 % of 4500 m². Ground outside the fence was not looked at.",
            "ok",
        ),
        (
            ExploreStatus(True, 0.97, left_out=LeftOut(16.0, 15.0, 14.9, 300.0)),
            "Explored: the lot found is seen whole, 97 % of 4500 m². 16 m² of it outside the fence were left out. "
            "No picture from inside the fence shows 15 m² of it. "
            "300 m² beside it were not looked at: the lot may go on there.",
            "ok",
        ),
        (
            ExploreStatus(True, 0.7, unreached=True, left_out=LeftOut(given_up_m2=120.0)),
            "Explored: 70 % of the lot found is seen, 4500 m². "
            "120 m² were given up: pictures showed nothing new there.",
            "ok",
        ),
        (ExploreStatus(True, 0.7), "Explored: 70 % of the lot found is seen, 4500 m². The rest was not reached.", "ok"),
        (
            ExploreStatus(True, 1.0, unreached=True),
            "Explored: 99 % of the lot found is seen, 4500 m². The rest was not reached.",
            "ok",
        ),
        (ExploreStatus(True, lot_known=False), "No lot was found here.", "warning"),
    ],
)
def test_explore_ends_with_what_was_found(explore: ExploreStatus, words: str, level: str) -> None:
    facts = flying(1.0)
    facts = replace(facts, sight=replace(facts.sight, plan=PathPlan(explore=explore), plan_time=1.0, lot_area=4500.0))
    following = made(ToExplore()).transition_next_state(facts).transition
    assert isinstance(following, ToHover)
    assert (following.reason, following.level) == (words, level)


def test_explore_that_gets_nowhere_for_ten_seconds_holds() -> None:
    state = made(ToExplore())
    state.process(flying(0.0))
    state.process(flying(9.99))
    assert state.transition_next_state(flying(9.99)) == STAY
    state.process(flying(10.0))
    step = state.transition_next_state(flying(10.0))
    assert step.transition == ToHover("No progress for 10 s. The planner gives no further path.", level="warning")


@pytest.mark.parametrize(
    ("plan", "goal"),
    [
        (PathPlan(), None),
        (PathPlan(MapPoint(30.0, 1.0)), Goal(30.0, 1.0, 35.0, 0.7)),
        (PathPlan(MapPoint(30.0, 1.0), 40.0, 0.5), Goal(30.0, 1.0, 40.0, 0.5)),
        (PathPlan(MapPoint(30.0, 1.0), 14.0, 0.5), Goal(30.0, 1.0, 15.0, 0.5)),
        (PathPlan(MapPoint(30.0, 1.0), float("inf")), None),
        (PathPlan(MapPoint(float("nan"), 1.0)), None),
        (PathPlan(MapPoint(30.0, 1.0), 40.0, float("inf")), None),
    ],
)
def test_explore_goes_to_a_whole_plan_alone_between_min_and_max(plan: PathPlan, goal: Goal | None) -> None:
    facts = flying(0.05)
    here = pose(0.05)
    assert here.map is not None
    here = replace(here, map=replace(here.map, yaw=0.7))
    facts = replace(facts, position=replace(facts.position, pose=here), sight=replace(facts.sight, plan=plan))
    state = made(ToExplore())
    assert len(targets(state.process(facts))) == (goal is not None)
    assert state.goal == goal


@pytest.mark.parametrize(
    ("speed", "messages"), [(None, 0), (-0.5, 0), (0.0, 0), (0.5, 1), (3.99, 1), (4.0, 0), (float("nan"), 0)]
)
def test_a_plan_that_makes_the_drone_slower_is_reported_once(speed: float | None, messages: int) -> None:
    state, facts = made(ToExplore()), flying(0.05)
    plan = PathPlan(MapPoint(30.0, 0.0), speed=speed)
    for _ in range(3):
        texts_of_tick = texts(state.process(replace(facts, sight=replace(facts.sight, plan=plan))))
        assert sum("Slower" in text for text in texts_of_tick) == messages
        messages = 0


def test_the_next_place_is_reported_from_eight_metres_and_five_seconds_on() -> None:
    state = made(ToExplore())
    assert texts(state.process(planned(flying(0.0), 30.0))) == ["Next: to the north, 30 m away."]
    assert texts(state.process(planned(flying(4.99), 38.0))) == []
    assert texts(state.process(planned(flying(5.0), 37.99))) == []
    assert texts(state.process(planned(flying(5.0), 38.0))) == ["Next: to the north, 38 m away."]
    assert texts(state.process(planned(flying(10.0), 8.0))) == ["Next: to the north, 8 m away."]


@pytest.mark.parametrize(("north", "east", "words"), [(40.0, 0.0, "south, 10 m"), (30.0, 20.0, "west, 20 m")])
def test_the_next_place_is_reported_as_seen_from_the_drone(north: float, east: float, words: str) -> None:
    assert texts(made(ToExplore()).process(at(planned(flying(0.05)), north, east))) == [f"Next: to the {words} away."]


NORTH, SOUTH = RoundLot("n", "North"), RoundLot("s", "South")


def on_round(facts: Facts, *looks: LotLook, path_m: float = 0.0, charge: float = 60.0) -> Facts:
    """Over two lots; the flight home needs 30 %, and the battery loses 0.1 % a second."""
    explore = ExploreStatus(seen=0.5, lots=looks, path_m=path_m)
    plan = PathPlan(MapPoint(80.0, 0.0), 35.0, 0.0, explore=explore)
    lots = OutlineFacts(900.0, 0.0, (NORTH, SOUTH))
    return replace(
        facts,
        sight=replace(facts.sight, plan=plan, plan_time=facts.now),
        limits=replace(facts.limits, outline=lots),
        battery=replace(facts.battery, reserve=Reserve(charge, 30.0, 100.0, drain=0.1)),
    )


def test_a_lot_that_is_over_is_ended_once_and_said() -> None:
    looks = (LotLook("n", 0.98, is_over=True), LotLook("s", 0.1))
    facts = on_round(flying(1.0), *looks)
    acts = made(ToExplore()).process(facts)
    assert EndLots(("n",)) in acts
    assert "North: 98 % of the stalls were looked at, the rest was not reached." in texts(acts)
    over = OutlineFacts(900.0, 0.0, (replace(NORTH, is_over=True), SOUTH))
    after = made(ToExplore()).process(replace(facts, limits=replace(facts.limits, outline=over)))
    assert not [act for act in after if isinstance(act, EndLots)]


def test_the_path_to_the_next_lot_is_flown_with_the_battery_for_it_and_the_path_back() -> None:
    looks = (LotLook("n", 1.0, is_over=True), LotLook("s", 0.0))
    path_s = 80.0 / SETTINGS.flight.speed_m_s
    enough = 30.0 + 0.1 * (1 + SAFETY_FACTOR) * path_s
    facts = on_round(flying(1.0), *looks, path_m=80.0, charge=enough + 0.1)
    assert made(ToExplore()).transition_next_state(facts) == STAY


@pytest.mark.parametrize("wind", [None, Wind(-14.0, 0.0)])
def test_without_the_battery_for_the_path_to_the_next_lot_it_returns_before_it_leaves(wind: Wind | None) -> None:
    """A head wind of 14 m/s makes the path longer, and refuses a charge that is enough in calm air."""
    looks = (LotLook("n", 1.0, is_over=True), LotLook("s", 0.0))
    path_s = 80.0 / SETTINGS.flight.speed_m_s
    enough = 30.0 + 0.1 * (1 + SAFETY_FACTOR) * path_s
    charge = enough - 0.1 if wind is None else enough + 0.1
    facts = on_round(flying(1.0), *looks, path_m=80.0, charge=charge)
    facts = replace(facts, wind=replace(facts.wind, estimate=wind))
    step = made(ToExplore()).transition_next_state(facts)
    assert isinstance(step.transition, ToReturn)
    assert step.transition.cause == Cause(
        "The battery does not last for the 80 m to the next lot and back.", CauseKind.RESERVE
    )


def test_over_a_lot_the_reserve_alone_decides() -> None:
    facts = on_round(flying(1.0), LotLook("n", 0.5), LotLook("s", 0.0), charge=30.5)
    assert made(ToExplore()).transition_next_state(facts) == STAY


def test_a_round_ends_with_the_number_of_its_lots() -> None:
    looks = (LotLook("n", 1.0, is_over=True), LotLook("s", 1.0, is_over=True))
    facts = on_round(flying(1.0), *looks)
    plan = PathPlan(explore=ExploreStatus(True, 1.0, lots=looks))
    step = made(ToExplore()).transition_next_state(replace(facts, sight=replace(facts.sight, plan=plan)))
    assert isinstance(step.transition, ToHover)
    assert step.transition.reason == "Surveyed again: every stall in the plans of 2 lots was looked at."
    sight = replace(facts.sight, plan=plan, counts=Counts(suggested=24))
    step = made(ToExplore()).transition_next_state(replace(facts, sight=sight))
    assert isinstance(step.transition, ToHover)
    assert "24 suggested stalls are not in the plan" in step.transition.reason
