"""Preflight check: what must be well before Arm, each with its consequence and remedy. Functions of facts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from hawk.comm.protocol.heartbeat import CheckItem
from hawk.config.sections import HeightSettings
from hawk.ddc.battery.charge import cell_words
from hawk.ddc.battery.chemistry import CHEMISTRIES, LEAST_CELL_V, PACKS, Chemistry
from hawk.ddc.battery.survey import check_words
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import FenceError, contains, extent, sees_all, to_map
from hawk.ddc.fence.plan import where_outside
from hawk.ddc.parameters.failsafes import AutopilotView, FlightLimits, check_failsafes, return_altitude
from hawk.ddc.parameters.heights import heights_problem
from hawk.ddc.parameters.values import NOT_READ, RETURN_HEIGHT, FailsafeCheck, Values
from hawk.ddc.readings.clearance import slope_words
from hawk.ddc.readings.fall import fall_words
from hawk.ddc.readings.home import HOME_AGE_S, home_words
from hawk.ddc.readings.remote_control import remote_control_check
from hawk.ddc.readings.remote_id import remote_id_checks
from hawk.ddc.settings import DdcSettings
from hawk.ddc.witnesses.witness import COMPASS_LOST
from hawk.ddc.words import metres
from hawk.model.operation import Fall
from hawk.model.plans import Fence
from hawk.model.poses import GlobalPose, MapPoint
from hawk.model.sentences import say, series, words_of

GPS_FIX_3D = 3
MOTORS = say("Motors")
LINK = say("Link")
AUTOPILOT = say("Autopilot")
GPS = say("GPS")
BATTERY = say("Battery")
SURVEY = say("Survey")
CAMERA = say("Camera")
RECORDING = say("Recording")
HEIGHTS = say("Heights")
SLOPE = say("Slope")
FENCE = say("Fence")
HOME = say("Home")
"""Names of the checks; those of the failsafes are in `hawk.ddc.parameters.failsafes`."""
HOME_NEAR_M = 10.0
"""A home within this distance of the drone on the ground is at the drone, metres."""

Remedy = Literal["Set Failsafes", "Clear Kill", "Set Fence"]


@dataclass(frozen=True, slots=True)
class _Plan:
    """The fence that Arm would put in force, and the drone's place: its home."""

    fence: Fence
    home: MapPoint
    datum: GlobalPose


def preflight_items(
    facts: Facts, values: Values, settings: DdcSettings, *, is_killed: bool, fall: Fall | None = None
) -> tuple[CheckItem, ...]:
    """Return all checks in the order in which they should be put right.

    Args:
        facts: The facts of this moment, on the ground.
        values: The autopilot's parameters that were read lately.
        settings: Limits to check against.
        is_killed: The motors were cut, or went off in the air, and nobody cleared it.
        fall: They went off in the air, so.
    """
    plan = _plan(facts, settings)
    altitude = return_altitude(values)
    return (
        _kill(is_killed, fall),
        _link(facts),
        _sensors(facts),
        _gps(facts, settings.flight.maximum_hdop_m),
        _battery(facts, settings.flight.battery_arm_percent, CHEMISTRIES[settings.flight.battery_chemistry]),
        *_survey(facts),
        remote_control_check(facts.remote_control, values, settings.remote_control),
        *remote_id_checks(facts.remote_id, settings.remote_id),
        _camera(facts),
        _recording(facts),
        _heights(facts, settings.heights),
        *_slope(facts, settings.heights, plan),
        plan if isinstance(plan, CheckItem) else _fence(plan),
        _home(facts, None if isinstance(plan, CheckItem) else plan),
        _return_height(altitude, None if isinstance(plan, CheckItem) else plan),
        *(_item(check) for check in failsafe_checks(facts, values, settings)),
    )


def failsafe_checks(facts: Facts, values: Values, settings: DdcSettings) -> tuple[FailsafeCheck, ...]:
    """Return the checks of the autopilot's own failsafes, on the ground and in flight."""
    return check_failsafes(values, autopilot_view(facts, settings))


