"""Check of the autopilot: it is found by the daemon's own code, answers, and its failsafes are read and judged.

Nothing is sent but requests for parameters and for the rates of messages: `ReadingLink` refuses the rest. Our
heartbeats are held back where the autopilot speaks first (``udpin``): an autopilot that has heard a ground station
misses it when the check ends, and in the air its ground-station failsafe would act.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

from hawk.check.result import CheckResult, failed, not_looked_at, passed, warning
from hawk.comm.autopilot.autopilot import MavsdkAutopilot
from hawk.comm.autopilot.commands import MavCommand
from hawk.comm.autopilot.mavlink_link import Link, Message, OnMessage
from hawk.comm.autopilot.vehicle import AutopilotError, FenceRings, VehicleTopics
from hawk.comm.clock import Clock
from hawk.comm.mavlink.claim import device_of
from hawk.comm.mavlink.frames import ARDUPILOT, COPTERS
from hawk.comm.mavlink.peer import Expected
from hawk.config.sections import Config
from hawk.ddc.battery.chemistry import CHEMISTRIES
from hawk.ddc.parameters.failsafes import MAY_BE_MISSING, AutopilotView, check_failsafes, watched_names
from hawk.ddc.parameters.values import FailsafeCheck, Values
from hawk.ddc.readings.instant import Instant
from hawk.ddc.readings.remote_control import RemoteControlReading, remote_control_check
from hawk.model.vehicle import mode_name
from hawk.runtime.programs import Processes
from hawk.runtime.supervision import Supervisor

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
    reading = RemoteControlReading(topics.remote_control, settings)
    now = 0.0 if latest is None else latest.time + topics.remote_control.age
    instant = Instant(now, parameters={name: value for name, value in values.items() if value is not None})
    reading.update(instant)
    found = remote_control_check(reading.facts(instant), values, settings)
    if found.passed:
        return passed(found.name, f"{_upper(found.value)}.")
    return warning(found.name, f"{_upper(found.value)}. {found.consequence}", found.remedy)


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]


FIND_S: Final = 5.0
"""Real seconds for the first heartbeat: it comes once a second, and MAVSDK is opened first."""
READ_S: Final = 7.0
"""Real seconds for the parameters; one that the autopilot lacks takes 2 s, some of them at once."""
SETTLE_S: Final = 1.0
"""Real seconds for the streams that were asked for, after the parameters were read."""
AT_ONCE: Final = 6
"""Reads under way at a time, as in `hawk.ddc.parameters.reader`."""
PROBED: Final = ("FS_GCS_ENABLE", "FENCE_ENABLE", "FLTMODE_CH")
"""Parameters of every ArduCopter from 4.5 on: when none answers, nothing that we send is heard."""
_NAME: Final = "Autopilot"
_OFF_DOWN_DEG: Final = 10.0
"""Beyond this a gimbal was not pointed down: a lot is mapped from straight above."""
_VERSIONS: Final = ((4, 5), (4, 7))
"""Oldest and newest ArduCopter whose parameters were compared (`hawk.ddc.parameters.failsafes`)."""
_MAVLINK_2: Final = "Set SERIALn_PROTOCOL of the autopilot's port to 2 (MAVLink 2), and restart the autopilot."
_SIGNING: Final = (
    "MAVLink signing may be on in the autopilot: switch it off with a station that has the key. Else only one "
    "direction of the link works: check the wire from this computer's TX to the autopilot's RX."
)


class ReadingLink(Link):
    """A link by which nothing can be changed: it sends requests for parameters and for message rates only."""

    def send(self, name: str, fields: Mapping[str, Any]) -> None:
        """Send a request for a parameter or for a message's rate. Raises AutopilotError for anything else."""
        is_rate = name == "COMMAND_LONG" and fields.get("command") == MavCommand.SET_MESSAGE_INTERVAL
        if name != "PARAM_REQUEST_READ" and not is_rate:
            raise AutopilotError(f"{name}: a check only reads: not sent")
        super().send(name, fields)

    def command(self, command: int, parameters: Sequence[float] = ()) -> int:  # noqa: ARG002 - as `Link` has it
        """Raise AutopilotError: a check only reads."""
        raise AutopilotError(f"Command {command}: a check only reads: not sent")

    def upload_fence(self, rings: FenceRings) -> None:  # noqa: ARG002 - as `Link` has it
        """Raise AutopilotError: a check only reads."""
        raise AutopilotError("The fence: a check only reads: not sent")


