"""The autopilot's own failsafes: what is left when this computer dies. Which parameters must say what.

The values and their meaning are those of ArduPilot's parameter documentation for Copter 4.5 to 4.7
(ArduCopter/Parameters.cpp, AC_Fence/AC_Fence.cpp, AP_BattMonitor/AP_BattMonitor_Params.cpp, GCS_MAVLink/GCS.cpp). A
value passes only when it is listed here: a new one is unsafe until somebody has read what it does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from hawk.ddc.battery.chemistry import LIPO, Chemistry
from hawk.ddc.parameters.values import (
    ALL_RETURN_NAMES,
    NOT_READ,
    OPTIONAL_RETURN_NAMES,
    RALLY_NAME,
    RETURN_ALTITUDE_NAMES,
    RETURN_CHECK,
    RETURN_HEIGHT,
    THRESHOLD_NAMES,
    Choice,
    FailsafeCheck,
    Span,
    Values,
    names_to_read,
    present_name,
    problem_of,
    return_check,
    return_names,
    threshold_problem,
    threshold_words,
    wanted_returns,
)
from hawk.ddc.readings.remote_control import SWITCH_NAMES
from hawk.model.sentences import say

GROUND_STATION = say("Ground-station failsafe")
PILOT = say("Pilot keeps control")
REMOTE_CONTROL = say("Remote-control failsafe")
POSITION = say("Position failsafe")
FENCE = say("Fence in the autopilot")
BATTERY = say("Battery failsafe")
THRESHOLDS = say("Battery thresholds")
"""Names of the checks; those of the return are in `hawk.ddc.parameters.values`."""
WATCHED_ID_NAMES = ("MAV_GCS_SYSID", "SYSID_MYGCS")
"""The parameter with the id that the ground-station failsafe watches: since ArduPilot 4.7, and before."""
HIGHEST_ID_NAME = "MAV_GCS_SYSID_HI"
"""End of the range of watched ids, since ArduPilot 4.7 (GCS::sysid_is_gcs): at or below the first id there is none."""
SPARE_PILOT_BIT = 16
"""FS_OPTIONS bit 4: continue in pilot-controlled modes on ground-station failsafe."""
CEILING_NAME = "FENCE_ALT_MAX"
"""The autopilot's ceiling, metres above home; the upload of the fence sets it."""
CORNERS_NAME = "FENCE_TOTAL"
"""Number of items of the autopilot's fence. It decides nothing: a change of it asks for a comparison of the fence."""
FENCE_NAMES = ("FENCE_TYPE", "FENCE_ACTION", CEILING_NAME, "FENCE_ENABLE")
"""Parameters of the fence: ceiling and polygon first, then what it does, enabled last."""
CEILING_TOLERANCE_M = 0.1
MAY_BE_MISSING = frozenset({HIGHEST_ID_NAME, RALLY_NAME, CORNERS_NAME, *OPTIONAL_RETURN_NAMES})
"""Parameters that an autopilot of the versions 4.5 to 4.7 may lack without an older name for them."""


@dataclass(frozen=True, slots=True)
class AutopilotView:
    """Facts about the autopilot that a value is compared with.

    ``system_id`` is our MAVLink id. ``cells``: the cell counts that the battery may have. ``fence_on``: SYS_STATUS says
    that a fence is enabled (a switch or a command may turn it off without a change of FENCE_ENABLE); None: not heard.
    ``needs_remote_control``: False where the drone is flown without one, and its failsafe may be off.
    ``limits``: None before a flight.
    """

    system_id: int
    cells: tuple[int, ...] = ()
    fence_on: bool | None = None
    needs_remote_control: bool = True
    chemistry: Chemistry = LIPO
    limits: FlightLimits | None = None


@dataclass(frozen=True, slots=True)
class FlightLimits:
    """Limits of a flight under way, metres above the arm place: our ceiling, and the autopilot's."""

    ceiling: float
    autopilot_ceiling: float


