"""Return To Launch in a bent fence: the path inside it, and every reason to have RTL fly straight instead."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import pytest

from hawk.comm.protocol.commands import Arm, Hold, Land, ReturnToLaunch
from hawk.ddc.acts import Acts, Ask, EnterState, Log, SendMode, SendTarget, SetHome, SetMode
from hawk.ddc.battery.battery import RESERVE_CONFIRM_S
from hawk.ddc.battery.energy import LANDING_PERCENT, Reserve
from hawk.ddc.decider import Decider
from hawk.ddc.facts import Answer, Facts
from hawk.ddc.fence import path as fence_path
from hawk.ddc.fence.geometry import contains, outside_by, polygon_fence
from hawk.ddc.motion import PROGRESS_S, Goal
from hawk.ddc.orders import Cause, CauseKind, ToReturn
from hawk.ddc.readings.home import HomeFacts
from hawk.ddc.readings.link import LinkFacts, VehicleEvent
from hawk.ddc.requests.service_interface import Limits, target_refusal
from hawk.ddc.rules.failed_ticks import AIR_S
from hawk.ddc.rules.kill import KillTokens
from hawk.ddc.rules.silence import SILENCE_S
from hawk.ddc.states import path_home, rtl_and_land
from hawk.ddc.states.path_home import RETURNS_ALREADY, PathHome, begin
from hawk.model.operation import StateName as S
from hawk.model.plans import Fence
from hawk.model.poses import GlobalPose, MapPoint
from hawk.model.vehicle import CopterMode
from tests.unit.ddc.fakes import Rig
from tests.unit.ddc.fence.test_plan import U_SHAPE, WEST_ARM, draw, fence
from tests.unit.ddc.written_facts import DATUM, SETTINGS, decider, flying, follow, of_kind, pose

BENT = polygon_fence(U_SHAPE, 5.0, 100.0, 3.0)
"""Home stands between the feet of two arms, at 0, 0."""
AWAY = ((90.0, -58.0), (90.0, -56.0), (92.0, -56.0))
"""A zone at the far end of the west arm: no path comes near it."""
ZONED = polygon_fence(U_SHAPE, 5.0, 100.0, 3.0, [AWAY])
TICK_S = 0.05
TOP_M = 60.0
"""Max: the return height."""
BY_ORDER = ToReturn()
Change = Callable[[Facts], Facts]


def bent(
    now: float, north: float = WEST_ARM.north, east: float = WEST_ARM.east, height: float = TOP_M, percent: float = 80.0
) -> Facts:
    """A drone in the west arm: the straight line home leaves the fence."""
    facts = flying(now)
    return replace(
        facts,
        position=replace(facts.position, pose=pose(now, north, east, height)),
        limits=replace(facts.limits, fence=BENT, held=BENT),
        battery=replace(facts.battery, reserve=Reserve(percent, 40.0, 300.0, 20.0)),
    )


def at_home(facts: Facts) -> Facts:
    return replace(facts, position=replace(facts.position, pose=pose(facts.now, 8.0, -30.0, TOP_M)))


def returning(facts: Facts, order: ToReturn = BY_ORDER) -> Decider:
    """A program whose drone begins to return at these facts."""
    made = decider(facts.now - 1.0)
    made.tick(replace(facts, now=facts.now - 0.5))
    follow(made, facts, order)
    return made


def modes(acts: Acts) -> list[CopterMode]:
    return [act.request.mode for act in acts if isinstance(act, Ask) and isinstance(act.request, SetMode)]


def texts(acts: Acts) -> str:
    return " ".join(act.text for act in acts if isinstance(act, Log))


def gate(acts: Acts) -> list[bool]:
    return [act.may_send_targets for act in acts if isinstance(act, EnterState)]


LED, STRAIGHT = (True, None, False), (False, CopterMode.RTL, True)


def traits(made: Decider) -> tuple[bool, CopterMode | None, bool]:
    """Return whether it may send targets, the mode for a silent autopilot, and whether it is left alone."""
    state = made.state
    return state.may_send_targets, state.autopilot_mode, state.is_left_alone


def flown(made: Decider, now: float, seconds: float, change: Change = lambda facts: facts) -> Acts:
    """Tick for a while with facts in which the drone does not move; return all acts."""
    acts: Acts = ()
    for k in range(round(seconds / TICK_S) + 1):
        acts += made.tick(change(bent(now + k * TICK_S))).acts
    return acts


# -- the path ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.fault("a return in a bent fence: the straight line home leaves it")
def test_it_is_led_by_targets_that_the_gate_takes_until_home_is_in_sight() -> None:
    made, facts = returning(bent(10.0)), bent(10.0)
    acts = made.tick(facts).acts
    assert gate(acts) == [True]
    assert "The straight path home leaves the fence: returning inside it, 98 m." in texts(acts)
    assert modes(acts) == []
    assert traits(made) == LED
    now = 10.0
    north, east = WEST_ARM.north, WEST_ARM.east
    for _ in range(2000):
        now += TICK_S
        facts = bent(now, north, east)
        acts = made.tick(facts).acts
        if modes(acts):
            break
        (target,) = (act.goal for act in acts if isinstance(act, SendTarget))
        here = facts.place
        assert here is not None
        assert not target_refusal(target, here, Limits(BENT, facts.limits.heights, 4.0, holds=False))
        away = max(here.point.distance(MapPoint(target.north, target.east)), 1e-9)
        step = min(1.0, 5.0 * TICK_S / away)
        north, east = north + (target.north - north) * step, east + (target.east - east) * step
        assert contains(BENT, MapPoint(north, east))
    assert modes(acts) == [CopterMode.RTL]
    assert gate(acts) == [False]
    assert "Home is in straight sight." in texts(acts)
    assert traits(made) == STRAIGHT
    assert made.state.route(facts) == ()
    assert north < 20.0, "past the corner"


def test_the_page_shows_the_path_and_what_is_left_of_it() -> None:
    made = returning(bent(10.0), ToReturn(Cause("The operator is lost.", CauseKind.OPERATOR)))
    made.tick(bent(10.0))
    route = made.state.route(bent(10.0))
    assert route[0] == WEST_ARM
    assert route[-1] == MapPoint(0.0, 0.0)
    left = sum(a.distance(b) for a, b in pairwise(route))
    assert made.state.detail(bent(10.0)) == (
        f"Returning home inside the fence, {left:.0f} m to go. The operator is lost."
    )


def test_below_the_return_height_it_climbs_first() -> None:
    made = returning(bent(10.0, height=30.0))
    goals: list[Goal] = []
    for k in range(40):
        acts = made.tick(bent(10.0 + k * TICK_S, height=30.0)).acts
        goals += [act.goal for act in acts if isinstance(act, SendTarget)]
    assert {(goal.north, goal.east) for goal in goals} == {(WEST_ARM.north, WEST_ARM.east)}
    assert goals[-1].height > goals[0].height >= 30.0
    acts = made.tick(bent(12.1, height=TOP_M - 1.0)).acts
    acts += made.tick(bent(12.2, height=TOP_M - 1.0)).acts
    assert any(act.goal.north < WEST_ARM.north for act in acts if isinstance(act, SendTarget))


def test_it_never_climbs_above_our_ceiling() -> None:
    low = replace(BENT, ceiling=40.0)

    def under(facts: Facts) -> Facts:
        return replace(facts, limits=replace(facts.limits, fence=low, held=low))

    made = returning(under(bent(10.0, height=39.0)))
    acts: Acts = ()
    for k in range(100):
        acts += made.tick(under(bent(10.0 + k * TICK_S, height=39.0))).acts
    assert {act.goal.height <= 40.0 for act in acts if isinstance(act, SendTarget)} == {True}


def test_where_home_is_in_sight_rtl_flies_at_once() -> None:
    made = returning(at_home(bent(10.0)))
    acts = made.tick(at_home(bent(10.0))).acts
    assert modes(acts) == [CopterMode.RTL]
    assert "Straight home" not in texts(acts)


def test_a_drone_that_is_about_to_leave_the_sight_of_home_is_led() -> None:
    facts = bent(10.0, 14.0, -35.0)
    assert not path_home.is_beyond_sight(facts)
    moving = replace(pose(10.0, 14.0, -35.0, TOP_M), velocity=(6.0, 0.0, 0.0))  # it comes to rest in the arm
    facts = replace(facts, position=replace(facts.position, pose=moving))
    assert path_home.is_beyond_sight(facts)
    made = returning(facts)
    acts = made.tick(facts).acts
    assert modes(acts) == []
    assert of_kind(acts, SendTarget)


@pytest.mark.parametrize("limit", [BENT, ZONED], ids=["without zones", "with a zone"])
def test_a_path_that_the_wind_drove_it_off_is_planned_again(limit: Fence) -> None:
    def at(now: float, north: float = WEST_ARM.north, east: float = WEST_ARM.east) -> Facts:
        facts = bent(now, north, east)
        return replace(facts, limits=replace(facts.limits, fence=limit, held=limit))

    made = returning(at(10.0))
    made.tick(at(10.0))
    for k in range(40):
        acts = made.tick(at(10.1 + k * TICK_S, 80.0, 40.0)).acts
    assert of_kind(acts, SendTarget)
    assert made.state.route(at(12.1, 80.0, 40.0))[1].east > 0


@pytest.mark.parametrize(("estimate", "frame"), [(80.0, 0.0), (0.0, 80.0), (0.5, 0.0)])
def test_a_jump_of_the_position_gives_another_path(estimate: float, frame: float) -> None:
    made = returning(bent(10.0))
    made.tick(bent(10.0))
    before = made.state.route(bent(10.0))
    moved = bent(10.1, 80.0, 40.0)
    made.tick(replace(moved, position=replace(moved.position, estimate_jump_m=estimate, jump_m=frame)))
    after = made.state.route(bent(10.1, 80.0, 40.0))
    assert before[1].east < 0 < after[1].east


# -- straight instead: at the beginning -----------------------------------------------------------------------------


def path_home_of(*, lands: bool | None = None) -> PathHome:
    begun = begin(bent(10.0), SETTINGS) if lands is None else begin(bent(10.0), SETTINGS, lands=lands)
    assert isinstance(begun, PathHome)
    return begun


def test_only_a_path_that_lands_may_take_over_an_autopilot_that_returns_and_only_before_it_led() -> None:
    for lands, reason in ((None, RETURNS_ALREADY), (False, RETURNS_ALREADY), (True, "")):
        path = path_home_of(lands=lands)
        path.process(rtl(bent(10.1)))
        assert ("" if path.end is None else path.end.reason) == reason
    path = path_home_of(lands=True)
    path.process(bent(10.1))
    path.process(rtl(bent(10.2)))
    assert path.end is not None
    assert path.end.reason == RETURNS_ALREADY, "a pilot, or the autopilot, took it back"


def test_above_home_only_a_path_that_lands_ends_there_while_rtl_would_end_elsewhere() -> None:
    for lands, astray, above in ((True, True, True), (True, False, False), (False, True, False)):
        path, here = path_home_of(lands=lands), bent(10.1, 0.5, 0.5)
        path.process(replace(here, kept=replace(here.kept, astray="a rally point" if astray else "")))
        assert (path.end is not None and path.end.is_above_home) is above


def old(facts: Facts) -> Facts:
    return replace(facts, position=replace(facts.position, age=0.6))


def distrusted(facts: Facts) -> Facts:
    return replace(facts, position=replace(facts.position, distrusted_s=2.0))


def outside(facts: Facts) -> Facts:
    return replace(facts, position=replace(facts.position, pose=pose(facts.now, 80.0, 0.0, TOP_M)))


def breached(facts: Facts) -> Facts:
    return replace(facts, limits=replace(facts.limits, breached_s=0.0))


def home_outside(facts: Facts) -> Facts:
    return replace(facts, position=replace(facts.position, home=MapPoint(60.0, 0.0)))


def rtl(facts: Facts) -> Facts:
    return replace(facts, vehicle=replace(facts.vehicle, custom_mode=int(CopterMode.RTL)))


def charge(percent: float) -> Change:
    reserve = Reserve(percent, 40.0, 0.0, 20.0)
    return lambda facts: replace(facts, battery=replace(facts.battery, reserve=reserve))


def charge_unknown(facts: Facts) -> Facts:
    return replace(facts, battery=replace(facts.battery, info=None, unknown_s=30.0))


def no_reserve(facts: Facts) -> Facts:
    return replace(facts, battery=replace(facts.battery, reserve=None))


@pytest.mark.fault(
    "a return in a bent fence with an old or distrusted position, outside the fence, without a path, with too "
    "little charge",
    "RTL straight at once, with the reason",
)
@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (old, path_home.POSITION_OLD),
        (distrusted, path_home.POSITION_LOST),
        (outside, path_home.OUTSIDE),
        (breached, path_home.OUTSIDE),
        (home_outside, path_home.NO_PATH),
        (charge(20.0 + LANDING_PERCENT - 0.1), path_home.TOO_FAR),
        (charge_unknown, path_home.CHARGE_UNKNOWN),
        (no_reserve, path_home.CHARGE_UNKNOWN),
    ],
)
def test_it_goes_straight_at_once_and_says_why(change: Change, reason: str) -> None:
    facts = change(bent(10.0))
    made = returning(facts)
    acts = made.tick(facts).acts
    assert modes(acts) == [CopterMode.RTL]
    assert not of_kind(acts, SendTarget)
    assert f"Straight home, beyond the fence: {reason}." in texts(acts)
    assert made.state.detail(facts) == f"Returning home. Straight: {reason}."
    assert not made.state.may_send_targets
    later = flown(made, 11.0, 5.0)
    assert not of_kind(later, SendTarget), "it is decided once"


def test_an_autopilot_that_returns_already_is_left_to_it() -> None:
    facts = rtl(bent(10.0))
    made = returning(facts)
    acts = made.tick(facts).acts
    assert modes(acts) == []
    assert not of_kind(acts, SendTarget)
    assert made.state.autopilot_mode is CopterMode.RTL


@pytest.mark.parametrize("percent", [20.0 + LANDING_PERCENT, 40.0])
def test_a_charge_that_lasts_for_the_path_flies_it(percent: float) -> None:
    made = returning(charge(percent)(bent(10.0)))
    assert of_kind(made.tick(charge(percent)(bent(10.0))).acts, SendTarget)


@pytest.mark.parametrize("starts", [2])
def test_the_second_start_in_the_air_goes_straight(starts: int) -> None:
    made = Decider(SETTINGS, KillTokens(), 9.0)
    begun = bent(9.0)
    made.tick(replace(begun, link=replace(begun.link, events=(VehicleEvent.FOUND,))))
    acts = made.tick(replace(bent(9.1), starts_in_air=starts)).acts
    assert made.state.identity is S.RETURN_TO_LAUNCH
    assert modes(acts) == [CopterMode.RTL]
    assert not of_kind(acts, SendTarget)


# -- straight instead: along the path --------------------------------------


def aged(seconds: float) -> Change:
    return lambda facts: replace(facts, position=replace(facts.position, age=seconds))


@pytest.mark.fault(
    "a return along a path inside a bent fence: too little charge, no progress, or GUIDED refused",
    "RTL straight, within 3 s for the charge and 10 s without progress",
)
@pytest.mark.parametrize(
    ("change", "seconds", "reason"),
    [
        (aged(1.1), 0.0, path_home.POSITION_OLD),
        (distrusted, 0.0, path_home.POSITION_LOST),
        (breached, 0.0, path_home.OUTSIDE),
        (home_outside, 0.0, path_home.NO_PATH),
        (charge(20.0), RESERVE_CONFIRM_S, path_home.TOO_FAR),
        (charge_unknown, 0.0, path_home.CHARGE_UNKNOWN),
        (lambda facts: facts, PROGRESS_S, "no progress on the path for 10 s"),
    ],
)
def test_in_flight_it_goes_straight_when_the_path_cannot_be_flown_on(
    change: Change, seconds: float, reason: str
) -> None:
    made = returning(bent(10.0))
    made.tick(bent(10.0))
    assert CopterMode.RTL not in modes(flown(made, 10.05, max(0.0, seconds - 0.2), change)) or seconds == 0.0
    acts = flown(made, 10.05 + max(0.0, seconds - 0.15), 0.4, change)
    if seconds > 0.0:
        assert modes(acts) == [CopterMode.RTL]
        assert f"Straight home, beyond the fence: {reason}" in texts(acts)
    assert not made.state.may_send_targets
    assert made.state.autopilot_mode is CopterMode.RTL
    assert reason in made.state.detail(bent(20.0))


def test_a_pose_that_is_late_for_a_moment_ends_nothing() -> None:
    made = returning(bent(10.0))
    made.tick(bent(10.0))
    acts = flown(made, 10.05, 0.3, aged(0.7))
    assert not of_kind(acts, SendTarget)
    assert modes(acts) == []
    assert of_kind(made.tick(bent(10.5)).acts, SendTarget)


def test_a_dip_of_the_charge_ends_nothing() -> None:
    made = returning(bent(10.0))
    made.tick(bent(10.0))
    assert modes(flown(made, 10.05, RESERVE_CONFIRM_S - 0.5, charge(20.0))) == []
    assert modes(flown(made, 12.6, RESERVE_CONFIRM_S - 0.5)) == []


@pytest.mark.fault("a return along a path inside a bent fence: too little charge, no progress, or GUIDED refused")
def test_guided_that_is_refused_is_not_waited_for() -> None:
    def brakes(facts: Facts) -> Facts:
        return replace(facts, vehicle=replace(facts.vehicle, custom_mode=int(CopterMode.BRAKE)))

    made = returning(brakes(bent(10.0)))
    acts = made.tick(brakes(bent(10.0))).acts
    assert modes(acts) == [CopterMode.GUIDED]
    (ask,) = (act for act in acts if isinstance(act, Ask) and isinstance(act.request, SetMode))
    refused = replace(brakes(bent(10.3)), answers=(Answer(ask.name, ask.at, "failed", "Not now."),))
    acts = made.tick(refused).acts
    acts += made.tick(replace(refused, now=10.35)).acts
    assert modes(acts) == [CopterMode.RTL]
    assert "Straight home, beyond the fence: GUIDED was refused: Not now." in texts(acts)


@pytest.mark.fault(
    "a return along a path inside a bent fence: a step of it raises, or the program ends",
    "RTL straight",
)
def test_a_fault_in_the_path_leads_straight_home(monkeypatch: pytest.MonkeyPatch) -> None:
    made = returning(bent(10.0))
    made.tick(bent(10.0))

    def boom(*_: object) -> None:
        raise RuntimeError("boom")

    monkeypatch.setattr(path_home.PathHome, "_lead", boom)
    failed = made.tick(bent(10.05))
    assert not failed.is_sound
    assert modes(made.tick(bent(10.1)).acts) == [CopterMode.RTL]


def test_a_fault_in_the_planning_leads_straight_home(monkeypatch: pytest.MonkeyPatch) -> None:
    def boom(*_: object) -> None:
        raise RuntimeError("boom")

    monkeypatch.setattr(rtl_and_land, "begin", boom)
    made = returning(bent(10.0))
    assert not made.tick(bent(10.0)).is_sound
    assert modes(made.tick(bent(10.05)).acts) == [CopterMode.RTL]


# -- somebody else, silence, the end of the program --------------------------------------------------------------------


def foreign(mode: CopterMode) -> Change:
    def change(facts: Facts) -> Facts:
        link = replace(facts.link, events=(VehicleEvent.FOREIGN_MODE,))
        return replace(facts, link=link, vehicle=replace(facts.vehicle, custom_mode=int(mode)))

    return change


@pytest.mark.slow
@pytest.mark.fault(
    "a return along a path inside a bent fence: a pilot or a failsafe of the autopilot changes the mode",
    "nothing is asked for, no target is sent",
)
@pytest.mark.parametrize(
    ("mode", "state"),
    [(CopterMode.LOITER, S.MANUAL), (CopterMode.RTL, S.RETURN_TO_LAUNCH), (CopterMode.LAND, S.LAND)],
)
def test_another_mode_is_not_countermanded(mode: CopterMode, state: S) -> None:
    made = returning(bent(10.0))
    made.tick(bent(10.0))
    acts = made.tick(foreign(mode)(bent(10.05))).acts
    assert made.state.identity is state
    assert made.state.autopilot_mode is None, "nothing of ours is sent to a silent autopilot either"

    def stays(facts: Facts) -> Facts:
        return replace(facts, vehicle=replace(facts.vehicle, custom_mode=int(mode)))

    acts += flown(made, 10.1, 12.0, stays)
    assert modes(acts) == []
    assert not of_kind(acts, SendTarget)


@pytest.mark.fault("a return along a path inside a bent fence: the autopilot is not heard", "RTL is sent after 3 s")
def test_a_silent_autopilot_is_sent_rtl_after_three_seconds() -> None:
    made = returning(bent(10.0))
    made.tick(bent(10.0))
    sent: list[tuple[float, CopterMode]] = []
    for k in range(120):
        age = k * TICK_S
        facts = replace(bent(10.0 + age), link=LinkFacts(is_up=age < 2.6, age=age))
        acts = made.tick(facts).acts
        assert age < 2.6 or not of_kind(acts, SendTarget)
        sent += [(age, a.request.mode) for a in acts if isinstance(a, Ask) and isinstance(a.request, SendMode)]
    assert sent[0][0] == pytest.approx(SILENCE_S, abs=0.06)
    assert {mode for _, mode in sent} == {CopterMode.RTL}
    assert traits(made) == STRAIGHT


def test_heard_again_before_that_it_goes_on_from_where_it_is() -> None:
    made = returning(bent(10.0))
    made.tick(bent(10.0))
    made.tick(replace(bent(12.7), link=LinkFacts(is_up=False, age=2.7, events=(VehicleEvent.LINK_LOST,))))
    back = bent(12.9, 60.0, -40.0)
    acts = made.tick(replace(back, link=replace(back.link, events=(VehicleEvent.LINK_BACK,)))).acts
    assert of_kind(acts, SendTarget)
    assert made.state.route(back)[0] == MapPoint(60.0, -40.0)


def test_heard_again_in_rtl_it_stays_in_rtl() -> None:
    made = returning(bent(10.0))
    made.tick(bent(10.0))
    back = rtl(bent(12.9))
    acts = made.tick(replace(back, link=replace(back.link, events=(VehicleEvent.LINK_BACK,)))).acts
    assert not of_kind(acts, SendTarget)
    assert CopterMode.GUIDED not in modes(acts)
    assert made.state.identity is S.RETURN_TO_LAUNCH


@pytest.mark.fault("a return along a path inside a bent fence: a step of it raises, or the program ends")
def test_the_end_of_the_program_has_rtl_fly_straight() -> None:
    made = returning(bent(10.0))
    made.tick(bent(10.0))
    decision = made.leave_air(bent(10.05), Cause("The program ends.", CauseKind.ALWAYS))
    assert decision is not None
    assert made.state.autopilot_mode is CopterMode.RTL
    assert gate(decision.acts) == [False]
    acts = made.tick(bent(10.1)).acts
    assert modes(acts) == [CopterMode.RTL]
    assert "Straight home, beyond the fence: the program cannot lead it." in texts(acts)


@pytest.mark.parametrize(("command", "state"), [(Hold(), S.HOVER), (Land(), S.LAND)])
def test_the_operator_holds_and_lands_it(command: Hold | Land, state: S) -> None:
    made = returning(bent(10.0))
    made.tick(bent(10.0))
    made.command(bent(10.05), "ana", command)
    assert made.state.identity is state


def test_the_reserve_refuses_hold_as_before() -> None:
    made = returning(bent(10.0), ToReturn(Cause("The battery is needed for the flight home.", CauseKind.RESERVE)))
    made.tick(bent(10.0))
    reached = charge(39.0)(bent(10.05))
    answer = made.command(reached, "ana", Hold()).answer
    assert answer is not None
    assert "Not while this lasts" in str(answer)
    assert of_kind(made.tick(reached).acts, SendTarget)


def test_a_moved_home_is_set_back_while_the_path_leads_to_the_arm_place() -> None:
    there = GlobalPose(DATUM.latitude + 0.003, DATUM.longitude, 100.0)

    def moved(facts: Facts) -> Facts:
        home = HomeFacts(there, 0.1, 330.0, 1.0, is_inside=False)
        return replace(facts, position=replace(facts.position, autopilot_home=home))

    made = returning(moved(bent(10.0)))
    acts = flown(made, 10.0, 1.0, moved)
    assert any(isinstance(act.request, SetHome) for act in acts if isinstance(act, Ask))
    assert modes(acts) == []
    assert of_kind(acts, SendTarget)
    assert made.state.route(bent(10.0))[-1] == MapPoint(0.0, 0.0)


# -- the whole manager -----------------------------------------------------------------------------------------------


@pytest.fixture
async def led(rig: Rig) -> Rig:
    """A drone that returns from the west arm by targets."""
    await draw(rig, fence(U_SHAPE))
    rig.order(Arm())
    await rig.until(S.ARM)
    await rig.run(0.5)
    rig.autopilot.put_in_air()
    rig.autopilot.north, rig.autopilot.east = WEST_ARM.north, WEST_ARM.east
    await rig.run(0.5)
    rig.order(ReturnToLaunch())
    await rig.run(1.0)
    assert rig.autopilot.mode == CopterMode.GUIDED
    assert rig.detail.startswith("Returning home inside the fence, ")
    return rig


@pytest.mark.nightly
async def test_a_return_from_the_arm_of_a_bent_fence_stays_inside_and_lands_at_home(led: Rig) -> None:
    rig, before = led, led.autopilot.asked("set_mode")
    assert len(rig.shown.travel.route) == 3
    limit = rig.fence
    assert limit is not None
    worst = 0.0
    for _ in range(4000):
        await rig.tick()
        worst = max(worst, outside_by(limit, MapPoint(rig.autopilot.north, rig.autopilot.east)))
        if rig.state is S.IDLE:
            break
    rig.expect(S.IDLE)
    assert worst == 0.0
    assert abs(rig.autopilot.north) + abs(rig.autopilot.east) < 2.0
    assert rig.autopilot.asked("set_mode") == [*before, CopterMode.RTL]
    assert "Home is in straight sight." in rig.log


@pytest.mark.nightly
async def test_the_end_of_the_program_asks_for_rtl_before_it_ends(led: Rig) -> None:
    assert await led.manager.shutdown_in_air()
    assert led.autopilot.mode == CopterMode.RTL
    assert led.log[-1] == "The program ends. Returning home."


@pytest.mark.nightly
async def test_failed_ticks_on_the_path_ask_for_rtl(led: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    def boom(*_: object) -> None:
        raise RuntimeError("boom")

    monkeypatch.setattr(led.manager._performer, "_perform", boom)
    await led.run(AIR_S + 0.2)
    assert led.autopilot.mode == CopterMode.RTL
    assert led.manager.state.autopilot_mode == CopterMode.RTL


async def test_the_check_and_the_editor_say_what_flies_straight(rig: Rig) -> None:
    await draw(rig, fence(U_SHAPE))
    await rig.run(0.5)
    (found,) = (check.value for check in rig.shown.operation.checks if check.name == "Return height")
    assert found.endswith(
        "our returns stay inside the fence, the autopilot's own failsafes fly straight and leave it from parts"
    )


async def test_paths_are_prepared_off_the_loop_when_the_fence_comes_into_force(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[tuple[str, str]] = []
    done = threading.Event()

    def note(_: Fence) -> None:
        made.append(("paths", threading.current_thread().name))
        done.set()

    monkeypatch.setattr(fence_path, "prepare", note)
    rig.order(Arm())
    await rig.until(S.ARM)
    await rig.run(0.5)
    assert done.wait(5.0)
    assert {name.startswith("hawk-parameters") for _, name in made} == {True}


@pytest.mark.fault(
    "the reserve counts the straight line where the path is longer",
    "it counts the path, so that the drone turns home in time",
)
async def test_the_reserve_counts_the_path_where_it_is_longer(rig: Rig) -> None:
    await draw(rig, fence(U_SHAPE))
    rig.order(Arm())
    await rig.until(S.ARM)
    await rig.run(0.5)
    rig.autopilot.put_in_air()
    rig.autopilot.north, rig.autopilot.east = WEST_ARM.north, WEST_ARM.east
    await rig.run(1.5)
    bent_path = rig.manager.situation().facts.battery.reserve
    assert bent_path is not None
    fences = rig.topics.fence_pub
    assert fences.value is not None
    fences.publish(replace(fences.value, polygon=((-90.0, -90.0), (-90.0, 90.0), (110.0, 90.0), (110.0, -90.0))))
    await rig.run(1.5)
    straight = rig.manager.situation().facts.battery.reserve
    assert straight is not None
    assert bent_path.needed > straight.needed + 0.1