MakeLink = Callable[[str, int, Clock, OnMessage, Expected], Link]


@dataclass(frozen=True, slots=True)
class AutopilotTools:
    """Link, programs and times (real seconds), replaced in tests."""

    make_link: MakeLink = ReadingLink
    processes: Processes = field(default_factory=Processes)
    find_s: float = FIND_S
    settle_s: float = SETTLE_S
    parameter_answer_s: float = 0.5


@dataclass(slots=True)
class _Heard:
    """Facts that are on no topic: the newest HEARTBEAT, and the firmware's version when MAVSDK asked for it."""

    beat: Mapping[str, Any] = field(default_factory=dict)
    version: tuple[int, int, int] | None = None

    def take(self, message: Message) -> None:
        if message.name == "HEARTBEAT":
            self.beat = message.fields
        elif message.name == "AUTOPILOT_VERSION":
            number = message.fields.get("flight_sw_version")
            if isinstance(number, int) and number:
                self.version = (number >> 24 & 255, number >> 16 & 255, number >> 8 & 255)


async def look_at_autopilot(config: Config, clock: Clock, tools: AutopilotTools) -> list[CheckResult]:
    """Find the autopilot, read what the preflight check reads, and judge it."""
    refusal = _before_opening(config.autopilot.url, tools.processes)
    if refusal is not None:
        return [refusal]
    heard, topics = _Heard(), VehicleTopics.create(clock)

    def make_link(url: str, system_id: int, clock: Clock, on_message: OnMessage, expected: Expected) -> Link:
        def take(message: Message) -> None:
            heard.take(message)
            on_message(message)

        return tools.make_link(url, system_id, clock, take, expected)

    autopilot = MavsdkAutopilot(
        config.autopilot,
        clock,
        topics,
        make_link=make_link,
        parameter_answer_s=tools.parameter_answer_s,
        supervisor=Supervisor(),
        has_gimbal=config.camera.gimbal,
    )
    autopilot.set_voice(urlsplit(config.autopilot.url).scheme == "udpout")  # a listening peer must hear us first
    await autopilot.start()
    try:
        return await _look(config, autopilot, heard, tools, clock)
    finally:
        await autopilot.close()


async def _look(
    config: Config, autopilot: MavsdkAutopilot, heard: _Heard, tools: AutopilotTools, clock: Clock
) -> list[CheckResult]:
    loop = asyncio.get_running_loop()
    end = loop.time() + tools.find_s
    while not _is_connected(autopilot) and (left := end - loop.time()) > 0:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(left):
                await autopilot.topics.state.next()
    if not _is_connected(autopilot):
        return [_not_found(config.autopilot.url, autopilot)]
    autopilot.set_voice(False)
    found = _vehicle(autopilot, heard)
    if _is_armed(autopilot):
        words = "The motors are on: nothing more is asked of it."
        return [found, failed("Motors", words, "Land, switch the motors off, then check again.")]
    values = await _read(autopilot)
    if not values:
        asked = ", ".join(PROBED)
        words = f"It is heard, but answers no request (asked for {asked})."
        return [found, *_senders(autopilot, config.autopilot.vehicle_system_id), failed("Parameters", words, _SIGNING)]
    await asyncio.sleep(tools.settle_s)
    found = _vehicle(autopilot, heard)  # the version may have come meanwhile
    if _is_armed(autopilot):
        return [found, failed("Motors", "The motors were started meanwhile.", "Land, then check again.")]
    gimbal = [_gimbal(autopilot.telemetry.gimbal.off_down(clock()))] if config.camera.gimbal else []
    failsafes = failsafe_results(config, values, autopilot.topics)
    senders = _senders(autopilot, config.autopilot.vehicle_system_id)
    return [found, *senders, *gimbal, _parameters(values), *failsafes]


