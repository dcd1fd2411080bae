"""Makes all checks of ``hawk-drone check``: the ports first, since the others open them, then the rest at once."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from hawk.check.autopilot import AutopilotTools, look_at_autopilot
from hawk.check.camera import CameraSight, CameraTimes, look_at_camera
from hawk.check.machine import (
    DiskReading,
    clock_result,
    disk_results,
    is_synchronized,
    look_at_model,
    program_date,
    read_disk,
)
from hawk.check.network import (
    NetworkTools,
    address_result,
    autopilot_port,
    bind_port,
    certificate_result,
    own_addresses,
    page_port,
    token_result,
)
from hawk.check.result import CheckResult, Look, failed, not_looked_at, on_thread, passed, run_look, run_looks
from hawk.comm.cameras.drone_camera import make_source
from hawk.comm.cameras.sources.source import CameraSource
from hawk.comm.clock import Clock
from hawk.config.sections import CameraSettings, Config, ConfigError
from hawk.runtime.programs import Processes

PORTS_S: Final = 3.0
REST_S: Final = 15.0
"""Real seconds of the longest check. With the ports before it and END_S after it the whole takes 20 s at most."""
OTHERS: Final = ("Camera", "Autopilot", "Store", "Ports", "Network", "Certificate", "Model")
"""Checks that need a configuration."""


@dataclass(frozen=True, slots=True)
class Tools:
    """Everything outside that the checks ask; replaced in tests."""

    network: NetworkTools
    autopilot: AutopilotTools
    make_source: Callable[[CameraSettings, Clock], CameraSource] = make_source
    camera_times: CameraTimes = field(default_factory=CameraTimes)
    read_disk: Callable[[Path], DiskReading] = read_disk
    synchronized: Callable[[], bool | None] = is_synchronized
    look_at_model: Callable[[Config], CheckResult] = look_at_model
    wall: Callable[[], float] = time.time
    not_before: Callable[[], datetime] = program_date


def usual_tools() -> Tools:
    """Return the tools of a real check."""
    processes = Processes()
    network = NetworkTools(bind_port, processes, own_addresses)
    return Tools(network, AutopilotTools(processes=processes))


async def check_all(load: Callable[[], Config], tools: Tools, clock: Clock) -> list[CheckResult]:
    """Make all checks. ``load`` returns the settings, or raises ConfigError."""
    try:
        config = load()
    except ConfigError as error:
        first = failed("Configuration", f"{error}.", "Correct the settings; config.toml describes each.")
        unread = [not_looked_at(name, "It needs the configuration.") for name in OTHERS]
        return [first, *unread, await _clock(tools)]
    first = passed("Configuration", "The settings can be read and fit together.")
    return [first, *await _check(config, tools, clock)]


async def _check(config: Config, tools: Tools, clock: Clock) -> list[CheckResult]:
    ports = await run_look(Look("Ports", lambda: on_thread(lambda: _ports(config, tools)), PORTS_S))
    sights: list[CameraSight] = []
    disks: list[DiskReading] = []

    async def camera() -> Sequence[CheckResult]:
        sights.append(await look_at_camera(config.camera, clock, tools.make_source, tools.camera_times))
        return sights[0].results

    async def disk() -> Sequence[CheckResult]:
        disks.append(await on_thread(lambda: tools.read_disk(config.store.directory)))
        return []

    async def autopilot() -> Sequence[CheckResult]:
        taken = [each for each in ports if each.name == "Autopilot's port" and not each.is_well]
        if taken:
            return [not_looked_at("Autopilot", "Its port cannot be opened.", taken[0].remedy)]
        return await look_at_autopilot(config, clock, tools.autopilot)

    async def clock_look() -> Sequence[CheckResult]:
        return [await _clock(tools)]

    async def model() -> Sequence[CheckResult]:
        return [await on_thread(lambda: tools.look_at_model(config))]

    async def access() -> Sequence[CheckResult]:
        return await on_thread(lambda: _access(config, tools))

    seen, vehicle, stored, rest = await asyncio.gather(
        *(
            run_look(Look(name, work, REST_S))
            for name, work in (("Camera", camera), ("Autopilot", autopilot), ("Store", disk))
        ),
        run_looks([Look("Clock", clock_look, REST_S), Look("Network", access, REST_S), Look("Model", model, REST_S)]),
    )
    if disks:
        bytes_s = sights[0].picture_bytes_s if sights else None
        stored = disk_results(disks[0], config.store, bytes_s, os.geteuid())
    return [*seen, *vehicle, *stored, *ports, *rest]


def _ports(config: Config, tools: Tools) -> list[CheckResult]:
    found = [page_port(config.web, tools.network), autopilot_port(config.autopilot, tools.network)]
    return [each for each in found if each is not None]


def _access(config: Config, tools: Tools) -> list[CheckResult]:
    return [
        address_result(config.web, tools.network),
        token_result(config),
        certificate_result(config.web, tools.wall()),
    ]


async def _clock(tools: Tools) -> CheckResult:
    synchronized = await on_thread(tools.synchronized)
    return clock_result(datetime.fromtimestamp(tools.wall(), UTC), tools.not_before(), synchronized)
