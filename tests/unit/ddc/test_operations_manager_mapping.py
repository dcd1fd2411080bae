from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.ddc.rules.follower import state_from_autopilot
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode, LandedState

AIR = [LandedState.IN_AIR, LandedState.TAKING_OFF, LandedState.LANDING, LandedState.UNDEFINED]


@pytest.mark.parametrize(
    ("armed", "landed", "mode", "at_start", "expected"),
    [
        (False, LandedState.ON_GROUND, CopterMode.GUIDED, False, StateName.IDLE),
        (False, LandedState.IN_AIR, CopterMode.RTL, True, StateName.IDLE),
        (True, LandedState.ON_GROUND, CopterMode.GUIDED, False, StateName.ARM),
        (True, LandedState.ON_GROUND, CopterMode.STABILIZE, False, StateName.MANUAL),
        (True, LandedState.ON_GROUND, CopterMode.RTL, False, StateName.MANUAL),
        (True, LandedState.IN_AIR, CopterMode.RTL, False, StateName.RETURN_TO_LAUNCH),
        (True, LandedState.IN_AIR, CopterMode.SMART_RTL, True, StateName.RETURN_TO_LAUNCH),
        (True, LandedState.LANDING, CopterMode.LAND, False, StateName.LAND),
        (True, LandedState.IN_AIR, CopterMode.GUIDED, False, StateName.HOVER),
        (True, LandedState.IN_AIR, CopterMode.BRAKE, False, StateName.HOVER),
        (True, LandedState.IN_AIR, CopterMode.GUIDED, True, StateName.COMMUNICATION_LOST),
        (True, LandedState.UNDEFINED, CopterMode.BRAKE, True, StateName.COMMUNICATION_LOST),
        (True, LandedState.IN_AIR, CopterMode.LOITER, False, StateName.MANUAL),
        (True, LandedState.IN_AIR, CopterMode.AUTO, True, StateName.MANUAL),
        (True, LandedState.IN_AIR, CopterMode.AUTO_RTL, False, StateName.MANUAL),
        (True, LandedState.IN_AIR, None, False, StateName.MANUAL),
        (True, LandedState.IN_AIR, 99, False, StateName.MANUAL),
    ],
)
def test_the_table(armed: bool, landed: LandedState, mode: int | None, at_start: bool, expected: StateName) -> None:
    assert state_from_autopilot(armed, landed, mode, at_start) is expected


@given(st.sampled_from(LandedState), st.none() | st.integers(-5, 300), st.booleans())
def test_disarmed_is_always_idle(landed: LandedState, mode: int | None, at_start: bool) -> None:
    assert state_from_autopilot(False, landed, mode, at_start) is StateName.IDLE


@given(st.sampled_from(AIR), st.none() | st.integers(-5, 300), st.booleans())
def test_in_the_air_only_guided_and_brake_are_ours_to_hold(
    landed: LandedState, mode: int | None, at_start: bool
) -> None:
    found = state_from_autopilot(True, landed, mode, at_start)
    holds = found in (StateName.HOVER, StateName.COMMUNICATION_LOST)
    assert holds == (mode in (CopterMode.GUIDED, CopterMode.BRAKE))
    assert found not in (StateName.IDLE, StateName.CONFIGURE, StateName.ARM, StateName.TAKEOFF)


@given(st.booleans(), st.sampled_from(LandedState), st.none() | st.integers(-5, 300), st.booleans())
def test_no_task_is_ever_taken_up(armed: bool, landed: LandedState, mode: int | None, at_start: bool) -> None:
    tasks = {
        StateName.AUTONOMOUS_EXPLORE,
        StateName.AUTONOMOUS_MOVE,
        StateName.COMPULSIVE_MOVE,
        StateName.TAKEOFF,
        StateName.CONFIGURE,
    }
    assert state_from_autopilot(armed, landed, mode, at_start) not in tasks
