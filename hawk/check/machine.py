"""Checks of the computer: the disk of the store, the clock, and the network that looks for stalls."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.network import NetworkMaps, StallNetwork
from hawk.algo.vision.network_file import VisionModelError
from hawk.algo.vision.rectify import GROUND_M, MAXIMUM_PIXELS
from hawk.check.result import CheckResult, failed, passed, warning
from hawk.config.sections import Config, StoreSettings, VisionSettings
from hawk.web.access.tls import RELEASED

LEAST_HZ: Final = 3.0
"""At fewer frames a second the drone must fly slower than its travel speed, or the map has holes."""
_ROUNDS: Final = 3
_LEAST_SIDE: Final = 64
_NAME: Final = "Model"

Run = Callable[[NDArray[np.uint8]], NetworkMaps]


def load_network(settings: VisionSettings) -> StallNetwork:
    """Return the network of the settings. Raises VisionModelError."""
    return StallNetwork.load(settings.model, settings.engine, settings.threads)


def look_at_model(
    config: Config,
    load: Callable[[Config], Run] = lambda config: load_network(config.vision).run,
    monotonic: Callable[[], float] = time.perf_counter,
) -> CheckResult:
    """Load the network, run it on a picture as large as the flight's, and judge its time. Blocks for some seconds."""
    cv2.setNumThreads(config.vision.threads)
    try:
        run = load(config)
        milliseconds = _time(run, ground_size(config), monotonic)
    except VisionModelError as error:
        remedy = "Name a fitting ONNX file in vision.model and an engine that is installed, or leave both out."
        return failed(_NAME, f"{error}.", remedy)
    width, height = ground_size(config)
    rate = 1000 / max(milliseconds, 1e-3)
    found = f"{milliseconds:.0f} ms for a frame of {width} x {height} at {config.heights.desired_m:g} m"
    words = f"{found}: {rate:.1f} frames a second at most."
    if rate >= LEAST_HZ:
        return passed(_NAME, words)
    remedy = (
        "Free the processor, raise vision.threads, install the extra onnxruntime, fly lower or slower, or use a faster "
        "computer."
    )
    return warning(_NAME, f"{words[:-1]}, {LEAST_HZ:g} are needed.", remedy)


def ground_size(config: Config) -> tuple[int, int]:
    """Return (width, height) in pixels of the rectified picture that a 16:9 camera gives at the desired height."""
    metres = 2 * config.heights.desired_m * math.tan(math.radians(config.camera.horizontal_fov_deg) / 2)
    width, height = metres / GROUND_M, metres / GROUND_M * 9 / 16
    shrink = min(1.0, MAXIMUM_PIXELS[0] / width, MAXIMUM_PIXELS[1] / height)
    return max(_LEAST_SIDE, round(width * shrink)), max(_LEAST_SIDE, round(height * shrink))


def _time(run: Run, size: tuple[int, int], monotonic: Callable[[], float]) -> float:
    """Return the least time of some runs, milliseconds: the first one allocates."""
    picture = np.random.default_rng(1).integers(0, 255, (size[1], size[0], 3), np.uint8)
    spent = []
    for _ in range(_ROUNDS):
        begun = monotonic()
        run(picture)
        spent.append(monotonic() - begun)
    return min(spent) * 1000


PROBE_BYTES: Final = 4_000_000
SLOW_BYTES_S: Final = 2_000_000.0
"""Below this speed of a written and synchronised file, bytes a second, a recording may lose messages."""
HOUR_S: Final = 3600.0
_TIMEDATECTL_S: Final = 3.0
_MB: Final = 1_000_000


@dataclass(frozen=True, slots=True)
class DiskReading:
    """The store's disk. ``problem``: why it cannot be written, empty when it can. Bytes, and bytes a second."""

    folder: Path
    free: int = 0
    write_speed: float = 0.0
    problem: str = ""
    is_new: bool = False
    """The folder does not exist yet; the daemon makes it."""
    owner: int | None = None
    """User who owns the folder."""


def read_disk(
    folder: Path,
    free_bytes: Callable[[Path], int] = lambda path: shutil.disk_usage(path).free,
    monotonic: Callable[[], float] = time.monotonic,
) -> DiskReading:
    """Write, synchronise and remove a small file; return what was found. A missing folder is not made.

    The daemon's user makes it: a folder that root makes, the daemon cannot write.
    """
    place = folder
    while not place.exists() and place != place.parent:
        place = place.parent
    is_new = place != folder
    try:
        free, owner = free_bytes(place), place.stat().st_uid
        if is_new:
            problem = "" if os.access(place, os.W_OK | os.X_OK) else f"{place} cannot be written by this user"
            return DiskReading(folder, free, 0.0, problem, is_new=True, owner=owner)
        return DiskReading(folder, free, _write(folder, monotonic), owner=owner)
    except OSError as error:
        return DiskReading(folder, problem=f"{folder}: {error.strerror or error}", is_new=is_new)