def autopilot_view(facts: Facts, settings: DdcSettings) -> AutopilotView:
    """Return what the autopilot's parameters are compared with; in flight its limits, too."""
    fence, limits = facts.limits.fence, None
    if facts.vehicle.armed and fence is not None:
        limits = FlightLimits(fence.ceiling, fence.autopilot_ceiling)
    return AutopilotView(
        settings.system_id,
        facts.battery.cells,
        facts.diagnostics.fence_on,
        settings.remote_control.required,
        CHEMISTRIES[settings.flight.battery_chemistry],
        limits,
    )


def _kill(is_killed: bool, fall: Fall | None) -> CheckItem:
    if not is_killed:
        return _passed(MOTORS, say("free to start"))
    found = say("cut") if fall is None else say("off in the air {where}", where=fall_words(fall))
    return _failed(
        MOTORS,
        found,
        say("The drone may be damaged."),
        say("Look at it, then clear the cut."),
        remedy_command="Clear Kill",
    )


def _link(facts: Facts) -> CheckItem:
    if facts.link.second_sender:
        remedy = say("Find out who sends there; name the autopilot in autopilot.vehicle_address.")
        return _failed(LINK, facts.link.second_sender, say("Somebody may forge what the drone says."), remedy)
    health = facts.health("link")
    if health.is_healthy and facts.link.is_up:
        return _passed(LINK, say("{age:.1f} s", age=facts.link.age))
    found = health.reason or say("looking at it")
    return _failed(LINK, found, say("Nothing can be commanded."), say("Switch the drone on, check its cable."))


def _sensors(facts: Facts) -> CheckItem:
    if facts.diagnostics.all_ok and not facts.is_on_ground:
        words = facts.ground.doubt or say("it is not known to be on the ground")
        return _failed(AUTOPILOT, words, say("Its landing would not be seen."), say("Wait a moment, then restart it."))
    if facts.diagnostics.compass_ok is False:
        return _failed(AUTOPILOT, COMPASS_LOST, say("It would not know where it heads."), say("Check the compasses."))
    if facts.diagnostics.all_ok:
        return _passed(AUTOPILOT, say("its sensors are well"))
    words = facts.link.words or say("its sensors are not ready")
    return _failed(AUTOPILOT, words, say("It would refuse to arm."), say("Wait a minute after switching on."))


def _gps(facts: Facts, limit: float) -> CheckItem:
    found = facts.diagnostics
    accuracy, has_fix = found.horizontal_accuracy, found.gps_fix is not None and found.gps_fix >= GPS_FIX_3D
    parts = (
        "" if has_fix else say("no fix"),
        say("{satellites} satellites", satellites=found.satellites) if found.satellites is not None else "",
        say("±{accuracy:.1f} m", accuracy=accuracy) if accuracy is not None else say("accuracy unknown"),
        found.estimator_fault,
    )
    text = series(*parts)
    good = has_fix and accuracy is not None and accuracy <= limit
    if good and found.global_position_ok and facts.health("position").is_healthy:
        return _passed(GPS, text)
    if found.is_mavlink_1 and accuracy is None:
        text = say("{text}: the link speaks MAVLink 1, which has none", text=text)
        remedy = say("Set SERIALn_PROTOCOL of the autopilot's port to 2, restart it.")
        return _failed(GPS, text, say("The drone would not know where it is."), remedy)
    return _failed(GPS, text, say("The drone would not know where it is."), say("Wait under open sky."))


