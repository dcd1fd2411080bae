"""When the place's witness doubts a drawn flight, and the figures of many."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from multiprocessing import get_context

import cv2

from benchmarks.figures import Figure, Limit, Section
from benchmarks.witness.drawn import FAST_M_S, Named
from benchmarks.witness.flight import Flight
from hawk.ddc.witnesses.place import PlaceReading

LATE_FAST_M, LATE_SLOW_M = 4.0, 8.0
"""Farthest that a position may go wrong before it is doubted: by a walk of at least `FAST_M_S`, and by a slower one."""


@dataclass(frozen=True, slots=True)
class Result:
    """A flight: seconds flown, and when and how far (metres) the position had gone when it was doubted; inf: never.

    ``is_false``: it was doubted before it walked. ``seen``: share of the pictures that were compared.
    """

    name: str
    phase: str
    speed: float
    seconds: float
    doubted_at: float
    late_m: float
    is_false: bool
    seen: float


def flown(flight: Named) -> Result:
    """Fly until the position is doubted, or to the end."""
    cv2.setNumThreads(1)
    reading, count, seen, now = PlaceReading(), 0, 0, 0.0
    for glance in Flight(*flight.drawn()).glances():
        count, now = count + 1, glance.time
        if glance.step is None:
            continue
        seen += 1
        reading.note(glance.step)
        if reading.facts(now).is_doubted:
            is_false = now < flight.setting.walk_at
            return Result(flight.name, flight.phase, flight.speed, now, now, glance.gone, is_false, seen / count)
    return Result(flight.name, flight.phase, flight.speed, now, math.inf, math.inf, False, seen / max(1, count))


def all_flown(flights: Iterable[Named], processes: int) -> Iterator[Result]:
    """Fly all, those over one world in one process; say each on standard error."""
    parts = [list(part) for _, part in groupby(flights, key=lambda flight: (flight.world, flight.is_poor))]
    with get_context("spawn").Pool(processes) as pool:
        for results in pool.imap_unordered(_part, parts):
            for result in results:
                print(line(result), file=sys.stderr, flush=True)
                yield result


def _part(flights: list[Named]) -> list[Result]:
    return [flown(flight) for flight in flights]


def line(result: Result) -> str:
    """Return one flight in words."""
    if result.is_false:
        what = f"FALSE DOUBT after {result.doubted_at:.0f} s"
    elif math.isfinite(result.late_m):
        what = f"doubted after {result.late_m:.1f} m"
    else:
        what = "not doubted" if result.speed else "no doubt"
    return f"{result.name}: {what}, {result.seconds:.0f} s, {100 * result.seen:.0f} % of the pictures compared"


def sections(
    honest: Sequence[Result], walks: Sequence[Result], high: Sequence[Result], tasks: Sequence[Result]
) -> list[Section]:
    """Return the figures."""
    fast = [each for each in walks if each.speed >= FAST_M_S - 1e-9]
    slow = [each for each in walks if each.speed < FAST_M_S - 1e-9]
    false = sum(each.is_false for each in honest)
    walked = [*walks, *high, *tasks]
    return [
        Section(
            "walks while the drone holds",
            [
                *_late("late_fast_m", f"gone before the doubt, at {FAST_M_S} m/s and more", fast, LATE_FAST_M),
                *_late("late_slow_m", "the same of slower walks, from 0.1 m/s", slow, LATE_SLOW_M),
            ],
        ),
        Section(
            "walks while the drone holds above the height of a survey",
            [
                Figure("high_walks", "flights", len(high)),
                Figure("high_doubted", "doubted", sum(math.isfinite(each.late_m) for each in high)),
                Figure("late_high_m_median", "gone before the doubt, median", _median(high), "m"),
            ],
        ),
        Section(
            "walks while a survey is flown",
            [
                Figure("task_walks", "flights", len(tasks)),
                Figure("task_doubted", "doubted in the task", sum(math.isfinite(each.late_m) for each in tasks)),
                Figure("late_task_m_median", "gone before the doubt, median", _median(tasks), "m"),
            ],
        ),
        Section(
            "honest receivers",
            [
                Figure("honest_flights", "flights without a walk", len(honest)),
                Figure("honest_minutes", "their time", sum(each.seconds for each in honest) / 60.0, "min"),
                Figure("false_doubts", "doubts without a walk", false, limit=Limit(highest=0.0)),
                Figure("early_flights", "flights with a walk", len(walked)),
                Figure("early_doubts", "of these doubted before it", sum(each.is_false for each in walked)),
            ],
        ),
    ]


def _late(key: str, text: str, results: Sequence[Result], limit: float) -> list[Figure]:
    worst = max((each.late_m for each in results), default=None)
    return [
        Figure(f"{key}_max", f"{text}, worst of {len(results)}", worst, "m", limit=Limit(highest=limit)),
        Figure(f"{key}_median", "its median", _median(results), "m"),
    ]


def _median(results: Sequence[Result]) -> float | None:
    late = sorted(each.late_m for each in results)
    return late[len(late) // 2] if late else None
