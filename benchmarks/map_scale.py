"""Cost of a large map against a small one: a lot that grows to many hectares, and the same flight over each.

``python -m benchmarks.map_scale [--hectares 100] [--json FILE]``

A map of 1, 10, 30 and 100 ha (up to ``--hectares``) is read from what an earlier flight left in the journal, each in a
process of its own; then the drone flies across its border, half over known ground and half over new. Times are
processor milliseconds of one thread, so that other programs do not matter; the last column of each stage is the
ratio to the smallest map's figure of the same run.
"""

from __future__ import annotations

import argparse
import asyncio
import ctypes
import gc
import json
import math
import multiprocessing
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.still_drone import StillDrone
from benchmarks.wide_lot import WideLot
from hawk.algo.frame import FrameInput
from hawk.algo.mapper.app import MapperApp
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.topic_interface import AlgorithmTopicInterface
from hawk.algo.vision.detection import VisionResult
from hawk.model.lot_map import TILE_M, OccupancyMap
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import DesiredPose, HeightParameters
from hawk.model.poses import MapPoint, MapPose
from hawk.store.journal import FlightJournal
from hawk.web.clients import ClientView
from hawk.web.sessions import ControlView

STAGES: Final = (1.0, 10.0, 30.0, 100.0)
FRAMES: Final = 160
STEP_M: Final = 1.0
FRAME_S: Final = 0.25
HEIGHT_M: Final = 35.0
MOVE_M: Final = 80.0
CAMERA: Final = CameraModel(1280, 720, 914.0, 914.0, 640.0, 360.0)
LIMITS: Final = {"update_ms_p99": 10.0, "memory_mb_per_ha": 5.0, "heartbeat_bytes_max": 72_000.0}
TEXTS: Final = {
    "update_ms_p50": "Mapper update, median, ms",
    "update_ms_p99": "Mapper update, p99, ms",
    "explore_ms_p50": "Exploration step, median, ms",
    "explore_ms_p99": "Exploration step, p99, ms",
    "route_ms_p50": "Route of a move of 80 m planned, median, ms",
    "route_ms_p99": "Route of a move of 80 m planned, p99, ms",
    "recheck_ms_p99": "Route looked at again, p99, ms",
    "tick_ms_p50": "Tick of the state machine, median, ms",
    "tick_ms_p99": "Tick of the state machine, p99, ms",
    "heartbeat_ms_p50": "One client's heartbeat built, median, ms",
    "heartbeat_ms_p99": "One client's heartbeat built, p99, ms",
    "heartbeat_bytes_p50": "Heartbeat in flight, median, bytes",
    "heartbeat_bytes_max": "Heartbeat while the whole map is sent, most, bytes",
    "sync_ms_max": "Heartbeat while the whole map is sent, longest, ms",
    "journal_ms_p99": "Changes gathered for the journal, p99, ms",
    "journal_bytes_p50": "Changes for the journal, median, bytes",
    "memory_mb": "Resident memory of the map, MB",
    "memory_mb_per_ha": "Resident memory of the map, MB/ha",
    "stalls": "Stalls",
}
NOT_FLAT: Final = frozenset({"memory_mb", "stalls", "memory_mb_per_ha"})
"""Figures without a ratio: they grow, or are rates already."""


@dataclass
class Samples:
    """Milliseconds and bytes by name."""

    values: dict[str, list[float]] = field(default_factory=dict)

    @contextmanager
    def timed(self, name: str) -> Iterator[None]:
        """Take the processor time of this thread."""
        started = time.thread_time()
        yield
        self.add(name, (time.thread_time() - started) * 1e3)

    def add(self, name: str, value: float) -> None:
        """Take one value."""
        self.values.setdefault(name, []).append(value)

    def figure(self, key: str) -> float | None:
        """Return the figure of a key such as ``update_ms_p99``; None when nothing was measured."""
        name, _, kind = key.rpartition("_")
        found = self.values.get(name)
        if not found:
            return None
        share = {"p50": 50.0, "p99": 99.0, "max": 100.0}[kind]
        return round(float(np.percentile(found, share)), 4)


