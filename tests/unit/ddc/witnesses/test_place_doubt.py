"""A doubted position: tasks end, the camera holds the drone within limits, else it lands; no RTL."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import AutonomousExplore, CompulsiveMove, Land, ReturnToLaunch
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import circle, contains, polygon_fence
from hawk.ddc.motion import Goal
from hawk.ddc.orders import (
    Cause,
    CauseKind,
    Rank,
    ToCommunicationLost,
    ToExplore,
    ToHover,
    ToLand,
    ToMove,
    ToReturn,
    ToTakeoff,
    Transition,
)
from hawk.ddc.rules import guard
from hawk.ddc.rules.notices import WitnessNotices
from hawk.ddc.states.base import returning
from hawk.ddc.states.hover import FARTHEST_M, FOLLOWS_M_S, STRAYS_S, held
from hawk.ddc.witnesses.height import HeightFacts
from hawk.ddc.witnesses.place import PlaceFacts
from hawk.ddc.witnesses.witness import WitnessFacts
from hawk.model.operation import Health, StateName
from hawk.model.pictures import GroundStep
from hawk.model.poses import MapPoint
from hawk.model.vehicle import CopterMode, LandedState
from tests.unit.ddc.by_facts import MOVE, at, made, requests, targets, texts, without_operator
from tests.unit.ddc.fakes import TICK_S, Rig
from tests.unit.ddc.written_facts import flying

S = StateName
CAUSE = Cause("The battery is needed for the flight home.", CauseKind.RESERVE)


def doubted(facts: Facts, off: tuple[float, float] = (4.0, 0.0), *, followed: bool = True) -> Facts:
    place = PlaceFacts(camera_age=0.1, apart=4.0, doubted_s=1.0, off=off, is_followed=followed)
    return replace(facts, witness=WitnessFacts(place))


def low(facts: Facts) -> Facts:
    return replace(facts, battery=replace(facts.battery, reached_s=5.0))


# -- values ----------------------------------------------------------------------------------------------------------


def test_a_doubt_makes_a_good_position_unhealthy_and_leaves_a_bad_one() -> None:
    bad = Health.bad("No position from the autopilot.")
    well = WitnessFacts()
    assert well.position_health(Health()) == Health()
    assert well.doubt == ""
    ill = doubted(flying(0.0)).witness
    assert ill.position_health(bad) is bad
    assert ill.position_health(Health()) == Health.bad(
        "The camera sees the drone move 4 m that the position does not show."
    )


@pytest.mark.parametrize("transition", [ToExplore(), ToMove(MOVE)])
def test_a_doubt_ends_a_task(transition: Transition) -> None:
    found = guard.reaction(doubted(flying(0.0)), made(transition))
    assert found is not None
    assert isinstance(found.transition, ToHover)
    assert (found.rank, found.transition.level) == (Rank.PERCEPTION, "warning")
    assert found.transition.reason == "The camera sees the drone move 4 m that the position does not show."


@pytest.mark.parametrize("transition", [ToHover(), ToTakeoff(), ToReturn(), ToLand(), ToCommunicationLost()])
def test_a_doubt_is_no_reason_to_leave_another_state(transition: Transition) -> None:
    assert guard.reaction(doubted(flying(0.0)), made(transition)) is None


@pytest.mark.fault(
    "GNSS walks away and takes the estimate with it, all flags good, and the battery, the wind, the operator "
    "or the program's end asks for a return",
    "Land",
)
@pytest.mark.parametrize("transition", [ToHover(), ToExplore(), ToTakeoff(), ToCommunicationLost()])
def test_a_return_that_is_needed_becomes_a_landing(transition: Transition) -> None:
    found = guard.reaction(doubted(low(flying(0.0))), made(transition))
    assert found is not None
    assert isinstance(found.transition, ToLand)
    assert found.rank is Rank.LAND
    assert found.transition.cause == Cause(
        "The battery is needed for the flight home. "
        "The camera sees the drone move 4 m that the position does not show.",
        CauseKind.RESERVE,
    )
    trusted = guard.reaction(low(flying(0.0)), made(transition))
    assert trusted is not None
    assert isinstance(trusted.transition, ToReturn)


def test_a_program_that_ends_lands_a_drone_whose_place_is_doubted() -> None:
    assert isinstance(returning(doubted(flying(0.0)), CAUSE), ToLand)
    assert isinstance(returning(flying(0.0), CAUSE), ToReturn)


@pytest.mark.fault(
    "GNSS walks away and takes the estimate with it, all flags good, and the battery, the wind, the operator "
    "or the program's end asks for a return"
)
def test_a_lost_operator_lands_a_drone_whose_place_is_doubted() -> None:
    state = made(ToCommunicationLost())
    step = state.transition_next_state(without_operator(doubted(flying(60.0))))
    assert isinstance(step.transition, ToLand)
    assert step.transition.cause is not None
    assert step.transition.cause.kind is CauseKind.OPERATOR
    trusted = made(ToCommunicationLost()).transition_next_state(without_operator(flying(60.0)))
    assert isinstance(trusted.transition, ToReturn)


# -- a return under way ------------------------------------------------------------------------------------------------


def misled(now: float, seconds: float, *, by_height: bool = False, height: float = 30.0) -> Facts:
    """Return facts of a return whose place, or height (reported 4 m too high), has been doubted for ``seconds``."""
    facts = at(doubted(flying(now, CopterMode.RTL)), 20.0, height=height)
    witness = WitnessFacts(replace(facts.witness.place, doubted_s=seconds))
    if by_height:
        witness = WitnessFacts(height=HeightFacts(4.0, 4.0, None, height, doubted_s=seconds))
    return replace(facts, witness=witness)


@pytest.mark.fault(
    "GNSS walks away and takes the estimate with it, all flags good, while the drone returns (or a doubt of "
    "the height begins then)",
    "a return that must be becomes Land; one that the operator asked for becomes Hover, below Min Land; a "
    "return that was asked for in spite of the doubt goes on",
)
@pytest.mark.parametrize("by_height", [False, True])
def test_a_return_that_must_be_lands_when_a_doubt_begins_in_flight(by_height: bool) -> None:
    step = made(ToReturn(CAUSE)).transition_next_state(misled(9.0, 1.0, by_height=by_height))
    assert isinstance(step.transition, ToLand)
    assert step.transition.cause is not None
    assert step.transition.cause.kind is CAUSE.kind
    assert step.transition.cause.text.startswith(f"{CAUSE.text} The ")


@pytest.mark.fault(
    "GNSS walks away and takes the estimate with it, all flags good, while the drone returns (or a doubt of "
    "the height begins then)"
)
@pytest.mark.parametrize("by_height", [False, True])
def test_a_return_that_the_operator_asked_for_holds_when_a_doubt_begins_in_flight(by_height: bool) -> None:
    step = made(ToReturn()).transition_next_state(misled(9.0, 1.0, by_height=by_height))
    assert isinstance(step.transition, ToHover)
    assert step.transition.level == "warning"
    assert step.transition.reason.endswith("Land, or fly by hand.")


def test_one_that_is_below_min_lands_there() -> None:
    lowest = flying(0.0).limits.heights.minimum
    for height, found in ((lowest, ToHover), (lowest - 0.1, ToLand)):
        step = made(ToReturn()).transition_next_state(misled(9.0, 1.0, height=height))
        assert isinstance(step.transition, found)
    step = made(ToReturn()).transition_next_state(misled(9.0, 1.0, by_height=True, height=lowest + 3.9))
    assert isinstance(step.transition, ToLand), "truly below Min"
    assert step.transition.cause is not None
    assert step.transition.cause.kind is CauseKind.NEVER


@pytest.mark.fault(
    "GNSS walks away and takes the estimate with it, all flags good, while the drone returns (or a doubt of "
    "the height begins then)"
)
def test_a_return_in_spite_of_a_doubt_that_the_operator_knew_goes_on_and_so_does_the_autopilots_own() -> None:
    assert made(ToReturn()).transition_next_state(misled(9.0, 10.0)).transition is None
    assert isinstance(made(ToReturn()).transition_next_state(misled(9.0, 9.9)).transition, ToHover), (
        "seen a second late"
    )
    assert made(ToReturn(CAUSE, by_autopilot=True)).transition_next_state(misled(9.0, 1.0)).transition is None


@pytest.mark.fault(
    "GNSS walks away and takes the estimate with it, all flags good, while the drone returns (or a doubt of "
    "the height begins then)"
)
def test_a_return_that_nobody_asked_for_lands_whenever_the_doubt_began() -> None:
    """The link was silent in a doubt, and RTL was sent without an answer."""
    assert isinstance(made(ToReturn(CAUSE)).transition_next_state(misled(9.0, 60.0)).transition, ToLand)


@pytest.mark.parametrize(("off", "seconds"), [(1.9, None), (2.0, 1.0), (-4.0, None), (0.0, None)])
def test_only_a_height_that_is_two_metres_lower_than_it_says_misleads_home(off: float, seconds: float | None) -> None:
    witness = WitnessFacts(height=HeightFacts(off, off, None, 30.0, doubted_s=1.0))
    assert witness.misled_s == seconds
    assert witness.misleads_home is (seconds is not None)
    facts = replace(misled(9.0, 1.0), witness=witness)
    assert (made(ToReturn()).transition_next_state(facts).transition is not None) is (seconds is not None)


def test_the_newer_of_two_doubts_is_the_one_that_the_operator_did_not_know() -> None:
    facts = misled(9.0, 60.0)
    lower = HeightFacts(8.0, 8.0, None, 30.0, doubted_s=1.0)
    both = replace(facts, witness=WitnessFacts(facts.witness.place, lower))
    assert both.witness.misled_s == 1.0
    assert isinstance(made(ToReturn()).transition_next_state(both).transition, ToHover)


# -- the place that the camera holds -----------------------------------------------------------------------------------

GOAL = Goal(10.0, 0.0, 30.0, 0.5)


def test_the_target_goes_along_with_the_error() -> None:
    assert held(doubted(flying(0.0), (4.0, -3.0)), GOAL, (0.0, 0.0)) == Goal(14.0, -3.0, 30.0, 0.5)
    assert held(doubted(flying(0.0), (4.0, -3.0)), GOAL, (3.0, -3.0)) == Goal(11.0, 0.0, 30.0, 0.5)


def test_the_camera_holds_nothing_beyond_its_limits() -> None:
    facts = flying(0.0)
    assert held(doubted(facts, followed=False), GOAL, (0.0, 0.0)) is None
    assert held(doubted(facts, (FARTHEST_M, 0.0)), GOAL, (0.0, 0.0)) is not None
    assert held(doubted(facts, (FARTHEST_M + 0.1, 0.0)), GOAL, (0.0, 0.0)) is None
    unfenced = replace(doubted(facts), limits=replace(facts.limits, fence=None))
    assert held(unfenced, GOAL, (0.0, 0.0)) is None


def test_the_target_stays_inside_the_fence_by_the_report() -> None:
    edge = Goal(140.0, 0.0, 30.0, 0.0)
    assert held(doubted(flying(0.0), (4.0, 0.0)), edge, (0.0, 0.0)) is not None
    assert held(doubted(flying(0.0), (12.0, 0.0)), edge, (0.0, 0.0)) is None


def test_a_place_outside_the_fence_by_the_camera_is_left_for_one_inside() -> None:
    """The drone holds at 140 m as reported, and the report is 12 m behind: truly at 152 m, 7 m outside."""
    facts = doubted(flying(0.0), (-12.0, 0.0))
    found = held(facts, Goal(140.0, 0.0, 30.0, 0.0), (-12.0, 0.0))
    assert found is not None
    true = MapPoint(found.north + 12.0, found.east)
    assert facts.limits.fence is not None
    assert contains(facts.limits.fence, true)
    assert true.north == pytest.approx(143.0, abs=0.5)


# -- Hover -------------------------------------------------------------------------------------------------------------


def test_hover_holds_by_the_camera_and_says_so() -> None:
    state = made(ToHover("Stopped."))
    assert targets(state.process(flying(0.05))) == [Goal(0.0, 0.0, 30.0, 0.0)]
    assert state.detail(flying(0.05)) == "Stopped. Holding at 30 m."
    (goal,) = targets(state.process(doubted(flying(0.1), (4.0, 1.0))))
    assert (goal.north, goal.east) == (4.0, 1.0)
    assert state.detail(flying(0.1)) == "Stopped. Holding at 30 m by the camera."
    (goal,) = targets(state.process(flying(0.15)))
    assert (goal.north, goal.east) == (0.0, 0.0)


def test_a_hover_with_a_goal_of_its_own_goes_along_with_the_whole_error() -> None:
    state = made(ToHover(goal=Goal(10.0, 5.0, 30.0, 0.0)))
    (goal,) = targets(state.process(at(doubted(flying(0.05), (4.0, 0.0)), 14.0, 5.0)))
    assert (goal.north, goal.east) == (14.0, 5.0)


def test_a_hover_that_begins_in_doubt_holds_where_it_begins() -> None:
    state = made(ToHover())
    (goal,) = targets(state.process(at(doubted(flying(0.05), (4.0, 0.0)), 7.0)))
    assert (goal.north, goal.east) == (7.0, 0.0)
    (goal,) = targets(state.process(at(doubted(flying(1.05), (4.7, 0.0)), 7.0)))
    assert goal.north == pytest.approx(7.7)


@pytest.mark.fault(
    "a car fills a low picture and looks like a walk of 8 m/s",
    "the target follows it at 1.5 m/s at most, inside the fence, 30 m at most",
)
def test_a_car_that_fills_the_picture_leads_the_drone_slowly() -> None:
    """The camera sees 8 m/s: no walk of GNSS. Without the pace the target would be 13 m away after a second."""
    state = made(ToHover())
    state.process(flying(0.05))
    (goal,) = targets(state.process(doubted(flying(1.0), (3.0, 4.0))))
    assert (goal.north, goal.east) == (3.0, 4.0), "what went before the doubt is taken back at once"
    (goal,) = targets(state.process(doubted(flying(2.0), (11.0, 4.0))))
    assert (goal.north, goal.east) == (3.0 + FOLLOWS_M_S, 4.0)
    state.process(doubted(flying(2.5), followed=False))
    (goal,) = targets(state.process(doubted(flying(3.0), (11.0, 4.0))))
    assert (goal.north, goal.east) == (11.0, 4.0), "a camera that follows again begins there"
    (goal,) = targets(state.process(flying(3.1)))
    assert (goal.north, goal.east) == (0.0, 0.0), "without a doubt the goal counts"


def test_a_slower_target_leaves_no_drone_outside_the_fence() -> None:
    """It holds at 140 m as reported and truly; our limit is 144.7 m. The report walks south at 5 m/s."""
    state = made(ToHover())
    state.process(at(flying(0.05), 140.0))
    state.process(at(doubted(flying(1.0), (-3.0, 0.0)), 137.0))
    for second in range(1, 4):
        off = (-3.0 - 5.0 * second, 0.0)
        (goal,) = targets(state.process(at(doubted(flying(1.0 + second), off), 137.0 - 5.0 * second)))
        fence = flying(0.0).limits.fence
        assert fence is not None
        assert contains(fence, MapPoint(goal.north - off[0], goal.east - off[1]))


def test_a_hover_that_sent_nothing_leads_the_drone_when_its_place_is_doubted() -> None:
    state = made(ToHover(passive=True))
    assert state.process(flying(0.05, CopterMode.BRAKE)) == ()
    assert len(requests(state.process(doubted(flying(0.1, CopterMode.BRAKE))))) == 1


@pytest.mark.fault(
    "GNSS walks away and takes the estimate with it, all flags good, and the camera cannot hold the drone (no "
    "pictures for 3 s, 30 m off, fence)",
    "Land after 3 s, never RTL",
)
@pytest.mark.parametrize("transition", [ToHover(), ToCommunicationLost()])
def test_a_drone_that_the_camera_cannot_hold_lands(transition: Transition) -> None:
    state, change = (
        made(transition),
        without_operator if isinstance(transition, ToCommunicationLost) else (lambda it: it),
    )
    state.process(flying(0.05))
    lost = change(doubted(flying(1.0), followed=False))
    state.process(lost)
    assert state.transition_next_state(lost).transition is None
    almost = replace(lost, now=1.0 + STRAYS_S - 0.05)
    state.process(almost)
    assert state.transition_next_state(almost).transition is None
    late = replace(lost, now=1.0 + STRAYS_S)
    state.process(late)
    step = state.transition_next_state(late)
    assert isinstance(step.transition, ToLand)
    assert step.transition.cause == Cause(
        "The camera sees the drone move 4 m that the position does not show. The camera cannot hold it here.",
        CauseKind.NEVER,
    )


@pytest.mark.fault(
    "GNSS walks away and takes the estimate with it, all flags good, and the camera loses the drone after 11 m",
    "the last target stays until the landing: the goal of before the error is not flown to",
)
def test_a_drone_that_the_camera_loses_stays_where_it_was_held_last() -> None:
    """The goal as it was reported lies 11 m away by now: it would drag the drone there before it lands."""
    state = made(ToHover())
    state.process(flying(0.05))
    state.process(doubted(flying(1.0), (11.0, -3.0)))
    (goal,) = targets(state.process(doubted(flying(1.05), (11.0, -3.0), followed=False)))
    assert (goal.north, goal.east) == (11.0, -3.0)
    state.restart()
    (goal,) = targets(state.process(at(doubted(flying(1.1), followed=False), 2.0)))
    assert (goal.north, goal.east) == (2.0, 0.0), "begun again where it is reported"


def test_a_camera_that_holds_again_in_time_keeps_the_drone_up() -> None:
    state = made(ToHover())
    state.process(flying(0.05))
    for now, followed in ((1.0, False), (2.0, True), (2.5, False), (5.4, False)):
        facts = doubted(flying(now), followed=followed)
        state.process(facts)
        assert state.transition_next_state(facts).transition is None


def test_a_drone_that_goes_back_inside_is_led_by_the_report() -> None:
    state = made(ToHover())
    state.process(flying(0.05))
    facts = at(doubted(flying(1.0), (4.0, 0.0)), 147.0)
    for now in (1.0, 2.0, 5.0):
        outside = replace(facts, now=now, limits=replace(facts.limits, breached_s=now))
        acts = state.process(outside)
        assert state.transition_next_state(outside).transition is None
        assert state.rank is Rank.FENCE
    assert all(goal.north < 147.0 for goal in targets(acts))


# -- reports -----------------------------------------------------------------------------------------------------------


def test_a_doubt_is_reported_once_and_so_is_its_end() -> None:
    reports, hover = WitnessNotices(), made(ToHover())
    assert reports.tick(flying(0.0), hover) == ()
    assert texts(reports.tick(doubted(flying(0.0)), hover)) == [
        "The camera sees the drone move 4 m that the position does not show."
    ]
    assert reports.tick(doubted(flying(0.0), (5.0, 0.0)), hover) == ()
    assert texts(reports.tick(flying(0.0), hover)) == ["The position agrees with its witnesses again."]
    assert reports.tick(doubted(flying(0.0)), made(ToExplore())) == (), "the task that ends says it"
    down = replace(flying(0.0), vehicle=replace(flying(0.0).vehicle, landed=LandedState.ON_GROUND))
    assert reports.tick(down, hover) == ()


# -- the whole state machine -------------------------------------------------------------------------------------------


class Walker:
    """GNSS that walks: the drone follows its report, and the camera sees its true motion."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.off = [0.0, 0.0]
        self._before = (rig.autopilot.north, rig.autopilot.east)
        self._since = rig.clock()

    @property
    def true(self) -> MapPoint:
        return MapPoint(self.rig.autopilot.north - self.off[0], self.rig.autopilot.east - self.off[1])

    async def run(self, seconds: float, walk: tuple[float, float] = (0.0, 0.0), *, sees: bool = True) -> None:
        for k in range(round(seconds / TICK_S)):
            for axis in (0, 1):
                self.off[axis] += walk[axis] * TICK_S
            self.rig.autopilot.north += walk[0] * TICK_S  # the report moves at once, the drone goes back
            self.rig.autopilot.east += walk[1] * TICK_S
            await self.rig.tick()
            if k % 8 == 7:
                self._see(walk, sees=sees)

    def _see(self, walk: tuple[float, float], *, sees: bool) -> None:
        here, now = (self.rig.autopilot.north, self.rig.autopilot.east), self.rig.clock()
        reported = here[0] - self._before[0], here[1] - self._before[1]
        seconds = now - self._since
        seen = reported[0] - walk[0] * seconds, reported[1] - walk[1] * seconds
        if sees:
            self.rig.inputs.ground_step.publish(GroundStep(self._since, now, seen, reported, 0.0, 0.0, 30.0))
        self._before, self._since = here, now


