"""Flights of a real ArduCopter, each with a required end and time."""

from __future__ import annotations

import signal
from typing import Final

from hawk.comm.autopilot.commands import MavCommand
from hawk.comm.protocol.commands import Arm, AutonomousExplore, CompulsiveMove, ReturnToLaunch
from hawk.ddc.readings.sight import PERCEPTION_PARTS
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode
from proving.faults.fault import (
    DOWN,
    FELL,
    INSIDE,
    MOTORS_OFF,
    SILENT,
    UP,
    CountAgain,
    Drone,
    Fault,
    KillMotors,
    Link,
    Order,
    Return,
    See,
    Sight,
    Signal,
    StartAgain,
    Station,
    Survey,
    When,
    absent,
    asked,
    both,
    dropped,
    either,
    healthy,
    lower_than,
    mode,
    near_home,
    refused,
    reported,
    restarted,
    sent,
    state,
    stayed_within,
    surveyed,
    unhealthy,
)
from proving.faults.proxy import Direction
from proving.faults.sights import stayed, truly_between
from proving.faults.station import FORCE, command_fields, parameter_fields

_HOVER, _EXPLORE, _RETURN = StateName.HOVER, StateName.AUTONOMOUS_EXPLORE, StateName.RETURN_TO_LAUNCH
_MANUAL, _IDLE, _LOST = StateName.MANUAL, StateName.IDLE, StateName.COMMUNICATION_LOST
_MOVE: Final = StateName.COMPULSIVE_MOVE
_SENT_HOME: Final = asked(MavCommand.DO_SET_MODE, "RTL sent")
_HOLDS: Final = mode("GUIDED", "BRAKE")
_BEFORE_FAILSAFE_S: Final = 4.5
"""A daemon that is started again within this time is back before the autopilot's ground-station failsafe (5 s) acts."""
_GUST_M_S, _EAST_DEG = 16.0, 90.0
"""More than ArduCopter's greatest lean (30°) holds against."""
_EDGE: Final = CompulsiveMove(x=0.0, y=32.0, frame="Map")
"""Some metres inside the eastern limit of the drawn lot's fence."""
_OUTSIDE_M: Final = 10.0
_OUTSIDE: Final = Sight("outside the fence", lambda m: m.truth["outside"] > 0.0)


def _switch(to: CopterMode) -> Station:
    return Station("COMMAND_LONG", command_fields(MavCommand.DO_SET_MODE, 1.0, float(to)))


def _left_alone(state_name: StateName, *modes: CopterMode, seconds: float) -> tuple[CountAgain, See]:
    """Return the steps that see a state and a mode shown, and nothing commanded, for so long."""
    return CountAgain(), See(both(state(state_name), mode(*(each.name for each in modes)), SILENT), seconds, lasts=True)


