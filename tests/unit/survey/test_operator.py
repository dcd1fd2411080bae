from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from hawk.comm.protocol.commands import (
    Arm,
    AutonomousExplore,
    CompulsiveMove,
    Configure,
    Control,
    Disarm,
    NewSurvey,
    ReturnToLaunch,
    SetFailsafes,
    SetOutline,
    SurveyAgain,
    Takeoff,
)
from hawk.comm.protocol.heartbeat import FenceCorner, Heartbeat
from hawk.model.operation import StateName, UserError
from hawk.model.plans import HeightParameters
from hawk.survey.handset import SurveyStatus
from hawk.survey.operator import (
    NOTHING_LEFT,
    SPIRAL_LENGTH_M,
    SurveyLimits,
    SurveyOperator,
    SurveyOutcome,
    SurveyPlan,
    spiral,
)
from tests.unit.survey.fake_drone import FakeDrone

LIMITS = SurveyLimits(
    link_s=20, map_s=10, checks_s=20, arm_s=15, takeoff_s=20, look_s=2, move_s=20, explore_s=60, home_s=60, silence_s=1
)
PLAN = SurveyPlan(limits=LIMITS)


async def fly(drone: FakeDrone, plan: SurveyPlan = PLAN) -> SurveyOutcome:
    return await SurveyOperator(drone, plan).run()


def is_down(drone: FakeDrone) -> bool:
    return drone.state is StateName.IDLE and not drone.armed and drone.height == 0


async def test_a_survey_from_the_checks_to_motors_off() -> None:
    drone, phases = FakeDrone(), list[str]()

    def note(phase: str, _: Heartbeat) -> None:
        if not phases or phases[-1] != phase:
            phases.append(phase)

    outcome = await SurveyOperator(drone, PLAN, note).run()
    assert outcome == SurveyOutcome(
        SurveyStatus.DONE, "The whole lot was seen.", True, True, outcome.duration_s, 12.0, 0.5
    )
    assert outcome.duration_s is not None
    assert 5 < outcome.duration_s < 30
    kinds = [type(command) for command in drone.orders]
    assert kinds == [Control, Arm, Takeoff, AutonomousExplore, Control, ReturnToLaunch, Control]
    assert phases == ["Connecting", "Checking", "Taking off", "Exploring", "Coming home"]
    assert is_down(drone)
    assert not drone.control, "control is given back"


async def test_a_survey_is_continued_when_there_is_a_map_of_an_earlier_one() -> None:
    drone = FakeDrone(lot_area=3_200.0)
    assert (await fly(drone, replace(PLAN, continues=True))).status is SurveyStatus.DONE
    assert is_down(drone)


async def test_without_an_earlier_map_nothing_is_continued_and_the_drone_stays_on_the_ground() -> None:
    drone = FakeDrone()
    outcome = await fly(drone, replace(PLAN, continues=True))
    assert outcome.status is SurveyStatus.FAILED
    assert "no survey to continue" in outcome.reason
    assert not drone.received(Arm)


@pytest.mark.parametrize("left", [{"is_left_done": True}, {"done": True}])
async def test_a_survey_of_which_nothing_is_left_ends_at_once_on_the_ground(left: dict[str, bool]) -> None:
    drone = FakeDrone(lot_area=3_200.0, **left)  # type: ignore[arg-type]
    outcome = await fly(drone, replace(PLAN, continues=True))
    assert (outcome.status, outcome.reason) == (SurveyStatus.FAILED, NOTHING_LEFT)
    assert not outcome.was_flown
    assert not drone.received(Arm)
    assert drone.time < 10.0


AGAIN = SurveyAgain(lots=["one"])