def _write(folder: Path, monotonic: Callable[[], float]) -> float:
    """Return the speed of a synchronised write, bytes a second. Raises OSError."""
    probe = folder / f".check-{os.getpid()}"
    begun = monotonic()
    try:
        with probe.open("xb") as file:
            file.write(bytes(PROBE_BYTES))
            file.flush()
            os.fsync(file.fileno())
    finally:
        probe.unlink(missing_ok=True)
    return PROBE_BYTES / max(monotonic() - begun, 1e-6)


def disk_results(
    reading: DiskReading, store: StoreSettings, picture_bytes_s: float | None, user: int
) -> list[CheckResult]:
    """Judge the disk.

    Args:
        reading: The disk.
        store: Settings of the store.
        picture_bytes_s: Bytes a second that the camera sends, of which a recording keeps as many at most; None where
            no picture was received.
        user: Number of the user who checks.
    """
    if reading.problem:
        remedy = f"Give the folder to the daemon's user: chown hawk {reading.folder}; or name another store.directory."
        return [failed("Store", f"The store cannot be written: {reading.problem}.", remedy)]
    return [_folder(reading, user), _room(reading, store, picture_bytes_s)]


def _folder(reading: DiskReading, user: int) -> CheckResult:
    if user == 0 and reading.owner != 0:
        value = f"{reading.folder} belongs to another user, and root can write everything."
        return warning("Store", value, "Check as the daemon's user: sudo -u hawk hawk-drone check.")
    if reading.is_new:
        return passed("Store", f"{reading.folder} does not exist yet; the daemon can make it.")
    speed = f"{reading.write_speed / _MB:.1f} MB/s"
    if reading.write_speed < SLOW_BYTES_S:
        value = f"{reading.folder} can be written, but slowly: {speed}."
        return warning("Store", value, "Use a faster card or disk: recordings may lose messages.")
    return passed("Store", f"{reading.folder} can be written, {speed}.")


def _room(reading: DiskReading, store: StoreSettings, picture_bytes_s: float | None) -> CheckResult:
    free, least = reading.free / _MB, float(store.minimum_free_mb)
    remedy = "Make room: old recordings are in the store's folder recordings."
    if free <= least:
        value = f"{free:.0f} MB are free, recording stops at {least:.0f} MB (store.minimum_free_mb)."
        return failed("Disk space", value, remedy)
    if not store.record:
        return passed("Disk space", f"{free:.0f} MB are free; nothing is recorded (store.record).")
    if picture_bytes_s is None:
        return passed("Disk space", f"{free:.0f} MB are free; what a flight needs is known with pictures only.")
    hours = (free - least) * _MB / max(picture_bytes_s * HOUR_S, 1.0)
    value = f"{free:.0f} MB are free: {hours:.1f} hours of recording at most {picture_bytes_s / _MB:.1f} MB/s."
    return passed("Disk space", value) if hours >= 1.0 else warning("Disk space", value, remedy)


def program_date(module: Path = Path(__file__)) -> datetime:
    """Return the time that no right clock is before: the release, or the time this program's files were written."""
    try:
        return max(RELEASED, datetime.fromtimestamp(module.stat().st_mtime, UTC))
    except OSError:
        return RELEASED


def is_synchronized() -> bool | None:
    """Return what systemd says of the clock's synchronisation; None where it says nothing. Blocks for 3 s at most."""
    if shutil.which("timedatectl") is None:
        return None
    command = ["timedatectl", "show", "--property=NTPSynchronized", "--value"]
    try:
        ended = subprocess.run(command, capture_output=True, text=True, timeout=_TIMEDATECTL_S, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return {"yes": True, "no": False}.get(ended.stdout.strip())


def clock_result(now: datetime, not_before: datetime, synchronized: bool | None) -> CheckResult:
    """Judge the system's clock: recordings, logins and certificates need it."""
    shown = now.strftime("%Y-%m-%d %H:%M:%S UTC")
    remedy = "Let the computer reach a time server once (timedatectl set-ntp true), or set it: sudo date -s."
    if now < not_before:
        return failed("Clock", f"It is {shown} here, before this program was written ({not_before:%Y-%m-%d}).", remedy)
    if synchronized is False:
        return warning("Clock", f"It is {shown} here; no time server has confirmed it.", remedy)
    return passed("Clock", f"It is {shown} here{', by a time server' if synchronized else ''}.")
