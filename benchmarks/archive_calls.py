"""Time of every call for statistics, and of every reading of the API, over an archive of surveys: what a page or a tool
waits for.

The archive is written into the store's tables: a registration of each survey would take minutes and change no call.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, Final

import numpy as np
from sqlalchemy import Connection, insert, select, update

from benchmarks.archive_files import FileTimes, measure_files
from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LOT, OBSERVATION, STALL, SURVEY
from hawk.lots.survey.observations import keep_looks, missing_looks
from hawk.lots.values import FinishedSurvey
from hawk.stats.panel import Period
from hawk.stats.partition import PARTITIONS
from hawk.stats.queries import changes, stalls_use, statistics, surveys_use
from hawk.web.v1 import parameters as forms
from hawk.web.v1 import reads
from hawk.web.v1.answers import Read, encoded
from hawk.web.v1.features import reads as features
from hawk.web.v1.features.parameters import Items
from hawk.web.v1.features.reads import COLLECTIONS
from hawk.web.v1.parameters import MOST_ITEMS, Query, Request

SURVEYS: Final = 1000
HOURS: Final = (8.2, 11.4, 14.6, 17.8)
"""Hours of a day's surveys."""
REPEATS: Final = 12
_BEGIN: Final = datetime(2026, 1, 5, tzinfo=UTC)
_TAKEN: Final = 0.55
_MOVED: Final = 0.35
"""Share of the stalls whose state is drawn again between two surveys."""


_BY_LOOKS: Final = (reads.statistics, reads.surveys_use, reads.stalls_use)


@dataclass(frozen=True, slots=True)
class Calls:
    """Milliseconds of each call, by its name, and the times of files."""

    times: dict[str, list[float]]
    files: FileTimes

    @property
    def slowest(self) -> tuple[str, float]:
        """The call with the greatest median, and that."""
        medians = {name: float(np.median(times)) for name, times in self.times.items()}
        name = max(medians, key=lambda each: medians[each])
        return name, medians[name]

    @property
    def p99_ms(self) -> float:
        """The time that 99 % of all calls need at most."""
        return float(np.percentile([each for times in self.times.values() for each in times], 99))


def fill(
    store: Database, first: FinishedSurvey, surveys: int = SURVEYS, ended_at: Callable[[int], float] | None = None
) -> str:
    """Write an archive of surveys of one lot, and return its id.

    ``first``: the survey that makes the lot; ``ended_at`` gives the end of each further one from 0, Unix seconds, four
    a day without it.
    """
    ended_of = ended_at or four_a_day
    rng = np.random.default_rng(39)
    with store.writing() as connection:
        lot = save(connection, first).lot
        assert lot is not None, "the first survey made no lot"
        keys = np.array(connection.execute(select(STALL.c.key).where(STALL.c.lot == lot)).scalars().all())
        ended = _BEGIN.timestamp() - 86_400.0
        connection.execute(update(SURVEY).values(began=ended - 900, ended=ended))
        like = dict(connection.execute(select(SURVEY)).mappings().one())
        state = rng.random(len(keys)) < _TAKEN
        for number in range(surveys):
            state = np.where(rng.random(len(keys)) < _MOVED, rng.random(len(keys)) < _TAKEN, state)
            _write(connection, like, number, ended_of(number), keys, state, rng)
    return lot


def four_a_day(number: int) -> float:
    """Return the end of a survey from 0, Unix seconds."""
    day, turn = divmod(number, len(HOURS))
    return (_BEGIN + timedelta(days=day, hours=HOURS[turn])).timestamp()


def _write(
    connection: Connection, like: dict[str, Any], number: int, ended: float, keys: np.ndarray[Any, Any],
    state: np.ndarray[Any, Any], rng: np.random.Generator,
) -> None:  # fmt: skip
    seq, named = like["seq"] + 1 + number, f"{number:08d}-0000-4000-8000-000000000000"
    shown = {"seq": seq, "id": named, "origin": f"archive {number}", "placed": "registered"}
    connection.execute(insert(SURVEY).values(**{**like, **shown, "began": ended - 900, "ended": ended}))
    taken = np.where(state, 1 - rng.beta(1, 60, len(keys)), rng.beta(1, 60, len(keys)))
    rows = [
        {"survey": seq, "stall": key, "looked_at": ended - 300, "taken_probability": chance, "picture_count": 9}
        | {"state": "taken" if chance >= 0.5 else "free"}
        for key, chance in zip(keys.tolist(), taken.tolist(), strict=True)
    ]  # fmt: skip
    connection.execute(insert(OBSERVATION), rows)
    keep_looks(connection, [seq])