@pytest.mark.parametrize(
    ("seen", "words"), [(1.0, "Every stall was looked at."), (0.987, "98 % of the stalls were looked at.")]
)
async def test_a_lot_is_surveyed_again_by_its_planned_flight_without_a_search(seen: float, words: str) -> None:
    drone = FakeDrone(lot_seen_after=float("inf"), explored=seen)
    outcome = await fly(drone, replace(PLAN, again=AGAIN))
    assert drone.received(SurveyAgain) == [AGAIN]
    assert (outcome.status, outcome.reason) == (SurveyStatus.DONE, words)
    assert outcome.planned_m == 87.5
    assert outcome.was_flown


@pytest.mark.parametrize("continues", [False, True])
async def test_a_lot_is_surveyed_again_on_an_empty_map_unless_the_survey_goes_on(continues: bool) -> None:
    drone = FakeDrone(lot_area=900.0)
    await fly(drone, replace(PLAN, again=AGAIN, continues=continues))
    assert len(drone.received(NewSurvey)) == (0 if continues else 1)
    assert len(drone.received(SurveyAgain)) == 1


async def test_a_lot_that_is_refused_is_asked_for_again_until_the_drone_has_read_its_lots() -> None:
    refused = {"Survey Again": "Lots: no lot has this id: open the list of lots, then choose one."}

    def read(drone: FakeDrone) -> None:
        if drone.time > 6.0:
            drone.refusals = {}

    drone = FakeDrone(refusals=dict(refused), on_beat=read)
    assert (await fly(drone, replace(PLAN, again=AGAIN))).status is SurveyStatus.DONE
    assert len(drone.received(SurveyAgain)) > 1
    drone = FakeDrone(refusals=refused)
    outcome = await fly(drone, replace(PLAN, again=AGAIN))
    assert outcome.status is SurveyStatus.FAILED
    assert "no lot has this id" in outcome.reason
    assert not drone.received(Arm)


async def test_a_flight_over_a_lot_that_is_not_planned_does_not_begin() -> None:
    drone = FakeDrone(tour_m=None)
    outcome = await fly(drone, replace(PLAN, again=AGAIN))
    assert outcome.status is SurveyStatus.FAILED
    assert "not planned" in outcome.reason
    assert not drone.received(Arm)


async def test_heights_are_configured_when_given() -> None:
    drone = FakeDrone()
    await fly(drone, replace(PLAN, heights=HeightParameters(10.0, 20.0, 30.0)))
    assert drone.received(Configure) == [Configure(min=10.0, des=20.0, max=30.0)]
    assert drone.heights == (10.0, 20.0, 30.0)


async def test_failsafes_are_set_only_when_allowed() -> None:
    drone = FakeDrone(failsafes_set=False)
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.FAILED
    assert "Failsafes" in outcome.reason
    assert "--set-failsafes" in outcome.reason
    assert drone.received(Arm) == drone.received(SetFailsafes) == []
    drone = FakeDrone(failsafes_set=False)
    assert (await fly(drone, replace(PLAN, set_failsafes=True))).status is SurveyStatus.DONE
    assert len(drone.received(SetFailsafes)) == 1


async def test_failsafes_that_cannot_be_set_end_it_on_the_ground() -> None:
    drone = FakeDrone(failsafes_set=False, failsafes_settable=False)
    outcome = await fly(drone, replace(PLAN, set_failsafes=True))
    assert outcome.status is SurveyStatus.FAILED
    assert len(drone.received(SetFailsafes)) == 1
    assert drone.received(Arm) == []


async def test_an_autopilot_that_is_never_found_is_reported() -> None:
    outcome = await fly(FakeDrone(connected_at=math.inf))
    assert outcome.status is SurveyStatus.FAILED
    assert "autopilot is not reached" in outcome.reason


async def test_someone_else_in_control_is_left_alone() -> None:
    drone = FakeDrone(refusals={"Control": "Someone else has control."}, state=StateName.HOVER, armed=True, height=35.0)
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.FAILED
    assert "Someone else has control." in outcome.reason
    assert drone.received(ReturnToLaunch) == []
    assert drone.state is StateName.HOVER


