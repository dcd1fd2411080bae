from __future__ import annotations

import os
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from hawk.check.machine import (
    PROBE_BYTES,
    DiskReading,
    clock_result,
    disk_results,
    program_date,
    read_disk,
)
from hawk.check.result import CheckResult, Outcome
from hawk.config.sections import StoreSettings
from hawk.web.access.tls import RELEASED

GOOD = DiskReading(Path("/store"), free=100_000_000_000, write_speed=50e6, owner=1000)
MB = 1_000_000


def judge(reading: DiskReading, picture_bytes_s: float | None = 2e6, user: int = 1000) -> dict[str, CheckResult]:
    found = disk_results(reading, StoreSettings(minimum_free_mb=500), picture_bytes_s, user)
    return {each.name: each for each in found}


def test_a_written_folder_leaves_nothing_behind(tmp_path: Path) -> None:
    moments = iter((10.0, 12.0))
    reading = read_disk(tmp_path, lambda _: 7 * MB, lambda: next(moments))
    assert (reading.free, reading.problem, reading.write_speed) == (7 * MB, "", PROBE_BYTES / 2)
    assert list(tmp_path.iterdir()) == []


def test_a_missing_folder_is_not_made(tmp_path: Path) -> None:
    """Made by root, the daemon's user could not write it."""
    reading = read_disk(tmp_path / "var" / "hawk")
    assert reading.is_new
    assert not reading.problem
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_fails(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    reading = read_disk(tmp_path / "file")  # a file is no folder, for root either
    assert judge(reading)["Store"].outcome is Outcome.FAILED
    assert "store.directory" in judge(reading)["Store"].remedy


def test_a_parent_that_cannot_be_written_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert judge(read_disk(tmp_path / "new"))["Store"].outcome is Outcome.FAILED


@pytest.mark.parametrize(
    ("free", "outcome"),
    [
        (499 * MB, Outcome.FAILED),
        (500 * MB, Outcome.FAILED),
        (500 * MB + 7_199 * MB, Outcome.WARNING),  # an hour at 2 MB/s is 7200 MB
        (500 * MB + 7_200 * MB, Outcome.PASSED),
    ],
)
def test_room_for_an_hour_of_recording(free: int, outcome: Outcome) -> None:
    reading = DiskReading(Path("/store"), free, 50e6, owner=1000)
    assert judge(reading)["Disk space"].outcome is outcome


def test_without_pictures_the_least_free_space_still_counts() -> None:
    assert judge(GOOD, None)["Disk space"].outcome is Outcome.PASSED
    full = DiskReading(Path("/store"), 10 * MB, 50e6, owner=1000)
    assert judge(full, None)["Disk space"].outcome is Outcome.FAILED


def test_a_slow_disk_and_a_check_by_root_are_warnings() -> None:
    slow = DiskReading(Path("/store"), GOOD.free, 1e6, owner=1000)
    assert judge(slow)["Store"].outcome is Outcome.WARNING
    assert judge(GOOD)["Store"].outcome is Outcome.PASSED
    by_root = judge(GOOD, user=0)["Store"]
    assert by_root.outcome is Outcome.WARNING
    assert "sudo -u hawk" in by_root.remedy


def test_a_clock_before_the_program_s_files_fails(tmp_path: Path) -> None:
    module = tmp_path / "module.py"
    module.touch()
    written = RELEASED + timedelta(days=40)
    os.utime(module, (written.timestamp(), written.timestamp()))
    assert program_date(module) == written
    assert program_date(tmp_path / "none") == RELEASED
    early = clock_result(written - timedelta(seconds=1), written, synchronized=None)
    assert early.outcome is Outcome.FAILED
    assert early.remedy


@pytest.mark.parametrize(("synchronized", "outcome"), [(True, "passed"), (None, "passed"), (False, "warning")])
def test_a_clock_is_confirmed_where_the_system_knows(synchronized: bool | None, outcome: str) -> None:
    now = datetime(2027, 1, 2, 3, 4, 5, tzinfo=UTC)
    found = clock_result(now, RELEASED, synchronized)
    assert found.outcome == outcome
    assert "2027-01-02 03:04:05 UTC" in found.value
