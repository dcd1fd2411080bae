"""The health check of a container: the daemon holds its file, and its state is young."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

from hawk.versions.alive import fault, main
from hawk.versions.flight_state import FILE, FlightStateFile
from hawk.versions.switch import ASKED_S


@pytest.mark.parametrize("may_fly", [True, False])
def test_a_daemon_that_writes_its_state_is_alive(tmp_path: Path, may_fly: bool) -> None:
    file = FlightStateFile(tmp_path, lambda: 100.0)
    file.write(may_fly=may_fly)
    try:
        assert fault(tmp_path, 100.0 + ASKED_S) is None
    finally:
        file.close()


def test_one_whose_state_machine_stands_still_is_not(tmp_path: Path) -> None:
    file = FlightStateFile(tmp_path, lambda: 100.0)
    file.write(may_fly=True)
    try:
        assert "no progress for 3 s" in str(fault(tmp_path, 100.1 + ASKED_S))
        (tmp_path / FILE).write_text("nonsense")
        assert "no progress" in str(fault(tmp_path, 100.0))
    finally:
        file.close()


def test_one_that_ended_is_not_however_young_its_state(tmp_path: Path) -> None:
    file = FlightStateFile(tmp_path)
    file.write(may_fly=False)
    file.close()
    assert "no daemon runs" in str(fault(tmp_path, time.monotonic()))
    assert "no daemon runs" in str(fault(tmp_path / "nowhere", time.monotonic()))


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    assert "cannot be read" in str(fault(tmp_path / ("x" * 300), 0.0))


@pytest.mark.slow
def test_the_command_has_a_status(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    environment = {"RUNTIME_DIRECTORY": str(tmp_path)}
    assert main([], environment) == 1
    assert "no daemon runs" in capsys.readouterr().err
    file = FlightStateFile(tmp_path)
    file.write(may_fly=False)
    command = [sys.executable, "-I", "-m", "hawk.versions.alive"]
    try:
        assert main([], environment) == 0
        assert subprocess.run(command, env=environment, check=False).returncode == 0
    finally:
        file.close()
    assert subprocess.run(command, env=environment, capture_output=True, check=False).returncode == 1


@pytest.mark.parametrize(("may_fly", "status"), [(True, 1), (False, 0)])
def test_an_armed_drone_is_not_on_the_ground(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], may_fly: bool, status: int
) -> None:
    file = FlightStateFile(tmp_path, lambda: time.monotonic() + 1.0)  # said after it is asked
    file.write(may_fly=may_fly)
    try:
        assert main(["--on-the-ground"], {"RUNTIME_DIRECTORY": str(tmp_path)}) == status
    finally:
        file.close()
    assert ("armed" in capsys.readouterr().err) is may_fly


def test_a_daemon_that_does_not_run_says_nothing_of_the_ground(tmp_path: Path) -> None:
    assert main(["--on-the-ground"], {"RUNTIME_DIRECTORY": str(tmp_path)}) == 1
