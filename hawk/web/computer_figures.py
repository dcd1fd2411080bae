"""Figures of the computer: free disk, temperatures, processor time. They show what will end a flight early.

Sensors and disks answer late at times, so they are read on a thread of their own; late figures are left out.
"""

from __future__ import annotations

import asyncio
import logging
import math
import os
from collections.abc import AsyncIterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final

from aiohttp import web

_LOG = logging.getLogger(__name__)

THERMAL: Final = Path("/sys/class/thermal")
STAT: Final = Path("/proc/stat")
LATE_S: Final = 0.5
"""Real seconds that an answer waits for them."""
_COLDEST, _HOTTEST = -60.0, 200.0
"""Degrees Celsius; a sensor that reads beyond them is broken."""
_TICKS: Final = os.sysconf("SC_CLK_TCK")
_READER = web.AppKey("computer_figures_reader", ThreadPoolExecutor)

Figure = tuple[str, str, str, float, Mapping[str, str]]
"""Name in ``/metrics``, kind, description, value, labels."""


def computer_figures(store: Path | None, thermal: Path = THERMAL, stat: Path = STAT) -> list[Figure]:
    """Return the figures; one that cannot be read is left out. May block.

    Args:
        store: The daemon's folder.
        thermal: Folder of the kernel's thermal zones (Documentation/driver-api/thermal/sysfs-api.rst).
        stat: Processor times (proc(5)).
    """
    used = os.times()
    found: list[Figure] = [
        ("cpu_seconds_total", "counter", "Processor time of the daemon.", used.user + used.system, {}),
    ]
    if store is not None:
        try:
            disk = os.statvfs(store)
        except OSError:
            pass
        else:
            free, whole = disk.f_bavail * disk.f_frsize, disk.f_blocks * disk.f_frsize
            found.append(("disk_free_bytes", "gauge", "Free on the disk of the store.", float(free), {}))
            found.append(("disk_size_bytes", "gauge", "Size of that disk.", float(whole), {}))
    for zone, degrees in temperatures(thermal).items():
        found.append(("temperature_celsius", "gauge", "Of the computer's parts.", degrees, {"zone": zone}))
    for mode, seconds in processor_times(stat).items():
        text = "Processor time of the computer, all cores together."
        found.append(("computer_cpu_seconds_total", "counter", text, seconds, {"mode": mode}))
    return found


def temperatures(thermal: Path = THERMAL) -> dict[str, float]:
    """Return degrees Celsius by zone; zones of one type are numbered."""
    found: dict[str, float] = {}
    for folder in sorted(thermal.glob("thermal_zone*")):
        try:
            kind = (folder / "type").read_text().strip() or folder.name
            degrees = int((folder / "temp").read_text()) / 1000.0
        except (OSError, ValueError):
            continue
        if math.isfinite(degrees) and _COLDEST <= degrees <= _HOTTEST:
            found[kind if kind not in found else f"{kind}-{folder.name.removeprefix('thermal_zone')}"] = degrees
    return found


def processor_times(stat: Path = STAT) -> dict[str, float]:
    """Return seconds since the boot that the processors were busy, and idle; empty when they cannot be read."""
    try:
        name, *fields = stat.read_text().splitlines()[0].split()
        user, nice, system, idle, wait, *rest = (int(field) / _TICKS for field in fields[:8])
    except (OSError, ValueError, IndexError):
        return {}
    return {"busy": user + nice + system + sum(rest), "idle": idle + wait} if name == "cpu" else {}


async def figures(app: web.Application, store: Path | None) -> list[Figure]:
    """Return `computer_figures`, read on the thread; none when they are late."""
    work = asyncio.get_running_loop().run_in_executor(app[_READER], computer_figures, store)
    try:
        return await asyncio.wait_for(work, LATE_S)
    except TimeoutError:
        _LOG.info("figures of the computer were not read within %g s", LATE_S)
        return []


async def reader(app: web.Application) -> AsyncIterator[None]:
    """Own the thread; a context of the application. A read that hangs is left behind."""
    executor = ThreadPoolExecutor(1, thread_name_prefix="computer-figures")
    app[_READER] = executor
    yield
    executor.shutdown(wait=False, cancel_futures=True)