def _is_connected(autopilot: MavsdkAutopilot) -> bool:
    state = autopilot.topics.state.value
    return state is not None and state.connected


def _is_armed(autopilot: MavsdkAutopilot) -> bool:
    state = autopilot.topics.state.value
    return state is not None and state.armed


# --- before the link is opened ----------------------------------------------------------------------------------------


def _before_opening(url: str, processes: Processes) -> CheckResult | None:
    """Return why the link must not, or cannot, be opened; None when it may be."""
    daemons = processes.daemons()
    if daemons:
        words = f"A daemon runs (process {daemons[0]}), and the autopilot is its own."
        return not_looked_at(_NAME, words, "Stop it on the ground: sudo systemctl stop hawk-drone. Then check again.")
    device = device_of(url)
    return None if device is None else _device(Path(device), processes)


def _device(device: Path, processes: Processes) -> CheckResult | None:
    if not device.exists():
        remedy = "Plug the autopilot in; ls /dev/serial/by-id names the devices. A Pi's UART: raspi-config."
        return failed(_NAME, f"There is no device {device} (autopilot.url).", remedy)
    if not os.access(device, os.R_OK | os.W_OK):
        remedy = "Join the group dialout: sudo usermod -aG dialout USER, then log in again."
        return failed(_NAME, f"{device} may not be read and written by this user.", remedy)
    holder = processes.holder_of_file(device)
    if holder:
        remedy = "Stop it, or let a router (mavlink-router) serve both over UDP."
        return not_looked_at(_NAME, f"{device} is in use by {holder}.", remedy)
    return None


# --- results ----------------------------------------------------------------------------------------------------------


def _not_found(url: str, autopilot: MavsdkAutopilot) -> CheckResult:
    other = autopilot.hearing.second_sender
    if other:
        remedy = "Correct autopilot.vehicle_address and autopilot.vehicle_system_id, or stop that sender."
        return failed(_NAME, f"Not the expected autopilot is heard: {other}", remedy)
    heard = autopilot.hearing.heard
    if heard:
        remedy = "Is the copter switched on? Then forward its messages to this link, too (SERIALn_PROTOCOL, router)."
        return failed(_NAME, f"No copter is heard at {url}, but: {heard}.", remedy)
    value = f"No autopilot is heard at {url}."
    if "opened" in autopilot.problem:
        value = f"{autopilot.problem.rstrip('.')}."
    return failed(_NAME, value, not_found_remedy(url))


def not_found_remedy(url: str) -> str:
    """Return what to do when nothing is heard, by the kind of link."""
    place = urlsplit(url)
    if device_of(url) is not None:
        return (
            "Switch the autopilot on; cross TX and RX; compare the baud rate with SERIALn_BAUD, and set "
            "SERIALn_PROTOCOL to 2."
        )
    if place.scheme == "udpin":
        return (
            f"Does the autopilot or mavlink-router send to {place.netloc}? From another computer it must send to an "
            "address of this one, and autopilot.url must name that address or 0.0.0.0."
        )
    return f"Does the autopilot or mavlink-router listen at {place.netloc}? Is its address reachable (ping)?"