SURVEY: Final = Fault(
    "a whole survey",
    When.GROUND,
    (Survey(), See(surveyed(recall=0.9, precision=0.9), 420.0), See(both(DOWN, state(_IDLE)), 420.0)),
)
SECOND_STATION: Final = Fault(
    "a second station takes LOITER and ALT_HOLD, sends it home, and gives it back",
    When.EXPLORING,
    (
        Drone({"stick": 0.5}),  # with the stick down, LOITER and ALT_HOLD descend
        _switch(CopterMode.LOITER),
        See(state(_MANUAL), 2.0),
        *_left_alone(_MANUAL, CopterMode.LOITER, seconds=5.0),
        _switch(CopterMode.ALT_HOLD),
        See(mode("ALT_HOLD"), 2.0),
        *_left_alone(_MANUAL, CopterMode.ALT_HOLD, seconds=5.0),
        _switch(CopterMode.GUIDED),
        See(state(_HOVER), 2.0),
        _switch(CopterMode.RTL),
        See(state(_RETURN), 2.0),
        *_left_alone(_RETURN, CopterMode.RTL, seconds=5.0),
        _switch(CopterMode.GUIDED),
        See(both(state(_HOVER), UP), 2.0),
        Drone({"stick": 0.0}),
    ),
)
GUST: Final = Fault(
    "a gust of 16 m/s pushes it over the fence",
    When.HOVERING,
    (
        Order(_EDGE),
        See(state(_MOVE), 2.0),
        See(state(_HOVER), 40.0),
        Drone({"wind": _GUST_M_S, "wind_heading_deg": _EAST_DEG}),
        See(_OUTSIDE, 20.0),
        See(either(reported("utside the fence"), mode("RTL")), 20.0),
        Drone({"wind": 0.0}),
        See(INSIDE, 30.0),
        Order(ReturnToLaunch(confirmed=True)),
        See(DOWN, 120.0),
        See(both(state(_IDLE), stayed_within(_OUTSIDE_M)), 125.0),
    ),
)
UNHEARD: Final = Fault(
    "the autopilot is not heard, it hears us",
    When.HOVERING,
    (
        Link((dropped(Direction.DOWN),)),
        See(_SENT_HOME, 4.0),
        See(mode("RTL"), 5.0),
        CountAgain(),
        See(absent(sent("HEARTBEAT")), 5.0, lasts=True),
        See(DOWN, 120.0),
        Link(),
        See(state(_IDLE), 10.0),
    ),
)
RESTART: Final = Fault(
    "our program is killed and started again",
    When.EXPLORING,
    (
        Signal(signal.SIGKILL),
        See(both(restarted(), state(_HOVER, _LOST), _HOLDS), _BEFORE_FAILSAFE_S, real=True),
        See(both(_HOLDS, UP), 5.0, lasts=True),
        Return(),
        See(state(_HOVER), 5.0),
        See(both(*(healthy(part) for part in PERCEPTION_PARTS)), 45.0, real=True),
        Order(AutonomousExplore()),
        See(state(_EXPLORE), 5.0),
        See(both(state(_EXPLORE), UP), 5.0, lasts=True),
    ),
)
KILLED: Final = Fault(
    "our program is killed and stays away",
    When.EXPLORING,
    (
        Signal(signal.SIGKILL, withheld=True),
        See(mode("RTL"), 8.0, real=True),
        See(DOWN, 120.0, real=True),
        StartAgain(),
        See(both(restarted(), state(_IDLE)), 15.0, real=True),
        See(both(healthy("vision"), healthy("mapper")), 45.0, real=True),  # the map is back then
    ),
)
RESERVE: Final = Fault(
    "the battery falls to 21 %",
    When.EXPLORING,
    (
        Drone({"battery": 21.0}),
        See(both(_SENT_HOME, reported("battery is needed")), 10.0),
        See(both(mode("RTL"), state(_RETURN)), 10.0),
        See(DOWN, 120.0),
    ),
)
LOW_VOLTAGE: Final = Fault(
    "the battery's voltage falls below BATT_LOW_VOLT",
    When.EXPLORING,
    (
        Station("PARAM_SET", parameter_fields("SIM_BATT_VOLTAGE", 10.4)),
        See(mode("RTL"), 16.0),
        See(both(state(_RETURN), reported("Battery")), 18.0),
        CountAgain(),
        See(both(mode("RTL", "LAND"), state(_RETURN, StateName.LAND), SILENT), 10.0, lasts=True),
        See(DOWN, 120.0),
        See(both(state(_IDLE), SILENT), 125.0),
    ),
    ends_flight=True,
)
KILL: Final = Fault(
    "the operator cuts the motors",
    When.HOVERING,
    (KillMotors(), See(MOTORS_OFF, 1.0), See(FELL, 10.0), See(both(state(_IDLE), MOTORS_OFF), 15.0)),
    ends_flight=True,
    falls=True,
)

