"""Faults of one sensor while the others are right: GNSS, barometer, compasses, battery; and pictures."""

from __future__ import annotations

from typing import Any, Final

from hawk.comm.protocol.commands import Arm, Land, ReturnToLaunch
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
    Order,
    See,
    When,
    absent,
    both,
    check_fails,
    either,
    healthy,
    lower_than,
    mode,
    refused,
    state,
)
from proving.faults.sights import stayed, truly_between, warned

_HOVER, _EXPLORE, _RETURN = StateName.HOVER, StateName.AUTONOMOUS_EXPLORE, StateName.RETURN_TO_LAUNCH
_LAND, _IDLE = StateName.LAND, StateName.IDLE
_STOPPED: Final = absent(state(_EXPLORE))
_GOES_ON: Final = both(state(_EXPLORE), UP)
_HELD: Final = either(DOWN, both(UP, state(_HOVER, _LAND)))


def _refuses_arm(put: dict[str, Any], check: str, well: dict[str, Any]) -> tuple[Act | See, ...]:
    """Return the steps of a fault on the ground: a check fails, Arm is refused, and all is well again."""
    return (
        Drone(put),
        See(check_fails(check), 15.0),
        Order(Arm()),
        See(refused(), 1.0),
        See(MOTORS_OFF, 2.0, lasts=True),
        Drone(well),
        See(absent(check_fails(check)), 30.0),
    )


def _ends_a_return(put: dict[str, Any], word: str, within_s: float) -> tuple[Act | See, ...]:
    """Return the steps of a fault while the drone returns: the drone is down already, or holds or lands for it."""
    return (
        Drone(put),
        See(either(DOWN, both(state(_HOVER, _LAND), warned(word))), within_s),
        Order(Land()),
        See(DOWN, 120.0),
    )


def _held_by_camera(put: dict[str, Any], within_s: float, metres: float) -> tuple[Act | See, ...]:
    """Return the steps of a walk while the drone hovers: it is reported, and the drone is held where it was."""
    return (
        Drone(put),
        See(warned("camera sees"), within_s),
        See(both(stayed(metres), _HELD), 25.0, lasts=True),
    )


SLOW: Final = (
    Fault(
        "GNSS walks at 0.1 m/s, the autopilot with it",
        When.HOVERING,
        _held_by_camera({"gps_walk": (0.06, -0.08)}, 110.0, 14.0),
        ends_flight=True,
        answer=answers.GNSS_SLOW_WALK,
    ),
    Fault(
        "GNSS walks at 0.25 m/s, the autopilot with it",
        When.HOVERING,
        _held_by_camera({"gps_walk": (0.15, 0.2)}, 40.0, 12.0),
        ends_flight=True,
        answer=answers.GNSS_SLOW_WALK,
    ),
    Fault(
        "GNSS walks at 0.25 m/s over ground without texture",
        When.HOVERING,
        _held_by_camera({"gps_walk": (0.25, 0.0), "camera_contrast": 0.3}, 40.0, 12.0),
        ends_flight=True,
        answer=answers.GNSS_SLOW_WALK,
    ),
    Fault(
        "GNSS walks at 0.7 m/s in a flight's first hover, in wind",
        When.HOVERING,
        _held_by_camera({"gps_walk": (-0.7, 0.0), "wind": 8.0}, 15.0, 12.0),
        ends_flight=True,
        answer=answers.GNSS_SLOW_WALK,
    ),
    Fault(
        "GNSS walks at 0.7 m/s while every fourth picture shows nothing",
        When.HOVERING,
        _held_by_camera({"gps_walk": (0.0, 0.7), "camera_blank_every": 4}, 15.0, 12.0),
        ends_flight=True,
        answer=answers.GNSS_SLOW_WALK,
    ),
    Fault(
        "GNSS has walked at 0.25 m/s, then the battery falls to 15 %",
        When.HOVERING,
        (
            *_held_by_camera({"gps_walk": (0.25, 0.0)}, 40.0, 12.0),
            Drone({"battery": 15.0}),
            See(either(DOWN, state(_LAND)), 15.0),
            See(DOWN, 120.0),
        ),
        ends_flight=True,
        answer=answers.GNSS_SLOW_WALK,
    ),
    Fault(
        "the camera sees nothing for 15 s",
        When.HOVERING,
        (
            Drone({"camera_contrast": 0.0}),
            See(warned("no second witness"), 15.0),
            See(both(UP, state(_HOVER), stayed(3.0)), 5.0, lasts=True),
            Drone({"camera_contrast": 1.0}),
            See(healthy("witness"), 10.0),
        ),
        answer=answers.NO_WITNESS,
    ),
)