def api_calls(connection: Connection, lot: str) -> Iterator[tuple[str, Callable[[Connection], object]]]:
    """Yield every reading of the API by its name, with the most items, encoded and packed as an answer is."""
    stall = connection.execute(select(STALL.c.id).where(STALL.c.lot == lot)).scalar()
    rows = connection.execute(select(SURVEY.c.seq, SURVEY.c.id).where(SURVEY.c.lot == lot).order_by(SURVEY.c.seq))
    seqs, surveys = zip(*rows.all(), strict=True)
    middle = len(surveys) // 2
    most, there = {"limit": MOST_ITEMS}, f"{seqs[middle]}.{MOST_ITEMS}"
    asked: list[tuple[str, Read, dict[str, str], Query]] = [
        ("lots", reads.lots, {}, forms.Listed(**most)),
        ("lot", reads.lot, {"id": lot}, Query()),
        ("layouts", reads.layouts, {"id": lot}, forms.Listed(**most)),
        ("layout", reads.stalls_of_layout, {"id": lot, "version": "1"}, forms.Listed(**most)),
        ("stalls", reads.stalls, {"id": lot}, forms.Stalls(**most)),
        ("stall", reads.stall, {"id": str(stall)}, Query()),
        ("zones", reads.zones, {"id": lot}, forms.Listed(**most)),
        ("surveys", reads.surveys, {}, forms.Surveys(order="newest", **most)),
        ("surveys of a lot", reads.surveys, {"id": lot}, forms.Surveys(**most)),
        ("survey", reads.survey, {"id": surveys[middle]}, Query()),
        ("observations", reads.observations, {"id": lot}, forms.Observations(**most)),
        ("later observations", reads.observations, {"id": lot}, forms.Observations(after=there, **most)),
        ("observations of a stall", reads.observations, {"id": lot}, forms.Observations(stall=stall, **most)),
        ("observations of a survey", reads.observations_of_survey, {"id": surveys[middle]}, forms.Listed(**most)),
        ("statistics", reads.statistics, {"id": lot}, forms.Statistics(by="row")),
        ("a question about mornings", reads.ask, {"id": lot}, forms.UseQuery(weekday="mon-fri", hour="7-11")),
        ("surveys with their shares", reads.surveys_use, {"id": lot}, forms.SurveysOf()),
        ("newest surveys with their shares", reads.surveys_use, {"id": lot}, forms.SurveysOf(newest=8)),
        ("stalls with their shares", reads.stalls_use, {"id": lot}, forms.Period()),
        ("survey with its stalls", reads.survey_stalls, {"id": lot, "survey": surveys[middle]}, Query()),
        ("changes", reads.changes, {}, forms.Changes(**most)),
        ("changes of a lot", reads.changes, {}, forms.Changes(lot=lot, **most)),
        ("collections", features.collections, {}, Query()),
        *((f"features: {name}", features.items, {"collection": name}, Items(**most)) for name in COLLECTIONS),
        ("features: a box", features.items, {"collection": "surveys"}, Items(bbox="4,51,6,53", **most)),
        ("features: a time", features.items, {"collection": "stalls"}, Items(datetime="2026-01-06/..", **most)),
    ]
    for name, read, path, query in asked:
        given: Request[Query] = Request(path, query, "http://drone", 0.0)
        yield f"api: {name}", lambda c, read=read, given=given: _answer(c, read, given)  # type: ignore[misc]


def _answer(connection: Connection, read: Read, given: Request[Query]) -> object:
    """Read and pack an answer; before one by the looks of a lot, the daemon asks whether any are not in one piece."""
    if read in _BY_LOOKS:
        missing_looks(connection, given.id)
    return encoded(read(connection, given), packs=True)


def calls(lot: str) -> Iterator[tuple[str, Callable[[Connection], object]]]:
    """Yield every call by its name: the figures in each division, over all, a month and a day, and two surveys."""
    periods = {"all": (None, None), "month": (30, 60), "day": (30, 31)}
    for name, (begin, end) in periods.items():
        period = Period(_moment(begin), _moment(end), UTC, "UTC")
        for by in (None, *PARTITIONS):
            yield f"{by or 'lot'}, {name}", lambda c, p=period, b=by: statistics(c, lot, p, b)  # type: ignore[misc]
    before, after = (f"{number:08d}-0000-4000-8000-000000000000" for number in (100, 103))
    ever = Period(None, None, UTC, "UTC")
    yield "surveys, all", lambda connection: surveys_use(connection, lot, ever)
    yield "heat, all", lambda connection: stalls_use(connection, lot, ever)
    yield "changes", lambda connection: changes(connection, lot, before, after)


def _moment(day: int | None) -> float | None:
    return None if day is None else (_BEGIN + timedelta(days=day)).timestamp()


def measure_calls(path: Path, first: FinishedSurvey, surveys: int = SURVEYS, repeats: int = REPEATS) -> Calls:
    """Fill a store and time every call, as `timed_calls` does."""
    store = Database(path, {"synchronous": 0})
    try:
        lot = fill(store, first, surveys)
        times = timed_calls(store, lot, repeats)
        with store.reading() as connection:
            files = measure_files(connection, lot, path)
        return Calls(times, files)
    finally:
        store.close()


def timed_calls(
    store: Database, lot: str, repeats: int = REPEATS, without: tuple[str, ...] = ()
) -> dict[str, list[float]]:
    """Return the milliseconds of every call of a process that has begun, a transaction each, by its name.

    Calls whose names begin as one of ``without`` are not made. The store changes before each round, as by a flight
    that has landed: nothing that was kept of an earlier round is of use. Within a round, a call finds what the one
    before has left, as in the daemon.
    """
    times: dict[str, list[float]] = {}
    with store.reading() as connection:
        every = [each for each in (*calls(lot), *api_calls(connection, lot)) if not each[0].startswith(without)]
    for repeat in range(repeats + 1):
        with store.writing() as connection:
            connection.execute(update(LOT).where(LOT.c.id == lot).values(name=f"Lot {repeat}"))
        for name, call in every:
            began = time.perf_counter()
            with store.reading() as connection:
                call(connection)
            if repeat:  # the first ones load libraries
                times.setdefault(name, []).append((time.perf_counter() - began) * 1e3)
    return times
