"""Too close to what is below: a task ends above it. A bad reading, a doubted range, no rangefinder change nothing."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import pytest
from pydantic import TypeAdapter

from hawk.comm.autopilot.terrain import Terrain
from hawk.comm.protocol.commands import CompulsiveMove
from hawk.ddc.facts import Facts
from hawk.ddc.motion import Goal
from hawk.ddc.orders import Cause, CauseKind, MoveOrder, Rank, ToHover
from hawk.ddc.readings.clearance import (
    GAP_S,
    LOW_READINGS,
    LOW_S,
    BelowFacts,
    ClearanceReading,
    least_clearance,
    range_health,
)
from hawk.ddc.rules import guard
from hawk.ddc.states.base import State
from hawk.ddc.states.explore import AutonomousExploreState
from hawk.ddc.states.ground import TakeoffState
from hawk.ddc.states.hover import CommunicationLostState, HoverState, ManualState
from hawk.ddc.states.moves import AutonomousMoveState, CompulsiveMoveState
from hawk.ddc.states.rtl_and_land import LandState, ReturnToLaunchState
from hawk.model.operation import StateName
from hawk.model.plans import Route
from hawk.model.poses import MapPoint
from hawk.store.frame_codec import to_json
from tests.unit.ddc.fakes import Rig
from tests.unit.ddc.written_facts import SETTINGS, flying, pose

S = StateName
STEP_S = 0.1
NOT_LOW = (None, None)
ORDER = MoveOrder(MapPoint(60, 0), 15.0, 0.0, False, 1, Route((MapPoint(0, 0), MapPoint(60, 0)), (0.0, 0.0)))
TASKS: list[Callable[[], State]] = [
    lambda: AutonomousExploreState(0.0, SETTINGS),
    lambda: CompulsiveMoveState(0.0, ORDER, SETTINGS),
    lambda: AutonomousMoveState(0.0, replace(ORDER, autonomous=True), SETTINGS),
]
OTHERS: list[Callable[[], State]] = [
    lambda: HoverState(0.0, SETTINGS),
    lambda: CommunicationLostState(0.0, SETTINGS),
    lambda: TakeoffState(0.0),
    lambda: ReturnToLaunchState(0.0, SETTINGS, Cause("", CauseKind.ALWAYS), False, ""),
    lambda: LandState(0.0, Cause("", CauseKind.ALWAYS), False),
    lambda: ManualState(0.0),
]


def close(height: float = 15.0, distance: float = 3.0, low_s: float | None = LOW_S) -> Facts:
    """A drone that flies and measures this distance."""
    facts = flying(100.0)
    below = BelowFacts(Terrain(100.0, None, None, 50.0), low_s, None if low_s is None else distance)
    return replace(facts, position=replace(facts.position, pose=pose(100.0, height=height), below=below))


# -- guard -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", TASKS)
def test_a_task_too_close_to_what_is_below_ends_above_it(make: Callable[[], State]) -> None:
    found = guard.reaction(close(), make())
    assert found is not None
    assert found.rank is Rank.FENCE
    assert isinstance(found.transition, ToHover)
    assert found.transition.goal == Goal(0.0, 0.0, 27.0, 0.0), "Min, 15 m, above what is below"
    assert found.transition.level == "warning"
    assert found.transition.reason.startswith("Only 3.0 m above what is below: up to 27 m.")


@pytest.mark.parametrize("make", OTHERS)
def test_what_is_no_task_is_left_alone(make: Callable[[], State]) -> None:
    assert guard.reaction(close(), make()) is None


@pytest.mark.parametrize("low_s", [None, 0.0, LOW_S - 0.05])
def test_it_must_last(low_s: float | None) -> None:
    assert guard.reaction(close(low_s=low_s), TASKS[0]()) is None


def test_the_climb_ends_at_the_ceiling_and_never_leads_down() -> None:
    ceiling = flying(0.0).ceiling(on_ground=False)
    for height, wanted in ((ceiling - 4.0, ceiling), (ceiling + 1.0, ceiling + 1.0)):
        found = guard.reaction(close(height), TASKS[0]())
        assert found is not None
        assert isinstance(found.transition, ToHover)
        assert found.transition.goal is not None
        assert found.transition.goal.height == wanted


def test_without_a_place_it_holds() -> None:
    facts = close()
    facts = replace(facts, position=replace(facts.position, age=0.8))
    found = guard.reaction(facts, TASKS[0]())
    assert found is not None
    assert found.transition == ToHover("Too close to what is below.", level="warning")


# -- clearance ---------------------------------------------------------------------------------------------------------


def watched(*distances: float | None, doubt: str = "") -> tuple[ClearanceReading, float]:
    reading, now = ClearanceReading(), 0.0
    for distance in distances:
        now += STEP_S
        reading.update(Terrain(now, distance, doubt=doubt), 5.0)
    return reading, now


def test_readings_below_the_limit_count_from_the_first() -> None:
    reading, now = watched(*[4.0] * 6)
    assert reading.low(now)[0] == pytest.approx(LOW_S)
    assert reading.low(now)[1] == 4.0
    assert reading.low(now + GAP_S + 0.1) == NOT_LOW, "none is heard any more"


@pytest.mark.fault("single readings of the rangefinder are too short")
@pytest.mark.parametrize(
    "distances",
    [
        [20.0, 3.0, 20.0, 20.0],
        [3.0, 20.0] * 20,
        [3.0] * (LOW_READINGS - 1),
        [3.0] * 9 + [5.0],
        [None] * 20,
        [20.0] * 20,
    ],
)
def test_single_bad_readings_do_nothing(distances: list[float | None]) -> None:
    reading, now = watched(*distances)
    assert reading.low(now) == NOT_LOW


@pytest.mark.fault("the rangefinder repeats one distance")
def test_a_doubted_range_does_nothing() -> None:
    reading, now = watched(*[3.0] * 20, doubt="its distance does not follow the height")
    assert reading.low(now) == NOT_LOW


def test_a_message_without_a_reading_between_them_does_not_end_it_but_a_second_of_them_does() -> None:
    reading, now = watched(*[3.0] * 4, None, *[3.0] * 3)
    assert reading.low(now)[0] == pytest.approx(0.7)
    reading, now = watched(*[3.0] * 8, *[None] * 11)
    assert reading.low(now) == NOT_LOW
    reading, now = watched(*[3.0] * 8, *[None] * 11, 3.0)
    assert reading.low(now) == NOT_LOW, "it begins again"


def test_the_least_distance_of_the_run_counts() -> None:
    reading, now = watched(1.0, 20.0, 4.0, 3.0, 2.5, 4.5, 4.0)
    assert reading.low(now)[1] == 2.5


def test_the_same_message_twice_counts_once() -> None:
    reading = ClearanceReading()
    for _ in range(20):
        reading.update(Terrain(1.0, 3.0), 5.0)
    assert reading.low(1.0) == NOT_LOW


def test_min_itself_may_be_flown() -> None:
    assert least_clearance(5.0, 15.0) == 5.0
    assert least_clearance(5.0, 6.0) == 3.0


# -- the whole room ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.fault(
    "a task flies closer over something than the least clearance",
    "within 0.5 s of readings the task ends by Hover, Min above it",
)
async def test_a_move_towards_a_roof_ends_above_it(flying: Rig) -> None:
    flying.autopilot.below = lambda north, _: 26.0 if north > 20.0 else 0.0
    flying.order(CompulsiveMove(x=60.0, y=0.0))
    await flying.run(9.0)
    flying.expect(S.HOVER)
    assert any(text.startswith("Only 4.0 m above what is below: up to 41 m.") for text in flying.log)
    assert flying.autopilot.north < 30.0
    await flying.run(8.0)
    assert flying.autopilot.height == pytest.approx(41.0, abs=0.3)
    flying.expect(S.HOVER)


@pytest.mark.nightly
async def test_without_a_rangefinder_the_same_move_goes_on(flying: Rig) -> None:
    flying.order(CompulsiveMove(x=60.0, y=0.0))
    await flying.run(9.0)
    flying.expect(S.COMPULSIVE_MOVE)
    assert "rangefinder" not in dict(flying.manager.situation().facts.parts)


@pytest.mark.fault("single readings of the rangefinder are too short", "no state changes")
async def test_one_bad_reading_ends_no_move(flying: Rig) -> None:
    readings = iter([0.0] * 40 + [27.0] * 2 + [0.0] * 10_000)
    flying.autopilot.below = lambda _north, _east: next(readings)
    flying.order(CompulsiveMove(x=60.0, y=0.0))
    await flying.run(6.0)
    flying.expect(S.COMPULSIVE_MOVE)


@pytest.mark.nightly
async def test_takeoff_climbs_through_the_first_metres(fresh: Rig) -> None:
    fresh.autopilot.below = lambda _north, _east: 0.0
    await fresh.enter(S.TAKEOFF)
    await fresh.run(20.0)
    fresh.expect(S.HOVER)
    assert not any("above what is below" in text for text in fresh.log)


@pytest.mark.nightly
async def test_a_landing_goes_down_to_the_ground(flying: Rig) -> None:
    flying.autopilot.below = lambda _north, _east: 0.0
    flying.autopilot.change_mode(9)
    await flying.run(25.0)
    flying.expect(S.IDLE)


# -- health ------------------------------------------------------------------------------------------------------------


@pytest.mark.fault("the rangefinder falls silent in flight, or its range ends")
def test_the_health_of_the_rangefinder() -> None:
    assert range_health(None, float("inf")) is None
    good = range_health(Terrain(1.0, 20.0, 0.0, 50.0), 0.1)
    assert good is not None
    assert (good.is_healthy, good.reason) == (True, "")
    far = range_health(Terrain(1.0, None, None, 50.0), 0.1)
    assert far is not None
    assert (far.is_healthy, far.reason) == (True, "no reading (it reaches 50 m)")
    silent = range_health(Terrain(1.0, 20.0, 0.0, 50.0), 4.0)
    assert silent is not None
    assert (silent.is_healthy, silent.reason) == (False, "silent for 4 s: heights count above the arm place")
    odd = range_health(Terrain(1.0, 3.0, 0.0, 50.0, "its distance does not follow the height"), 0.1)
    assert odd is not None
    assert (odd.is_healthy, odd.reason) == (False, "not believed: its distance does not follow the height")


async def test_height_above_ground_is_shown_where_it_is_known(flying: Rig) -> None:
    status = flying.manager.status.value
    assert status is not None
    assert status.pose.height_above_ground is None
    flying.autopilot.below = lambda _north, _east: 6.0
    await flying.run(1.0)
    status = flying.manager.status.value
    assert status is not None
    assert status.pose.height_above_ground == pytest.approx(24.0, abs=0.2)
    assert dict(flying.manager.situation().facts.parts)["rangefinder"].is_healthy


# -- recordings --------------------------------------------------------------------------------------------------------


def test_facts_with_a_rangefinder_are_read_back_and_older_ones_have_none() -> None:
    facts = close()
    kept = json.loads(to_json(facts))
    adapter = TypeAdapter(Facts)
    assert adapter.validate_python(kept) == facts
    del kept["position"]["below"]
    assert adapter.validate_python(kept).position.below == BelowFacts()
