"""Found, lost and found again; started in the air; ended in the air."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.comm.protocol.commands import CompulsiveMove, Hold, Land, ReturnToLaunch
from hawk.ddc.rules.follower import (
    FLIGHT_KEPT_S,
    RESTART_WINDOW_S,
    RestartRule,
    flight_goes_on,
    restart_rule,
    starts_before,
)
from hawk.model.moment import Moment
from hawk.model.operation import FlightSoFar, StateName
from hawk.model.vehicle import CopterMode, LandedState
from tests.sweep import sweep
from tests.unit.ddc.fakes import PLACE, SAFE_PARAMETERS, START, UTC_START, Rig

S = StateName
NOW = Moment("boot", 500.0, UTC_START)
"""The rig's first moment."""


@pytest.fixture
async def make(tmp_path: Path) -> Callable[..., Rig]:
    def build(
        starts: int = 1,
        *,
        height: float = 30.0,
        mode: int = CopterMode.GUIDED,
        survey: bool = False,
        flight: FlightSoFar | None = None,
    ) -> Rig:
        rig = Rig(tmp_path, starts=starts, continues_survey=survey, flight=flight)
        rig.autopilot.put_in_air(height, mode)
        rig.autopilot.held_fence = rig.manager.fences.build(PLACE, PLACE)  # the earlier run uploaded it
        rig.desk.present = False
        return rig

    return build


def commanded(rig: Rig) -> list[tuple[str, object]]:
    """Return the calls beside those that only look: at parameters and fence."""
    return [call for call in rig.autopilot.calls if call[0] not in ("get_parameter", "compare_fence")]


@pytest.mark.parametrize(
    ("starts", "rule"),
    [(1, RestartRule.ADOPT), (2, RestartRule.RETURN_HOME), (3, RestartRule.STAY_AWAY), (9, RestartRule.STAY_AWAY)],
)
def test_the_rule(starts: int, rule: RestartRule) -> None:
    assert restart_rule(starts) is rule


MODES = [
    (CopterMode.GUIDED, S.COMMUNICATION_LOST),
    (CopterMode.BRAKE, S.COMMUNICATION_LOST),
    (CopterMode.RTL, S.RETURN_TO_LAUNCH),
    (CopterMode.SMART_RTL, S.RETURN_TO_LAUNCH),
    (CopterMode.LAND, S.LAND),
    (CopterMode.LOITER, S.MANUAL),
    (CopterMode.STABILIZE, S.MANUAL),
]


@pytest.mark.nightly
@sweep(("mode", "state"), MODES)
async def test_the_first_start_takes_its_state_from_the_mapping_and_sends_nothing(
    make: Callable[..., Rig], mode: int, state: StateName
) -> None:
    rig = make(mode=mode)
    await rig.run(3.0)
    rig.expect(state)
    assert commanded(rig) == []
    assert rig.autopilot.targets == []
    assert "The program started while the drone was in the air." in rig.log


@pytest.mark.slow
@sweep(("mode", "state"), MODES)
@sweep("starts", [2, 3])
async def test_the_second_start_returns_home_before_anything_else(
    make: Callable[..., Rig], starts: int, mode: int, state: StateName
) -> None:
    rig = make(starts, mode=mode)
    await rig.tick(3)
    alone = state in (S.RETURN_TO_LAUNCH, S.LAND, S.MANUAL)
    rig.expect(state if alone else S.RETURN_TO_LAUNCH)
    assert commanded(rig) == ([] if alone else [("set_mode", CopterMode.RTL)])


@pytest.mark.slow
async def test_it_never_arms_or_disarms(make: Callable[..., Rig]) -> None:
    rig = make()
    await rig.run(10)
    assert rig.autopilot.count("arm") == rig.autopilot.count("disarm") == 0


async def test_it_acts_within_three_seconds_without_a_landed_state(make: Callable[..., Rig]) -> None:
    rig = make()
    rig.autopilot.landed = LandedState.UNDEFINED
    await rig.run(1.0)
    rig.expect(S.IDLE)
    await rig.run(1.0)
    rig.expect(S.COMMUNICATION_LOST)


@pytest.mark.nightly
async def test_without_an_operator_it_returns_after_its_hold(make: Callable[..., Rig]) -> None:
    rig = make()
    await rig.run(30.5)
    rig.expect(S.RETURN_TO_LAUNCH)


