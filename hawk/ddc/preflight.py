"""Preflight check: what must be well before Arm, each with its consequence and remedy. Functions of facts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from hawk.comm.status import CheckItem
from hawk.config import HeightSettings
from hawk.ddc.chemistry import CHEMISTRIES, LEAST_CELL_V, PACKS, Chemistry
from hawk.ddc.facts import Facts
from hawk.ddc.failsafes import AutopilotView, FlightLimits, check_failsafes, return_altitude
from hawk.ddc.fall import fall_words
from hawk.ddc.fence import where_outside
from hawk.ddc.geofence import FenceError, contains, extent, sees_all, to_map
from hawk.ddc.home import HOME_AGE_S, home_words
from hawk.ddc.parameter_values import FailsafeCheck, Values
from hawk.ddc.params import ParameterError, check_heights
from hawk.ddc.remote_control import remote_control_check
from hawk.ddc.remote_id import remote_id_checks
from hawk.ddc.settings import DdcSettings
from hawk.ddc.slope import slope_words
from hawk.ddc.survey_need import check_words
from hawk.ddc.witness import COMPASS_LOST
from hawk.ddc.words import metres
from hawk.model.limits import Fence
from hawk.model.operation import Fall
from hawk.model.poses import GlobalPose, MapPoint

GPS_FIX_3D = 3
BLIND_PARTS = "our returns stay inside the fence, the autopilot's own failsafes fly straight and {} from parts"
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
        return _passed("Motors", "free to start")
    found = "cut" if fall is None else f"off in the air {fall_words(fall)}"
    return _failed(
        "Motors", found, "The drone may be damaged.", "Look at it, then clear the cut.", remedy_command="Clear Kill"
    )


def _link(facts: Facts) -> CheckItem:
    if facts.link.second_sender:
        remedy = "Find out who sends there; name the autopilot in autopilot.vehicle_address."
        return _failed("Link", facts.link.second_sender, "Somebody may forge what the drone says.", remedy)
    health = facts.health("link")
    if health.is_healthy and facts.link.is_up:
        return _passed("Link", f"{facts.link.age:.1f} s")
    found = health.reason or "looking at it"
    return _failed("Link", found, "Nothing can be commanded.", "Switch the drone on, check its cable.")


def _sensors(facts: Facts) -> CheckItem:
    if facts.diagnostics.all_ok and not facts.is_on_ground:
        words = facts.ground.doubt or "it is not known to be on the ground"
        return _failed("Autopilot", words, "Its landing would not be seen.", "Wait a moment, then restart it.")
    if facts.diagnostics.compass_ok is False:
        return _failed("Autopilot", COMPASS_LOST, "It would not know where it heads.", "Check the compasses.")
    if facts.diagnostics.all_ok:
        return _passed("Autopilot", "its sensors are well")
    words = facts.link.words or "its sensors are not ready"
    return _failed("Autopilot", words, "It would refuse to arm.", "Wait a minute after switching on.")


def _gps(facts: Facts, limit: float) -> CheckItem:
    found = facts.diagnostics
    accuracy, has_fix = found.horizontal_accuracy, found.gps_fix is not None and found.gps_fix >= GPS_FIX_3D
    parts = (
        "" if has_fix else "no fix",
        f"{found.satellites} satellites" if found.satellites is not None else "",
        f"±{accuracy:.1f} m" if accuracy is not None else "accuracy unknown",
        found.estimator_fault,
    )
    text = ", ".join(filter(None, parts))
    good = has_fix and accuracy is not None and accuracy <= limit
    if good and found.global_position_ok and facts.health("position").is_healthy:
        return _passed("GPS", text)
    if found.is_mavlink_1 and accuracy is None:
        text = f"{text}: the link speaks MAVLink 1, which has none"
        remedy = "Set SERIALn_PROTOCOL of the autopilot's port to 2, restart it."
        return _failed("GPS", text, "The drone would not know where it is.", remedy)
    return _failed("GPS", text, "The drone would not know where it is.", "Wait under open sky.")


def _battery(facts: Facts, needed: float, chemistry: Chemistry) -> CheckItem:
    name, battery, charge = "Battery", facts.battery.info, facts.battery.charge
    if battery is None or battery.percentage is None:
        return _failed(name, "not known", "It could fall.", "Set up the autopilot's battery monitor.")
    if battery.voltage is None or battery.voltage < LEAST_CELL_V * PACKS[0]:
        text = f"{battery.percentage:.0f} %, voltage not known"
        return _failed(name, text, "It could fall: a counter alone is no witness.", "Set up BATT_MONITOR for voltage.")
    each = "" if charge.volts is None else f", {charge.volts:.2f} V a cell of {charge.cells}"
    text = f"{battery.percentage:.0f} %, {battery.voltage:.1f} V{each}"
    if charge.volts is not None and charge.volts > chemistry.resting[1]:
        remedy = "Set flight.battery_cells and flight.battery_chemistry, or calibrate BATT_VOLT_MULT."
        return _failed(name, text, "No such cell holds so much: its voltage is not known.", remedy)
    if charge.doubt:
        remedy = "Charge the battery, or set flight.battery_cells."
        text = f"{battery.voltage:.1f} V; {charge.doubt}"
        return _failed(name, text, "It would be empty sooner than its counter says.", remedy)
    lowest = battery.percentage if charge.allowed is None else min(battery.percentage, charge.allowed)
    if lowest >= needed:
        return _passed(name, text)
    if lowest < battery.percentage:
        text = f"{text}: {lowest:.0f} % at most"
    return _failed(name, text, "It would have to return at once.", f"Charge it to {needed:.0f} % or more.")


def _survey(facts: Facts) -> tuple[CheckItem, ...]:
    """Report whether the battery is enough for the survey. It refuses nothing: a survey goes on after a swap."""
    need = facts.battery.survey
    return () if need is None else (_passed("Survey", check_words(need)),)


def _camera(facts: Facts) -> CheckItem:
    health, age = facts.health("camera"), facts.sight.camera_age
    if health.is_healthy:
        text = "on" if age is None else f"picture {age:.1f} s old"
        return _passed("Camera", ", ".join(filter(None, (text, health.reason))))
    return _failed("Camera", health.reason, "Nothing would be seen.", "Check the camera and its address.")


def _recording(facts: Facts) -> CheckItem:
    health = facts.health("recording")
    if health.is_healthy:
        return _passed("Recording", health.reason or "on")
    return _failed("Recording", health.reason, "The flight would not be recorded.", "Make room on the disk.")


def _heights(facts: Facts, settings: HeightSettings) -> CheckItem:
    heights, obstacle = facts.limits.heights, settings.highest_obstacle_m
    declared = "no obstacle declared" if obstacle is None else f"highest obstacle {obstacle:g} m"
    text = f"{heights.desired:g} m, never below {heights.minimum:g} m or above {heights.maximum:g} m; {declared}"
    try:
        check_heights(heights, facts.ceiling(on_ground=True), settings.floor_m)
    except ParameterError as error:
        return _failed("Heights", text, str(error), "Change the heights.")
    return _passed("Heights", text)


def _slope(facts: Facts, settings: HeightSettings, plan: _Plan | CheckItem) -> tuple[CheckItem, ...]:
    """Return what the drone's tilt says about the ground; nothing on level ground. It never refuses Arm."""
    slope = facts.position.below.slope
    if slope is None or not slope.is_notable or isinstance(plan, CheckItem):
        return ()
    words = slope_words(slope, plan.fence, plan.home, facts.limits.heights.minimum, settings.highest_obstacle_m)
    return (_passed("Slope", words),)


