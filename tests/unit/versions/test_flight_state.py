from __future__ import annotations

import logging
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hawk.versions.flight_state import FILE, FlightState, FlightStateFile, FoundState, read_flight_state

HOLDER = """
import sys, time
from pathlib import Path
from hawk.versions.flight_state import FlightStateFile
file = FlightStateFile(Path(sys.argv[1]), lambda: 7.0)
file.write(may_fly=True)
print("held", flush=True)
time.sleep(60)
"""


def test_a_state_is_read_with_its_time_while_the_file_is_held_and_after(tmp_path: Path) -> None:
    now = 5.0
    file = FlightStateFile(tmp_path, lambda: now)
    file.write(may_fly=True)
    assert read_flight_state(tmp_path) == FoundState(FlightState(may_fly=True, at_s=5.0), is_held=True)
    now = 6.25
    file.write(may_fly=False)
    assert read_flight_state(tmp_path) == FoundState(FlightState(may_fly=False, at_s=6.25), is_held=True)
    file.close()
    assert read_flight_state(tmp_path) == FoundState(FlightState(may_fly=False, at_s=6.25), is_held=False)


def test_a_killed_daemon_releases_its_file_and_leaves_its_state(tmp_path: Path) -> None:
    daemon = subprocess.Popen([sys.executable, "-c", HOLDER, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    assert daemon.stdout is not None
    with daemon:
        assert daemon.stdout.readline() == "held\n"
        assert read_flight_state(tmp_path).is_held
        daemon.kill()
    assert read_flight_state(tmp_path) == FoundState(FlightState(may_fly=True, at_s=7.0), is_held=False)


def test_there_is_no_state_where_no_daemon_ever_ran(tmp_path: Path) -> None:
    assert read_flight_state(tmp_path) == FoundState(None, is_held=False)


@pytest.mark.parametrize(
    "text",
    ["", "\0\0", "[]", "{", '{"may_fly": false}', '{"may_fly": 0, "at_s": 1.0}', '{"may_fly": false, "at_s": "1"}'],
)
def test_a_damaged_file_has_no_state(tmp_path: Path, text: str) -> None:
    (tmp_path / FILE).write_text(text)
    assert read_flight_state(tmp_path).state is None


def test_a_second_daemon_waits_until_the_first_has_ended(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    first, second = FlightStateFile(tmp_path, lambda: 1.0), FlightStateFile(tmp_path, lambda: 2.0)
    first.write(may_fly=True)
    with caplog.at_level(logging.WARNING):
        second.write(may_fly=False)
        second.write(may_fly=False)
    assert len(caplog.records) == 1
    assert read_flight_state(tmp_path).state == FlightState(may_fly=True, at_s=1.0)
    first.close()
    second.write(may_fly=False)
    assert read_flight_state(tmp_path) == FoundState(FlightState(may_fly=False, at_s=2.0), is_held=True)
    second.close()


def test_a_folder_that_is_missing_is_reported_and_stops_nothing(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = FlightStateFile(tmp_path / "gone")
    with caplog.at_level(logging.WARNING):
        file.write(may_fly=False)
    assert "gone" in caplog.text
    file.close()


def test_without_systemd_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    file = FlightStateFile(None)
    file.write(may_fly=True)
    file.close()
    assert list(tmp_path.iterdir()) == []


def test_everybody_may_read_the_file_under_the_unit_s_mask(tmp_path: Path) -> None:
    before = os.umask(0o077)
    try:
        file = FlightStateFile(tmp_path)
        file.write(may_fly=False)
    finally:
        os.umask(before)
    assert (tmp_path / FILE).stat().st_mode & 0o777 == 0o644
    file.close()