def _battery(facts: Facts, needed: float, chemistry: Chemistry) -> CheckItem:
    name, battery, charge = BATTERY, facts.battery.info, facts.battery.charge
    if battery is None or battery.percentage is None:
        return _failed(name, say("not known"), say("It could fall."), say("Set up the autopilot's battery monitor."))
    if battery.voltage is None or battery.voltage < LEAST_CELL_V * PACKS[0]:
        alone = say("{percent:.0f} %, voltage not known", percent=battery.percentage)
        consequence = say("It could fall: a counter alone is no witness.")
        return _failed(name, alone, consequence, say("Set up BATT_MONITOR for voltage."))
    each = "" if charge.volts is None else cell_words(charge.volts, charge.cells)
    text = series(say("{percent:.0f} %", percent=battery.percentage), _volts(battery.voltage), each)
    if charge.volts is not None and charge.volts > chemistry.resting[1]:
        remedy = say("Set flight.battery_cells and flight.battery_chemistry, or calibrate BATT_VOLT_MULT.")
        return _failed(name, text, say("No such cell holds so much: its voltage is not known."), remedy)
    if charge.doubt:
        remedy = say("Charge the battery, or set flight.battery_cells.")
        text = say("{volts}; {doubt}", volts=_volts(battery.voltage), doubt=charge.doubt)
        return _failed(name, text, say("It would be empty sooner than its counter says."), remedy)
    lowest = battery.percentage if charge.allowed is None else min(battery.percentage, charge.allowed)
    if lowest >= needed:
        return _passed(name, text)
    if lowest < battery.percentage:
        text = say("{text}: {lowest:.0f} % at most", text=text, lowest=lowest)
    return _failed(
        name, text, say("It would have to return at once."), say("Charge it to {needed:.0f} % or more.", needed=needed)
    )


def _volts(voltage: float) -> str:
    return say("{volts:.1f} V", volts=voltage)


def _survey(facts: Facts) -> tuple[CheckItem, ...]:
    """Report whether the battery is enough for the survey. It refuses nothing: a survey goes on after a swap."""
    need = facts.battery.survey
    return () if need is None else (_passed(SURVEY, check_words(need)),)


def _camera(facts: Facts) -> CheckItem:
    health, age = facts.health("camera"), facts.sight.camera_age
    if health.is_healthy:
        text = say("on") if age is None else say("picture {age:.1f} s old", age=age)
        return _passed(CAMERA, series(text, health.reason))
    return _failed(CAMERA, health.reason, say("Nothing would be seen."), say("Check the camera and its address."))


def _recording(facts: Facts) -> CheckItem:
    health = facts.health("recording")
    if health.is_healthy:
        return _passed(RECORDING, health.reason or say("on"))
    return _failed(RECORDING, health.reason, say("The flight would not be recorded."), say("Make room on the disk."))


def _heights(facts: Facts, settings: HeightSettings) -> CheckItem:
    heights, obstacle = facts.limits.heights, settings.highest_obstacle_m
    declared = (
        say("no obstacle declared") if obstacle is None else say("highest obstacle {obstacle:g} m", obstacle=obstacle)
    )
    text = say(
        "{desired:g} m, never below {minimum:g} m or above {maximum:g} m; {declared}",
        desired=heights.desired,
        minimum=heights.minimum,
        maximum=heights.maximum,
        declared=declared,
    )
    problem = heights_problem(heights, facts.ceiling(on_ground=True), settings.floor_m)
    return _failed(HEIGHTS, text, problem, say("Change the heights.")) if problem else _passed(HEIGHTS, text)


def _slope(facts: Facts, settings: HeightSettings, plan: _Plan | CheckItem) -> tuple[CheckItem, ...]:
    """Return what the drone's tilt says about the ground; nothing on level ground. It never refuses Arm."""
    slope = facts.position.below.slope
    if slope is None or not slope.is_notable or isinstance(plan, CheckItem):
        return ()
    words = slope_words(slope, plan.fence, plan.home, facts.limits.heights.minimum, settings.highest_obstacle_m)
    return (_passed(SLOPE, words),)


def _fence(plan: _Plan) -> CheckItem:
    north, east = extent(plan.fence)
    text = say("{north:.0f} × {east:.0f} m", north=north, east=east)
    if not contains(plan.fence, plan.home):
        return _bad_fence(
            say("{size}, drone {where}", size=text, where=where_outside(plan.fence, plan.home)),
            say("It could not fly anywhere."),
        )
    return _passed(FENCE, say("{size}, drone and home inside", size=text))


