"""A city for tests: a grey picture of several windows, and a detector that does what files beside its network say."""

from __future__ import annotations

import contextlib
import os
import signal
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.detector import ALL_ENDS, Ends
from hawk.algo.vision.network import Engine, EngineChoice
from hawk.picture.city.job import Job
from hawk.picture.orthophoto.source import Orthophoto, open_orthophoto
from hawk.picture.orthophoto.steps import tasks_of
from hawk.picture.orthophoto.tile_detector import LOT_M, TileDetections, TileDetector, program_name
from hawk.picture.orthophoto.windows import Task, windows_of
from hawk.picture.values import PictureError
from tests.unit.picture.orthophoto.drawn import UTM, placed, write

CORE_M = 20.0
WINDOWS = 12
SHA = "5" * 64
_KILL, _BROKEN, LOOKS, _OTHER = "kill", "broken", "looks", "other"


class FakeDetector(TileDetector):
    """Finds a stall in the middle of each picture, wider where that is brighter, and writes down each look."""

    def __init__(self, folder: Path, engine: EngineChoice, sha: str) -> None:
        self._folder = folder
        self._chosen: Engine = "opencv" if engine == "auto" else engine
        self.model = sha

    @property
    def engine(self) -> Engine:
        return self._chosen

    def detect(
        self,
        image: NDArray[np.uint8],
        metres_per_pixel: float | tuple[float, float],
        valid: NDArray[np.bool_] | None = None,
        ends: Ends = ALL_ENDS,
    ) -> TileDetections:
        with (self._folder / LOOKS).open("a") as file:
            file.write(f"{os.getpid()} {os.environ.get('MALLOC_TRIM_THRESHOLD_', '')}\n")
        if (self._folder / _KILL).exists():
            (self._folder / _KILL).unlink()
            os.kill(os.getpid(), signal.SIGKILL)
        if (self._folder / _BROKEN).exists() and image.mean() > 200:
            raise PictureError("it is too bright")
        side = (0.1, 0.1) if isinstance(metres_per_pixel, float) else metres_per_pixel
        wide, high = image.shape[1] * side[0], image.shape[0] * side[1]
        half = np.array([(-1, -2.5), (1, -2.5), (1, 2.5), (-1, 2.5)]) * (1.2 + image.mean() / 1000, 1.0)
        lot = np.ones((round(high / LOT_M), round(wide / LOT_M)), np.bool_)
        stalls = (half + np.array([wide / 2, high / 2]))[None]
        return TileDetections(stalls, np.array([0.9]), np.array([0.8]), lot, np.zeros((0, 4, 2)))


def load_fake(model: Path | None, engine: EngineChoice) -> TileDetector:
    """Load the detector of the folder in which the network's file would be; another one in a worker if asked."""
    assert model is not None
    return FakeDetector(model.parent, engine, SHA)


def looks(folder: Path) -> int:
    """Return how often detectors of a folder have looked."""
    return len((folder / LOOKS).read_text().splitlines()) if (folder / LOOKS).exists() else 0


def city(folder: Path) -> Path:
    """Write a picture of 80 by 60 m, brighter to the right and to the bottom."""
    row, column = np.mgrid[:600, :800]
    grey = (column / 5 + row / 4).clip(0, 255).astype(np.uint8)
    return write(folder / "city.tif", np.stack([grey] * 3), placed(UTM, 800, 600))


def windows(folder: Path) -> tuple[Orthophoto, tuple[Task, ...]]:
    """Return a city and its tasks."""
    source = open_orthophoto(city(folder))
    return source, tasks_of(source, windows_of(source, core_m=CORE_M), SHA, "opencv")


def job_of(folder: Path, source: Orthophoto) -> Job:
    """Return the job of a city, marked, with its folders."""
    out = folder / "out"
    out.mkdir()
    (out / ".run-1").touch()
    return Job(source, None, folder / "model", SHA, program_name(SHA), "opencv", out, load_fake, ".run-1")


def break_bright(folder: Path, is_broken: bool = True) -> None:
    """Let detectors of a folder fail at bright windows, or no longer."""
    if is_broken:
        (folder / _BROKEN).touch()
    else:
        (folder / _BROKEN).unlink()


def kill_once(folder: Path) -> None:
    """Let the next look of a detector of a folder end its process."""
    (folder / _KILL).touch()


def spawned() -> list[int]:
    """Return the processes that this one has started by spawning Python, by proc(5)."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            parent = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
            if parent == os.getpid() and b"spawn_main" in (folder / "cmdline").read_bytes():
                found.append(int(folder.name))
    return found
