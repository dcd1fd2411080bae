"""Faults that others make: stations that change what we set, rally points, motors that stop, strangers on the link."""

from __future__ import annotations

import signal
from typing import Any, Final

from hawk.comm.autopilot.commands import MavCommand
from hawk.comm.protocol.commands import Arm, AutonomousExplore, ReturnToLaunch, Takeoff
from hawk.model.operation import StateName
from proving.faults import answers
from proving.faults.fault import (
    DOWN,
    MOTORS_OFF,
    UP,
    Act,
    Bring,
    CountAgain,
    Drone,
    Fault,
    Forge,
    Order,
    See,
    Signal,
    Station,
    When,
    absent,
    both,
    check_fails,
    either,
    healthy,
    mode,
    refused,
    reported,
    restarted,
    state,
)
from proving.faults.sights import CLEAN, FENCE_IS_OURS, NO_RALLY, parameter, stayed, warned
from proving.faults.station import FORCE, command_fields

_HOVER, _EXPLORE, _RETURN = StateName.HOVER, StateName.AUTONOMOUS_EXPLORE, StateName.RETURN_TO_LAUNCH
_IDLE, _MANUAL = StateName.IDLE, StateName.MANUAL
_BACK_S: Final = 15.0
"""One look every 10 s, and the time to write."""
_AWAY: Final = [(30.0, 32.0, 15.0)]
"""A rally point 44 m from home."""
_WIDE: Final = [(400.0, 400.0), (400.0, -400.0), (-400.0, -400.0), (-400.0, 400.0)]
_ELSEWHERE: Final = [(-150.0, 150.0), (-150.0, 200.0), (-200.0, 200.0), (-200.0, 150.0)]
_NAMES: Final = {
    "BATT_FS": "Battery failsafe",
    "BATT_LOW": "Battery thresholds",
    "FENCE_": "Fence in the autopilot",
    "FS_GCS": "Ground-station failsafe",
    "RTL_ALT": "Return height",
}
"""Names of the checks that parameters belong to."""
_CLEAR: Final = {"kind": "MISSION_CLEAR_ALL", "fields": {"target_system": 1, "target_component": 1, "mission_type": 1}}
_UNPRINTABLE: Final = b"\xff\xfe\x1b[31mred \x9b2J\x07 bell"


def _put_back(name: str, value: float) -> tuple[Act | See, ...]:
    """Return the steps of a parameter that another station sets: it is reported and put back."""
    changed = parameter(name, value)
    is_reported = warned(name, *(words for beginning, words in _NAMES.items() if name.startswith(beginning)))
    return Drone({"parameters": {name: value}}), See(both(is_reported, absent(changed)), _BACK_S)


def _fence(change: dict[str, Any]) -> tuple[Act | See, ...]:
    """Return the steps of a fence that another station changes: it is reported and put back."""
    return Drone(change), See(absent(FENCE_IS_OURS), 1.0), See(both(FENCE_IS_OURS, reported("ence")), _BACK_S)


