"""Acts and transitions of Arm and Takeoff, unsafe ones refused."""

from __future__ import annotations

from typing import Any

import pytest

from hawk.comm.protocol.commands import (
    Arm,
    CompulsiveMove,
    Disarm,
    Hold,
    Takeoff,
)
from hawk.ddc.fence.geometry import FenceError
from hawk.ddc.fence.plan import FencePlan
from hawk.model.operation import StateName
from hawk.model.plans import Fence
from hawk.model.vehicle import CopterMode
from tests.unit.ddc.fakes import Rig

S = StateName


# -- Arm --------------------------------------------------------------------------------------------------------------


async def test_arm_uploads_the_fence_then_guided_then_arms(rig: Rig) -> None:
    rig.autopilot.calls.clear()
    rig.order(Arm())
    await rig.run(0.5)
    asked = [name for name, _ in rig.autopilot.calls if name != "get_parameter"]
    assert asked == ["upload_fence", "set_mode", "arm"]
    assert rig.fence == rig.autopilot.asked("upload_fence")[0]
    assert rig.detail == "Armed. Motors stop in 10 s without take-off."
    await rig.run(4.0)
    assert "Motors stop in 6 s" in rig.detail


@pytest.mark.parametrize(
    ("request_name", "text"),
    [("upload_fence", "The fence was not taken."), ("arm", "Arm was refused.")],
)
async def test_a_refused_arm_leads_to_idle_with_the_autopilots_words(rig: Rig, request_name: str, text: str) -> None:
    rig.autopilot.refuse[request_name] = "PreArm: GPS 1: Bad fix"
    rig.order(Arm())
    await rig.run(0.5)
    rig.expect(S.IDLE)
    entry = rig.manager.log.entries[-1]
    assert (entry.text, entry.details) == (text, "PreArm: GPS 1: Bad fix")
    assert not rig.autopilot.armed


@pytest.mark.nightly
async def test_armed_that_comes_after_it_gave_up_is_disarmed_at_once(rig: Rig) -> None:
    rig.autopilot.silent.add("arm")
    rig.order(Arm())
    await rig.run(21)
    rig.expect(S.IDLE)
    rig.autopilot.armed = True
    await rig.tick(2)
    assert rig.autopilot.count("disarm") == 1
    await rig.tick(2)
    assert not rig.autopilot.armed
    rig.expect(S.IDLE)


async def test_armed_by_somebody_else_is_not_disarmed(rig: Rig) -> None:
    rig.autopilot.armed = True
    await rig.tick()
    rig.expect(S.MANUAL)
    assert rig.autopilot.count("disarm") == 0


async def test_armed_by_somebody_else_in_guided_is_taken_up_as_arm(rig: Rig) -> None:
    rig.autopilot.armed, rig.autopilot.mode = True, CopterMode.GUIDED
    await rig.tick()
    rig.expect(S.ARM)


async def test_a_lost_operator_ends_arm_and_the_motors_stop(fresh: Rig) -> None:
    await fresh.enter(S.ARM)
    fresh.desk.present = False
    await fresh.run(0.5)
    fresh.expect(S.IDLE)
    assert not fresh.autopilot.armed


async def test_disarm_stops_the_motors(fresh: Rig) -> None:
    await fresh.enter(S.ARM)
    fresh.order(Disarm())
    await fresh.tick(2)
    fresh.expect(S.IDLE)


async def test_disarm_while_arming_stops_it(rig: Rig) -> None:
    rig.autopilot.silent.add("arm")
    rig.order(Arm())
    await rig.run(0.5)
    rig.order(Disarm())
    rig.expect(S.IDLE)
    rig.autopilot.armed = True
    await rig.run(0.2)
    assert not rig.autopilot.armed


async def test_the_autopilots_own_disarm_leads_to_idle(fresh: Rig) -> None:
    await fresh.enter(S.ARM)
    fresh.autopilot.armed = False
    await fresh.tick()
    fresh.expect(S.IDLE)


async def test_armed_in_another_mode_is_someone_elses(fresh: Rig) -> None:
    await fresh.enter(S.ARM)
    fresh.autopilot.mode = CopterMode.STABILIZE
    await fresh.tick()
    fresh.expect(S.MANUAL)


async def test_a_mode_that_changed_while_arming_is_someone_elses(rig: Rig) -> None:
    rig.autopilot.silent.add("arm")
    rig.order(Arm())
    await rig.run(0.5)
    rig.autopilot.mode = CopterMode.STABILIZE
    await rig.tick()
    rig.expect(S.ARM)
    rig.autopilot.armed = True
    await rig.tick(2)
    rig.expect(S.MANUAL)


async def test_without_a_fence_it_does_not_arm(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    around, checked = FencePlan.around, iter([True])

    def fail_after_the_check(plan: FencePlan, *where: Any) -> Fence:
        if next(checked, False):
            return around(plan, *where)
        raise FenceError("fence: too narrow")

    monkeypatch.setattr(FencePlan, "around", fail_after_the_check)
    rig.order(Arm())
    await rig.tick()
    rig.expect(S.IDLE)
    assert rig.manager.log.entries[-1].details == "fence: too narrow"
    assert rig.autopilot.count("arm") == 0


async def test_takeoff_waits_for_armed(rig: Rig) -> None:
    rig.autopilot.silent.add("arm")
    rig.order(Arm())
    await rig.run(0.5)
    assert rig.command(Takeoff()).reason == "Arming: wait until it is armed."


# -- Takeoff ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("armed", "state"), [(True, S.ARM), (False, S.IDLE)])
async def test_a_refused_takeoff_leads_back_to_the_ground(fresh: Rig, armed: bool, state: StateName) -> None:
    await fresh.enter(S.ARM)
    fresh.autopilot.refuse["takeoff"] = "Mode change failed"
    fresh.order(Takeoff())
    fresh.autopilot.armed = armed
    await fresh.tick(2)
    fresh.expect(state)
    if armed:
        assert fresh.manager.log.entries[-1].details == "Mode change failed"


async def test_hold_below_min_brakes_at_the_present_height(fresh: Rig) -> None:
    await fresh.enter(S.TAKEOFF)
    await fresh.run(2.0)
    height = fresh.autopilot.height
    assert 2 < height < 13
    fresh.order(Hold())
    await fresh.run(1.0)
    assert fresh.autopilot.mode == CopterMode.BRAKE
    assert fresh.autopilot.targets == []
    assert fresh.autopilot.height == pytest.approx(height, abs=0.5)
    fresh.expect(S.HOVER)


@pytest.mark.nightly
async def test_the_move_after_a_low_hold_climbs_to_min_first(fresh: Rig) -> None:
    await fresh.enter(S.TAKEOFF)
    await fresh.run(2.0)
    fresh.order(Hold())
    await fresh.run(1.0)
    fresh.order(CompulsiveMove(x=20, y=0))
    await fresh.until(S.HOVER)
    assert fresh.autopilot.north == pytest.approx(20, abs=2)
    sent = fresh.autopilot.targets
    assert all(abs(t.north) < 0.1 for t in sent if t.height < 14.4)
    assert sent[-1].height == pytest.approx(15)


@pytest.mark.nightly
async def test_an_operator_lost_while_it_climbs_lets_the_climb_end(fresh: Rig) -> None:
    await fresh.enter(S.TAKEOFF)
    fresh.desk.present = False
    await fresh.run(5.0)
    fresh.expect(S.TAKEOFF)
    await fresh.until(S.COMMUNICATION_LOST)
    assert fresh.autopilot.height > 33
