"""Cost of storing and registering a survey of a known lot, of statistics, and of recordings: seconds, bytes, lag.

``python -m benchmarks.archive [--json FILE]``

A lot of 300 and one of 2,000 stalls are flown over again, each time with other cars, 4 % of the stalls missed, 0.15 m
of error a stall, GNSS 2 m off and 1.5 degrees of turn about the middle. A survey goes through the daemon's store and
registration, on the store's thread, while an event loop runs a timer every 10 ms. The median of the surveys after the
first one counts: the first one loads libraries. Then every call for statistics and every reading of the API is timed
over a thousand surveys of 300 stalls, four a day. `benchmarks.recording` measures the recording of a flight,
`benchmarks.replayed` its replay.
"""

from __future__ import annotations

import asyncio
import math
import statistics
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from sqlalchemy import Connection, select

from benchmarks import recording, replayed
from benchmarks.archive_calls import SURVEYS, Calls, measure_calls
from benchmarks.archive_files import PACKED
from benchmarks.figures import Figure, Limit, Section, print_and_write
from benchmarks.options import make_parser
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots.ingest import save
from hawk.lots.registration.frames import Move
from hawk.lots.storage.schema import OBSERVATION, STALL
from hawk.lots.store import LotStore
from hawk.lots.values import Detection, FinishedSurvey, Placed, Saved
from hawk.model.lot_map import StallState
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import to_global
from hawk.runtime.performance import LoopLag

SIZES: Final = (300, 2000)
FLIGHTS: Final = 5
DATUM: Final = GlobalPose(52.0, 5.0, 0.0)
BIAS: Final = Move(1.6, -1.2, math.radians(1.5))
MISSED: Final = 0.04
ERROR_M: Final = 0.15
_BEGAN: Final = 1_770_000_000.0
_PITCH_M, _DEEP_M, _APART_M = 2.5, 5.0, 9.0
_DAY_S: Final = 86_400.0
_AROUND_M: Final = 10.0
_LIMITS: Final = {300: 3.0, 2000: 10.0}
_BYTES: Final = 40_000
_LAG_MS: Final = 20.0
_CALL_MS: Final = 100.0
_COG_S: Final = 10.0
_GPKG_S: Final = 3.0
_RECORD_CPU: Final = 0.05
_REPLAY_X: Final = 20.0
_PROCESS_X: Final = 2.0


@dataclass(frozen=True, slots=True)
class Measured:
    """Costs of the surveys of one lot after the first: seconds each, bytes a survey, and which stalls were right."""

    seconds: list[float] = field(repr=False)
    size: float
    wrong: int
    registered: int


