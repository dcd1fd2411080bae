from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from benchmarks import map_scale
from benchmarks.map_scale import Samples, Stage, flat, print_table, ratio, sizes_up_to
from benchmarks.wide_lot import WideLot
from hawk.algo.mapper.app import MapperApp
from hawk.model.lot_map import StallState
from hawk.model.plans import Inbound
from hawk.model.poses import MapPose


def test_the_sizes_end_with_the_largest() -> None:
    assert sizes_up_to(100) == (1, 10, 30, 100)
    assert sizes_up_to(20) == (1, 10, 20)
    assert sizes_up_to(1) == (1,)


@pytest.mark.parametrize(("value", "first", "expected"), [(3.0, 2.0, 1.5), (None, 2.0, None), (1.0, 0.0, None)])
def test_ratios(value: float | None, first: float | None, expected: float | None) -> None:
    assert ratio(value, first) == expected


def test_samples_give_percentiles_and_what_was_not_measured_is_none() -> None:
    samples = Samples()
    for value in range(101):
        samples.add("update_ms", float(value))
    assert [samples.figure(f"update_ms_{kind}") for kind in ("p50", "p99", "max")] == [50.0, 99.0, 100.0]
    assert samples.figure("other_ms_p50") is None
    with samples.timed("work_ms"):
        sum(range(100_000))
    assert (samples.figure("work_ms_p50") or 0) > 0


def test_the_json_is_flat_and_says_what_holds() -> None:
    small: dict[str, float | None] = {
        "update_ms_p99": 4.0,
        "memory_mb_per_ha": 9.0,
        "heartbeat_bytes_max": 5e4,
        "stalls": 5.0,
    }
    large: dict[str, float | None] = {
        "update_ms_p99": 12.0,
        "memory_mb_per_ha": 3.0,
        "heartbeat_bytes_max": 5e4,
        "stalls": 500.0,
    }
    values = flat({1.0: small, 100.0: large})
    assert values["update_ms_p99_100ha"] == 12.0
    assert values["update_ms_p99_ratio_100ha"] == 3.0
    assert "stalls_ratio_100ha" not in values
    assert (values["update_ms_p99_holds"], values["memory_mb_per_ha_holds"]) == (0.0, 1.0)
    console = Console(record=True, width=150)
    print_table({1.0: small, 100.0: large}, console)
    assert "3.00" in console.export_text()


@pytest.mark.slow
def test_the_drawn_map_is_read_as_it_is_drawn() -> None:
    lot, mapper = WideLot(0.5), MapperApp()
    assert mapper.restore([lot.parts()]) == []
    known = lot.stalls[lot.stalls["east"] < lot.half]
    counts = mapper.get_occupancy_map().counts
    assert counts.total == len(known) > 150
    assert counts.taken == int((known["taken"] > 0).sum())
    assert mapper.inbound(0.0, 0.0) is Inbound.INSIDE
    assert mapper.inbound(0.0, lot.half + 10) is not Inbound.INSIDE
    seen = lot.look(MapPose(0.0, lot.half, 35.0, 0.0, 0.0, 0.0), 1.0)
    places = np.array([(s.north, s.east) for s in seen.stalls])
    assert (places[:, 1] > lot.half).any()
    assert (places[:, 1] < lot.half).any()
    assert {s.taken > 0.5 for s in seen.stalls} == {True, False}
    assert StallState.UNKNOWN not in {s.state for s in mapper.get_occupancy_map().stalls.values()}


@pytest.mark.flight
@pytest.mark.nightly
def test_a_short_flight_measures_everything(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(map_scale, "FRAMES", 18)
    figures = asyncio.run(Stage(1.0).run(tmp_path))
    missing = [key for key in map_scale.TEXTS if figures.get(key) is None and key != "heartbeat_bytes_max"]
    assert not missing
    assert (figures["stalls"] or 0) > 400
