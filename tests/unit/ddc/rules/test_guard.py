"""Automatic reactions and their one order of rank, each flown from one state: the table of states and events
(`test_decider_state_table`) has them from every one."""

from __future__ import annotations

from pathlib import Path

import pytest

from hawk.comm.protocol.commands import Arm, CompulsiveMove, Hold
from hawk.config.sections import FenceSettings, FlightSettings, HeightSettings, OperatorSettings
from hawk.ddc.orders import Rank
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import Health, StateName
from hawk.model.vehicle import CopterMode
from tests.unit.ddc.fakes import Rig

S = StateName
TASKS = [S.AUTONOMOUS_EXPLORE, S.AUTONOMOUS_MOVE, S.COMPULSIVE_MOVE]


def test_the_order_of_rank() -> None:
    assert sorted(Rank, reverse=True) == [
        Rank.KILL,
        Rank.PILOT,
        Rank.AUTOPILOT,
        Rank.LAND,
        Rank.RETURN_TO_LAUNCH,
        Rank.COMMUNICATION_LOST,
        Rank.FENCE,
        Rank.PERCEPTION,
        Rank.TASK,
    ]


# -- battery ----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
async def test_the_battery_reserve_brings_it_home(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.autopilot.battery = 25.0
    await fresh.run(2.8)
    fresh.expect(S.AUTONOMOUS_EXPLORE)
    await fresh.run(0.5)
    fresh.expect(S.RETURN_TO_LAUNCH)
    assert "The battery is needed for the flight home. Returning home." in fresh.log


async def test_the_battery_reserve_acts_in_takeoff(fresh: Rig) -> None:
    await fresh.enter(S.TAKEOFF)
    fresh.autopilot.battery = 22.0
    await fresh.run(3.5)
    fresh.expect(S.RETURN_TO_LAUNCH)


async def test_a_dip_under_load_is_no_reserve(flying: Rig) -> None:
    flying.autopilot.battery = 15.0
    await flying.run(2.5)
    flying.autopilot.battery = 90.0
    await flying.run(2.0)
    flying.expect(S.HOVER)


async def test_farther_away_it_returns_with_more(flying: Rig) -> None:
    flying.autopilot.battery = 33.0
    await flying.run(4)
    flying.expect(S.HOVER)
    flying.autopilot.north = 140.0
    await flying.run(4)
    flying.expect(S.RETURN_TO_LAUNCH)


async def test_hold_is_refused_while_the_battery_is_low(flying: Rig) -> None:
    flying.autopilot.battery = 22.0
    await flying.run(4)
    assert "battery is needed" in flying.command(Hold()).reason
    flying.expect(S.RETURN_TO_LAUNCH)
    flying.autopilot.battery = 80.0
    await flying.tick()
    flying.order(Hold())
    flying.expect(S.HOVER)


@pytest.mark.nightly
async def test_a_battery_that_is_not_known_for_thirty_seconds_brings_it_home(fresh: Rig) -> None:
    await fresh.enter(S.COMPULSIVE_MOVE)
    fresh.autopilot.battery = None
    for _ in range(12):
        if fresh.state is not S.RETURN_TO_LAUNCH:
            fresh.target_plan(40 if fresh.autopilot.north < 20 else 0, 0)
            await fresh.run(2.45)
    assert fresh.state is not S.RETURN_TO_LAUNCH
    await fresh.run(1.0)
    fresh.expect(S.RETURN_TO_LAUNCH)
    assert any(text.startswith("The battery is not known.") for text in fresh.log)


# -- operator ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
async def test_a_lost_operator_makes_it_hold(fresh: Rig) -> None:
    await fresh.enter(S.COMPULSIVE_MOVE)
    fresh.desk.present = False
    await fresh.tick()
    fresh.expect(S.COMMUNICATION_LOST)
    north = fresh.autopilot.north
    await fresh.run(10)
    assert abs(fresh.autopilot.north - north) < 9


@pytest.mark.nightly
async def test_a_lost_operator_changes_nothing_of_higher_rank(fresh: Rig) -> None:
    await fresh.enter(S.RETURN_TO_LAUNCH)
    fresh.autopilot.stuck = True
    fresh.desk.present = False
    await fresh.run(35)
    fresh.expect(S.RETURN_TO_LAUNCH)


# -- fence and ceiling ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("state", TASKS)
async def test_beyond_our_fence_it_goes_two_metres_inside_and_holds(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    fresh.autopilot.targets.clear()
    fresh.autopilot.north = 147.0
    await fresh.tick(2)
    fresh.expect(S.HOVER)
    assert fresh.detail == "Outside the fence: going back inside."
    assert fresh.command(CompulsiveMove(x=-20, y=0)).reason.startswith("Outside the fence")
    await fresh.run(3)
    assert all(t.north < 145 for t in fresh.autopilot.targets)
    assert fresh.autopilot.north == pytest.approx(143, abs=0.4)
    fresh.expect(S.HOVER)
    assert fresh.detail.endswith("Holding at 30 m.")


@pytest.mark.parametrize("state", [S.HOVER, S.COMMUNICATION_LOST])
async def test_a_holding_state_goes_back_inside_itself(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    fresh.autopilot.east = -148.0
    await fresh.run(3)
    fresh.expect(state)
    assert fresh.autopilot.east == pytest.approx(-143, abs=0.4)


@pytest.mark.nightly
async def test_above_our_ceiling_it_goes_two_metres_below(flying: Rig) -> None:
    flying.autopilot.height = 98.5
    await flying.run(4)
    assert flying.autopilot.height == pytest.approx(95, abs=0.3)
    flying.expect(S.HOVER)


async def test_half_a_metre_of_noise_is_no_breach(flying: Rig) -> None:
    flying.autopilot.north = 145.0
    await flying.run(1)
    flying.autopilot.targets.clear()
    flying.autopilot.north = 145.2
    await flying.run(1)
    assert not any("Outside" in text for text in flying.log)


@pytest.mark.nightly
async def test_not_inside_after_ten_seconds_it_returns_home(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.autopilot.stuck = True
    fresh.autopilot.north = 148.0
    await fresh.run(9.5)
    assert fresh.state in (S.HOVER, S.COMMUNICATION_LOST)
    await fresh.run(1.0)
    fresh.expect(S.RETURN_TO_LAUNCH)
    assert "Still outside the fence" in fresh.command(Hold()).reason


@pytest.mark.nightly
async def test_the_fence_changes_nothing_of_higher_rank(fresh: Rig) -> None:
    await fresh.enter(S.LAND)
    fresh.autopilot.stuck = True
    sent = len(fresh.autopilot.targets)
    fresh.autopilot.north = 148.0
    await fresh.run(15)
    fresh.expect(S.LAND)
    assert len(fresh.autopilot.targets) == sent


# -- perception -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", ["vision", "mapper", "path_plan", "camera"])
async def test_a_perception_fault_ends_what_flies_by_sight(fresh: Rig, part: str) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    getattr(fresh.inputs, f"{part}_health").publish = lambda _: None  # nothing well is heard of it any longer
    topic = getattr(fresh.inputs, f"{part}_health")
    type(topic).publish(topic, Health.bad("lens covered"))
    await fresh.run(0.9)
    fresh.expect(S.AUTONOMOUS_EXPLORE)
    await fresh.run(0.4)
    fresh.expect(S.HOVER)
    assert "lens covered" in fresh.log[-1]


async def test_perception_that_falls_silent_is_a_fault(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.sight.flows = False
    await fresh.run(3.2)
    fresh.expect(S.HOVER)
    assert "No result lately" in fresh.log[-1]


async def test_one_bad_picture_is_no_fault(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    for _ in range(5):
        fresh.sight.healthy = False
        await fresh.run(0.3)
        fresh.sight.healthy = True
        await fresh.run(0.3)
    fresh.expect(S.AUTONOMOUS_EXPLORE)


# -- position ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
async def test_a_jump_of_the_position_makes_it_hold(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_MOVE)
    fresh.autopilot.topics.frame_jump.publish(1.7)
    await fresh.tick()
    fresh.expect(S.HOVER)
    assert "The position jumped by 1.7 m." in fresh.log


async def test_a_position_that_the_autopilot_distrusts_makes_it_hold(fresh: Rig) -> None:
    await fresh.enter(S.COMPULSIVE_MOVE)
    fresh.autopilot.position_good = False
    await fresh.run(1.8)
    fresh.expect(S.COMPULSIVE_MOVE)
    await fresh.run(0.4)
    fresh.expect(S.HOVER)
    assert fresh.log[-1] == "The position was lost. Holding."


@pytest.mark.nightly
async def test_a_jump_while_holding_holds_where_it_is_by_the_new_position(flying: Rig) -> None:
    flying.order(CompulsiveMove(x=10, y=0))
    await flying.until(S.HOVER)
    await flying.run(3)
    flying.autopilot.north += 5.0
    flying.autopilot.wanted = None
    flying.autopilot.topics.frame_jump.publish(5.0)
    await flying.run(0.5)
    flying.expect(S.HOVER)
    assert flying.autopilot.targets[-1].north == pytest.approx(15, abs=0.7)


@pytest.mark.fault("local and global position jump together by 25 m (EKF reset after a GPS glitch) in a task")
@pytest.mark.parametrize("state", TASKS)
async def test_a_jump_of_the_estimate_ends_a_task_at_the_new_place(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    await fresh.run(1)
    fresh.autopilot.north, fresh.autopilot.wanted = fresh.autopilot.north + 25.0, None
    sent = len(fresh.autopilot.targets)
    here = fresh.autopilot.north
    fresh.autopilot.topics.estimate_jump.publish(25.0)
    await fresh.tick()
    fresh.expect(S.HOVER)
    assert "The position estimate jumped by 25 m: the map may not fit it." in fresh.log
    await fresh.run(0.5)
    assert len(fresh.autopilot.targets) > sent
    assert all(abs(target.north - here) < 8.0 for target in fresh.autopilot.targets[sent:])  # the distance to stop


@pytest.mark.slow
@pytest.mark.fault(
    "local and global position jump together by 25 m (EKF reset after a GPS glitch) while the drone holds "
    "(Hover, CommunicationLost)"
)
@pytest.mark.parametrize("state", [S.HOVER, S.COMMUNICATION_LOST])
async def test_a_held_drone_is_not_dragged_by_a_jump_of_the_estimate(fresh: Rig, state: StateName) -> None:
    await fresh.enter(S.COMPULSIVE_MOVE)
    await fresh.until(S.HOVER)
    fresh.desk.present = state is S.HOVER
    await fresh.run(1)
    fresh.expect(state)
    sent = len(fresh.autopilot.targets)
    fresh.autopilot.wanted = None
    fresh.autopilot.north += 25.0
    here = fresh.autopilot.north
    fresh.autopilot.topics.estimate_jump.publish(25.0)
    await fresh.run(1)
    fresh.expect(state)
    assert len(fresh.autopilot.targets) > sent
    assert all(abs(target.north - here) < 0.5 for target in fresh.autopilot.targets[sent:])


@pytest.mark.nightly
async def test_a_jump_while_it_goes_back_into_the_fence_forms_the_path_back_again(flying: Rig) -> None:
    flying.autopilot.north, flying.autopilot.wanted = 148.0, None
    await flying.run(0.3)
    flying.autopilot.north, flying.autopilot.wanted = 158.0, None
    flying.autopilot.topics.estimate_jump.publish(10.0)
    await flying.run(12)
    assert flying.autopilot.north < 144.0
    assert not flying.manager.situation().facts.is_breached


async def test_on_the_ground_a_jump_of_the_estimate_is_no_event(rig: Rig) -> None:
    await rig.run(1)
    rig.autopilot.topics.estimate_jump.publish(25.0)
    await rig.run(0.2)
    rig.expect(S.IDLE)
    assert not any("jumped" in line for line in rig.log)


@pytest.mark.fault(
    "EKF_STATUS_REPORT: GPS glitch, no absolute position, constant position, not initialised, variance above 0.8"
)
async def test_the_reason_of_a_distrusted_position_is_reported(fresh: Rig) -> None:
    await fresh.enter(S.COMPULSIVE_MOVE)
    fresh.autopilot.estimator_fault = "GPS glitch"
    await fresh.run(1.8)
    fresh.expect(S.COMPULSIVE_MOVE)
    await fresh.run(0.4)
    fresh.expect(S.HOVER)
    assert fresh.log[-1] == "The autopilot does not trust its position: GPS glitch. Holding."
    assert fresh.manager.situation().facts.health("position").reason.endswith("GPS glitch.")


# -- several at once --------------------------------------------------------------------------------------------------


async def test_the_highest_rank_wins(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.autopilot.battery = 21.0
    await fresh.run(2.9)
    fresh.desk.present = False
    fresh.sight.healthy = False
    fresh.autopilot.north = 149.0
    await fresh.run(0.4)
    fresh.expect(S.RETURN_TO_LAUNCH)


@pytest.mark.nightly
async def test_the_autopilots_own_return_is_never_countermanded(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.autopilot.say("GCS Failsafe", severity=4)
    fresh.autopilot.change_mode(CopterMode.RTL)
    await fresh.tick()
    fresh.expect(S.RETURN_TO_LAUNCH)
    entry = fresh.manager.log.entries[-1]
    assert (entry.text, entry.details) == ("The autopilot returns home by itself.", "GCS Failsafe")
    assert fresh.command(Hold()).reason == "The autopilot does this by itself. GCS Failsafe"
    fresh.autopilot.stuck = True
    asked = len(fresh.autopilot.asked("set_mode"))
    fresh.autopilot.battery, fresh.desk.present = 5.0, False
    await fresh.run(40)
    fresh.expect(S.RETURN_TO_LAUNCH)
    assert len(fresh.autopilot.asked("set_mode")) == asked


@pytest.mark.nightly
async def test_a_landing_that_nobody_asked_for_is_followed(fresh: Rig) -> None:
    await fresh.enter(S.RETURN_TO_LAUNCH)
    fresh.autopilot.change_mode(CopterMode.LAND)
    await fresh.tick()
    fresh.expect(S.LAND)
    assert fresh.manager.state.rank is Rank.AUTOPILOT
    await fresh.until(S.IDLE)


@pytest.mark.slow
@pytest.mark.fault(
    "under load 3.25 V a cell in flight",
    "the task ends, the drone returns within 4 s; the log has voltage, counter and time flown",
)
@pytest.mark.parametrize("state", [S.AUTONOMOUS_EXPLORE, S.COMMUNICATION_LOST])
async def test_a_voltage_that_sags_brings_it_home(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    fresh.autopilot.volts = 3.25 * 3
    for _ in range(3):
        fresh.target_plan(40 if fresh.autopilot.north < 20 else 0, 0)
        await fresh.run(2.0)
    fresh.expect(S.RETURN_TO_LAUNCH)
    assert "The battery's voltage is too low. Returning home." in fresh.log
    assert any(text.startswith("The battery's voltage sags: 3.25 V a cell of 3, the counter") for text in fresh.log)
    assert fresh.command(Hold()).reason == "Not while this lasts: The battery's voltage is too low."
    fresh.autopilot.volts = 12.0
    await fresh.run(8.0)
    assert not fresh.command(Hold()).accepted, "a battery that sagged once sags again"


@pytest.mark.slow
@pytest.mark.fault("under load 3.1 V a cell in flight, during a return too", "it lands within 4 s")
@pytest.mark.parametrize("state", [S.COMPULSIVE_MOVE, S.RETURN_TO_LAUNCH])
async def test_a_voltage_that_is_nearly_gone_lands_it(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    fresh.autopilot.north += 20.0
    fresh.autopilot.volts = 3.1 * 3
    for _ in range(3):
        fresh.target_plan(40 if fresh.autopilot.north < 20 else 0, 0)
        await fresh.run(2.0)
    fresh.expect(S.LAND)
    assert fresh.autopilot.mode == CopterMode.LAND
    assert "The battery's voltage is nearly gone. Landing." in fresh.log


@pytest.mark.slow
async def test_a_pilot_and_the_autopilots_own_failsafe_are_left_alone(flying: Rig) -> None:
    flying.autopilot.change_mode(CopterMode.LOITER)
    await flying.run(1.0)
    flying.autopilot.volts = 3.1 * 3
    await flying.run(5.0)
    flying.expect(S.MANUAL)
    flying.autopilot.change_mode(CopterMode.RTL)
    await flying.run(2.0)
    flying.expect(S.RETURN_TO_LAUNCH)


@pytest.mark.nightly
async def test_on_the_ground_a_voltage_sends_nothing(fresh: Rig) -> None:
    await fresh.enter(S.ARM)
    fresh.autopilot.volts = 3.0 * 3
    await fresh.run(8.0)
    fresh.expect(S.ARM)


@pytest.mark.slow
@pytest.mark.fault(
    "the counter stands still in flight, creeps, begins again, or says more than the voltage under load allows",
    "reported once; the charge is counted by time and voltage from there, and the reserve brings it home",
)
async def test_a_counter_that_stands_still_is_reported_once_and_the_time_flown_counts(flying: Rig) -> None:
    flying.autopilot.battery = 60.0
    await flying.run(125.0)
    messages = [
        text
        for text in flying.log
        if text.startswith("The battery's counter is not believed: the counter stands still")
    ]
    assert len(messages) == 1
    reserve = flying.manager.situation().facts.battery.reserve
    assert reserve is not None
    assert reserve.percentage < 50.0
    await flying.until(S.RETURN_TO_LAUNCH, 240.0)
    assert len([text for text in flying.log if "not believed" in text]) == 1


@pytest.mark.slow
@pytest.mark.fault("the counter says 100 % at 11.0 V of three cells, or 30 to 100 % at 3.2 to 3.85 V a cell at rest")
@pytest.mark.parametrize(("volts", "words"), [(11.0, "at rest is 29 % at most"), (3.53 * 3, "at rest is 6 % at most")])
async def test_arm_is_refused_with_a_counter_that_the_voltage_contradicts(rig: Rig, volts: float, words: str) -> None:
    rig.autopilot.battery, rig.autopilot.volts = 100.0, volts
    await rig.run(8.0)
    answer = rig.command(Arm())
    assert not answer.accepted
    assert answer.reason.startswith(
        f"Battery: {volts:.1f} V; the counter says 100 %, {volts / 3:.2f} V a cell {words}."
    )
    assert "Charge the battery" in answer.reason
    rig.autopilot.volts = 12.6
    await rig.run(8.0)
    assert rig.command(Arm()).accepted


@pytest.mark.slow
@pytest.mark.fault("the counter says 100 % at 11.0 V of three cells, or 30 to 100 % at 3.2 to 3.85 V a cell at rest")
async def test_arm_is_refused_with_less_than_the_voltage_needs(rig: Rig) -> None:
    rig.autopilot.battery, rig.autopilot.volts = 31.0, 3.6 * 3
    await rig.run(8.0)
    assert "13 % at most" in rig.command(Arm()).reason


@pytest.mark.slow
@pytest.mark.fault(
    "the autopilot measures no voltage (none, 0.01 V), or more than the cells can have",
    "Arm is refused with the setting",
)
@pytest.mark.parametrize("volts", [None, 0.01, 3.9])
async def test_arm_is_refused_without_a_voltage(rig: Rig, volts: float | None) -> None:
    rig.autopilot.volts = volts
    await rig.run(8.0)
    assert "voltage not known" in rig.command(Arm()).reason


@pytest.mark.slow
@pytest.mark.fault("the autopilot measures no voltage (none, 0.01 V), or more than the cells can have")
async def test_arm_is_refused_with_more_volts_than_its_cells_hold(tmp_path: Path) -> None:
    settings = DdcSettings(FlightSettings(battery_cells=3), FenceSettings(), OperatorSettings(), HeightSettings(), 245)
    rig = Rig(tmp_path, settings=settings)
    rig.autopilot.volts = 14.8
    await rig.run(8.0)
    assert "4.93 V a cell of 3. Set flight.battery_cells" in rig.command(Arm()).reason
    await rig.close()