def drawn_lot(count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the centres (N, 2) of stalls about their middle: rows of drawn lengths that begin at drawn places."""
    places: list[tuple[float, float]] = []
    longest = max(8, round(math.sqrt(count)))
    row = 0
    while len(places) < count:
        begin = float(rng.uniform(0, 20))
        length = int(rng.integers(longest // 2, longest * 3 // 2))
        places += [(-row * _APART_M, begin + k * _PITCH_M) for k in range(length)]
        row += 1
    centres = np.array(places[:count])
    return np.asarray(centres - centres.mean(axis=0))


def flight(number: int, centres: NDArray[np.float64], move: Move, rng: np.random.Generator) -> FinishedSurvey:
    """Return a survey of stalls, which have their number from 1 as id, in a frame that is moved."""
    kept = np.flatnonzero(rng.random(len(centres)) >= (MISSED if number > 1 else 0))
    places = move.of(centres[kept]) + rng.normal(0, ERROR_M, (len(kept), 2))
    began = _BEGAN + number * _DAY_S
    stalls = tuple(
        Detection(
            id=int(k) + 1, north=north, east=east, angle=move.turn % math.pi, width=_PITCH_M, length=_DEEP_M,
            taken_probability=float(rng.random()), state=StallState(rng.choice(["free", "taken"])),
            score=float(rng.random()), picture_count=int(rng.integers(1, 200)),
            looked_at=began + float(rng.uniform(0, 900)),
        )
        for k, (north, east) in zip(kept.tolist(), places.tolist(), strict=True)
    )  # fmt: skip
    seen = shapely.transform(shapely.MultiPoint(centres).buffer(_AROUND_M).simplify(0.5), move.of)
    outline = _outline(shapely.MultiPoint(centres).convex_hull)
    return FinishedSurvey(
        name=f"{number:06d}-benchmark", datum=DATUM, began=began, ended=began + 900, time_is_sure=True,
        outline=outline, stalls=stalls, program="benchmark", seen_ground=_outline(seen),
    )  # fmt: skip


def _outline(ground: shapely.Geometry) -> Outline:
    parts = [part for part in shapely.get_parts(ground).tolist() if isinstance(part, shapely.Polygon)]
    rings = [to_global(DATUM, np.array(part.exterior.coords[:-1])) for part in parts]
    return Outline(tuple(tuple((float(a), float(b)) for a, b in ring) for ring in rings))


async def measure(path: Path, count: int, lag: LoopLag) -> Measured:
    """Store surveys of one lot, all but the first with the registration, and return what they cost."""
    rng = np.random.default_rng(count)
    centres = drawn_lot(count, rng)
    store = LotStore(path, find_stalls)
    await _saved(store, flight(1, centres, Move(), rng))
    await _saved(store, flight(2, centres, BIAS, rng))
    flown = [flight(number, centres, BIAS, rng) for number in range(3, 3 + FLIGHTS)]
    before = _size(path)
    seconds: list[float] = []
    outcomes: list[Saved] = []
    sampling = asyncio.create_task(lag.run())
    for each in flown:
        began = time.perf_counter()
        outcomes.append(await _saved(store, each))
        seconds.append(time.perf_counter() - began)
    sampling.cancel()
    size = (_size(path) - before) / FLIGHTS
    wrong = [
        await store.read(partial(wrong_ids, seq=saved.seq, flown=each))
        for saved, each in zip(outcomes, flown, strict=True)
    ]
    await store.close()
    return Measured(seconds, size, sum(wrong), sum(saved.placed is Placed.REGISTERED for saved in outcomes))


def _size(path: Path) -> int:
    return path.stat().st_size


def wrong_ids(connection: Connection, seq: int, flown: FinishedSurvey) -> int:
    """Return how many looks of a survey are stored with another stall than the one that was looked at."""
    truth = {stall.id: stall.taken_probability for stall in flown.stalls}
    asked = select(STALL.c.first_id, OBSERVATION.c.taken_probability).join(
        OBSERVATION, OBSERVATION.c.stall == STALL.c.key
    )
    rows = connection.execute(asked.where(OBSERVATION.c.survey == seq))
    return sum(truth.get(row.first_id) != row.taken_probability for row in rows)


async def _saved(store: LotStore, survey: FinishedSurvey) -> Saved:
    return await store.write(lambda connection: save(connection, survey, store.register))


def figures(measured: dict[int, Measured], lag_p99_ms: float | None, calls: Calls) -> list[Figure]:
    """Return the figures of lots by their number of stalls, and of calls for statistics."""
    found = [
        Figure(f"register_{count}_s", f"stored and registered, {count} stalls, median", statistics.median(each.seconds),
               "s", limit=Limit(highest=_LIMITS[count]))
        for count, each in measured.items()
    ]  # fmt: skip
    smallest = measured[min(measured)]
    flights = FLIGHTS * len(measured)
    wrong, registered = (sum(getattr(each, name) for each in measured.values()) for name in ("wrong", "registered"))
    return [
        *found,
        Figure("bytes_per_survey", f"a stored survey, {min(measured)} stalls", smallest.size, "bytes",
               limit=Limit(highest=_BYTES)),
        Figure("lag_p99_ms", "lag of the loop meanwhile, p99", lag_p99_ms, "ms", limit=Limit(highest=_LAG_MS)),
        Figure("registered", f"registered surveys, of {flights}", registered, limit=Limit(lowest=flights)),
        Figure("archive_p99_ms", f"a call for statistics or by the API, {SURVEYS} surveys of {min(SIZES)} stalls, p99",
               calls.p99_ms, "ms", limit=Limit(highest=_CALL_MS)),
        Figure("archive_slowest_ms", f"the slowest call, median: {calls.slowest[0]}", calls.slowest[1], "ms"),
        Figure("cog_s", "a Cloud Optimised GeoTIFF of 3 ha with occupancy and STAC item", calls.files.cog_s, "s",
               limit=Limit(highest=_COG_S)),
        Figure("gpkg_s", f"a GeoPackage of {PACKED} surveys of {min(SIZES)} stalls", calls.files.gpkg_s, "s",
               limit=Limit(highest=_GPKG_S)),
        Figure("wrong_ids", "stalls with another one's id", wrong, limit=Limit(highest=0)),
    ]  # fmt: skip


def recording_figures(recorded: recording.Recorded) -> list[Figure]:
    """Return the figures of a recorded flight."""
    return [
        Figure("record_cpu", "recording at 10 pictures a second, share of a core", recorded.cpu,
               limit=Limit(highest=_RECORD_CPU)),
        Figure("record_bytes_s", "written by it", recorded.bytes_s, "bytes/s"),
        Figure("record_lost", "messages that it lost", recorded.lost, limit=Limit(highest=0)),
    ]  # fmt: skip


def replay_figures(found: replayed.Replayed) -> list[Figure]:
    """Return the figures of recordings that are replayed."""
    pictures = f"{replayed.PICTURES_S} pictures a second"
    return [
        Figure("replay_x", "decisions of a recording made again, times real time on one core", found.decided_x,
               limit=Limit(lowest=_REPLAY_X)),
        Figure("replay_differences", "of them, those that differ", found.differences, limit=Limit(highest=0)),
        Figure("process_x", f"a recording processed again, {pictures}, times real time on one core", found.processed_x,
               limit=Limit(lowest=_PROCESS_X)),
        Figure("process_ms", "of it, a picture", found.picture_ms, "ms"),
        Figure("process_waited_x", "as it was waited for, on all cores", found.waited_x),
        Figure("process_stalls", "stalls that it finds", found.stalls, limit=Limit(lowest=1)),
    ]  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Store and register, and print a table; return 1 when a figure lies outside its limits."""
    parser = make_parser("benchmarks.archive", __doc__)
    options = parser.parse_args(arguments)
    lag = LoopLag(window=1_000_000)

    async def all_sizes(folder: Path) -> dict[int, Measured]:
        return {count: await measure(folder / f"{count}.db", count, lag) for count in SIZES}

    with tempfile.TemporaryDirectory() as folder:
        measured = asyncio.run(all_sizes(Path(folder)))
        rng = np.random.default_rng(min(SIZES))
        first = flight(1, drawn_lot(min(SIZES), rng), Move(), rng)
        calls = measure_calls(Path(folder) / "archive.db", first)
        recorded = asyncio.run(recording.measure(Path(folder)))
        again = replayed.measure(Path(folder))
    found = [*figures(measured, lag.summary().p99_ms, calls), *recording_figures(recorded), *replay_figures(again)]
    return print_and_write([Section("archive", found)], options.json)


if __name__ == "__main__":
    sys.exit(main())