_RETURNS = say("returns home")
_LANDS = say("lands")
_OFF = say("off")
_REPORTS = say("only reports")
_CUTS = say("cuts the motors")
_GOES_ON = say("goes on in Auto")
_ELSEWHERE = say("flies a stored mission's landing (DO_LAND_START), wherever that is")
_STAYS = say("stops and stays in the air")  # "Brake or Land" lands only where Brake cannot be entered
GCS_ACTION = Choice(
    "FS_GCS_ENABLE",
    {1: _RETURNS, 3: _RETURNS, 4: _RETURNS, 5: _LANDS},
    {0: _OFF, 2: _GOES_ON, 6: _ELSEWHERE, 7: _STAYS},
    1,
)
GCS_TIMEOUT = Span("FS_GCS_TIMEOUT", 3, 10, 5, " s")
"""Below 3 s two lost heartbeats of 1 Hz trigger it; after 10 s a drone at travel speed is 40 m farther on."""
RADIO_ACTION = Choice(
    "FS_THR_ENABLE",
    {1: _RETURNS, 3: _LANDS, 4: _RETURNS, 5: _RETURNS},
    {0: _OFF, 2: _GOES_ON, 6: _ELSEWHERE, 7: _STAYS},
    1,
)
EKF_ACTION = Choice(
    "FS_EKF_ACTION", {1: _LANDS, 3: _LANDS}, {0: _REPORTS, 2: say("drifts without a position in AltHold")}, 1
)
EKF_THRESHOLD = Span("FS_EKF_THRESH", 0.59, 1.01, 0.8)
"""The documented values are 0.6, 0.8 and 1.0 (single precision on the wire); 0 turns the failsafe off."""
FENCE_TYPE = Choice(
    "FENCE_TYPE", {5: say("ceiling and polygon"), 7: say("ceiling, circle and polygon")}, {0: say("no fence")}, 5
)
"""Bit 0 ceiling, bit 1 circle around home, bit 2 polygon, bit 3 floor (which a landing breaches)."""
FENCE_ACTION = Choice(
    "FENCE_ACTION",
    {1: _RETURNS, 2: _LANDS, 3: _RETURNS, 4: say("stops"), 5: _RETURNS},
    {0: _REPORTS},
    1,
)
FENCE_ENABLE = Choice("FENCE_ENABLE", {1: say("on")}, {0: _OFF}, 1)
LOW_ACTION = Choice(
    "BATT_FS_LOW_ACT",
    {1: _LANDS, 2: _RETURNS, 3: _RETURNS, 4: _RETURNS},
    {0: _OFF, 5: _CUTS, 6: _ELSEWHERE, 7: _STAYS},
    2,
)
CRITICAL_ACTION = Choice(
    "BATT_FS_CRT_ACT",
    {0: _OFF, 1: _LANDS, 2: _RETURNS, 3: _RETURNS, 4: _RETURNS},
    {5: _CUTS, 6: _ELSEWHERE, 7: _STAYS},
    1,
)
_SETTINGS: tuple[Choice | Span, ...] = (
    GCS_ACTION,
    GCS_TIMEOUT,
    RADIO_ACTION,
    EKF_ACTION,
    EKF_THRESHOLD,
    LOW_ACTION,
    CRITICAL_ACTION,
    FENCE_TYPE,
    FENCE_ACTION,
    FENCE_ENABLE,
)
"""The parameters that Set Failsafes may write, in its order: the fence is enabled last."""

ALL_NAMES = (
    *(setting.name for setting in _SETTINGS),
    "FS_OPTIONS",
    CEILING_NAME,
    CORNERS_NAME,
    *THRESHOLD_NAMES,
    *SWITCH_NAMES,
    *WATCHED_ID_NAMES,
    HIGHEST_ID_NAME,
    *RETURN_ALTITUDE_NAMES,
    *sorted(ALL_RETURN_NAMES),
)
"""Every parameter that decides something here, under each of its names."""

NOT_IN_EVERY_VERSION = MAY_BE_MISSING.union(WATCHED_ID_NAMES, RETURN_ALTITUDE_NAMES, ALL_RETURN_NAMES)
"""Parameters, under each of their names, that an autopilot of the versions 4.5 to 4.7 need not know."""

PARAMETERS_OF: Mapping[str, tuple[str, ...]] = {
    GROUND_STATION: (GCS_ACTION.name, GCS_TIMEOUT.name, *WATCHED_ID_NAMES, HIGHEST_ID_NAME),
    PILOT: ("FS_OPTIONS",),
    REMOTE_CONTROL: (RADIO_ACTION.name,),
    POSITION: (EKF_ACTION.name, EKF_THRESHOLD.name),
    FENCE: FENCE_NAMES,
    RETURN_CHECK: tuple(sorted(ALL_RETURN_NAMES)),
    RETURN_HEIGHT: RETURN_ALTITUDE_NAMES,
    BATTERY: (LOW_ACTION.name, CRITICAL_ACTION.name),
    THRESHOLDS: THRESHOLD_NAMES,
}
"""Check -> the parameters that decide it, in the order in which they are put back."""