PLACE: Final = (
    Fault(
        "GNSS walks north at 0.7 m/s, the autopilot with it",
        When.HOVERING,
        (
            Drone({"gps_walk": (0.7, 0.0)}),
            See(warned("position", "camera", "place"), 20.0),
            See(both(stayed(20.0), _HELD), 40.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.GNSS_WALK,
    ),
    Fault(
        "GNSS walks west at 0.7 m/s, the autopilot with it",
        When.EXPLORING,
        (
            See(_GOES_ON, 8.0, lasts=True),  # the camera is seen to agree first
            Drone({"gps_walk": (0.0, -0.7)}),
            See(_STOPPED, 20.0),
            CountAgain(),
            See(both(stayed(15.0), _HELD), 30.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.GNSS_WALK,
    ),
    Fault(
        "GNSS walks south-east at 1.4 m/s for 12 s, from the first metre of the task on",
        When.EXPLORING,
        (
            Drone({"gps_walk": (-1.0, 1.0)}),
            See(_STOPPED, 12.0),
            Drone({"gps_walk": (0.0, 0.0)}),
            See(_HELD, 15.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.GNSS_WALK,
    ),
    Fault(
        "GNSS walks at 0.7 m/s while the drone returns",
        When.RETURNING,
        _ends_a_return({"gps_walk": (0.5, 0.5)}, "camera sees", 45.0),
        ends_flight=True,
        answer=answers.GNSS_WALK,
    ),
    Fault(
        "GNSS wanders at 0.04 m/s",
        When.EXPLORING,
        (Drone({"gps_walk": (0.04, 0.0)}), See(_GOES_ON, 20.0, lasts=True)),
        answer=answers.GNSS_SMALL_ERROR,
    ),
    Fault(
        "GNSS is off by 10 m from the boot on",
        When.GROUND,
        (
            Drone({"gps_bias": (8.0, -6.0, 4.0), "autopilot": "reboot"}),
            CountAgain(),
            See(check_fails("GPS"), 20.0),  # the autopilot is away
            See(both(absent(check_fails("GPS")), healthy("position")), 60.0),
            Bring(When.HOVERING),
            See(both(UP, state(_HOVER), stayed(3.0)), 8.0, lasts=True),
            Order(ReturnToLaunch()),
            See(both(DOWN, stayed(3.0)), 120.0),
        ),
        ends_flight=True,
        answer=answers.GNSS_SMALL_ERROR,
    ),
    Fault(
        "GNSS is off by 25 m for 4 s",
        When.HOVERING,
        (
            Drone({"gps_glitch": (25.0, 0.0, 0.0), "gps_glitch_s": 4.0}),
            See(both(UP, stayed(4.0)), 15.0, lasts=True),
            See(state(_HOVER), 16.0),
        ),
        answer=answers.GNSS_SMALL_ERROR,
    ),
    Fault(
        "GNSS is off by 30 m and stays so",
        When.EXPLORING,
        (
            Drone({"gps_glitch": (0.0, 30.0, 0.0)}),
            See(_STOPPED, 6.0),
            See(warned("position"), 6.0),
            See(_HELD, 15.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.POSITION_JUMP,
    ),
    Fault(
        "GNSS steps by 1.5 m",
        When.EXPLORING,
        (Drone({"gps_bias": (1.5, 0.0, 0.0)}), See(_GOES_ON, 15.0, lasts=True)),
        answer=answers.GNSS_SMALL_ERROR,
    ),
    Fault(
        "GNSS is lost",
        When.RETURNING,
        (Drone({"gps": "lost"}), See(mode("LAND"), 25.0), See(DOWN, 90.0)),
        ends_flight=True,
        answer=answers.GNSS_LOST,
    ),
)

HEIGHT: Final = (
    Fault(
        "the barometer rises by 0.5 m/s",
        When.HOVERING,
        (
            Drone({"baro_drift": 0.5}),
            See(warned("height", "altitude", "barometer"), 20.0),
            See(either(DOWN, truly_between(8.0, 30.0)), 40.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.BAROMETER_DRIFT,
    ),
    Fault(
        "the barometer rises by 0.5 m/s",
        When.EXPLORING,
        (
            Drone({"baro_drift": 0.5}),
            See(both(_STOPPED, warned("height", "altitude", "barometer")), 20.0),
            See(absent(both(state(_EXPLORE), lower_than(8.0))), 30.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.BAROMETER_DRIFT,
    ),
    Fault(
        "the barometer falls by 0.5 m/s",
        When.EXPLORING,
        (
            Drone({"baro_drift": -0.5}),
            See(both(_STOPPED, warned("height", "altitude", "barometer")), 20.0),
            See(either(DOWN, truly_between(0.0, 40.0)), 30.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.BAROMETER_DRIFT,
    ),
    Fault(
        "the barometer rises by 0.5 m/s while the drone returns",
        When.RETURNING,
        _ends_a_return({"baro_drift": 0.5}, "height", 40.0),
        ends_flight=True,
        answer=answers.BAROMETER_DRIFT,
    ),
    Fault(
        "the barometer rises by 0.05 m/s, too slowly for the camera's minute",
        When.HOVERING,
        (
            See(both(UP, state(_HOVER)), 45.0, lasts=True),  # the usual size of the stalls is known then
            Drone({"baro_drift": 0.05}),
            See(warned("height is not what"), 150.0),
            See(both(UP, truly_between(12.0, 24.0)), 20.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.BAROMETER_DRIFT,
    ),
    Fault(
        "the barometer steps by 6 m",
        When.EXPLORING,
        (
            Drone({"baro_error": 6.0}),
            See(_STOPPED, 20.0),
            See(warned("height", "altitude", "barometer"), 20.0),
        ),
        ends_flight=True,
        answer=answers.BAROMETER_DRIFT,
    ),
    Fault(
        "the barometer rises by 0.02 m/s, as with the weather",
        When.EXPLORING,
        (Drone({"baro_drift": 0.02}), See(_GOES_ON, 25.0, lasts=True)),
        answer=answers.BAROMETER_WEATHER,
    ),
    Fault(
        "the barometer rises by 0.2 m/s before the flight",
        When.GROUND,
        (
            Drone({"baro_drift": 0.2}),
            See(both(absent(UP), state(_IDLE)), 20.0, lasts=True),
            Drone({"baro_drift": 0.0}),
            See(both(absent(UP), state(_IDLE)), 5.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.BAROMETER_WEATHER,
    ),
)

HEADING: Final = (
    Fault(
        "all compasses fail for 20 s",
        When.HOVERING,
        (
            Drone({"compass": "lost"}),
            See(warned("ompass", "eading"), 10.0),
            See(both(UP, stayed(3.0)), 10.0, lasts=True),
            Drone({"compass": "ok"}),
            See(both(UP, state(_HOVER)), 10.0),
        ),
        ends_flight=True,
        answer=answers.COMPASSES_FAIL,
    ),
    Fault(
        "all compasses fail",
        When.EXPLORING,
        (Drone({"compass": "lost"}), See(both(UP, warned("ompass", "eading")), 10.0)),
        ends_flight=True,
        answer=answers.COMPASSES_FAIL,
    ),
    Fault(
        "all compasses fail on the ground",
        When.GROUND,
        (
            Drone({"compass": "lost"}),
            See(warned("ompass", "eading"), 10.0),
            Order(Arm()),
            See(refused(), 1.0),
            Drone({"compass": "ok"}),
            See(both(healthy("compass"), absent(check_fails("Autopilot"))), 20.0),
        ),
        answer=answers.COMPASSES_FAIL,
    ),
    Fault(
        "all compasses turn by 45°",
        When.EXPLORING,
        (
            Drone({"compass_error_deg": 45.0}),
            See(_STOPPED, 10.0),
            CountAgain(),
            See(both(UP, stayed(25.0)), 20.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.COMPASSES_TURN,
    ),
    Fault(
        "all compasses turn by −60°",
        When.HOVERING,
        (
            Drone({"compass_error_deg": -60.0}),
            See(warned("position", "ompass", "eading", "camera"), 10.0),
            See(both(UP, stayed(30.0)), 25.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.COMPASSES_TURN,
    ),
)

BATTERY: Final = (
    Fault(
        "an old battery sags to 3.25 V a cell under load",
        When.EXPLORING,
        (
            Drone({"battery_resistance_ohm": 0.18}),
            See(both(_STOPPED, warned("attery", "V a cell")), 20.0),
            See(either(DOWN, state(_RETURN, _LAND)), 25.0),
        ),
        ends_flight=True,
        answer=answers.VOLTAGE_SAG,
    ),
    Fault(
        "a battery sags to 3.1 V a cell",
        When.HOVERING,
        (
            Drone({"battery_rest_v": 9.48}),
            See(mode("LAND", "RTL"), 15.0),
            See(DOWN, 90.0),
        ),
        ends_flight=True,
        answer=answers.VOLTAGE_SAG,
    ),
    Fault(
        "a battery sags to 3.1 V a cell for 2 s, in a gust",
        When.HOVERING,
        (
            Drone({"battery_rest_v": 9.48}),
            See(UP, 1.5, lasts=True),
            Drone({"battery_rest_v": 0.0}),
            See(both(UP, state(_HOVER)), 15.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.VOLTAGE_SAG,
    ),
    Fault(
        "the counter of charge stands still",
        When.EXPLORING,
        (Drone({"battery_counter": "still"}), See(warned("attery", "harge"), 90.0)),
        ends_flight=True,
        answer=answers.CHARGE_COUNTER,
    ),
    Fault(
        "the counter of charge begins at 100 % again",
        When.EXPLORING,
        (
            Drone({"battery": 55.0}),
            See(UP, 3.0, lasts=True),
            Drone({"battery_counter": "restart"}),
            See(warned("attery", "harge"), 15.0),
        ),
        ends_flight=True,
        answer=answers.CHARGE_COUNTER,
    ),
    Fault(
        "the true charge is 8 % and the counter says 100 %",
        When.EXPLORING,
        (Drone({"battery_charge": 8.0}), See(both(_STOPPED, mode("RTL", "LAND")), 16.0), See(DOWN, 120.0)),
        ends_flight=True,
        answer=answers.CHARGE_LOW,
    ),
    Fault(
        "11.0 V and “100 %” on the ground",
        When.GROUND,
        _refuses_arm({"battery_charge": 40.0}, "Battery", {"battery": 100.0}),
        answer=answers.BATTERY_ON_GROUND,
    ),
    Fault(
        "3.53 V a cell on the ground",
        When.GROUND,
        _refuses_arm({"battery_rest_v": 10.6}, "Battery", {"battery_rest_v": 0.0}),
        answer=answers.BATTERY_ON_GROUND,
    ),
    Fault(
        "no voltage is measured on the ground",
        When.GROUND,
        _refuses_arm({"battery_rest_v": 0.02}, "Battery", {"battery_rest_v": 0.0}),
        answer=answers.BATTERY_ON_GROUND,
    ),
    Fault(
        "two cells in place of three",
        When.GROUND,
        _refuses_arm({"battery_cells": 2}, "Battery thresholds", {"battery_cells": 3}),
        answer=answers.BATTERY_ON_GROUND,
    ),
    Fault(
        "four cells where the autopilot's threshold is for three",
        When.GROUND,
        (
            Bring(When.ARMED),
            Bring(When.GROUND),
            See(absent(warned("attery", "BATT_")), 5.0),
            Drone({"battery_cells": 4}),
            See(warned("attery", "BATT_"), 15.0),
            Order(Arm()),
            See(refused(), 1.0),
            Drone({"battery_cells": 3}),
        ),
        ends_flight=True,
        answer=answers.BATTERY_ON_GROUND,
    ),
)

PICTURES: Final = (
    Fault(
        "3 kB are lost within one picture of ten",
        When.EXPLORING,
        (Drone({"camera": "damaged"}), See(_GOES_ON, 15.0, lasts=True)),
        answer=answers.PICTURE_DAMAGE,
    ),
    Fault(
        "the camera's stamps step back by 0.5 s",
        When.EXPLORING,
        (Drone({"camera_stamp_step_s": -0.5}), See(UP, 20.0, lasts=True)),
        ends_flight=True,
        answer=answers.PICTURE_DAMAGE,
    ),
    Fault(
        "the camera's stamps step ahead by 0.9 s",
        When.EXPLORING,
        (Drone({"camera_stamp_step_s": 0.9}), See(UP, 20.0, lasts=True)),
        ends_flight=True,
        answer=answers.PICTURE_DAMAGE,
    ),
    Fault(
        "pictures claim an EXIF orientation",
        When.EXPLORING,
        (
            Drone({"camera_orientation": 6}),
            See(either(_GOES_ON, warned("rientation", "camera", "turned")), 15.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.PICTURE_DAMAGE,
    ),
    Fault(
        "4000 bytes follow each picture's end",
        When.EXPLORING,
        (Drone({"camera_tail_bytes": 4000}), See(_GOES_ON, 12.0, lasts=True)),
        answer=answers.PICTURE_DAMAGE,
    ),
    Fault(
        "the camera sends no picture while the drone returns",
        When.RETURNING,
        (Drone({"camera": "dark"}), See(both(state(_RETURN), mode("RTL")), 5.0, lasts=True), See(DOWN, 120.0)),
        answer=answers.NO_PICTURE_ON_RETURN,
    ),
)

SENSORS: Final = (*PLACE, *SLOW, *HEIGHT, *HEADING, *BATTERY, *PICTURES)