async def test_the_operator_is_offered_to_continue_the_survey(make: Callable[..., Rig]) -> None:
    rig = make(survey=True)
    await rig.run(1)
    rig.desk.present = True
    await rig.tick()
    rig.expect(S.HOVER)
    assert rig.log[-1] == "Explore continues the survey."
    offered = {option.command: option.possible for option in rig.manager.options()}
    assert offered["Autonomous Explore"]


async def test_the_fence_of_the_arm_place_is_in_force_again(make: Callable[..., Rig]) -> None:
    rig = make()
    await rig.run(1)
    assert rig.fence is not None
    assert rig.topics.home_pub.value is not None
    rig.desk.present = True
    await rig.tick()
    rig.order(CompulsiveMove(x=20, y=0))
    await rig.until(S.HOVER)
    assert rig.autopilot.north == pytest.approx(20, abs=2)


# -- flight time and distance -----------------------------------------------------------------------------------------


def reported(rig: Rig) -> tuple[float, float]:
    status = rig.manager.status.value
    assert status is not None
    assert status.travel.flight_time is not None
    assert status.travel.distance_flown is not None
    return status.travel.flight_time, status.travel.distance_flown


@pytest.mark.slow
async def test_flight_time_and_distance_go_on(make: Callable[..., Rig]) -> None:
    rig = make(flight=FlightSoFar(300.0, 812.5, NOW.before(2.0)))
    await rig.run(5)
    seconds, path = reported(rig)
    assert seconds == pytest.approx(307, abs=0.3)
    assert path == pytest.approx(812.5, abs=1)
    rig.desk.present = True
    await rig.tick()
    rig.order(CompulsiveMove(x=20, y=0))
    await rig.until(S.HOVER)
    assert reported(rig)[1] == pytest.approx(832.5, abs=3)


@pytest.mark.nightly
async def test_a_parameter_that_was_changed_while_the_program_was_away_is_put_back(tmp_path: Path) -> None:
    first = Rig(tmp_path)
    await first.enter(S.HOVER)
    await first.run(10)
    kept = first.kept_flights[-1]
    assert kept is not None
    await first.close()
    right = kept.parameters["BATT_FS_LOW_ACT"]
    flight = replace(kept, moment=NOW.before(2.0))
    rig = Rig(tmp_path, parameters={**SAFE_PARAMETERS, "BATT_FS_LOW_ACT": 5.0}, flight=flight)
    rig.autopilot.put_in_air(30.0, CopterMode.GUIDED)
    rig.autopilot.held_fence = rig.manager.fences.build(PLACE, PLACE)
    await rig.run(20)
    assert ("set_parameter", ("BATT_FS_LOW_ACT", right)) in rig.autopilot.calls
    assert rig.autopilot.values["BATT_FS_LOW_ACT"] == right
    await rig.close()


@pytest.mark.parametrize("kept", [None, FlightSoFar(300.0, 812.5, NOW.before(10 * 60))])
async def test_a_flight_of_long_ago_is_another_one(make: Callable[..., Rig], kept: FlightSoFar | None) -> None:
    rig = make(flight=kept)
    await rig.run(5)
    seconds, path = reported(rig)
    assert seconds <= 5
    assert path < 1


@pytest.mark.nightly
async def test_a_flight_that_begins_from_the_ground_begins_at_zero(tmp_path: Path) -> None:
    rig = Rig(tmp_path, flight=FlightSoFar(300.0, 812.5, NOW.before(2.0)))
    await rig.enter(S.TAKEOFF)
    await rig.until(S.HOVER)
    seconds, path = reported(rig)
    await rig.close()
    assert seconds < 60
    assert path < 5


@pytest.mark.nightly
async def test_the_flight_is_kept_twice_a_second_and_ends_on_the_ground(fresh: Rig) -> None:
    await fresh.enter(S.HOVER)
    fresh.kept_flights.clear()
    await fresh.run(10)
    kept = [flight for flight in fresh.kept_flights if flight is not None]
    assert len(kept) == len(fresh.kept_flights)
    assert 17 <= len(kept) <= 21
    seconds, path = reported(fresh)
    assert (kept[-1].seconds, kept[-1].distance_m) == pytest.approx((seconds, path), abs=0.6)
    assert kept[-1].moment.since(NOW) == pytest.approx(fresh.clock() - START, abs=0.6)
    fresh.order(Land())
    await fresh.until(S.IDLE)
    assert fresh.kept_flights[-1] is None
    ended = len(fresh.kept_flights)
    await fresh.run(2)
    assert len(fresh.kept_flights) == ended


