"""The baseline: windows by their numbers, without a scheduler.

``seq 0 399 | xargs -P 2 -n 100 python -m benchmarks.city.plain SOURCE OUT CORE``: each process opens the picture and
loads the detector once, then looks at its hundred windows.
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2

from hawk.picture.orthophoto.source import open_orthophoto
from hawk.picture.orthophoto.steps import map_task, tasks_of
from hawk.picture.orthophoto.tile_detector import TileDetector
from hawk.picture.orthophoto.tile_results import Results
from hawk.picture.orthophoto.windows import windows_of


def main(source: str, out: str, core: str, *numbers: str) -> None:
    """Look at the windows of a picture that have these numbers."""
    cv2.setNumThreads(1)
    picture = open_orthophoto(Path(source).resolve())
    detector = TileDetector.load()
    tasks = tasks_of(picture, windows_of(picture, core_m=float(core)), detector.model, detector.engine)
    results = Results(Path(out).resolve())
    results.prepare()
    for number in numbers:
        map_task(tasks[int(number)], picture, detector, results)


if __name__ == "__main__":
    main(*sys.argv[1:])
