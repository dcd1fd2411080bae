"""The same windows by Ray, which the project does not install.

``python -m benchmarks.city.ray_baseline SOURCE OUT CORE WORKERS`` with a Python that has Ray beside hawk's packages
(docs/results/city.md). The last line that it prints is JSON: seconds from the start of Ray to the last window, and
the largest memory of an actor.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

import cv2

from benchmarks.city.once import peak_mib
from hawk.picture.orthophoto.source import open_orthophoto
from hawk.picture.orthophoto.steps import map_task, tasks_of
from hawk.picture.orthophoto.tile_detector import TileDetector
from hawk.picture.orthophoto.tile_results import Results
from hawk.picture.orthophoto.windows import Task, windows_of


class Looker:
    """A worker: it loads the detector once."""

    def __init__(self, source: Path, out: Path) -> None:
        """``source``: the picture; ``out``: the folder of results."""
        cv2.setNumThreads(1)
        self._source = open_orthophoto(source)
        self._detector = TileDetector.load()
        self._results = Results(out)

    def look(self, task: Task) -> float:
        """Look at a window; return this process's largest memory, MiB."""
        map_task(task, self._source, self._detector, self._results)
        return peak_mib(os.getpid())


def main(source: str, out: str, core: str, workers: str) -> None:
    """Look at all windows and print."""
    ray: Any = importlib.import_module("ray")
    began = time.monotonic()
    ray.init(num_cpus=int(workers), include_dashboard=False, logging_level="ERROR")
    path, folder = Path(source).resolve(), Path(out).resolve()
    picture, detector = open_orthophoto(path), TileDetector.load()
    tasks = tasks_of(picture, windows_of(picture, core_m=float(core)), detector.model, detector.engine)
    Results(folder).prepare()
    actor = ray.remote(num_cpus=1)(Looker)
    pool = importlib.import_module("ray.util").ActorPool([actor.remote(path, folder) for _ in range(int(workers))])
    most = max(pool.map_unordered(lambda looker, task: looker.look.remote(task), tasks))
    print(json.dumps({"seconds": time.monotonic() - began, "windows": len(tasks), "mib_worker": most}))


if __name__ == "__main__":
    main(*sys.argv[1:])