def _home(facts: Facts, plan: _Plan | None) -> CheckItem:
    """Check the autopilot's home: its own failsafes fly there at any time. Arm sets it to the drone's place."""
    home = facts.position.autopilot_home
    if home.place is None or home.age > HOME_AGE_S:
        return _failed(HOME, say("not known"), say("The autopilot could not return."), say("Wait for the position."))
    if home.is_moved:
        return _failed(
            HOME, home_words(home), say("It would not return here."), say("Leave home alone with other stations.")
        )
    if plan is None:
        return _failed(HOME, say("no fence to compare it with"), say("It may be outside the fence."), say("Wait."))
    place = to_map(plan.datum, home.place.latitude, home.place.longitude)
    away = place.distance(plan.home)
    if not contains(plan.fence, place):
        remedy = say("Switch the autopilot off and on where it stands.")
        return _failed(
            HOME, say("{away} away, outside the fence", away=metres(away)), say("It would return there."), remedy
        )
    if away <= HOME_NEAR_M:
        return _passed(HOME, say("at the drone"))
    return _passed(HOME, say("{away} away; Arm sets it here", away=metres(away)))


def _return_height(altitude: float | None, plan: _Plan | None) -> CheckItem:
    name = RETURN_HEIGHT
    if altitude is None or plan is None:
        value = (
            NOT_READ if altitude is None else say("{altitude}, no fence to compare it with", altitude=metres(altitude))
        )
        return _failed(name, value, say("It may be above the fence."), say("Wait."))
    text = say("{altitude}, ceiling {ceiling}", altitude=metres(altitude), ceiling=metres(plan.fence.ceiling))
    if altitude > plan.fence.ceiling:
        return _failed(name, text, say("On its return it would leave the fence."), say("Change the heights."))
    if not sees_all(plan.fence, plan.home):
        text = say("{heights}; {blind}", heights=text, blind=_blind_words(plan.fence))
    return _passed(name, text)


def _blind_words(fence: Fence) -> str:
    return say(
        "our returns stay inside the fence, the autopilot's own failsafes fly straight and {leave} from parts",
        leave=say("cross a zone") if fence.zones else say("leave it"),
    )


def _plan(facts: Facts, settings: DdcSettings) -> _Plan | CheckItem:
    """Return the planned fence with the drone's place; else the check that fails."""
    limits, place = facts.limits, facts.global_place
    if limits.plan_problem:
        return _bad_fence(limits.plan_problem, say("What it forbids is not known."))
    if place is None:
        return _failed(
            FENCE, say("position not known"), say("There is no fence to fly in."), say("Wait for the position.")
        )
    datum = facts.position.datum or place
    try:
        fence = limits.plan.around(datum, place, settings.fence)
    except FenceError as error:
        return _bad_fence(words_of(error), say("There is no fence to fly in."))
    return _Plan(fence, to_map(datum, place.latitude, place.longitude), datum)


def _item(check: FailsafeCheck) -> CheckItem:
    if check.passed:
        return _passed(check.name, check.value)
    command: Remedy | None = "Set Failsafes" if check.can_be_set else None
    return _failed(check.name, check.value, check.consequence, check.remedy, remedy_command=command)


def _passed(name: str, value: str) -> CheckItem:
    return CheckItem(name=name, passed=True, value=value)


def _bad_fence(value: str, consequence: str) -> CheckItem:
    remedy = say("Put the drone inside the fence, or draw another one.")
    return _failed(FENCE, value, consequence, remedy, remedy_command="Set Fence")


def _failed(name: str, value: str, consequence: str, remedy: str, *, remedy_command: Remedy | None = None) -> CheckItem:
    return CheckItem(
        name=name, passed=False, value=value, consequence=consequence, remedy=remedy, remedy_command=remedy_command
    )
