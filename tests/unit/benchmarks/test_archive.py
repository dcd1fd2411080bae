"""The archive benchmark measures what it says, on a small lot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.archive import BIAS, FLIGHTS, Measured, drawn_lot, figures, flight, measure, wrong_ids
from benchmarks.archive_calls import Calls, measure_calls
from benchmarks.archive_files import FileTimes
from hawk.lots.ingest import save
from hawk.lots.registration.frames import Move
from hawk.lots.store import LotStore
from hawk.lots.values import KnownGround, MappedGround, Registration
from hawk.runtime.performance import LoopLag

CALLS = Calls({"lot": [10.0], "row": [40.0] * 9}, FileTimes(2.0, 1.0))
SLOW = Calls({"lot": [10.0], "row": [101.0] * 9}, FileTimes(11.0, 4.0))


@pytest.mark.flight
@pytest.mark.nightly
def test_every_call_for_statistics_is_timed_over_an_archive(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    found = measure_calls(tmp_path / "lots.db", flight(1, drawn_lot(30, rng), Move(), rng), surveys=140, repeats=2)
    assert len(found.times) == 21 + 29  # and every reading of the API
    assert found.files.cog_s > 0
    assert found.files.gpkg_s > 0
    assert {len(times) for times in found.times.values()} == {2}
    assert 0 < found.p99_ms < 10_000


@pytest.mark.flight
@pytest.mark.nightly
async def test_surveys_of_a_small_lot_are_registered_and_cost_something(tmp_path: Path) -> None:
    lag = LoopLag()
    measured = await measure(tmp_path / "lots.db", 80, lag)
    assert (len(measured.seconds), measured.registered, measured.wrong) == (FLIGHTS, FLIGHTS, 0)
    assert min(measured.seconds) > 0
    assert 1_000 < measured.size < 40_000
    assert lag.summary().samples > 0


def test_a_drawn_lot_has_that_many_stalls_a_pitch_or_more_apart() -> None:
    centres = drawn_lot(300, np.random.default_rng(1))
    assert centres.shape == (300, 2)
    assert centres.mean(axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)
    apart = np.hypot(*(centres[:, None] - centres[None]).transpose(2, 0, 1))
    assert apart[~np.eye(300, dtype=bool)].min() == pytest.approx(2.5)


@pytest.mark.slow
async def test_a_look_at_another_stall_is_counted(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    centres = drawn_lot(30, rng)
    store = LotStore(tmp_path / "lots.db")
    await store.write(lambda connection: save(connection, flight(1, centres, Move(), rng)))

    def swapped(known: KnownGround, _: MappedGround) -> Registration:
        return Registration(0.0, 0.0, 0.0, {1: known.stalls[1].id, 2: known.stalls[0].id, 3: known.stalls[2].id})

    flown = flight(2, centres, BIAS, np.random.default_rng(5))
    assert {1, 2, 3} <= {stall.id for stall in flown.stalls}
    saved = await store.write(lambda connection: save(connection, flown, swapped))
    assert await store.read(lambda connection: wrong_ids(connection, saved.seq, flown)) == 2
    await store.close()


def test_a_survey_that_is_not_registered_or_a_wrong_id_misses_its_limit() -> None:
    good = Measured([1.0, 2.0, 9.0], 20_000.0, 0, FLIGHTS)
    right = {figure.key: figure for figure in figures({300: good, 2000: good}, 5.0, CALLS)}
    assert {key: figure.value for key, figure in right.items()} == {
        "register_300_s": 2.0, "register_2000_s": 2.0, "bytes_per_survey": 20_000.0, "lag_p99_ms": 5.0,
        "registered": 2 * FLIGHTS, "wrong_ids": 0, "archive_p99_ms": 40.0, "archive_slowest_ms": 40.0,
        "cog_s": 2.0, "gpkg_s": 1.0,
    }  # fmt: skip
    assert all(figure.passed is not False for figure in right.values())
    bad = Measured([1.0], 20_000.0, 1, FLIGHTS - 1)
    assert [figure.key for figure in figures({300: good, 2000: bad}, 5.0, SLOW) if figure.passed is False] == [
        "registered",
        "archive_p99_ms",
        "cog_s",
        "gpkg_s",
        "wrong_ids",
    ]