CUT_BY_ANOTHER: Final = Fault(
    "a second station cuts the motors in the air",
    When.HOVERING,
    (
        Station("COMMAND_LONG", command_fields(MavCommand.COMPONENT_ARM_DISARM, 0.0, FORCE)),
        See(MOTORS_OFF, 1.5),
        See(reported("otors off in the air"), 4.0),
        See(both(FELL, state(_IDLE), absent(reported("Landed. Motors off"))), 10.0),
        Order(Arm()),
        See(refused("went off in the air"), 1.0),
    ),
    ends_flight=True,
    falls=True,
)
SAG: Final = Fault(
    "the battery's voltage sags to 3.1 V a cell",
    When.EXPLORING,
    (
        Station("PARAM_SET", parameter_fields("SIM_BATT_VOLTAGE", 9.3)),
        See(both(mode("LAND"), state(StateName.LAND), reported("voltage sags")), 8.0),
        See(DOWN, 90.0),
        See(both(state(_IDLE), reported("Landed. Motors off")), 95.0),
    ),
    ends_flight=True,
)
_RIGHT_AGAIN: Final = reported("is right again")
_GOES_ON: Final = both(state(_EXPLORE), UP)
_RETURNS_HOME: Final = (
    Order(ReturnToLaunch(confirmed=True)),
    See(mode("RTL"), 10.0),
    See(both(DOWN, near_home(3.0)), 120.0),
    See(state(_IDLE), 125.0),
)
BATTERY_ACTION: Final = Fault(
    "another station sets BATT_FS_LOW_ACT 5, then the voltage falls",
    When.EXPLORING,
    (
        Drone({"parameters": {"BATT_FS_LOW_ACT": 5.0}}),
        See(reported("cuts the motors (BATT_FS_LOW_ACT 5)"), 10.0),
        See(both(reported("Battery failsafe is right again"), _GOES_ON), 12.0),
        Station("PARAM_SET", parameter_fields("SIM_BATT_VOLTAGE", 10.3)),
        See(both(mode("RTL"), UP), 16.0),
        See(DOWN, 120.0),
        See(state(_IDLE), 125.0),
    ),
    ends_flight=True,
)
RETURN_ALTITUDE: Final = Fault(
    "another station sets RTL_ALT to 300 m, then it returns",
    When.EXPLORING,
    (
        Drone({"parameters": {"RTL_ALT": 30_000.0}}),
        See(reported("Return height: 300 m"), 10.0),
        See(both(reported("Return height is right again"), _GOES_ON), 12.0),
        *_RETURNS_HOME[:2],
        See(lower_than(45.0), 20.0, lasts=True),
        *_RETURNS_HOME[2:],
    ),
)
FENCE_CLEARED: Final = Fault(
    "another station clears the fence",
    When.EXPLORING,
    (
        Drone({"fence": []}),
        See(reported("The fence in the autopilot was changed"), 10.0),
        See(both(reported("is in the autopilot again"), _GOES_ON), 20.0),
        See(_GOES_ON, 5.0, lasts=True),
    ),
)
FENCE_OFF: Final = Fault(
    "another station switches the fence off by a command",
    When.EXPLORING,
    (
        Station("COMMAND_LONG", command_fields(MavCommand.DO_FENCE_ENABLE, 0.0)),
        See(reported("Fence in the autopilot: "), 10.0),
        See(both(reported("Fence in the autopilot is right again"), _GOES_ON), 12.0),
        See(_GOES_ON, 5.0, lasts=True),
    ),
)
FENCE_REPLACED: Final = Fault(
    "another station replaces the fence by a larger one",
    When.EXPLORING,
    (
        Drone({"fence": [(-500.0, -500.0), (-500.0, 500.0), (500.0, 500.0), (500.0, -500.0)]}),
        See(reported("The fence in the autopilot was changed"), 12.0),
        See(both(reported("is in the autopilot again"), _GOES_ON), 22.0),
        See(_GOES_ON, 5.0, lasts=True),
    ),
)
RALLY_POINT: Final = Fault(
    "another station sets a rally point 44 m from home, then it returns",
    When.EXPLORING,
    (
        Drone({"rally": [(44.0, 0.0, 25.0)]}),
        See(reported("to a rally point where one is nearer"), 10.0),
        See(both(_RIGHT_AGAIN, _GOES_ON), 14.0),
        *_RETURNS_HOME,
    ),
)

_TRULY_HELD: Final = either(DOWN, both(UP, state(_HOVER, StateName.LAND), absent(mode("RTL"))))
GNSS_WALKS: Final = Fault(
    "GNSS walks at 0.7 m/s, all flags good",
    When.EXPLORING,
    (
        See(both(UP, state(_EXPLORE)), 20.0, lasts=True),  # the camera is seen to agree first
        Drone({"gps_walk": (0.5, -0.5)}),
        See(both(state(_HOVER), unhealthy("position", "camera sees")), 15.0),
        CountAgain(),
        See(both(_TRULY_HELD, stayed(12.0)), 25.0, lasts=True),
    ),
    ends_flight=True,
)
BAROMETER_DRIFTS: Final = Fault(
    "the barometer rises by 0.5 m/s, all flags good",
    When.HOVERING,
    (
        Drone({"baro_drift": 0.5}),
        See(unhealthy("position", "truly about"), 20.0),
        See(both(_TRULY_HELD, truly_between(8.0, 30.0)), 25.0, lasts=True),
    ),
    ends_flight=True,
)
NO_COMPASS: Final = Fault(
    "all compasses fail for 20 s",
    When.EXPLORING,
    (
        Drone({"compass": "lost"}),
        See(unhealthy("compass"), 10.0),
        See(both(UP, state(_EXPLORE)), 10.0, lasts=True),
        Drone({"compass": "ok"}),
        See(healthy("compass"), 20.0),
    ),
    ends_flight=True,
)

WITNESSES: Final = (GNSS_WALKS, BAROMETER_DRIFTS, NO_COMPASS)
KEPT: Final = (BATTERY_ACTION, RETURN_ALTITUDE, FENCE_CLEARED, FENCE_OFF, FENCE_REPLACED, RALLY_POINT)
VEHICLE: Final = (
    SURVEY,
    SECOND_STATION,
    GUST,
    UNHEARD,
    RESTART,
    KILLED,
    RESERVE,
    LOW_VOLTAGE,
    SAG,
    *KEPT,
    *WITNESSES,
    KILL,
    CUT_BY_ANOTHER,
)
