"""Refusals by facts alone: places and routes without position or fence, limits at their very value."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.comm.protocol.command_table import COMMAND_TABLE
from hawk.comm.protocol.commands import (
    AutonomousExplore,
    AutonomousMove,
    Command,
    CompulsiveMove,
    Disarm,
    Hold,
    KillRequest,
    Land,
    Resume,
    ReturnToLaunch,
    SetOutline,
    Takeoff,
)
from hawk.comm.protocol.heartbeat import FenceCorner
from hawk.ddc.facts import Facts, KeptFacts
from hawk.ddc.fence.geometry import ring_from_map
from hawk.ddc.fence.outline import OutlineFacts
from hawk.ddc.fence.plan import FencePlan
from hawk.ddc.orders import (
    Cause,
    CauseKind,
    ToArm,
    ToExplore,
    ToHover,
    ToIdle,
    ToManual,
    ToReturn,
    ToTakeoff,
    Transition,
)
from hawk.ddc.readings.home import HomeFacts
from hawk.ddc.rules.judge import fence_ahead, is_sent_unheard, options, place_refusal, refusal, route_refusal
from hawk.ddc.rules.needs import LOT_IS_SEEN, OUTLINE_IS_SEEN, RESUME_WAIT_S, Interlocks, Situation
from hawk.ddc.states.factory import make_state
from hawk.ddc.witnesses.place import PlaceFacts
from hawk.ddc.witnesses.witness import WitnessFacts
from hawk.model.operation import UserError
from hawk.model.plans import ExploreStatus, PathPlan, Route
from hawk.model.poses import MapPoint
from hawk.model.vehicle import CopterMode, LandedState
from tests.unit.ddc.fakes import SAFE_PARAMETERS
from tests.unit.ddc.written_facts import DATUM, SETTINGS, flying, on_ground, pose, without_link

SAFE = dict(SAFE_PARAMETERS)
NO_LOCKS = Interlocks()
HERE, THERE = MapPoint(0.0, 0.0), MapPoint(40.0, 0.0)


def situation(facts: Facts, transition: Transition, locks: Interlocks = NO_LOCKS) -> Situation:
    return Situation(facts, make_state(transition, flying(0.0), SETTINGS)[0], SETTINGS, SAFE, locks)


def reason(facts: Facts, transition: Transition, command: Command, locks: Interlocks = NO_LOCKS) -> str:
    found = refusal(situation(facts, transition, locks), "ana", command)
    return "" if found is None else found.reason


def without_pose(facts: Facts) -> Facts:
    return replace(facts, position=replace(facts.position, age=0.6))


def without_fence(facts: Facts) -> Facts:
    return replace(facts, limits=replace(facts.limits, fence=None))


@pytest.mark.parametrize("change", [without_pose, without_fence])
def test_no_place_is_judged_without_a_position_and_a_fence(change: object) -> None:
    assert callable(change)
    assert place_refusal(flying(1.0), THERE) is None
    found = place_refusal(change(flying(1.0)), THERE)
    assert found is not None
    assert "position is not known" in found.reason
    assert "position is not known" in reason(change(flying(1.0)), ToHover(), CompulsiveMove(x=10, y=0))


def test_a_route_needs_a_fence_two_points_and_every_leg_inside() -> None:
    inside = Route((HERE, THERE), (0.0, 0.0))
    assert route_refusal(flying(1.0), inside) is None
    for facts, route in (
        (without_fence(flying(1.0)), inside),
        (flying(1.0), Route((HERE,), (0.0,))),
        (flying(1.0), Route((HERE, THERE, MapPoint(200.0, 0.0), THERE), (0.0,) * 4)),
        (without_pose(flying(1.0)), inside),
    ):
        assert route_refusal(facts, route) is not None


def test_a_place_outside_the_fence_is_user_error_1() -> None:
    found = place_refusal(flying(1.0), MapPoint(160.0, 0.0))
    assert found is not None
    assert found.error is UserError.DESIRED_LOCATION_OUT_OF_BOUNDS


@pytest.mark.parametrize(("height", "taken"), [(14.9, False), (15.0, True), (60.0, True), (60.1, False), (None, True)])
def test_the_height_of_a_move_lies_between_min_and_max(height: float | None, taken: bool) -> None:
    assert (reason(flying(1.0), ToHover(), CompulsiveMove(x=10, y=0, height=height)) == "") is taken


def test_a_move_from_outside_the_fence_is_refused() -> None:
    facts = flying(1.0)
    breached = replace(facts, limits=replace(facts.limits, breached_s=0.0))
    assert "Outside the fence" in reason(breached, ToHover(), CompulsiveMove(x=10, y=0))


CUTTING = Interlocks(kill_state="sending", killer="ana")


def test_while_the_motors_are_cut_only_kill_and_what_replaces_it_are_taken() -> None:
    sending = situation(flying(1.0), ToExplore(), CUTTING)
    taken = {option.command for option in options(sending) if option.possible}
    assert taken == {"Kill Request", "Kill", "Hold", "Return To Launch", "Land"}


@pytest.mark.parametrize("command", [Hold(), ReturnToLaunch(), Land()])
def test_who_may_not_cut_the_motors_undoes_no_cut(command: Command) -> None:
    cutting, free = (situation(flying(1.0), ToExplore(), locks) for locks in (CUTTING, Interlocks()))
    refused = refusal(cutting, "eve", command)
    assert refused is not None
    assert refused.reason == "Someone else has control."
    assert refusal(cutting, "ana", command) is None
    assert (refusal(free, "eve", command) is None) is isinstance(command, Hold)


@pytest.mark.parametrize("command", [Hold(), ReturnToLaunch(), Land()])
@pytest.mark.parametrize("control", ["lost", "free"])
def test_who_did_not_cut_the_motors_undoes_no_cut_once_who_did_is_lost(command: Command, control: str) -> None:
    facts = flying(1.0)
    gone = (
        replace(facts.operator, is_present=False)
        if control == "lost"
        else replace(facts.operator, is_controlled=False, is_present=False, clients=frozenset())
    )
    facts = replace(facts, operator=gone)
    cutting, free = (situation(facts, ToExplore(), locks) for locks in (CUTTING, Interlocks()))
    refused = refusal(cutting, "eve", command)
    assert refused is not None
    assert refused.reason.lower().endswith("take control first.")
    assert refusal(cutting, "ana", command) is None
    assert refusal(free, "eve", command) is None
    assert refusal(cutting, "eve", KillRequest()) is None


@pytest.mark.parametrize("command", [Hold(), ReturnToLaunch(), Land()])
def test_a_cut_that_the_autopilot_says_is_done_is_not_undone(command: Command) -> None:
    facts = flying(1.0)
    falling = replace(facts, ground=replace(facts.ground, armed_said=False))
    cutting = situation(falling, ToExplore(), CUTTING)
    refused = refusal(cutting, "ana", command)
    assert refused is not None
    assert refused.reason == "The motors are being cut."
    assert {option.command for option in options(cutting) if option.possible} == {"Kill Request", "Kill"}


def test_return_and_land_go_to_an_armed_drone_that_is_not_heard_and_nothing_else_does() -> None:
    unheard = without_link(flying(1.0))
    assert reason(unheard, ToHover(), ReturnToLaunch()) == ""
    assert reason(unheard, ToHover(), Land()) == ""
    assert "No link" in reason(unheard, ToHover(), Hold())
    assert not is_sent_unheard(without_link(on_ground(flying(1.0))), COMMAND_TABLE["Land"])
    assert not is_sent_unheard(flying(1.0), COMMAND_TABLE["Land"])


def manual(changed: float, now: float = 10.0) -> Facts:
    facts = flying(now, CopterMode.LOITER)
    return replace(facts, link=replace(facts.link, mode_changed_at=changed))


def test_what_cannot_be_put_back_keeps_every_task_off() -> None:
    lost = replace(flying(5.0), kept=KeptFacts(lost="its home"))
    words = "Somebody changes the autopilot, and it cannot be put back: its home."
    assert reason(lost, ToHover(), CompulsiveMove(x=5.0, y=0.0)) == words
    assert reason(replace(on_ground(lost)), ToArm(), Takeoff()) != ""
    assert reason(lost, ToHover(), ReturnToLaunch()) == ""


def test_resume_is_refused_for_three_seconds_after_a_change_of_the_mode() -> None:
    sure, facts = Resume(confirmed=True), flying(10.0, CopterMode.LOITER)
    for now, refused in ((12.9, True), (13.0, False), (13.9, False)):
        at_the_switch = replace(facts, now=now, link=replace(facts.link, mode_changed_at=10.0))
        assert reason(at_the_switch, ToManual(), sure).startswith("The mode changed just now") is refused


@pytest.mark.parametrize(
    ("armed", "state", "refused"),
    [
        (True, ToArm(), True),
        (False, ToArm(), False),
        (True, ToHover(), True),
        (False, ToHover(), True),
    ],
)
def test_disarm_needs_the_ground_or_motors_that_are_off_in_a_state_of_the_ground(
    armed: bool, state: Transition, refused: bool
) -> None:
    facts = flying(5.0)
    facts = replace(facts, vehicle=replace(facts.vehicle, armed=armed))
    found = refusal(situation(facts, state), "ana", Disarm())
    assert (found is not None and found.reason.startswith("In the air")) is refused


def test_resume_waits_three_seconds_after_the_pilots_switch_and_needs_confirmation() -> None:
    sure = Resume(confirmed=True)
    assert "changed just now" in reason(manual(10.0 - RESUME_WAIT_S + 0.01), ToManual(), sure)
    assert reason(manual(10.0 - RESUME_WAIT_S), ToManual(), sure) == ""
    for command in (Resume(), ReturnToLaunch(), Land()):
        assert "Confirmed" in reason(manual(0.0), ToManual(), command)
    for command in (ReturnToLaunch(), Land()):
        assert reason(flying(1.0), ToHover(), command) == ""


@pytest.mark.fault(
    "GNSS walks away and takes the estimate with it, all flags good, a pilot takes over, and the camera no "
    "longer follows the drone",
    "Resume is refused: Hover could only land it. Land is accepted",
)
def test_a_drone_that_hover_could_only_land_is_not_taken_from_the_pilot() -> None:
    sure = Resume(confirmed=True)

    def doubted(*, followed: bool) -> Facts:
        place = PlaceFacts(camera_age=0.1, doubted_s=9.0, off=(4.0, 0.0), is_followed=followed)
        return replace(manual(0.0), witness=WitnessFacts(place=place))

    assert reason(doubted(followed=True), ToManual(), sure) == "", "the camera holds it"
    assert reason(doubted(followed=False), ToManual(), sure).endswith("It could not be held: land it, or fly by hand.")
    assert reason(doubted(followed=False), ToManual(), Land(confirmed=True)) == ""


def test_nothing_comes_down_from_the_ground_but_a_take_off_may_be_stopped() -> None:
    standing = replace(flying(1.0), vehicle=replace(flying(1.0).vehicle, landed=LandedState.ON_GROUND))
    for command in (Hold(), ReturnToLaunch(), Land()):
        assert reason(standing, ToHover(), command) == "On the ground."
        assert reason(standing, ToTakeoff(), command) == ""


def test_hold_and_land_are_refused_while_the_autopilot_returns_by_itself() -> None:
    own = ToReturn(Cause("", CauseKind.ALWAYS), by_autopilot=True)
    facts = flying(1.0, CopterMode.RTL)
    assert "by itself" in reason(facts, own, Hold())
    assert "by itself" in reason(facts, own, Land())
    assert reason(facts, ToReturn(), Land()) == ""


def test_take_off_waits_for_home_and_for_the_fence_in_the_autopilot() -> None:
    standing = replace(flying(1.0), vehicle=replace(flying(1.0).vehicle, landed=LandedState.ON_GROUND))
    armed = ToArm(armed=True)
    assert reason(standing, armed, Takeoff()) == ""
    assert "fence" in reason(standing, armed, Takeoff(), Interlocks(fence_problem="Another fence is there."))
    for away, taken in ((3.0, True), (3.1, False)):
        home = HomeFacts(standing.position.datum, 0.1, away, None, is_inside=True)
        moved = replace(standing, position=replace(standing.position, autopilot_home=home))
        assert ("Home is" not in reason(moved, armed, Takeoff())) is taken
    assert "Arming" in reason(standing, ToArm(), Takeoff())


def test_clear_kill_needs_a_kill_and_set_failsafes_waits_for_the_last_one() -> None:
    ground = on_ground(flying(1.0))
    possible = {option.command: option.possible for option in options(situation(ground, ToIdle()))}
    assert not possible["Clear Kill"]
    assert possible["Set Failsafes"]
    busy = situation(ground, ToIdle(), Interlocks(is_killed=True, is_setting=True))
    possible = {option.command: option.possible for option in options(busy)}
    assert possible["Clear Kill"]
    assert not possible["Set Failsafes"]
    assert not possible["Arm"], "the motors were cut"


def test_a_relative_move_starts_from_the_drone() -> None:
    facts = flying(1.0)
    away = replace(facts, position=replace(facts.position, pose=pose(1.0, 120.0, 0.0)))
    assert reason(away, ToHover(), CompulsiveMove(x=40, y=0, frame="Relative")).startswith("X, Y")
    assert reason(away, ToHover(), CompulsiveMove(x=40, y=0, frame="Map")) == ""


@pytest.mark.fault("one picture in two is bad")
@pytest.mark.parametrize("command", [AutonomousExplore(), AutonomousMove(x=20, y=0)])
def test_one_bad_picture_refuses_no_task_and_a_fault_that_lasts_does(command: Command) -> None:
    seen = flying(1.0)
    fault = "Vision: the picture is torn"
    for lasted, refused in ((0.0, ""), (0.99, ""), (1.0, fault), (9.0, fault)):
        torn = replace(seen, sight=replace(seen.sight, fault=fault, fault_s=lasted))
        assert reason(torn, ToHover(), command) == refused


def test_explore_is_refused_where_it_would_look_at_nothing_more() -> None:
    seen = flying(1.0)
    spent = replace(seen, sight=replace(seen.sight, plan=PathPlan(explore=ExploreStatus(True, 1.0, is_spent=True))))
    assert reason(spent, ToHover(), AutonomousExplore()) == LOT_IS_SEEN
    outlined = replace(spent, limits=replace(spent.limits, outline=OutlineFacts(900.0, 0.0)))
    assert reason(outlined, ToHover(), AutonomousExplore()) == OUTLINE_IS_SEEN
    open_ = replace(seen, sight=replace(seen.sight, plan=PathPlan(explore=ExploreStatus(True, 1.0))))
    assert reason(open_, ToHover(), AutonomousExplore()) == ""


def test_explore_needs_a_lot_in_sight_or_an_outline_with_ground_inside() -> None:
    seen = flying(1.0)
    blind = replace(seen, sight=replace(seen.sight, lot=False))
    assert reason(seen, ToHover(), AutonomousExplore()) == ""
    found = refusal(situation(blind, ToHover()), "ana", AutonomousExplore())
    assert found is not None
    assert (found.reason, found.error) == ("No lot in sight: move over the lot first.", UserError.NO_LOT_DETECTED)
    outlined = replace(blind, limits=replace(blind.limits, outline=OutlineFacts(900.0, 0.0)))
    assert reason(outlined, ToHover(), AutonomousExplore()) == ""
    empty = replace(seen, limits=replace(seen.limits, outline=OutlineFacts(0.0, 900.0)))
    assert reason(empty, ToHover(), AutonomousExplore()) != ""
    assert "position" in reason(without_pose(blind), ToHover(), AutonomousExplore()), "the position comes first"


class TestOutline:
    """It is judged by the fence in force, or by the one that Arm here would put in force."""

    def command(self, *corners: tuple[float, float]) -> SetOutline:
        ring = ring_from_map(DATUM, corners)
        return SetOutline(polygons=[[FenceCorner(latitude=north, longitude=east) for north, east in ring]])

    def square(self, north: float, side: float = 40.0) -> SetOutline:
        return self.command((north, 0.0), (north + side, 0.0), (north + side, side), (north, side))

    def test_a_ring_that_cannot_be_used_is_refused_with_what_is_wrong(self) -> None:
        crossed = self.command((0.0, 0.0), (50.0, 50.0), (50.0, 0.0), (0.0, 50.0))
        assert reason(flying(1.0), ToHover(), crossed).startswith("Polygon 1: ")
        assert reason(flying(1.0), ToHover(), self.square(0.0, 2.0)).startswith("Polygon 1: holds 4 m²")

    def test_in_flight_it_lies_at_least_partly_inside_the_fence_in_force(self) -> None:
        outside = "Polygons: nothing of the outline lies inside the fence: draw it inside, or set another fence."
        assert reason(flying(1.0), ToHover(), self.square(120.0)) == ""
        assert reason(flying(1.0), ToHover(), self.square(160.0)) == outside
        assert reason(without_fence(flying(1.0)), ToHover(), self.square(160.0)) == ""

    def test_on_the_ground_the_fence_that_arm_would_put_in_force_counts(self) -> None:
        ground = on_ground(flying(1.0))
        assert reason(ground, ToIdle(), self.square(160.0)) != ""
        assert fence_ahead(ground, SETTINGS) is not None

    @pytest.mark.parametrize(
        "limits",
        [
            {"plan_problem": "The stored fence cannot be read."},
            {"plan": FencePlan("drawn", ring_from_map(DATUM, ((0.0, 0.0), (8.0, 0.0), (8.0, 8.0), (0.0, 8.0))), 100.0)},
        ],
    )
    def test_while_no_fence_can_be_known_it_is_taken(self, limits: dict[str, object]) -> None:
        ground = on_ground(flying(1.0))
        unknown = replace(ground, limits=replace(ground.limits, **limits))  # type: ignore[arg-type]
        assert fence_ahead(unknown, SETTINGS) is None
        assert reason(unknown, ToIdle(), self.square(160.0)) == ""

    def test_without_any_place_no_fence_is_ahead(self) -> None:
        ground = on_ground(flying(1.0))
        nowhere = replace(ground, position=replace(ground.position, pose=None, datum=None))
        assert fence_ahead(nowhere, SETTINGS) is None
        armed = flying(1.0)
        assert fence_ahead(replace(armed, position=replace(armed.position, datum=None)), SETTINGS) is None