def watched_names(values: Values) -> tuple[str, ...]:
    """Return the parameters that must be read, given what was read so far."""
    fixed = (*(setting.name for setting in _SETTINGS), "FS_OPTIONS", *THRESHOLD_NAMES, CEILING_NAME, CORNERS_NAME)
    watched = names_to_read(WATCHED_ID_NAMES, values)
    highest = () if watched == WATCHED_ID_NAMES[1:] else (HIGHEST_ID_NAME,)
    needed_in_flight = (*fixed, *watched, *highest, *names_to_read(RETURN_ALTITUDE_NAMES, values))
    return (*needed_in_flight, *return_names(values), *SWITCH_NAMES)


def check_failsafes(values: Values, view: AutopilotView) -> tuple[FailsafeCheck, ...]:
    """Return the check of every failsafe; what was not read yet has not passed."""
    return _checks(frozenset(values.items()), view)


@lru_cache(maxsize=8)
def _checks(read: frozenset[tuple[str, float | None]], view: AutopilotView) -> tuple[FailsafeCheck, ...]:
    """Parameters change seldom: most of the checks of a tick are those of the tick before."""
    values = dict(read)
    return (
        _ground_station(values, view.system_id),
        _spares_pilot(values),
        _remote_control(values, is_needed=view.needs_remote_control),
        _position(values),
        _fence(values, view),
        return_check(values),
        *(() if view.limits is None else (_return_height(values, view.limits),)),
        _battery(values),
        _thresholds(values, view.cells, view.chemistry),
    )


def wanted_values(values: Values, system_id: int, *, needs_remote_control: bool = True) -> dict[str, float]:
    """Return what Set Failsafes must write: parameter -> value, the right ones left out.

    Without a remote control its failsafe stays off: it would never let the drone arm. It writes no threshold of the
    battery, and deletes no rally point: nobody here knows either.
    """
    wanted: dict[str, float] = {}
    watched = present_name(WATCHED_ID_NAMES, values)
    if values.get(watched) != system_id:
        wanted[watched] = float(system_id)
    if (values.get(HIGHEST_ID_NAME) or 0) > system_id:
        wanted[HIGHEST_ID_NAME] = 0.0
    options = int(values.get("FS_OPTIONS") or 0)
    if not options & SPARE_PILOT_BIT:
        wanted["FS_OPTIONS"] = float(options | SPARE_PILOT_BIT)
    for setting in _SETTINGS:
        value = values.get(setting.name)
        if setting is RADIO_ACTION and value == 0 and not needs_remote_control:
            continue
        if value is None or setting.problem(value):
            wanted[setting.name] = float(setting.wanted)
    return wanted | wanted_returns(values)


def return_altitude(values: Values) -> float | None:
    """Return the autopilot's return altitude in metres, None while it was not read."""
    in_metres, in_centimetres = RETURN_ALTITUDE_NAMES
    found = values.get(in_metres)
    if found is not None:
        return found
    centimetres = values.get(in_centimetres)
    return None if centimetres is None else centimetres / 100.0


def _words(setting: Choice, values: Values) -> str:
    value = values.get(setting.name)
    return "" if value is None else setting.right.get(int(value), "")


def _settable(name: str, problem: str, consequence: str) -> FailsafeCheck:
    return FailsafeCheck(name, False, problem, consequence, say("Set failsafes."), can_be_set=True)


def _judged(name: str, problem: str, consequence: str, right: str) -> FailsafeCheck:
    """Return the check of parameters with a problem, else with the words of those that are right."""
    return _settable(name, problem, consequence) if problem else FailsafeCheck(name, True, right)


def _ground_station(values: Values, system_id: int) -> FailsafeCheck:
    name = GROUND_STATION
    consequence = say("If this computer stops in flight, the drone stays in the air until the battery is empty.")
    watches = values.get(present_name(WATCHED_ID_NAMES, values))
    problem = problem_of(values, GCS_ACTION, GCS_TIMEOUT)
    if watches is None or (values.get(WATCHED_ID_NAMES[0]) is not None and HIGHEST_ID_NAME not in values):
        problem = NOT_READ
    if problem or watches is None:
        return _settable(name, problem, consequence)
    highest = values.get(HIGHEST_ID_NAME) or 0.0
    if highest > watches:
        problem = say(
            "watches every station from {watches:.0f} to {highest:.0f}: any of them keeps it quiet",
            watches=watches,
            highest=highest,
        )
    elif watches != system_id:
        problem = say("watches station {watches:.0f}, this is {system_id}", watches=watches, system_id=system_id)
    right = say("{does}, watches this station ({system_id})", does=_words(GCS_ACTION, values), system_id=system_id)
    return _judged(name, problem, consequence, right)