@pytest.mark.slow
@pytest.mark.fault("GNSS walks away and takes the estimate with it, all flags good (0.7 m/s), in a task")
async def test_gnss_that_walks_ends_the_exploration_and_the_camera_holds_the_drone(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    walker = Walker(fresh)
    fresh.target_plan(60, 0)
    await walker.run(10.0)
    fresh.target_plan(0, 0)
    await walker.run(10.0, (0.0, 0.7))
    fresh.expect(S.HOVER)
    assert math.hypot(*walker.off) <= 7.01
    assert any("The camera sees the drone move" in line for line in fresh.log)
    assert not fresh.manager.situation().facts.health("position").is_healthy
    assert "The camera sees" in (fresh.topics.doubt_pub.value or ""), "nothing is mapped"
    await walker.run(3.0, (0.0, 0.7))
    there = walker.true
    await walker.run(20.0, (0.0, 0.7))
    fresh.expect(S.HOVER)
    assert walker.true.distance(there) < 1.5, "in spite of 14 m that the position walked meanwhile"
    assert fresh.detail.endswith("by the camera.")
    for command in (AutonomousExplore(), CompulsiveMove(x=5.0, y=0.0)):
        assert "The camera sees the drone move" in fresh.command(command).reason
    await walker.run(14.0, (0.0, 0.7))
    fresh.expect(S.LAND)
    assert any("The camera cannot hold it here. Landing." in line for line in fresh.log)
    assert S.RETURN_TO_LAUNCH not in {
        state for kind, entry in fresh.records if kind == "state" for state in entry.values()
    }


@pytest.mark.nightly
async def test_the_operator_may_land_or_return_in_doubt(holding: Rig) -> None:
    walker = Walker(holding)
    await walker.run(8.0, (0.7, 0.0))
    holding.expect(S.HOVER)
    assert holding.command(ReturnToLaunch()).accepted
    await walker.run(1.0)
    assert holding.command(Land()).accepted


@pytest.mark.nightly
async def test_after_the_landing_nothing_is_doubted(holding: Rig) -> None:
    walker = Walker(holding)
    await walker.run(8.0, (0.7, 0.0))
    assert holding.manager.situation().facts.witness.doubt
    holding.order(Land())
    await walker.run(60.0)
    holding.expect(S.IDLE)
    assert not holding.manager.situation().facts.witness.doubt
    assert holding.topics.doubt_pub.value == ""
    assert holding.manager.situation().facts.health("position").is_healthy


@pytest.mark.nightly
async def test_a_leap_of_the_estimate_is_followed_no_more(holding: Rig) -> None:
    walker = Walker(holding)
    await walker.run(8.0, (0.7, 0.0))
    assert holding.manager.situation().facts.witness.place.is_followed
    holding.autopilot.topics.estimate_jump.publish(5.0)
    assert not holding.manager.situation().facts.witness.place.is_followed
    await holding.close()
    holding.inputs.ground_step.publish(GroundStep(0.0, 1.0, (0.0, 0.0), (0.0, 0.0), 0.0, 0.0, 30.0))


def test_a_fence_is_there_to_hold_in() -> None:
    small = polygon_fence(circle(MapPoint(0.0, 0.0), 12.0), 5.0, 100.0, 3.0)
    facts = doubted(flying(0.0), (9.0, 0.0))
    assert (
        held(replace(facts, limits=replace(facts.limits, fence=small)), Goal(0.0, 0.0, 30.0, 0.0), (0.0, 0.0)) is None
    )