async def test_a_drone_that_flies_already_is_left_alone() -> None:
    drone = FakeDrone(state=StateName.HOVER, armed=True, height=35.0)
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.FAILED
    assert "Hover" in outcome.reason
    assert drone.received(ReturnToLaunch) == []


async def test_the_autopilots_words_are_the_reason_when_it_does_not_arm() -> None:
    drone = FakeDrone(arms=False)
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.FAILED
    assert "compass not calibrated" in outcome.reason
    assert drone.received(Takeoff) == []


async def test_a_refused_takeoff_stops_the_motors() -> None:
    drone = FakeDrone(refusals={"Takeoff": "No."})
    outcome = await fly(drone)
    assert "Takeoff was refused: No." in outcome.reason
    assert drone.received(Disarm) != []
    assert is_down(drone)


async def test_a_drone_that_does_not_climb_is_brought_down() -> None:
    drone = FakeDrone(climbs=False, height=0.0)
    drone.on_beat = lambda d: setattr(d, "height", 4.0) if d.state is StateName.TAKEOFF else None
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.FAILED
    assert "did not reach its height" in outcome.reason
    assert is_down(drone)


async def test_without_a_lot_it_climbs_searches_and_comes_home_with_status_3() -> None:
    drone = FakeDrone(lot_seen_after=math.inf)
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.NO_LOT
    assert int(outcome.status) == 3
    assert "No lot in sight" in outcome.reason
    moves = [m for m in drone.received(CompulsiveMove) if isinstance(m, CompulsiveMove)]
    assert {m.height for m in moves} == {60.0}
    assert {m.frame for m in moves} == {"Map"}
    assert (moves[0].x, moves[0].y) == (3.0, -2.0), "climbs where it is first"
    assert drone.searched <= 60.0
    assert drone.received(AutonomousExplore) == []
    assert is_down(drone)


async def test_a_lot_found_on_the_spiral_is_explored() -> None:
    drone = FakeDrone(lot_seen_after=15.0)
    assert (await fly(drone)).status is SurveyStatus.DONE
    assert 1 < len(drone.received(CompulsiveMove)) < 5


OUTLINE = SetOutline(polygons=[[FenceCorner(latitude=lat, longitude=0.0) for lat in (0.0, 1e-3, 2e-3)]])


async def test_an_outline_is_given_before_arm_and_no_lot_is_looked_for() -> None:
    drone = FakeDrone(lot_seen_after=math.inf)
    outcome = await fly(drone, replace(PLAN, outline=OUTLINE))
    assert outcome.status is SurveyStatus.DONE
    assert outcome.reason == "The whole lot was seen."
    assert outcome.outline_m2 == 1000.0
    kinds = [type(command) for command in drone.orders]
    assert kinds.index(Control) < kinds.index(SetOutline) < kinds.index(Arm)
    assert CompulsiveMove not in kinds


async def test_an_outline_that_is_refused_keeps_the_drone_on_the_ground() -> None:
    drone = FakeDrone(refusals={"Set Outline": "Polygon 1: the sides 1-2 and 3-4 cross."})
    outcome = await fly(drone, replace(PLAN, outline=OUTLINE))
    assert outcome.status is SurveyStatus.FAILED
    assert "the sides 1-2 and 3-4 cross" in outcome.reason
    assert not drone.received(Arm)


async def test_what_of_an_outline_was_not_reached_is_said() -> None:
    outcome = await fly(FakeDrone(outline_unseen=120.0), replace(PLAN, outline=OUTLINE))
    assert outcome.status is SurveyStatus.DONE
    assert outcome.reason == "The outline was seen. 120 m² of it could not be reached."
    assert outcome.outline_unseen_m2 == 120.0