async def test_before_the_autopilot_is_found_nothing_overwrites_what_was_kept(make: Callable[..., Rig]) -> None:
    rig = make(flight=FlightSoFar(300.0, 812.5, NOW))
    rig.autopilot.landed = LandedState.UNDEFINED
    await rig.run(5)
    assert rig.kept_flights
    assert all(flight is not None and flight.seconds >= 300 for flight in rig.kept_flights)


FLOWN = FlightSoFar(300.0, 812.5, NOW)
MONTH = 30 * 86400.0


@pytest.mark.fault("the wall clock steps by 31 minutes or 3 days in the air, forward or back")
@pytest.mark.parametrize("step", [0.0, 31 * 60.0, -31 * 60.0, 3 * 86400.0, -MONTH])
def test_a_step_of_the_wall_clock_changes_nothing_within_a_boot(step: float) -> None:
    def later(seconds: float) -> Moment:
        return replace(NOW.before(-seconds), utc=NOW.utc + step)

    assert flight_goes_on(FLOWN, later(3.0), 2.0) == (306.0, 812.5)
    assert flight_goes_on(FLOWN, later(FLIGHT_KEPT_S), 1.0) == (300.0 + FLIGHT_KEPT_S, 812.5)
    assert flight_goes_on(FLOWN, later(FLIGHT_KEPT_S + 0.1), 1.0) is None
    starts = [later(-RESTART_WINDOW_S), later(-RESTART_WINDOW_S + 0.1), later(-1.0)]
    assert starts_before(starts, FLOWN, NOW) == 2


@pytest.mark.parametrize(
    ("up", "wall", "seconds"),
    [(20.0, 45.0, 345.0), (20.0, 5.0, 320.0), (20.0, -MONTH, 320.0), (20.0, MONTH, 420.0), (121.0, 45.0, None)],
    ids=["wall clock says", "not before the boot", "wall clock set back", "wall clock far ahead", "booted long ago"],
)
def test_a_flight_goes_on_when_the_computer_booted_a_moment_ago(up: float, wall: float, seconds: float | None) -> None:
    found = flight_goes_on(FLOWN, Moment("next", up, NOW.utc + wall), 1.0)
    assert found == (None if seconds is None else (seconds, 812.5))


def test_a_moment_of_an_unknown_boot_is_never_one_of_this_boot() -> None:
    unknown = replace(NOW, boot_id="")
    assert unknown.since(unknown) is None
    assert flight_goes_on(replace(FLOWN, moment=unknown), NOW, 1.0) is None


@pytest.mark.parametrize(
    ("flight", "up", "count"),
    [(FLOWN, 30.0, 2), (FLOWN, 59.0, 0), (FLOWN, 49.9, 1), (None, 30.0, 0), (replace(FLOWN, moment=Moment()), 5.0, 0)],
    ids=["booted in the air", "long down", "one is too old", "it had landed", "nobody knows"],
)
def test_starts_before_a_boot_in_the_air_count_by_the_end_of_that_boot(
    flight: FlightSoFar | None, up: float, count: int
) -> None:
    starts = [NOW.before(29.0), NOW.before(10.0), NOW.before(61.0)]
    assert starts_before(starts, flight, Moment("next", up, NOW.utc)) == count


def test_a_start_after_the_last_word_on_the_flight_is_as_old_as_the_boot_at_least() -> None:
    assert starts_before([NOW.before(-5.0)], FLOWN, Moment("next", 59.9, NOW.utc)) == 1
    assert starts_before([NOW.before(-5.0)], FLOWN, Moment("next", 60.0, NOW.utc)) == 0


async def test_a_start_beside_a_pilot_who_is_armed_on_the_ground_is_no_start_in_the_air(tmp_path: Path) -> None:
    rig = Rig(tmp_path, starts=2, flight=FlightSoFar(300.0, 812.5, NOW))
    rig.autopilot.armed, rig.autopilot.mode = True, int(CopterMode.LOITER)
    await rig.run(2)
    rig.expect(S.MANUAL)
    assert not any(kind == "start in the air" for kind, _ in rig.records)
    assert "The program started while the drone was in the air." not in rig.log
    await rig.close()


async def test_a_start_on_the_ground_is_idle_and_not_counted(rig: Rig) -> None:
    rig.expect(S.IDLE)
    assert not any(kind == "start in the air" for kind, _ in rig.records)