KEPT: Final = (
    Fault(
        "a second station sets BATT_FS_LOW_ACT to 5, which cuts the motors",
        When.EXPLORING,
        (*_put_back("BATT_FS_LOW_ACT", 5.0), See(UP, 5.0, lasts=True)),
        answer=answers.STATION_PARAMETERS,
    ),
    Fault(
        "a second station sets BATT_FS_CRT_ACT to 5, which cuts the motors",
        When.HOVERING,
        (*_put_back("BATT_FS_CRT_ACT", 5.0), See(UP, 5.0, lasts=True)),
        answer=answers.STATION_PARAMETERS,
    ),
    Fault(
        "a second station sets RTL_ALT to 300 m",
        When.EXPLORING,
        _put_back("RTL_ALT", 30000.0),
        answer=answers.STATION_PARAMETERS,
    ),
    Fault(
        "a second station sets BATT_LOW_VOLT to 0",
        When.HOVERING,
        _put_back("BATT_LOW_VOLT", 0.0),
        answer=answers.STATION_PARAMETERS,
    ),
    Fault(
        "a second station sets FENCE_ACTION to 0",
        When.HOVERING,
        _put_back("FENCE_ACTION", 0.0),
        answer=answers.STATION_PARAMETERS,
    ),
    Fault(
        "a second station sets FENCE_ENABLE to 0",
        When.EXPLORING,
        _put_back("FENCE_ENABLE", 0.0),
        answer=answers.STATION_PARAMETERS,
    ),
    Fault(
        "a second station sets FS_GCS_ENABLE to 0",
        When.EXPLORING,
        _put_back("FS_GCS_ENABLE", 0.0),
        ends_flight=True,
        answer=answers.STATION_PARAMETERS,
    ),
    Fault(
        "a second station switches the fence off by a command",
        When.HOVERING,
        (
            Station("COMMAND_LONG", command_fields(MavCommand.DO_FENCE_ENABLE, 0.0)),
            See(reported("ence"), _BACK_S),
        ),
        ends_flight=True,
        answer=answers.STATION_FENCE,
    ),
    Fault(
        "a second station clears the fence", When.HOVERING, _fence({"station": [_CLEAR]}), answer=answers.STATION_FENCE
    ),
    Fault(
        "a second station clears the fence, and again and again",
        When.EXPLORING,
        (
            *_fence({"fence": []}),
            *_fence({"fence": []}),
            *_fence({"fence": []}),
            See(UP, 3.0, lasts=True),
        ),
        answer=answers.STATION_FENCE,
    ),
    Fault(
        "a second station replaces the fence by a wide one",
        When.EXPLORING,
        _fence({"fence": _WIDE}),
        ends_flight=True,
        answer=answers.STATION_FENCE,
    ),
    Fault(
        "a second station replaces the fence by one that is elsewhere",
        When.HOVERING,
        (
            Drone({"fence": _ELSEWHERE}),
            See(absent(FENCE_IS_OURS), 1.0),
            See(reported("ence"), 5.0),
            See(FENCE_IS_OURS, _BACK_S),
            See(either(DOWN, both(UP, absent(state(_EXPLORE)))), 10.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.STATION_FENCE,
    ),
    Fault(
        "a second station clears the fence between Arm and Takeoff",
        When.ARMED,
        (
            Drone({"fence": []}),
            Order(Takeoff()),
            See(both(FENCE_IS_OURS, reported("ence")), 2 * _BACK_S),
            See(absent(state(_EXPLORE)), 3.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.STATION_FENCE,
    ),
    Fault(
        "after the fence is cleared no task begins until it is back",
        When.HOVERING,
        (
            Drone({"fence": []}),
            See(reported("ence in the autopilot was changed"), _BACK_S),
            Order(AutonomousExplore()),
            See(refused("ence"), 1.0),
            See(both(FENCE_IS_OURS, reported("is in the autopilot again")), _BACK_S),
            Order(AutonomousExplore()),
            See(state(_EXPLORE), 5.0),
        ),
        answer=answers.STATION_FENCE,
    ),
)

HOMEWARD: Final = (
    Fault(
        "a second station uploads a rally point 44 m from home",
        When.HOVERING,
        (
            Drone({"rally": _AWAY, "parameters": {"RALLY_INCL_HOME": 0.0}}),
            See(warned("ally"), _BACK_S),
            Order(ReturnToLaunch()),
            See(both(DOWN, stayed(4.0)), 150.0),
        ),
        ends_flight=True,
        answer=answers.STATION_RALLY,
    ),
    Fault(
        "a rally point is there before the flight",
        When.GROUND,
        (
            Bring(When.ARMED),  # failsafes are set
            Bring(When.GROUND),
            Drone({"rally": _AWAY}),
            See(absent(NO_RALLY), 1.0),
            See(warned("ally point"), 20.0),
            Order(Arm()),
            See(refused(), 1.0),
        ),
        ends_flight=True,
        answer=answers.STATION_RALLY,
    ),
    Fault(
        "rally points come while the drone returns",
        When.RETURNING,
        (
            Drone({"rally": _AWAY, "parameters": {"RALLY_INCL_HOME": 0.0}}),
            See(state(_RETURN), 5.0),
            See(DOWN, 120.0),
        ),
        ends_flight=True,
        answer=answers.STATION_RALLY,
    ),
    Fault(
        "a second station clears the fence and uploads a rally point outside",
        When.EXPLORING,
        (
            Drone({"fence": [], "rally": [(90.0, 90.0, 15.0)], "parameters": {"RALLY_INCL_HOME": 0.0}}),
            See(reported("ence"), _BACK_S),
            See(warned("ally"), _BACK_S),
            See(FENCE_IS_OURS, _BACK_S),
        ),
        ends_flight=True,
        answer=answers.STATION_RALLY,
    ),
    Fault(
        "a second station sends it 30 m away by a target of its own",
        When.HOVERING,
        (
            Station(
                "SET_POSITION_TARGET_LOCAL_NED",
                {
                    "time_boot_ms": 0,
                    "target_system": 1,
                    "target_component": 1,
                    "coordinate_frame": 7,
                    "type_mask": 2552,
                    **dict.fromkeys(("vx", "vy", "vz", "afx", "afy", "afz", "yaw", "yaw_rate", "z", "y"), 0.0),
                    "x": 30.0,
                },
            ),
            CountAgain(),
            See(both(UP, stayed(40.0)), 15.0, lasts=True),
            Order(ReturnToLaunch()),
            See(DOWN, 120.0),
        ),
        answer=answers.STATION_COMMANDS,
    ),
)

FALL: Final = (
    Fault(
        "a second station cuts the motors in the air",
        When.HOVERING,
        (
            Station("COMMAND_LONG", command_fields(MavCommand.COMPONENT_ARM_DISARM, 0.0, FORCE)),
            See(MOTORS_OFF, 1.0),
            See(reported("otors off in the air"), 3.0),
            See(absent(reported("Landed. Motors off")), 10.0, lasts=True),
            Order(Arm()),
            See(refused(), 1.0),
        ),
        ends_flight=True,
        falls=True,
        answer=answers.MOTORS_STOPPED,
    ),
    Fault(
        "the motors stop in the air by themselves",
        When.EXPLORING,
        (
            Drone({"motors": "off"}),
            See(reported("otors off in the air"), 3.0),
            See(absent(reported("Landed. Motors off")), 10.0, lasts=True),
            Order(Arm()),
            See(refused(), 1.0),
        ),
        ends_flight=True,
        falls=True,
        answer=answers.MOTORS_STOPPED,
    ),
)

_AGAIN: Final = (Signal(signal.SIGKILL), See(restarted(), 15.0, real=True))

STRANGERS: Final = (
    Fault(
        "an antenna tracker is heard before the copter",
        When.GROUND,
        (
            Drone({"others": ["tracker"]}),
            *_AGAIN,
            See(both(state(_IDLE), healthy("link"), absent(check_fails("GPS")), absent(check_fails("Battery"))), 25.0),
            See(mode("STABILIZE", "GUIDED", "LAND", "RTL"), 1.0),
        ),
        ends_flight=True,
        answer=answers.OTHERS_ON_LINK,
    ),
    Fault(
        "a gimbal is heard before the copter",
        When.GROUND,
        (
            Drone({"others": ["gimbal"]}),
            *_AGAIN,
            See(both(state(_IDLE), healthy("link"), absent(check_fails("GPS")), absent(check_fails("Battery"))), 25.0),
        ),
        ends_flight=True,
        answer=answers.OTHERS_ON_LINK,
    ),
    Fault(
        "a second copter is heard before ours",
        When.GROUND,
        (
            Drone({"others": ["copter"]}),
            *_AGAIN,
            See(
                either(
                    both(state(_IDLE), healthy("link"), absent(check_fails("GPS"))),
                    warned("other vehicle", "another vehicle", "vehicles", "system 3", "id 3"),
                ),
                25.0,
            ),
        ),
        ends_flight=True,
        answer=answers.OTHERS_ON_LINK,
    ),
    Fault(
        "antenna tracker, gimbal and second copter come onto the link",
        When.EXPLORING,
        (
            Drone({"others": ["tracker", "gimbal", "copter", "station"]}),
            See(
                both(state(_EXPLORE), UP, absent(reported("Motors off")), absent(reported("booted"))), 12.0, lasts=True
            ),
        ),
        answer=answers.OTHERS_ON_LINK,
    ),
    Fault(
        "the link speaks MAVLink 1 from the start",
        When.GROUND,
        (
            Drone({"link_version": 1}),
            *_AGAIN,
            See(warned("MAVLink 1", "MAVLink 2"), 30.0),
            Order(Arm()),
            See(refused(), 1.0),
        ),
        ends_flight=True,
        answer=answers.MAVLINK_1,
    ),
    Fault(
        "the link falls back to MAVLink 1",
        When.HOVERING,
        (
            Drone({"link_version": 1}),
            See(both(UP, absent(state(_IDLE))), 10.0, lasts=True),
            Order(ReturnToLaunch()),
            See(mode("RTL"), 5.0),
        ),
        ends_flight=True,
        answer=answers.MAVLINK_1,
    ),
    Fault(
        "the autopilot says what is no text",
        When.HOVERING,
        (
            Forge("STATUSTEXT", {"severity": 2, "text": _UNPRINTABLE}, times=3),
            See(both(UP, state(_HOVER), CLEAN), 5.0, lasts=True),
        ),
        answer=answers.FORGED,
    ),
)

OTHERS: Final = (*KEPT, *HOMEWARD, *FALL, *STRANGERS)