async def test_places_outside_the_fence_are_left_out_of_the_spiral() -> None:
    drone = FakeDrone(lot_seen_after=math.inf, refuse_moves_to=lambda move: move.x > 5)
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.NO_LOT
    assert drone.north <= 5
    assert len(drone.received(CompulsiveMove)) == len(list(spiral(0, 0)))


def test_the_spiral_is_square_grows_and_is_no_longer_than_60_m() -> None:
    places = list(spiral(0.0, 0.0))
    legs = [abs(b[0] - a[0]) + abs(b[1] - a[1]) for a, b in pairwise(places)]
    assert sum(legs) <= SPIRAL_LENGTH_M == 60.0
    assert legs == [10.0, 10.0, 20.0, 20.0]
    assert len(set(places)) == len(places)


async def test_exploring_is_begun_again_after_a_hold() -> None:
    drone = FakeDrone()

    def held_once(d: FakeDrone) -> None:
        d.explore_ends = None

    drone.explore_ends = held_once
    assert (await fly(drone)).status is SurveyStatus.DONE
    assert len(drone.received(AutonomousExplore)) == 2


async def test_exploring_that_never_finishes_ends_incomplete_and_at_home() -> None:
    drone = FakeDrone(explore_ends=lambda d: d.go(StateName.HOVER, "No progress for 10 s."))
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.INCOMPLETE
    assert "No progress for 10 s." in outcome.reason
    assert len(drone.received(AutonomousExplore)) == 3
    assert is_down(drone)


async def test_a_lot_that_is_lost_is_looked_for_from_the_next_place() -> None:
    def lose_once(d: FakeDrone) -> None:
        d.user_error = UserError.NO_LOT_DETECTED
        d.explore_ends = None

    drone = FakeDrone(explore_ends=lose_once)
    assert (await fly(drone)).status is SurveyStatus.DONE
    assert len(drone.received(AutonomousExplore)) == 2
    assert len(drone.received(CompulsiveMove)) == 1


@pytest.mark.slow
async def test_losing_the_lot_wherever_it_is_looked_for_ends_incomplete() -> None:
    def lose(d: FakeDrone) -> None:
        d.user_error = UserError.NO_LOT_DETECTED

    drone = FakeDrone(explore_ends=lose)
    assert (await fly(drone)).status is SurveyStatus.INCOMPLETE
    assert len(drone.received(AutonomousExplore)) == 1 + len(list(spiral(0, 0)))


@pytest.mark.slow
async def test_the_time_for_exploring_has_an_end() -> None:
    drone = FakeDrone(explore_s=math.inf)
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.INCOMPLETE
    assert "time for exploring is over" in outcome.reason
    assert is_down(drone)


async def test_a_drone_that_comes_home_by_itself_is_followed_down() -> None:
    def battery(d: FakeDrone) -> None:
        if d.state is StateName.AUTONOMOUS_EXPLORE and d.time - d.entered > 2:
            d.go(StateName.RETURN_TO_LAUNCH, "The battery is needed for the return.")

    drone = FakeDrone(on_beat=battery)
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.INCOMPLETE
    assert "battery" in outcome.reason
    assert drone.received(ReturnToLaunch) == [], "it returns already"
    assert is_down(drone)


async def test_a_pilot_who_takes_over_is_not_disturbed() -> None:
    def pilot(d: FakeDrone) -> None:
        if d.state is StateName.AUTONOMOUS_EXPLORE and d.time - d.entered > 2:
            d.go(StateName.MANUAL, "A pilot flies in LOITER.")
        if d.state is StateName.MANUAL and d.time - d.entered > 5:
            d.height, d.armed = 0.0, False
            d.go(StateName.IDLE)

    drone = FakeDrone(on_beat=pilot)
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.INCOMPLETE
    assert "pilot" in outcome.reason
    assert drone.received(ReturnToLaunch) == []