# -- a lost link ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("state", "after"),
    [
        (S.AUTONOMOUS_EXPLORE, S.RETURN_TO_LAUNCH),
        (S.COMPULSIVE_MOVE, S.RETURN_TO_LAUNCH),
        (S.HOVER, S.RETURN_TO_LAUNCH),
        (S.RETURN_TO_LAUNCH, S.RETURN_TO_LAUNCH),
        (S.LAND, S.LAND),
        (S.COMMUNICATION_LOST, S.RETURN_TO_LAUNCH),
        (S.MANUAL, S.MANUAL),
    ],
)
async def test_without_a_link_nothing_is_asked_and_no_task_resumes(
    fresh: Rig, state: StateName, after: StateName
) -> None:
    await fresh.enter(state)
    fresh.autopilot.stuck = True
    fresh.autopilot.connected = False
    await fresh.tick()
    sent, asked = len(fresh.autopilot.targets), len(fresh.autopilot.calls)
    await fresh.run(5)
    assert len(fresh.autopilot.targets) == sent
    assert {name for name, _ in fresh.autopilot.calls[asked:]} <= {"send_mode", "set_voice"}
    assert "No word from the autopilot." in fresh.log
    fresh.autopilot.connected = True
    await fresh.run(0.5)
    fresh.expect(after)


async def test_after_a_lost_link_what_the_autopilot_did_is_taken_up(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.autopilot.connected = False
    await fresh.run(5)
    fresh.autopilot.change_mode(CopterMode.LAND)
    fresh.autopilot.connected = True
    await fresh.tick()
    fresh.expect(S.LAND)
    who = "Another station asked for it, or the autopilot itself began it."
    assert fresh.command(Hold()).reason == f"Not while this lasts: {who}"


@pytest.mark.slow
async def test_a_return_that_was_asked_for_is_asked_for_again_after_a_lost_link(flying: Rig) -> None:
    flying.autopilot.battery = 21.0
    await flying.run(2.9)
    flying.autopilot.refuse["set_mode"] = "no answer"
    await flying.run(0.5)
    flying.expect(S.RETURN_TO_LAUNCH)
    flying.autopilot.connected = False
    await flying.run(5)
    flying.autopilot.refuse.clear()
    flying.autopilot.connected = True
    await flying.run(2.5)
    flying.expect(S.RETURN_TO_LAUNCH)
    assert flying.autopilot.mode == CopterMode.RTL


async def test_landed_while_the_link_was_lost(fresh: Rig) -> None:
    await fresh.enter(S.HOVER)
    fresh.autopilot.connected = False
    await fresh.run(5)
    fresh.autopilot.armed, fresh.autopilot.landed, fresh.autopilot.height = False, LandedState.ON_GROUND, 0.0
    await fresh.tick()
    fresh.autopilot.connected = True
    await fresh.tick()
    fresh.expect(S.IDLE)


# -- modes that we did not ask for -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mode", "state"),
    [(CopterMode.BRAKE, S.HOVER), (CopterMode.RTL, S.RETURN_TO_LAUNCH), (CopterMode.POSHOLD, S.MANUAL)],
)
async def test_a_mode_change_that_we_did_not_ask_for(fresh: Rig, mode: int, state: StateName) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.autopilot.change_mode(mode)
    calls, sent = len(fresh.autopilot.calls), len(fresh.autopilot.targets)
    await fresh.run(2.0)
    fresh.expect(state)
    assert len(fresh.autopilot.calls) == calls
    assert len(fresh.autopilot.targets) == sent


async def test_the_window_of_our_own_request_is_two_seconds(flying: Rig) -> None:
    flying.autopilot.refuse["set_mode"] = "busy"
    flying.ask(flying.service.set_mode(CopterMode.BRAKE))
    await flying.run(1.8)
    flying.autopilot.change_mode(CopterMode.BRAKE)
    former = flying.manager.state
    await flying.tick()
    assert flying.manager.state is former
    flying.ask(flying.service.set_mode(CopterMode.LAND))
    await flying.run(2.2)
    flying.autopilot.change_mode(CopterMode.LAND)
    await flying.tick()
    flying.expect(S.LAND)