def _fence(plan: _Plan) -> CheckItem:
    north, east = extent(plan.fence)
    text = f"{north:.0f} × {east:.0f} m"
    if not contains(plan.fence, plan.home):
        return _bad_fence(f"{text}, drone {where_outside(plan.fence, plan.home)}", "It could not fly anywhere.")
    return _passed("Fence", f"{text}, drone and home inside")


def _home(facts: Facts, plan: _Plan | None) -> CheckItem:
    """Check the autopilot's home: its own failsafes fly there at any time. Arm sets it to the drone's place."""
    home = facts.position.autopilot_home
    if home.place is None or home.age > HOME_AGE_S:
        return _failed("Home", "not known", "The autopilot could not return.", "Wait for the position.")
    if home.is_moved:
        return _failed("Home", home_words(home), "It would not return here.", "Leave home alone with other stations.")
    if plan is None:
        return _failed("Home", "no fence to compare it with", "It may be outside the fence.", "Wait.")
    place = to_map(plan.datum, home.place.latitude, home.place.longitude)
    away = place.distance(plan.home)
    if not contains(plan.fence, place):
        remedy = "Switch the autopilot off and on where it stands."
        return _failed("Home", f"{metres(away)} away, outside the fence", "It would return there.", remedy)
    if away <= HOME_NEAR_M:
        return _passed("Home", "at the drone")
    return _passed("Home", f"{metres(away)} away; Arm sets it here")


def _return_height(altitude: float | None, plan: _Plan | None) -> CheckItem:
    name = "Return height"
    if altitude is None or plan is None:
        value = "not read yet" if altitude is None else f"{metres(altitude)}, no fence to compare it with"
        return _failed(name, value, "It may be above the fence.", "Wait.")
    text = f"{metres(altitude)}, ceiling {metres(plan.fence.ceiling)}"
    if altitude > plan.fence.ceiling:
        return _failed(name, text, "On its way home it would leave the fence.", "Change the heights.")
    seen, parts = sees_all(plan.fence, plan.home), "cross a zone" if plan.fence.zones else "leave it"
    return _passed(name, text if seen else f"{text}; {BLIND_PARTS.format(parts)}")


def _plan(facts: Facts, settings: DdcSettings) -> _Plan | CheckItem:
    """Return the planned fence with the drone's place; else the check that fails."""
    limits, place = facts.limits, facts.global_place
    if limits.plan_problem:
        return _bad_fence(limits.plan_problem, "What it forbids is not known.")
    if place is None:
        return _failed("Fence", "position not known", "There is no fence to fly in.", "Wait for the position.")
    datum = facts.position.datum or place
    try:
        fence = limits.plan.around(datum, place, settings.fence)
    except FenceError as error:
        return _bad_fence(str(error), "There is no fence to fly in.")
    return _Plan(fence, to_map(datum, place.latitude, place.longitude), datum)


def _item(check: FailsafeCheck) -> CheckItem:
    if check.passed:
        return _passed(check.name, check.value)
    command: Remedy | None = "Set Failsafes" if check.can_be_set else None
    return _failed(check.name, check.value, check.consequence, check.remedy, remedy_command=command)


def _passed(name: str, value: str) -> CheckItem:
    return CheckItem(name=name, passed=True, value=value)


def _bad_fence(value: str, consequence: str) -> CheckItem:
    remedy = "Put the drone inside the fence, or draw another one."
    return _failed("Fence", value, consequence, remedy, remedy_command="Set Fence")


def _failed(name: str, value: str, consequence: str, remedy: str, *, remedy_command: Remedy | None = None) -> CheckItem:
    return CheckItem(
        name=name, passed=False, value=value, consequence=consequence, remedy=remedy, remedy_command=remedy_command
    )
