from __future__ import annotations

import logging

import pytest

from hawk.web.access.paced_log import LINES, PERIOD_S, PacedLog
from tests.manual_clock import ManualClock


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
def log(clock: ManualClock) -> PacedLog:
    return PacedLog(logging.getLogger("paced"), clock)


def test_lines_beyond_the_pace_are_counted(log: PacedLog, clock: ManualClock, caplog: pytest.LogCaptureFixture) -> None:
    for number in range(LINES + 7):
        log.warning("line %d", number)
    assert [record.message for record in caplog.records] == [f"line {n}" for n in range(LINES)]
    clock.advance(PERIOD_S)
    log.warning("again")
    assert [r.message for r in caplog.records[LINES:]] == ["7 more lines of this kind were left out", "again"]


def test_a_level_that_is_not_logged_is_not_counted(log: PacedLog, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.WARNING)
    for _ in range(2 * LINES):
        log.debug("not seen")
    log.error("seen")
    assert caplog.messages == ["seen"]


def test_a_fault_of_ours_keeps_its_traceback(log: PacedLog, caplog: pytest.LogCaptureFixture) -> None:
    try:
        raise ValueError("ours")
    except ValueError:
        log.exception("unhandled")
    assert "Traceback" in caplog.text