async def test_taken_off_by_somebody_else(fresh: Rig) -> None:
    await fresh.enter(S.ARM)
    fresh.autopilot.landed, fresh.autopilot.height = LandedState.IN_AIR, 3.0
    await fresh.tick()
    fresh.expect(S.HOVER)
    assert fresh.log[-1] == "Somebody else took off. Holding."
    assert fresh.autopilot.targets == []


# -- the end of the program -------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("state", [S.HOVER, S.AUTONOMOUS_EXPLORE, S.COMPULSIVE_MOVE, S.COMMUNICATION_LOST])
async def test_ended_in_the_air_it_returns_home(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    assert await fresh.manager.shutdown_in_air()
    assert fresh.autopilot.mode == CopterMode.RTL


@pytest.mark.parametrize("state", [S.MANUAL, S.RETURN_TO_LAUNCH, S.LAND, S.IDLE, S.ARM])
async def test_ended_elsewhere_it_leaves_the_drone_alone(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    calls = list(fresh.autopilot.calls)
    assert not await fresh.manager.shutdown_in_air()
    assert fresh.autopilot.calls == calls


async def test_a_refused_return_does_not_keep_the_program_from_ending(flying: Rig) -> None:
    flying.autopilot.refuse["set_mode"] = "no"
    assert await flying.manager.shutdown_in_air()


@pytest.mark.parametrize(("state", "mode"), [(S.RETURN_TO_LAUNCH, CopterMode.RTL), (S.LAND, CopterMode.LAND)])
async def test_our_own_descent_is_asked_for_again_when_the_mode_is_another_after_a_lost_link(
    fresh: Rig, state: StateName, mode: CopterMode
) -> None:
    await fresh.enter(state)
    await fresh.run(1)
    fresh.autopilot.connected = False
    await fresh.run(4)
    fresh.autopilot.change_mode(CopterMode.GUIDED)
    fresh.autopilot.calls.clear()
    fresh.autopilot.connected = True
    await fresh.run(1)
    fresh.expect(state)
    assert fresh.autopilot.asked("set_mode") == [mode]
    assert fresh.autopilot.mode == mode


def _held(rig: Rig) -> object:
    """Return the held fence of the last tick, as it was recorded; whole facts are recorded now and then only."""
    facts = [payload["facts"] for kind, payload in rig.records if kind == "tick"]
    return next(each["limits"] for each in reversed(facts) if "limits" in each).held


@pytest.mark.parametrize("fails", [False, True], ids=["", "while every tick fails"])
async def test_the_fence_that_was_held_before_a_lost_link_is_not_believed_after_it(
    flying: Rig, monkeypatch: pytest.MonkeyPatch, fails: bool
) -> None:
    await flying.run(1.0)
    assert _held(flying) == flying.fence
    with monkeypatch.context() as broken:
        if fails:
            broken.setattr(flying.topics, "get_part_healths", lambda: 1 / 0)
        flying.autopilot.connected = False
        await flying.tick(4)
        flying.autopilot.held_fence = None  # another station cleared it
        flying.autopilot.connected = True
        if fails:
            await flying.tick()
    await flying.tick()
    assert _held(flying) is None, "no tick decides by a fence that is forgotten after it"
    assert flying.service.held_fence is None
    await flying.run(5.0)
    assert flying.autopilot.held_fence == flying.fence, "it was compared, and put back"
    assert _held(flying) == flying.fence


async def test_a_mode_of_an_overtaken_request_that_shows_late_is_not_taken_for_ours(flying: Rig) -> None:
    flying.order(ReturnToLaunch())
    await flying.tick(3)
    flying.order(Land())
    await flying.tick(3)
    flying.expect(S.LAND)
    assert flying.autopilot.mode == CopterMode.LAND
    flying.autopilot.change_mode(CopterMode.RTL)  # the request was repeated on the wire
    await flying.tick(2)
    flying.expect(S.RETURN_TO_LAUNCH)
    who = "Another station asked for it, or the autopilot itself began it."
    assert f"Returning home. {who}" in flying.log


async def test_a_mode_that_shows_after_the_next_was_asked_for_is_still_ours(flying: Rig) -> None:
    flying.autopilot.silent.add("set_mode")
    flying.order(ReturnToLaunch())
    await flying.tick()
    flying.order(Land())
    await flying.tick()
    flying.autopilot.change_mode(CopterMode.RTL)
    await flying.tick()
    flying.expect(S.LAND)
    flying.autopilot.change_mode(CopterMode.LAND)
    await flying.tick()
    flying.expect(S.LAND)
