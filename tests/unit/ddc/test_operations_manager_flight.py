"""A whole flight, state by state."""

from __future__ import annotations

import pytest

from hawk.comm.protocol.commands import Arm, AutonomousExplore, Land, ReturnToLaunch, Takeoff
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode
from tests.unit.ddc.fakes import Rig


@pytest.mark.nightly
async def test_a_survey_goes_through_all_its_states(rig: Rig) -> None:
    rig.expect(StateName.IDLE)
    rig.order(Arm())
    await rig.until(StateName.ARM)
    await rig.run(1.0)
    rig.order(Takeoff())
    await rig.until(StateName.HOVER)
    rig.target_plan(30, 20)
    rig.order(AutonomousExplore())
    await rig.run(15)
    rig.expect(StateName.AUTONOMOUS_EXPLORE)
    assert abs(rig.autopilot.north - 30) < 1
    assert abs(rig.autopilot.east - 20) < 1
    rig.finish_plan()
    await rig.until(StateName.HOVER)
    rig.order(ReturnToLaunch())
    await rig.tick()
    assert rig.state is StateName.RETURN_TO_LAUNCH
    await rig.until(StateName.IDLE)
    assert rig.autopilot.asked("set_mode") == [CopterMode.GUIDED, CopterMode.RTL]
    assert not rig.autopilot.armed
    reported = [text for text in rig.log if "Next" not in text and "second witness" not in text]
    assert reported == [
        "Autopilot found.",
        "Armed by Ana. 21 checks passed.",
        "Took off.",
        "At 35 m. Holding.",
        "Lot found. Exploring.",
        "Explored: the lot found is seen whole, 100 % of 0 m². Ground outside the fence was not looked at. Holding.",
        "Returning home, asked by Ana.",
        "Landed. Motors off.",
    ]


@pytest.mark.nightly
async def test_land_arm_again_elsewhere_and_go_on(rig: Rig) -> None:
    for place in (0.0, 5.0):
        rig.autopilot.east = place
        await rig.tick()
        rig.order(Arm())
        await rig.run(1.0)
        datum = rig.service.datum
        rig.order(Takeoff())
        await rig.until(StateName.HOVER)
        home, fence = rig.topics.home_pub.value, rig.fence
        assert home is not None
        assert fence is not None
        assert (home.north, home.east) == pytest.approx((0, place), abs=0.01)
        easts = [east for _, east in fence.autopilot_polygon]
        assert (min(easts) + max(easts)) / 2 == pytest.approx(place, abs=0.01)
        rig.order(Land())
        await rig.until(StateName.IDLE)
        assert rig.service.datum is datum
    assert rig.autopilot.count("upload_fence") == 2
