"""Faults of the drone: its position, battery, autopilot and camera, and other people who command it."""

from __future__ import annotations

from typing import Final

from hawk.comm.autopilot.commands import MavCommand
from hawk.comm.protocol.commands import Arm, AutonomousExplore, Takeoff
from hawk.model.operation import StateName
from proving.faults import answers
from proving.faults.fault import (
    DOWN,
    MOTORS_OFF,
    UP,
    Drone,
    Fault,
    Order,
    See,
    Station,
    When,
    absent,
    both,
    check_fails,
    healthy,
    mode,
    refused,
    reported,
    state,
    unhealthy,
)
from proving.faults.station import command_fields, parameter_fields

_HOVER, _EXPLORE, _RETURN = StateName.HOVER, StateName.AUTONOMOUS_EXPLORE, StateName.RETURN_TO_LAUNCH
_EXPLORES: Final = (Order(Takeoff()), See(state(_HOVER), 60.0), Order(AutonomousExplore()))
_STOPS: Final = See(state(_HOVER), 27.0)
_HOME_MOVED: Final = Station(
    "COMMAND_LONG", command_fields(MavCommand.DO_SET_HOME, 0.0, 0.0, 0.0, 0.0, 43.2651, -79.9201, 100.0)
)


POSITION: Final = (
    Fault(
        "GNSS is lost",
        When.HOVERING,
        (Drone({"gps": "lost"}), See(unhealthy("position"), 12.0), See(mode("LAND", "ALT_HOLD"), 25.0)),
        ends_flight=True,
        answer=answers.GNSS_LOST,
    ),
    Fault(
        "GNSS is lost",
        When.EXPLORING,
        (Drone({"gps": "lost"}), See(absent(state(_EXPLORE)), 14.0), See(mode("LAND", "ALT_HOLD", "BRAKE"), 25.0)),
        ends_flight=True,
        answer=answers.GNSS_LOST,
    ),
    Fault(
        "GNSS is lost on the ground",
        When.GROUND,
        (
            Drone({"gps": "lost"}),
            See(check_fails("GPS"), 12.0),
            Order(Arm()),
            See(refused(), 1.0),
            Drone({"gps": "ok"}),
            See(absent(check_fails("GPS")), 30.0),
        ),
        answer=answers.GNSS_LOST,
    ),
    Fault(
        "the estimate of the position jumps by 25 m",
        When.HOVERING,
        (Drone({"gps_jump": (25.0, 0.0, 0.0)}), See(reported("position"), 4.0), See(both(UP, state(_HOVER)), 5.0)),
        ends_flight=True,
        answer=answers.POSITION_JUMP,
    ),
    Fault(
        "the estimate of the position jumps by 25 m",
        When.EXPLORING,
        (Drone({"gps_jump": (0.0, 25.0, 0.0)}), See(absent(state(_EXPLORE)), 4.0), See(reported("position"), 4.0)),
        ends_flight=True,
        answer=answers.POSITION_JUMP,
    ),
    Fault(
        "the autopilot's own origin moves by 20 m",
        When.EXPLORING,
        (
            Drone({"ekf_shift": (20.0, -10.0, 0.0)}),
            See(state(_EXPLORE, _HOVER), 3.0),
            See(both(UP, absent(state(_RETURN, StateName.LAND))), 8.0, lasts=True),
        ),
        answer=answers.GNSS_SMALL_ERROR,
    ),
)

