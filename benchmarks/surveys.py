"""Whole surveys by ``hawk-drone survey --sim``, of drawn worlds and of pictures of real places: counts
against the truth, and the distance flown against the least distance that could show the lot.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import sys
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import fmean
from typing import Any, Final

from shapely.geometry import Polygon
from shapely.ops import unary_union

from benchmarks.figures import BenchmarkError, Figure, Limit, number
from hawk.config.sections import CameraSettings, HeightSettings
from hawk.model.lot_map import HELD_SHARE
from hawk.survey.run import LATE_FRAMES_LIMIT
from hawk.survey.truth import GroundTruth, read_truth

SPEEDS: Final = (2.0, 1.0, 0.5)
"""Simulated seconds per second, tried in this order: perception figures are valid at 2 and less."""
TIMEOUT_S: Final = 1200.0
LEAST_F1: Final = 0.85
LEAST_RECALL_WHOLE: Final = 0.8
COUNT_ERROR_SHARE: Final = 0.10
COUNT_ERROR_STALLS: Final = 3.0
ASPECT: Final = 720 / 1280
_ALIKE: Final = ("state_accuracy", "unknown_share", "lot_iou")
"""Values whose means are figures of drawn worlds and of places."""


@dataclass(frozen=True, slots=True)
class Survey:
    """One survey. ``bound_m``: least distance that shows the whole lot, metres."""

    name: str
    report: dict[str, Any]
    bound_m: float

    def value(self, key: str) -> float | None:
        """Return a figure of the report, None when it is not there."""
        found = self.report.get(key)
        return None if found is None else float(found)

    @property
    def count_is_right(self) -> bool:
        """True when the count of free stalls is right to 10 % or 3 stalls, whichever is more."""
        share, stalls = self.value("free_count_error"), self.value("free_count_error_stalls")
        if stalls is None:
            return False
        return abs(stalls) <= COUNT_ERROR_STALLS or (share is not None and abs(share) <= COUNT_ERROR_SHARE)

    @property
    def finished(self) -> bool:
        """True when the whole lot was seen and the drone is down with its motors off."""
        return bool(self.report.get("status") == 0 and self.report.get("landed") and self.report.get("disarmed"))


def least_distance_m(truth: GroundTruth, height_m: float, field_of_view: float) -> float:
    """Return the least distance that shows every lot, metres: (area - one picture's area) / width of a picture.

    ``field_of_view``: of the picture's longer side, radians. A camera that flies along its shorter side sweeps its
    width, and its first picture costs no distance. Ground seen twice and flights between lots are left out.
    """
    swath = 2 * height_m * math.tan(field_of_view / 2)
    area = float(unary_union([Polygon(lot).buffer(0) for lot in truth.lots]).area)
    return max(0.0, area - swath * swath * ASPECT) / swath


async def measure(seeds: Sequence[int], folder: Path, simulated: Sequence[str] = ()) -> tuple[list[Figure], str]:
    """Fly every seed; return the figures, and why they are void if they are. Raises BenchmarkError when none flew.

    ``simulated``: more options of the simulation, as ``("--condition", "night")``.
    """
    surveys = [await _fly(f"seed-{seed}", ["--seed", str(seed), *simulated], folder) for seed in seeds]
    _check_flown(surveys, folder)
    return figures(surveys), _void(surveys)


async def measure_places(lots: Path, folder: Path, cars: int | None = None) -> tuple[list[Figure], str]:
    """Fly over every picture of a folder (PLACE.jpg, PLACE.json with ``metres_per_pixel`` and the truth).

    ``cars`` is the seed by which the pictures' cars are moved to other stalls; None: they stay. Raises BenchmarkError
    when there is none or none was flown.
    """
    moved = [] if cars is None else [f"--cars={cars}"]
    surveys = [await _fly(name, [*world, *moved], folder) for name, world in place_worlds(lots)]
    _check_flown(surveys, folder)
    return place_figures(surveys), _void(surveys)


def place_worlds(lots: Path) -> list[tuple[str, list[str]]]:
    """Return name and options of every place of a folder. Raises BenchmarkError for a file that misfits."""
    worlds = []
    for truth in sorted(lots.glob("*.json")):
        try:
            scale = str(float(json.loads(truth.read_text())["metres_per_pixel"]))
        except (KeyError, TypeError, ValueError) as error:
            raise BenchmarkError(f"{truth}: metres_per_pixel is missing or not a number ({error})") from error
        picture = str(truth.with_suffix(".jpg"))
        worlds.append((truth.stem, ["--world", picture, "--metres-per-pixel", scale, "--truth", str(truth)]))
    if not worlds:
        raise BenchmarkError(f"--places: {lots} holds no PLACE.json; name a folder of PLACE.jpg with PLACE.json")
    return worlds


def place_figures(surveys: Sequence[Survey]) -> list[Figure]:
    """Return the figures of all places together: means of the places, each counting alike."""
    recall = _mean(_values(surveys, "recall_whole"))
    return [
        *_flights(surveys, "places"),
        Figure("places_recall_whole", "recall of whole stalls, mean", recall, limit=Limit(lowest=LEAST_RECALL_WHOLE)),
        Figure("places_recall_whole_min", "recall of whole stalls, worst", _least(surveys, "recall_whole")),
        *_means(surveys, "places_", "precision_star", "free_recall", *_ALIKE, "duration_s"),
        *_seen(surveys, "places_"),
    ]


def figures(surveys: Sequence[Survey]) -> list[Figure]:
    """Return the figures of all surveys together."""
    f1 = _values(surveys, "stall_f1")
    errors = [abs(value) for value in _values(surveys, "free_count_error")]
    flown = [
        (distance, s.bound_m)
        for s in surveys
        if (distance := s.value("distance_flown_m")) is not None and s.bound_m > 0
    ]
    return [
        *_flights(surveys, "surveys"),
        Figure("stall_f1", "stall F1, mean", _mean(f1)),
        Figure("stall_f1_min", "stall F1, worst seed", min(f1, default=None), limit=Limit(lowest=LEAST_F1)),
        *_means(surveys, "", "recall_whole", *_ALIKE),
        *_seen(surveys, ""),
        Figure("free_count_error", "free-count error, mean size", _mean(errors)),
        Figure("free_count_error_max", "free-count error, worst seed", max(errors, default=None)),
        Figure(
            "free_counts_right", "counts within max(10 %, 3 stalls)", float(sum(s.count_is_right for s in surveys)),
            limit=Limit(lowest=float(len(surveys))),
        ),
        Figure(
            "free_in_range", "counts whose interval holds the true number, share",
            _mean(_values(surveys, "free_in_range")), limit=Limit(lowest=HELD_SHARE),
        ),
        Figure("distance_flown_m", "distance flown, mean", _mean([distance for distance, _ in flown]), "m"),
        Figure("distance_bound_m", "least distance, mean", _mean([bound for _, bound in flown]), "m"),
        Figure("distance_over_bound", "distance flown by least distance, mean", _mean([a / b for a, b in flown])),
        Figure("surveys_duration_s", "take-off to disarmed, mean", _mean(_values(surveys, "duration_s")), "s"),
    ]  # fmt: skip


def _flights(surveys: Sequence[Survey], name: str) -> list[Figure]:
    """Return how the flights went."""
    count, excursions = float(len(surveys)), _values(surveys, "excursions")
    finished = float(sum(s.finished for s in surveys))
    late = max(_values(surveys, "late_frames"), default=None)
    out = sum(excursions) if excursions else None
    return [
        Figure(name, name, count),
        Figure(f"{name}_finished", "finished, landed and disarmed", finished, limit=Limit(lowest=count)),
        Figure(f"{name}_excursions", "excursions, all flights", out, limit=Limit(0, 0)),
        Figure(f"{name}_late_frames", "late frames, worst", late, limit=Limit(highest=LATE_FRAMES_LIMIT)),
    ]


def _means(surveys: Sequence[Survey], prefix: str, *keys: str) -> list[Figure]:
    return [Figure(f"{prefix}{key}", f"{key.replace('_', ' ')}, mean", _mean(_values(surveys, key))) for key in keys]


def _seen(surveys: Sequence[Survey], prefix: str) -> list[Figure]:
    """Return what of lot and stalls was ever in view, beside what was found of it."""
    texts = {
        "lot_seen": "share of the true lot ever in view, mean",
        "stalls_seen": "share of the true stalls ever in view, mean",
        "stall_recall_seen": "recall of stalls ever in view, mean",
    }
    return [Figure(f"{prefix}{key}", text, _mean(_values(surveys, key))) for key, text in texts.items()]


async def _fly(name: str, world: Sequence[str], folder: Path) -> Survey:
    """Survey one world and report on it."""

    async def fly(speed: float) -> Survey:
        return await _fly_at(speed, name, world, _made(folder / name / f"speed-{speed:g}"))

    survey = await in_time(name, fly)
    print(_line(survey), file=sys.stderr, flush=True)
    return survey


async def in_time(name: str, fly: Callable[[float], Awaitable[Survey]]) -> Survey:
    """Fly at ever lower speeds, which ``fly`` gets, until few enough pictures were late; return the last flight.

    Only lateness decides whether a flight is flown again, never what it found: the figures of those that remain are
    not chosen. The slowest flight is returned also when it was late: its figures are void.
    """
    for speed, slower in pairwise(SPEEDS):
        flight = await fly(speed)
        if _late(flight) <= LATE_FRAMES_LIMIT:
            return flight
        words = f"{name}: {_late(flight):.0%} of the pictures came late at speed {speed:g}; flown again at {slower:g}"
        print(words, file=sys.stderr, flush=True)
    return await fly(SPEEDS[-1])


async def _fly_at(speed: float, name: str, world: Sequence[str], folder: Path) -> Survey:
    command = [sys.executable, "-m", "hawk.cli", "survey", "--sim", "--speed", f"{speed:g}", *world]
    with (folder / "survey.log").open("wb") as log:
        process = await asyncio.create_subprocess_exec(
            *command, "--out", str(folder), "--quiet", stdin=asyncio.subprocess.DEVNULL, stdout=log, stderr=log
        )
        try:
            async with asyncio.timeout(TIMEOUT_S):
                await process.wait()
        except TimeoutError:
            print(f"{name}: not home after {TIMEOUT_S:.0f} s", file=sys.stderr)
        finally:
            await _end(process)
    return _result(name, folder)


def _check_flown(surveys: Sequence[Survey], folder: Path) -> None:
    if not any(survey.report for survey in surveys):
        raise BenchmarkError(f"no survey was flown; see the logs in {folder}")


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder


async def _end(process: asyncio.subprocess.Process) -> None:
    """Interrupt, so that the survey ends what it started; by force when it does not listen."""
    if process.returncode is not None:
        return
    for end, patience in ((process.terminate, 60.0), (process.kill, 5.0)):
        with contextlib.suppress(ProcessLookupError):
            end()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(patience):
                await process.wait()
            return


def _result(name: str, folder: Path) -> Survey:
    """Read what a survey wrote; an empty report when it did not get so far."""
    try:
        report = json.loads((folder / "report.json").read_text())
        truth = read_truth(folder / "run" / "truth.json")
    except (OSError, ValueError) as error:
        print(f"{name}: no result ({error}); see {folder / 'survey.log'}", file=sys.stderr)
        return Survey(name, {}, 0.0)
    view = math.radians(CameraSettings().horizontal_fov_deg)
    return Survey(name, report, least_distance_m(truth, HeightSettings().desired_m, view))


def _void(surveys: Sequence[Survey]) -> str:
    late = [survey.name for survey in surveys if _late(survey) > LATE_FRAMES_LIMIT]
    return f"VOID: the simulator drew too late for {', '.join(late)}" if late else ""


def _late(survey: Survey) -> float:
    return survey.value("late_frames") or 0.0


def _line(survey: Survey) -> str:
    keys = (
        "stall_f1", "recall_whole", "precision_star", "free_recall", "state_accuracy", "lot_iou",
        "free_count_error_stalls", "excursions", "distance_flown_m", "duration_s", "late_frames",
    )  # fmt: skip
    values = ", ".join(f"{key} {number(survey.value(key))}" for key in keys)
    return f"{survey.name}: {values}, least distance {survey.bound_m:.0f} m: {survey.report.get('reason', 'no result')}"


def _values(surveys: Sequence[Survey], key: str) -> list[float]:
    return [value for survey in surveys if (value := survey.value(key)) is not None]


def _least(surveys: Sequence[Survey], key: str) -> float | None:
    return min(_values(surveys, key), default=None)


def _mean(values: Sequence[float]) -> float | None:
    return fmean(values) if values else None