def _spares_pilot(values: Values) -> FailsafeCheck:
    options = values.get("FS_OPTIONS")
    consequence = say("If this computer stops while a pilot flies, the drone is taken from the pilot's hands.")
    problem = NOT_READ if options is None else "" if int(options) & SPARE_PILOT_BIT else say("no")
    return _judged(PILOT, problem, consequence, say("yes"))


def _remote_control(values: Values, *, is_needed: bool) -> FailsafeCheck:
    if values.get(RADIO_ACTION.name) == 0 and not is_needed:
        return FailsafeCheck(REMOTE_CONTROL, True, say("off, no remote control is required"))
    consequence = say("If the remote control is lost while a pilot flies, nobody flies the drone.")
    return _judged(REMOTE_CONTROL, problem_of(values, RADIO_ACTION), consequence, _words(RADIO_ACTION, values))


def _position(values: Values) -> FailsafeCheck:
    consequence = say("When the autopilot loses its position, the drone drifts away.")
    return _judged(POSITION, problem_of(values, EKF_ACTION, EKF_THRESHOLD), consequence, _words(EKF_ACTION, values))


def _fence(values: Values, view: AutopilotView) -> FailsafeCheck:
    name = FENCE
    consequence = say("If the drone leaves the fence, the autopilot does nothing about it.")
    problem = problem_of(values, FENCE_ENABLE, FENCE_ACTION, FENCE_TYPE)
    if not problem and view.limits is not None:
        problem = _ceiling_problem(values, view.limits)
    if problem:
        return _settable(name, problem, consequence)
    if view.fence_on is None:
        return FailsafeCheck(name, False, NOT_READ, consequence, say("Wait."))
    if not view.fence_on:
        remedy = say("Switch it on at the remote control or the other station, or restart the autopilot.")
        return FailsafeCheck(name, False, say("switched off"), consequence, remedy, is_switched_off=True)
    return FailsafeCheck(name, True, say("on, {does}", does=_words(FENCE_ACTION, values)))


def _ceiling_problem(values: Values, limits: FlightLimits) -> str:
    """Return what is wrong with the autopilot's ceiling; one between ours and that of the upload is right."""
    value = values.get(CEILING_NAME)
    if value is None:
        return NOT_READ
    if limits.ceiling < value <= limits.autopilot_ceiling + CEILING_TOLERANCE_M:
        return ""
    return say(
        "its ceiling is {value:g} m, must be {autopilot_ceiling:g} m ({parameter})",
        value=value,
        autopilot_ceiling=limits.autopilot_ceiling,
        parameter=CEILING_NAME,
    )


def _return_height(values: Values, limits: FlightLimits) -> FailsafeCheck:
    found, problem = return_altitude(values), ""
    consequence = say("On its return the drone would leave the fence.")
    if found is None:
        return _settable(RETURN_HEIGHT, NOT_READ, consequence)
    if not 0.0 <= found <= limits.ceiling:
        problem = say("{found:g} m, must be at most {ceiling:g} m", found=found, ceiling=limits.ceiling)
    return _judged(RETURN_HEIGHT, problem, consequence, say("{found:g} m", found=found))


def _battery(values: Values) -> FailsafeCheck:
    consequence = say("With an empty battery the drone falls.")
    return _judged(BATTERY, problem_of(values, LOW_ACTION, CRITICAL_ACTION), consequence, _words(LOW_ACTION, values))


def _thresholds(values: Values, cells: tuple[int, ...], chemistry: Chemistry) -> FailsafeCheck:
    name = THRESHOLDS
    consequence = say("The autopilot notices too late, or never, that the battery is empty.")
    if any(values.get(each) is None for each in THRESHOLD_NAMES):
        return FailsafeCheck(name, False, NOT_READ, consequence, say("Wait."))
    numbers = {each: float(values[each] or 0.0) for each in THRESHOLD_NAMES}
    problem = threshold_problem(numbers, cells, chemistry)
    if problem is not None:
        return FailsafeCheck(name, False, problem.value, consequence, problem.remedy)
    return FailsafeCheck(name, True, threshold_words(numbers, cells))
