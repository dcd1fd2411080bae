from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import pytest

from hawk.versions import switch
from hawk.versions.flight_state import FlightState, FlightStateFile, FoundState
from hawk.versions.switch import ARMED, ASKED_S, ENDED_ARMED, SILENT, Refusal, judge, look
from tests.manual_clock import ManualClock

NOW = 100.0
GROUND, FLYING = FlightState(may_fly=False, at_s=NOW), FlightState(may_fly=True, at_s=NOW)
OLD, OLD_FLYING = FlightState(may_fly=False, at_s=NOW - 0.1), FlightState(may_fly=True, at_s=NOW - 100.0)


@pytest.mark.parametrize(
    ("state", "is_held", "unit_runs", "expected"),
    [
        (GROUND, True, True, None),
        (GROUND, True, False, None),  # started by hand
        (FLYING, True, True, ARMED),
        (OLD, True, True, SILENT),
        (OLD_FLYING, True, True, ARMED),
        (None, True, True, SILENT),
        (GROUND, False, True, SILENT),  # it starts, or it never said anything
        (None, False, True, SILENT),
        (FLYING, False, True, ENDED_ARMED),
        (FLYING, False, False, ENDED_ARMED),
        (GROUND, False, False, None),
        (OLD, False, False, None),
        (None, False, False, None),
    ],
)
def test_only_a_daemon_that_says_ground_now_or_does_not_run_lets_a_version_go(
    state: FlightState | None, is_held: bool, unit_runs: bool, expected: Refusal | None
) -> None:
    assert judge(FoundState(state, is_held), NOW, unit_runs=unit_runs) is expected


class Waiting:
    """A clock that sleeping moves."""

    def __init__(self) -> None:
        self.clock = ManualClock()
        self.slept = 0.0

    def sleep(self, seconds: float) -> None:
        self.clock.advance(seconds)
        self.slept += seconds


def test_a_daemon_that_hangs_is_asked_for_seconds_and_counts_as_armed(tmp_path: Path) -> None:
    waiting = Waiting()
    file = FlightStateFile(tmp_path, waiting.clock)
    file.write(may_fly=False)
    waiting.clock.advance(0.1)  # it said so a moment ago, and not since it was asked
    refusal = look(tmp_path, unit_runs=lambda: True, monotonic=waiting.clock, sleep=waiting.sleep)
    assert refusal is SILENT
    assert waiting.slept == pytest.approx(ASKED_S, abs=0.2)
    file.close()


def test_a_daemon_that_writes_again_counts(tmp_path: Path) -> None:
    waiting = Waiting()
    file = FlightStateFile(tmp_path, waiting.clock)
    file.write(may_fly=False)
    waiting.clock.advance(100.0)

    def sleep(seconds: float) -> None:
        waiting.sleep(seconds)
        file.write(may_fly=False)

    assert look(tmp_path, unit_runs=lambda: True, monotonic=waiting.clock, sleep=sleep) is None
    file.close()


def test_an_armed_drone_is_not_waited_for(tmp_path: Path) -> None:
    waiting = Waiting()
    file = FlightStateFile(tmp_path, waiting.clock)
    file.write(may_fly=True)
    assert look(tmp_path, unit_runs=lambda: True, monotonic=waiting.clock, sleep=waiting.sleep) is ARMED
    assert waiting.slept == 0.0
    file.close()


def test_a_state_that_cannot_be_read_is_a_refusal(tmp_path: Path) -> None:
    (tmp_path / "flight").symlink_to("flight")  # a loop: reading it fails for root too
    refusal = look(tmp_path, unit_runs=lambda: False)
    assert refusal is not None
    assert str(tmp_path) in refusal.reason


@pytest.mark.parametrize(
    ("state", "runs"),
    [("active\n", True), ("activating\n", True), ("deactivating\n", True), ("inactive\n", False), ("failed\n", False)],
)
def test_the_unit_runs_unless_systemd_says_that_it_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, state: str, runs: bool
) -> None:
    monkeypatch.setattr(switch, "SYSTEMD_FOLDER", tmp_path)
    monkeypatch.setattr(
        "hawk.versions.switch.subprocess.run", lambda *_a, **_k: subprocess.CompletedProcess([], 0, state, "")
    )
    assert switch.service_runs() is runs


def test_a_systemd_that_does_not_answer_counts_as_a_daemon_that_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def hang(*_arguments: Any, **_named: Any) -> None:
        raise subprocess.TimeoutExpired("systemctl", 10)

    monkeypatch.setattr(switch, "SYSTEMD_FOLDER", tmp_path)
    monkeypatch.setattr("hawk.versions.switch.subprocess.run", hang)
    assert switch.service_runs()


def test_without_systemd_no_unit_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(switch, "SYSTEMD_FOLDER", tmp_path / "none")
    assert not switch.service_runs()