def _vehicle(autopilot: MavsdkAutopilot, heard: _Heard) -> CheckResult:
    kind, vehicle = (int(heard.beat.get(name, -1)) for name in ("autopilot", "type"))
    if kind != ARDUPILOT:
        remedy = "Install ArduCopter on the autopilot, or name the right one in autopilot.vehicle_system_id."
        return failed(_NAME, f"It is no ArduPilot (MAV_AUTOPILOT {kind}).", remedy)
    if vehicle not in COPTERS:
        remedy = "Install ArduCopter: hawk flies no plane, rover or boat."
        return failed(_NAME, f"It is an ArduPilot, but no copter (MAV_TYPE {vehicle}).", remedy)
    state = autopilot.topics.state.value
    mode = mode_name(None if state is None else state.custom_mode)
    version = heard.version
    number = "" if version is None else f" {'.'.join(map(str, version))}"
    words = f"ArduCopter{number}, {COPTERS[vehicle]}, mode {mode}"
    if version is not None and not _VERSIONS[0] <= version[:2] <= _VERSIONS[1]:
        span = " to ".join(".".join(map(str, each)) for each in _VERSIONS)
        return warning(_NAME, f"{words}; hawk knows {span}.", "Install one of these, or read what has changed.")
    return passed(_NAME, f"{words}.")


def _senders(autopilot: MavsdkAutopilot, vehicle_id: int | None) -> list[CheckResult]:
    """Judge the link's protocol, and who else is on it. ``vehicle_id``: autopilot.vehicle_system_id."""
    found, results = autopilot.hearing, []
    diagnostics = autopilot.topics.diagnostics.value
    if diagnostics is not None and diagnostics.is_mavlink_1:
        words = "The link speaks MAVLink 1, which has neither the accuracy of the position nor the fence."
        results.append(failed("MAVLink", words, _MAVLINK_2))
    if found.second_sender:
        remedy = "Find out who sends there; name the autopilot in autopilot.vehicle_address."
        results.append(failed("Second sender", found.second_sender, remedy))
    if found.other_vehicles and vehicle_id is None:
        words = f"Another copter is on the link: {found.other_vehicles}."
        results.append(warning("Second copter", words, "Name yours in autopilot.vehicle_system_id."))
    return results


def _gimbal(off_down: float | None) -> CheckResult:
    """Judge a gimbal by the angle of its optical axis with straight down, radians; None: it is not reported."""
    if off_down is None:
        words = "Its attitude is not reported, and camera.gimbal is true: nothing would be mapped."
        remedy = (
            "Set MNT1_TYPE and SERIALn_PROTOCOL (a SIYI: 8 and 8) in the autopilot; for a camera that is fixed to the "
            "drone, camera.gimbal = false."
        )
        return failed("Gimbal", words, remedy)
    words = f"It looks {math.degrees(off_down):.0f}° off straight down."
    if math.degrees(off_down) > _OFF_DOWN_DEG:
        return warning("Gimbal", words, "Point it straight down, in follow mode, before Arm.")
    return passed("Gimbal", words)


def _parameters(values: Mapping[str, float | None]) -> CheckResult:
    wanted = needed_names(values)
    missing = [name for name in wanted if name not in values]
    if missing:
        words = f"{len(missing)} of {len(wanted)} were not answered: {', '.join(missing)}."
        return not_looked_at("Parameters", words, "Check again; a weak link loses answers.")
    return passed("Parameters", f"All {len(wanted)} that the preflight check reads are answered.")


async def _read(autopilot: MavsdkAutopilot) -> dict[str, float | None]:
    """Return the parameters that were answered; None for one that the autopilot may lack. Empty: nothing answered."""
    gate = asyncio.Semaphore(AT_ONCE)
    values: dict[str, float | None] = {}

    async def read(name: str) -> None:
        async with gate:
            if _is_armed(autopilot):
                return
            try:
                values[name] = await autopilot.get_parameter(name)
            except AutopilotError:
                return

    async def read_all(names: Sequence[str]) -> None:
        await asyncio.gather(*(read(name) for name in names if name not in values))

    await read_all(PROBED)
    if not values:
        return values
    witness = next(iter(values))
    with contextlib.suppress(TimeoutError, AutopilotError):
        async with asyncio.timeout(READ_S):
            await read_all(needed_names(values))
            await read_all(needed_names(values))  # once more those without an answer
            await autopilot.get_parameter(witness)  # it answers still: the others are lacking
            for name in MAY_BE_MISSING.intersection(needed_names(values)):
                values.setdefault(name, None)
    return values
