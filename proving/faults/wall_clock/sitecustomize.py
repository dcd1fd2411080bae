"""A wall clock that is off: Python imports this before a program whose PYTHONPATH has this folder (site module).

`time.time` is off by the seconds in the file that FAULTS_WALL_CLOCK names; clocks that cannot step stay.
"""

from __future__ import annotations

import os
import time

_real = time.time


def _off() -> float:
    try:
        with open(os.environ["FAULTS_WALL_CLOCK"]) as file:
            return float(file.read() or 0.0)
    except (OSError, ValueError):
        return 0.0


def _shifted() -> float:
    return _real() + _off()


if "FAULTS_WALL_CLOCK" in os.environ:
    time.time = _shifted
