"""The benchmark of documents takes every one of them in."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import collect


@pytest.mark.slow
async def test_every_document_is_taken_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("STALLS", 40), ("DRONES", 2), ("SURVEYS", 2)):
        monkeypatch.setattr(collect, name, value)
    sent = collect.documents(tmp_path)
    assert len({named for _, named, _ in sent}) == 4
    per_s, cpu_s = await collect.measure(tmp_path, sent)
    assert per_s > 0
    assert cpu_s > 0


@pytest.mark.nightly
async def test_a_desk_catches_up_with_a_drone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(collect, "STALLS", 40)
    seconds, cpu_s = await collect.catch_up(tmp_path, 3)
    assert seconds > 0
    assert cpu_s > 0


@pytest.mark.nightly
async def test_what_sending_in_flight_costs_is_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(collect, "STALLS", 40)
    share, most_mb = await collect.in_flight(tmp_path, 4.0, 100)
    assert 0 < share < 1
    assert 0 < most_mb < 100