POWER: Final = (
    Fault(
        "the battery falls to 15 %",
        When.EXPLORING,
        (Drone({"battery": 15.0}), See(mode("RTL"), 12.0), See(state(_RETURN), 13.0), See(DOWN, 180.0)),
        ends_flight=True,
        answer=answers.CHARGE_LOW,
    ),
    Fault(
        "the battery falls to 10 % on the ground",
        When.GROUND,
        (
            Drone({"battery": 10.0}),
            See(check_fails("Battery"), 10.0),
            Order(Arm()),
            See(refused(), 1.0),
            Drone({"battery": 100.0}),
            See(absent(check_fails("Battery")), 10.0),
        ),
        answer=answers.BATTERY_ON_GROUND,
    ),
    Fault(
        "the pilot's radio is lost",
        When.HOVERING,
        (Drone({"radio": "lost"}), See(mode("RTL"), 8.0), See(state(_RETURN), 10.0)),
        ends_flight=True,
        answer=answers.REMOTE_CONTROL_LOST,
    ),
)

AUTOPILOT: Final = (
    Fault(
        "the autopilot's program ends on the ground",
        When.GROUND,
        (
            Drone({"autopilot": "crash"}),
            See(unhealthy("link"), 4.0),
            Order(Arm()),
            See(refused(), 1.0),
            Drone({"autopilot": "power_cycle"}),
            See(both(healthy("link"), state(StateName.IDLE)), 20.0),
        ),
        ends_flight=True,
        answer=answers.AUTOPILOT_BOOTS,
    ),
    Fault(
        "the autopilot boots on the ground",
        When.GROUND,
        (
            Drone({"autopilot": "reboot"}),
            See(both(healthy("link"), state(StateName.IDLE)), 20.0),
            See(absent(check_fails("GPS")), 60.0),
        ),
        ends_flight=True,
        answer=answers.AUTOPILOT_BOOTS,
    ),
    Fault(
        "nobody takes off",
        When.ARMED,
        (See(MOTORS_OFF, 15.0), See(state(StateName.IDLE), 17.0)),
        answer=answers.NO_TAKEOFF,
    ),
)

CAMERA: Final = (
    Fault(
        "the camera sends no picture",
        When.EXPLORING,
        (
            Drone({"camera": "dark"}),
            See(unhealthy("camera"), 3.0, real=True),
            See(state(_HOVER), 5.0, real=True),
            Drone({"camera": "ok"}),
            See(healthy("camera"), 5.0),
        ),
        answer=answers.NO_PICTURE,
    ),
    Fault(
        "the camera sends no picture on the ground",
        When.GROUND,
        (
            Drone({"camera": "dark"}),
            See(check_fails("Camera"), 4.0, real=True),
            Order(Arm()),
            See(refused(), 1.0),
            Drone({"camera": "ok"}),
            See(absent(check_fails("Camera")), 5.0),
        ),
        answer=answers.NO_PICTURE,
    ),
    Fault(
        "the camera sends broken pictures",
        When.EXPLORING,
        (Drone({"camera": "garbage"}), See(absent(state(_EXPLORE)), 6.0), See(state(_HOVER), 6.0)),
        answer=answers.NO_PICTURE,
    ),
    Fault(
        "the camera refuses connections",
        When.EXPLORING,
        (
            Drone({"camera": "closed"}),
            See(unhealthy("camera"), 3.0, real=True),
            See(state(_HOVER), 5.0, real=True),
            Drone({"camera": "ok"}),
            See(healthy("camera"), 8.0),
        ),
        answer=answers.NO_PICTURE,
    ),
    Fault(
        "the camera sends no time stamps",
        When.EXPLORING,
        (Drone({"camera": "unstamped"}), See(state(_EXPLORE), 8.0, lasts=True)),
        answer=answers.PICTURE_DAMAGE,
    ),
    Fault(
        "the camera sends one picture with new time stamps",
        When.EXPLORING,
        (
            Drone({"camera": "frozen"}),
            See(unhealthy("camera", "stands still"), 6.0),
            See(both(state(_HOVER), reported("stands still")), 8.0),
            Drone({"camera": "ok"}),
            See(healthy("camera"), 5.0),
        ),
        answer=answers.NO_PICTURE,
    ),
    Fault(
        "the camera sits turned by 90°",
        When.ARMED,
        (Drone({"camera_turn_deg": 90.0}), *_EXPLORES, See(unhealthy("camera", "mount_yaw_deg to 90"), 25.0), _STOPS),
        ends_flight=True,
        answer=answers.CAMERA_TURNED,
    ),
    Fault(
        "the camera sits upside down",
        When.ARMED,
        (Drone({"camera_turn_deg": 180.0}), *_EXPLORES, See(unhealthy("camera", "mount_yaw_deg to 180"), 25.0), _STOPS),
        ends_flight=True,
        answer=answers.CAMERA_TURNED,
    ),
    Fault(
        "the camera mirrors its pictures",
        When.ARMED,
        (Drone({"camera": "mirrored"}), *_EXPLORES, See(unhealthy("camera", "mirrored"), 25.0), _STOPS),
        ends_flight=True,
        answer=answers.CAMERA_TURNED,
    ),
    Fault(
        "the camera comes loose and turns by 90°",
        When.EXPLORING,
        (Drone({"camera_turn_deg": 90.0}), See(unhealthy("camera"), 30.0), See(state(_HOVER), 32.0)),
        ends_flight=True,
        answer=answers.CAMERA_TURNED,
    ),
)

