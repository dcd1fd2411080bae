"""Metrics in Prometheus's text format: the daemon, its computer, and what the drone does."""

from __future__ import annotations

import asyncio
import logging
import math
import os
import resource
import threading
from collections.abc import AsyncIterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from aiohttp import web

from hawk.comm.protocol.heartbeat import DroneStatus
from hawk.model.lot_map import StallState
from hawk.web.services import Counters, WebServices

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
        async with asyncio.timeout(LATE_S):
            return await work
    except TimeoutError:
        _LOG.info("figures of the computer were not read within %g s", LATE_S)
        return []


async def reader(app: web.Application) -> AsyncIterator[None]:
    """Own the thread; a context of the application. A read that hangs is left behind."""
    executor = ThreadPoolExecutor(1, thread_name_prefix="computer-figures")
    app[_READER] = executor
    yield
    executor.shutdown(wait=False, cancel_futures=True)


PROC: Final = Path("/proc/self")


def process_figures(proc: Path = PROC) -> Mapping[str, tuple[str, float]]:
    """Return the figures by their name in ``/metrics``, each with its description (proc(5): statm, fd)."""
    resident = int((proc / "statm").read_text().split()[1]) * resource.getpagesize()
    files = open_files(proc)
    sockets = sum(name.startswith("socket:") for name in files)
    return {
        "resident_memory_bytes": ("Resident memory.", float(resident)),
        "open_files": ("Open descriptors, sockets among them.", float(len(files))),
        "open_sockets": ("Open sockets.", float(sockets)),
        "threads": ("Python's threads.", float(threading.active_count())),
        "tasks": ("Tasks of the event loop.", float(len(asyncio.all_tasks()))),
    }


def open_files(proc: Path = PROC) -> list[str]:
    """Return the targets of all descriptors; one that is closed meanwhile is left out."""
    found = []
    for name in os.listdir(proc / "fd"):
        try:
            found.append(str((proc / "fd" / name).readlink()))
        except OSError:
            continue
    return found


@dataclass(frozen=True, slots=True)
class Access:
    """Figures of the server's door; ``closed`` and ``wrong_tokens`` rise."""

    waiting: int = 0
    answered: int = 0
    closed: int = 0
    wrong_tokens: int = 0


def metrics_text(
    services: WebServices, counters: Counters, access: Access = Access(), computer: Sequence[Figure] = ()
) -> str:
    """Return all metrics, those of the computer among them; unknown values are left out."""
    shown = _Exposition()
    _add_program(shown, services, computer)
    _add_clients(shown, services, counters, access)
    if services.status.value is not None:
        _add_drone(shown, services.status.value)
    return "\n".join(shown.lines) + "\n"


class _Exposition:
    """Lines of the text format: help and kind before the first value of a name."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def add(self, name: str, kind: str, text: str, value: float | None, labels: str = "") -> None:
        if value is None or math.isnan(value):
            return
        head = f"hawk_{name}"
        if f"# TYPE {head} {kind}" not in self.lines:
            self.lines.extend((f"# HELP {head} {text}", f"# TYPE {head} {kind}"))
        self.lines.append(f"{head}{labels} {_number(value)}")


def _add_program(shown: _Exposition, services: WebServices, computer: Sequence[Figure]) -> None:
    lag = services.loop_lag()
    about = {"version": services.version, "simulation": str(services.simulation).lower()}
    shown.add("build_info", "gauge", "Always 1; the labels say which program runs.", 1.0, _labels(about))
    for statistic, value in (("median", lag.p50_ms), ("p99", lag.p99_ms), ("max", lag.max_ms)):
        text = "Lag of the event loop over the last minute."
        shown.add(
            "loop_lag_seconds", "gauge", text, None if value is None else value / 1e3, _labels({"statistic": statistic})
        )
    for name, kind, text, value, labels in computer:
        shown.add(name, kind, text, value, _labels(labels))


def _add_clients(shown: _Exposition, services: WebServices, counters: Counters, access: Access) -> None:
    shown.add("clients", "gauge", "Connected pages.", len(services.side.hub))
    shown.add("video_clients", "gauge", "Viewers of the video.", counters.video_clients)
    shown.add("video_frames_total", "counter", "Frames handed to viewers.", counters.video_frames)
    shown.add("video_latency_seconds", "gauge", "Age of the newest frame when handed out.", counters.frame_latency_s)
    shown.add("heartbeats_total", "counter", "Heartbeats sent to pages.", counters.heartbeats)
    shown.add("heartbeats_failed_total", "counter", "Heartbeats that could not be built.", counters.heartbeats_failed)
    shown.add("connections_waiting", "gauge", "Connections that wait for a request.", access.waiting)
    shown.add("requests_under_way", "gauge", "Requests that are being answered.", access.answered)
    shown.add("connections_closed_total", "counter", "Connections that were closed while they waited.", access.closed)
    shown.add("wrong_tokens_total", "counter", "Wrong tokens.", access.wrong_tokens)
    shown.add("status_age_seconds", "gauge", "Age of the state machine's last status.", services.status.age)
    shown.add("frame_age_seconds", "gauge", "Age of the newest annotated frame.", services.video.age)
    for name, (text, value) in process_figures().items():
        shown.add(name, "gauge", text, value)
    waiting = {"commands": services.side.socket.waiting, "answers": services.side.hub.waiting, **services.queues()}
    for name, count in waiting.items():
        shown.add("queued", "gauge", "Items that wait in a queue.", count, f'{{queue="{name}"}}')
    for name, count in services.counters().items():
        shown.add(f"{name}_total", "counter", f"{name.replace('_', ' ').capitalize()}.", count)


def _add_drone(shown: _Exposition, status: DroneStatus) -> None:
    shown.add("vision_rate_hertz", "gauge", "Frames fused per second.", status.perception.vision_rate)
    shown.add("armed", "gauge", "1 when armed.", None if status.vehicle.armed is None else float(status.vehicle.armed))
    charge = status.vehicle.battery_percentage
    shown.add("battery_ratio", "gauge", "Charge left, 0 to 1.", None if charge is None else charge / 100.0)
    seen = status.perception
    for state in StallState:
        shown.add("stalls", "gauge", "Stalls on the map.", getattr(seen, state.value), f'{{state="{state.value}"}}')
    for item in status.parts.health:
        shown.add("healthy", "gauge", "1 when the part is healthy.", float(item.healthy), f'{{part="{item.name}"}}')


def _labels(values: Mapping[str, str]) -> str:
    escaped = (
        (name, value.replace("\\", r"\\").replace('"', r"\"").replace("\n", r"\n")) for name, value in values.items()
    )
    text = ",".join(f'{name}="{value}"' for name, value in escaped)
    return f"{{{text}}}" if text else ""


def _number(value: float) -> str:
    if math.isinf(value):
        return "+Inf" if value > 0 else "-Inf"
    return repr(float(value))
