"""Return To Launch, Land, CommunicationLost and Manual: coming down, waiting and letting a pilot fly."""

from __future__ import annotations

import pytest

from hawk.comm.protocol.commands import (
    Hold,
    Land,
    Resume,
    ReturnToLaunch,
)
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode, LandedState
from tests.unit.ddc.fakes import Rig

S = StateName


# -- Return To Launch and Land ----------------------------------------------------------------------------------------


@pytest.mark.nightly
@pytest.mark.parametrize(("command", "mode"), [(ReturnToLaunch(), CopterMode.RTL), (Land(), CopterMode.LAND)])
async def test_coming_down_is_the_autopilots_work(flying: Rig, command: ReturnToLaunch | Land, mode: int) -> None:
    flying.autopilot.north = 40
    flying.order(command)
    await flying.tick(2)
    assert flying.autopilot.mode == mode
    sent = len(flying.autopilot.targets)
    await flying.until(S.IDLE, 90)
    assert len(flying.autopilot.targets) == sent
    assert flying.log[-1] == "Landed. Motors off."
    assert flying.autopilot.count("set_mode") == 1


async def test_a_refused_return_is_asked_for_again_and_reported(flying: Rig) -> None:
    flying.autopilot.refuse["set_mode"] = "EKF variance"
    flying.order(ReturnToLaunch())
    await flying.run(5)
    flying.expect(S.RETURN_TO_LAUNCH)
    assert flying.autopilot.count("set_mode") == 3
    assert "EKF variance" in flying.detail
    assert flying.manager.log.entries[-1].details == "EKF variance"
    flying.autopilot.refuse.clear()
    await flying.run(2.5)
    assert flying.autopilot.mode == CopterMode.RTL


async def test_the_operator_holds_a_return(fresh: Rig) -> None:
    await fresh.enter(S.RETURN_TO_LAUNCH)
    fresh.order(Hold())
    await fresh.run(1)
    fresh.expect(S.HOVER)
    assert fresh.autopilot.mode == CopterMode.GUIDED


# -- CommunicationLost ------------------------------------------------------------------------------------------------


@pytest.mark.nightly
async def test_it_holds_for_thirty_seconds_then_returns(fresh: Rig) -> None:
    await fresh.enter(S.COMMUNICATION_LOST)
    await fresh.run(1.0)
    assert fresh.manager.status.value is not None
    assert fresh.manager.status.value.operation.return_in == pytest.approx(28.9, abs=0.3)
    await fresh.run(28.5)
    fresh.expect(S.COMMUNICATION_LOST)
    assert fresh.autopilot.mode == CopterMode.GUIDED
    await fresh.run(0.8)
    fresh.expect(S.RETURN_TO_LAUNCH)
    await fresh.tick(2)
    assert fresh.autopilot.mode == CopterMode.RTL


async def test_nothing_resumes_by_itself_when_the_operator_is_back(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.desk.present = False
    await fresh.tick()
    fresh.expect(S.COMMUNICATION_LOST)
    fresh.desk.present = True
    await fresh.tick()
    fresh.expect(S.HOVER)
    await fresh.run(5)
    fresh.expect(S.HOVER)


# -- Manual -----------------------------------------------------------------------------------------------------------


@pytest.mark.nightly
async def test_a_pilot_takes_over_from_every_state_in_the_air(fresh: Rig) -> None:
    for state in (S.AUTONOMOUS_EXPLORE, S.COMPULSIVE_MOVE, S.RETURN_TO_LAUNCH, S.LAND):
        fresh.autopilot.put_in_air()
        fresh.autopilot.change_mode(CopterMode.GUIDED)
        await fresh.run(3.5)
        await fresh._order_from_hover(state)
        fresh.expect(state)
        sent, asked = len(fresh.autopilot.targets), len(fresh.autopilot.asked("set_mode"))
        fresh.autopilot.change_mode(CopterMode.LOITER)
        await fresh.run(3.5)
        fresh.expect(S.MANUAL)
        assert len(fresh.autopilot.targets) == sent
        assert len(fresh.autopilot.asked("set_mode")) == asked


@pytest.mark.nightly
async def test_manual_commands_nothing_by_itself(fresh: Rig) -> None:
    await fresh.enter(S.MANUAL)
    fresh.autopilot.calls.clear()
    sent = len(fresh.autopilot.targets)
    fresh.desk.present = False
    fresh.autopilot.battery = 3.0
    fresh.autopilot.north = 400.0
    fresh.sight.healthy = False
    await fresh.run(20)
    fresh.expect(S.MANUAL)
    assert {name for name, _ in fresh.autopilot.calls} <= {"get_parameter", "compare_fence"}
    assert len(fresh.autopilot.targets) == sent


async def test_the_pilot_lands_and_disarms(fresh: Rig) -> None:
    await fresh.enter(S.MANUAL)
    fresh.autopilot.landed, fresh.autopilot.height = LandedState.ON_GROUND, 0.0
    await fresh.tick()
    assert fresh.command(Resume(confirmed=True)).reason == "On the ground."
    fresh.autopilot.armed = False
    await fresh.tick()
    fresh.expect(S.IDLE)