OTHERS: Final = (
    Fault(
        "the pilot takes over",
        When.EXPLORING,
        (
            Drone({"pilot_mode": 2}),
            See(both(state(StateName.MANUAL), mode("ALT_HOLD")), 2.0),
            See(mode("ALT_HOLD"), 5.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.PILOT,
    ),
    Fault(
        "a second station lands it",
        When.EXPLORING,
        (
            Station("COMMAND_LONG", command_fields(MavCommand.DO_SET_MODE, 1.0, 9.0)),
            See(state(StateName.LAND), 2.0),
            See(DOWN, 90.0),
        ),
        answer=answers.STATION_COMMANDS,
    ),
    Fault(
        "a second station sends it home",
        When.HOVERING,
        (
            Station("COMMAND_LONG", command_fields(MavCommand.DO_SET_MODE, 1.0, 6.0)),
            See(state(_RETURN), 2.0),
            See(DOWN, 120.0),
        ),
        answer=answers.STATION_COMMANDS,
    ),
    Fault(
        "a second station stops it",
        When.EXPLORING,
        (Station("COMMAND_LONG", command_fields(MavCommand.DO_SET_MODE, 1.0, 17.0)), See(absent(state(_EXPLORE)), 2.0)),
        ends_flight=True,
        answer=answers.STATION_COMMANDS,
    ),
    Fault(
        "a second station turns the fence off",
        When.HOVERING,
        (Station("PARAM_SET", parameter_fields("FENCE_ENABLE", 0.0)), See(reported("ence"), 5.0)),
        ends_flight=True,
        answer=answers.STATION_FENCE,
    ),
    Fault(
        "a second station turns our failsafe off",
        When.HOVERING,
        (Station("PARAM_SET", parameter_fields("FS_GCS_ENABLE", 0.0)), See(reported("FS_GCS_ENABLE"), 10.0)),
        ends_flight=True,
        answer=answers.STATION_PARAMETERS,
    ),
    Fault(
        "a second station moves home",
        When.HOVERING,
        (
            _HOME_MOVED,
            See(reported("ome"), 5.0),
        ),
        ends_flight=True,
        answer=answers.STATION_HOME,
    ),
    Fault(
        "a second station moves home every 6 s",
        When.HOVERING,
        (
            *(step for _ in range(3) for step in (_HOME_MOVED, See(state(_HOVER), 6.0, lasts=True))),
            _HOME_MOVED,
            See(state(_RETURN), 5.0),
            See(DOWN, 120.0),
        ),
        ends_flight=True,
        answer=answers.STATION_HOME,
    ),
)

DRONE: Final = (*POSITION, *POWER, *AUTOPILOT, *CAMERA, *OTHERS)
