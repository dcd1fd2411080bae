"""Judges the autopilot's failsafes and remote control by the functions of the preflight check."""

from __future__ import annotations

from hawk.check.result import CheckResult, failed, not_looked_at, passed, warning
from hawk.comm.autopilot.vehicle import VehicleTopics
from hawk.config.sections import Config
from hawk.ddc.battery.chemistry import CHEMISTRIES
from hawk.ddc.parameters.failsafes import AutopilotView, check_failsafes, watched_names
from hawk.ddc.parameters.values import FailsafeCheck, Values
from hawk.ddc.readings.remote_control import SWITCH_CHANNEL, RemoteControlWatch, remote_control_check

BATTERY_AGE_S = 5.0
"""An older SYS_STATUS (2 Hz) says nothing, seconds."""


def needed_names(values: Values) -> tuple[str, ...]:
    """Return the parameters that the preflight check reads, given what was read so far."""
    return watched_names(values)


def failsafe_results(config: Config, values: Values, topics: VehicleTopics) -> list[CheckResult]:
    """Return the checks of remote control and failsafes."""
    battery, diagnostics = topics.battery.fresh(BATTERY_AGE_S), topics.diagnostics.fresh(BATTERY_AGE_S)
    chemistry, voltage = CHEMISTRIES[config.flight.battery_chemistry], None if battery is None else battery.voltage
    view = AutopilotView(
        config.autopilot.system_id,
        chemistry.possible_cells(voltage, config.flight.battery_cells, in_flight=False),
        None if diagnostics is None else diagnostics.fence_on,
        config.remote_control.required,
        chemistry,
    )
    return [_remote_control(config, values, topics), *(_result(check) for check in check_failsafes(values, view))]


def _result(check: FailsafeCheck) -> CheckResult:
    if check.passed:
        return passed(check.name, f"{_upper(check.value)}.")
    if not check.is_read:
        return not_looked_at(check.name, "It was not read.", "Check again; a weak link loses answers.")
    words = f"{_upper(check.value)}. {check.consequence}"
    if check.can_be_set:
        return warning(check.name, words, "Set failsafes on the page before Arm, which is refused until then.")
    return failed(check.name, words, check.remedy)


def _remote_control(config: Config, values: Values, topics: VehicleTopics) -> CheckResult:
    settings, latest = config.remote_control, topics.remote_control.latest
    watch = RemoteControlWatch(settings)
    now = 0.0 if latest is None else latest.time + topics.remote_control.age
    watch.look(topics.remote_control.value, values.get(SWITCH_CHANNEL), now, is_armed=False)
    found = remote_control_check(watch.read(now), values, settings)
    if found.passed:
        return passed(found.name, f"{_upper(found.value)}.")
    return warning(found.name, f"{_upper(found.value)}. {found.consequence}", found.remedy)


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]