class Stage:
    """One map of a size, and everything that works on it."""

    def __init__(self, hectares: float) -> None:
        self.hectares = hectares
        self.lot = WideLot(hectares)
        self.samples = Samples()
        self.interface = AlgorithmTopicInterface()
        self.mapper = MapperApp()
        self.planner = PathPlanApp()
        self.planner.init(self.mapper, self.interface)
        self.view = ClientView()
        self.version = 0

    async def run(self, folder: Path) -> dict[str, float | None]:
        """Measure and return every figure."""
        parts = self.lot.parts()
        before = resident_mb()
        journal = FlightJournal(folder / "journal")
        journal.put_map(parts)
        problems = self.mapper.restore([parts])
        if problems:
            raise RuntimeError(f"the drawn map cannot be read: {problems[0]}")
        self.version = self.mapper.changes_since(0).version
        drone = StillDrone(folder)
        try:
            self._send_everything(drone)
            self._fly(drone)
        finally:
            await drone.close()
            await journal.close()
        held = sum(map(len, parts.values())) / 1e6  # made before: the journal and the map share these bytes
        memory = resident_mb() - before + held
        figures = {key: self.samples.figure(key) for key in TEXTS if key.rpartition("_")[2] in ("p50", "p99", "max")}
        mapped = len(self.mapper.get_occupancy_map().tiles) * TILE_M**2 / 1e4
        return figures | {
            "memory_mb": round(memory, 1),
            "memory_mb_per_ha": round(memory / mapped, 2),
            "stalls": float(len(self.mapper.get_occupancy_map().stalls)),
        }

    def _fly(self, drone: StillDrone) -> None:
        for number in range(FRAMES):
            east = self.lot.half - (FRAMES / 2 - number) * STEP_M
            pose = MapPose(0.0, east, HEIGHT_M, 0.0, 0.0, 0.0)
            seen = VisionResult(park_lot_detected=True, ground=self.lot.look(pose, number * FRAME_S))
            frame = _frame(number, pose)
            self.interface.begin(frame)
            with self.samples.timed("update_ms"):
                self.mapper.fuse(frame, seen)
            with self.samples.timed("explore_ms"):
                self.planner.process()
            self._plan_move(number)
            current = self.mapper.get_occupancy_map()
            self._tick(drone, current)
            self._beat(drone, current, "heartbeat")
            if number % 2:
                with self.samples.timed("journal_ms"):
                    changes = self.mapper.changes_since(self.version)
                self.version = changes.version
                self.samples.add("journal_bytes", float(sum(map(len, changes.parts.values()))))

    def _plan_move(self, number: int) -> None:
        """Every eighth time a new move is planned inside the known lot, else the last one is looked at again."""
        pose = MapPose(0.1 * (number // 8), self.lot.half - 8.0, HEIGHT_M, 0.0, 0.0, 0.0)
        target = DesiredPose(number // 8, 20.0, pose.east - MOVE_M)
        self.interface.begin(_frame(number, pose, StateName.AUTONOMOUS_MOVE, target))
        with self.samples.timed("recheck_ms" if number % 8 else "route_ms"):
            self.planner.process()
        verdict = self.planner.get_local_pose().verdict
        if verdict is None or len(verdict.route.points) < 2:
            raise RuntimeError(f"no route over the drawn lot: {verdict}")

    def _tick(self, drone: StillDrone, current: OccupancyMap) -> None:
        drone.see(current)
        for _ in range(4):
            drone.advance()
            with self.samples.timed("tick_ms"):
                drone.manager.process()

    def _beat(self, drone: StillDrone, current: OccupancyMap, name: str) -> str:
        status = drone.status
        assert status.shared_json  # encoded once for all clients
        with self.samples.timed(f"{name}_ms"):
            text = self.view.heartbeat(status, current, ControlView())
        self.samples.add(f"{name}_bytes", float(len(text)))
        return text

    def _send_everything(self, drone: StillDrone) -> None:
        """Bring a client that knows nothing up to date, as a page that is opened late."""
        current = self.mapper.get_occupancy_map()
        drone.see(current)
        drone.advance()
        drone.manager.process()
        backlog = 1
        while backlog:
            text = self._beat(drone, current, "sync")
            backlog = json.loads(text)["Occupancy Map"]["Backlog"]
        self.samples.values["heartbeat_bytes"] = []
        self.most = max(self.samples.values["sync_bytes"])


def measure(hectares: float) -> dict[str, float | None]:
    """Measure one size; to be called in a fresh process."""
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory(prefix="hawk-scale-") as folder:
        stage = Stage(hectares)
        figures = asyncio.run(stage.run(Path(folder)))
    figures["heartbeat_bytes_max"] = stage.most
    return figures


def resident_mb() -> float:
    """Return the process's resident memory after everything free was given back."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 1e6


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.map_scale", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--hectares", type=_hectares, default=100.0, help="the largest map (1 to 400, default 100)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every figure as one flat object")
    options = parser.parse_args(arguments)
    sizes = sizes_up_to(options.hectares)
    context = multiprocessing.get_context("spawn")
    found = {}
    for size in sizes:
        print(f"measuring {size:g} ha ...", file=sys.stderr, flush=True)
        with context.Pool(1) as pool:
            found[size] = pool.apply(measure, (size,))
    print_table(found, Console(width=None if sys.stdout.isatty() else 150))
    if options.json is not None:
        options.json.parent.mkdir(parents=True, exist_ok=True)
        options.json.write_text(json.dumps(flat(found), indent=1) + "\n")
    return 0


def sizes_up_to(hectares: float) -> tuple[float, ...]:
    """Return the sizes to measure: the usual ones below the largest, and the largest."""
    return (*(size for size in STAGES if size < hectares), hectares)


def flat(found: dict[float, dict[str, float | None]]) -> dict[str, float | None]:
    """Return every figure under ``KEY_SIZEha``, its ratio under ``KEY_ratio_SIZEha``, and the limits' answers."""
    first = found[min(found)]
    values: dict[str, float | None] = {"hectares": max(found)}
    for size, figures in found.items():
        for key, value in figures.items():
            values[f"{key}_{size:g}ha"] = value
            if key not in NOT_FLAT:
                values[f"{key}_ratio_{size:g}ha"] = ratio(value, first[key])
    largest = found[max(found)]
    for key, limit in LIMITS.items():
        value = largest[key]
        values[f"{key}_holds"] = float(value is not None and value <= limit)
    return values


def ratio(value: float | None, first: float | None) -> float | None:
    """Return value / first, None when either was not measured or there is nothing to compare with."""
    if value is None or first is None or first == 0 or not math.isfinite(value):
        return None
    return round(value / first, 3)


def print_table(found: dict[float, dict[str, float | None]], console: Console) -> None:
    """Print a row a figure and two columns a size: the figure, and its ratio to the smallest map's."""
    table = Table(title="The map at scale")
    table.add_column("figure")
    sizes = sorted(found)
    for size in sizes:
        table.add_column(f"{size:g} ha", justify="right")
        if size != sizes[0]:
            table.add_column("ratio", justify="right")
    table.add_column("limit", justify="right")
    for key, text in TEXTS.items():
        cells = [text]
        for size in sizes:
            value, first = found[size].get(key), found[sizes[0]].get(key)
            cells.append(_number(value))
            if size != sizes[0]:
                cells.append("" if key in NOT_FLAT else _number(ratio(value, first)))
        table.add_row(*cells, f"≤ {LIMITS[key]:g}" if key in LIMITS else "")
    console.print(table)


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:,.2f}".replace(",", " ")


def _frame(
    number: int, pose: MapPose, state: StateName = StateName.AUTONOMOUS_EXPLORE, desired: DesiredPose | None = None
) -> FrameInput:
    return FrameInput(
        number + 1,
        number * FRAME_S,
        b"",
        CAMERA,
        pose,
        4.0,
        state,
        desired,
        HeightParameters(),
        None,
        MapPoint(0.0, 0.0),
    )


def _hectares(text: str) -> float:
    value = float(text)
    if not 1 <= value <= 400:
        raise argparse.ArgumentTypeError("1 to 400 hectares")
    return value


if __name__ == "__main__":
    sys.exit(main())