async def test_a_lost_operator_that_is_back_goes_on_exploring() -> None:
    def lose_and_find(d: FakeDrone) -> None:
        if (
            d.state is StateName.AUTONOMOUS_EXPLORE
            and d.time - d.entered > 2
            and len(d.received(AutonomousExplore)) == 1
        ):
            d.go(StateName.COMMUNICATION_LOST)
        if d.state is StateName.COMMUNICATION_LOST and d.time - d.entered > 2:
            d.go(StateName.HOVER)

    drone = FakeDrone(on_beat=lose_and_find)
    assert (await fly(drone)).status is SurveyStatus.DONE
    assert len(drone.received(AutonomousExplore)) == 2


async def test_the_return_is_asked_for_again_when_someone_stops_it() -> None:
    drone = FakeDrone(stop_the_return_once=True)
    assert (await fly(drone)).status is SurveyStatus.DONE
    assert len(drone.received(ReturnToLaunch)) == 2
    assert is_down(drone)


@pytest.mark.parametrize(
    "state", [StateName.TAKEOFF, StateName.HOVER, StateName.AUTONOMOUS_EXPLORE, StateName.COMPULSIVE_MOVE]
)
async def test_ctrl_c_brings_the_drone_home_from_any_phase(state: StateName) -> None:
    drone = FakeDrone(lot_seen_after=15.0)
    operator = SurveyOperator(drone, PLAN)
    drone.on_beat = lambda d: operator.interrupt() if d.state is state else None
    outcome = await operator.run()
    assert outcome.status is SurveyStatus.INTERRUPTED
    assert (outcome.landed, outcome.disarmed) == (True, True)
    assert is_down(drone)


async def test_ctrl_c_while_arming_stops_the_motors() -> None:
    drone = FakeDrone()
    operator = SurveyOperator(drone, PLAN)
    drone.on_beat = lambda d: operator.interrupt() if d.state is StateName.ARM else None
    assert (await operator.run()).status is SurveyStatus.INTERRUPTED
    assert drone.received(Takeoff) == drone.received(ReturnToLaunch) == []
    assert is_down(drone)


async def test_ctrl_c_before_arming_touches_nothing() -> None:
    drone = FakeDrone()
    operator = SurveyOperator(drone, PLAN)
    operator.interrupt()
    outcome = await operator.run()
    assert outcome.status is SurveyStatus.INTERRUPTED
    assert drone.received(Arm) == drone.received(Disarm) == []


async def test_a_link_that_is_lost_for_good_is_reported_and_the_end_is_not_claimed() -> None:
    drone = FakeDrone(silent_after=6.0)
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.FAILED
    assert "no heartbeat" in outcome.reason.lower()
    assert (outcome.landed, outcome.disarmed) == (False, False)


@pytest.mark.slow
async def test_a_restarted_drone_does_not_shorten_a_wait() -> None:
    drone = FakeDrone(explore_s=30.0)
    jumped = False

    def restart(d: FakeDrone) -> None:
        nonlocal jumped
        if d.state is StateName.AUTONOMOUS_EXPLORE and not jumped and d.time - d.entered > 5:
            jumped = True
            d.entered -= d.time
            d.time = 0.0

    drone.on_beat = restart
    assert (await fly(drone)).status is SurveyStatus.DONE


@pytest.mark.slow
async def test_a_drone_that_does_not_come_down_is_reported() -> None:
    drone = FakeDrone(refusals={"Return To Launch": "No home."})
    outcome = await fly(drone)
    assert outcome.status is SurveyStatus.FAILED
    assert "not down yet" in outcome.reason
    assert len(drone.received(ReturnToLaunch)) > 5
    assert not outcome.landed


@pytest.mark.slow
async def test_a_drone_that_stays_armed_on_the_ground_has_landed() -> None:
    outcome = await fly(FakeDrone(climbs=False, refusals={"Return To Launch": "No home."}))
    assert outcome.status is SurveyStatus.FAILED
    assert (outcome.landed, outcome.disarmed) == (True, False)
