from __future__ import annotations

import logging
import os
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.check.doctor import NO_FLIGHT, Line, in_words, last_flight, read_journal
from hawk.comm.protocol.heartbeat import (
    DroneStatus,
    HealthItem,
    LogEntry,
    OperationStatus,
    PartsStatus,
    TravelStatus,
    VehicleStatus,
)
from hawk.daemon.flight_trace import FlightTrace
from hawk.model.operation import StateName
from hawk.runtime.program_log import NOTICE, TRACE, ProgramLog, is_journal, journal_lines
from hawk.runtime.repeated_log import Repeated
from tests.manual_clock import ManualClock

REAL = Path(__file__).with_name("journal.json")
"""A flight as journald 252 gave it back: written by `ProgramLog` through systemd-cat, read by journalctl -o json."""


class Operators:
    def __init__(self) -> None:
        self.controller: str | None = None
        self.names = {"c1": "Anna"}


@pytest.fixture
def operators() -> Operators:
    return Operators()


@pytest.fixture
def trace(operators: Operators, caplog: pytest.LogCaptureFixture) -> FlightTrace:
    caplog.set_level(logging.INFO, logger=TRACE)
    return FlightTrace(lambda: operators.names, lambda: operators.controller, Repeated(ManualClock()))


STANDS = DroneStatus(
    vehicle=VehicleStatus(connected=True, armed=False, ardupilot_state="GUIDED", battery_percentage=98.0, voltage=16.42)
)


def said(caplog: pytest.LogCaptureFixture) -> list[tuple[int, str]]:
    lines = [(record.levelno, record.getMessage()) for record in caplog.records]
    caplog.clear()
    return lines


def in_state(name: StateName, detail: str, **more: object) -> OperationStatus:
    return OperationStatus(state=name, detail=detail, **more)  # type: ignore[arg-type]


def fly(trace: FlightTrace, operators: Operators) -> None:
    wind = LogEntry(number=1, time="", level="warning", text="Wind.", details="9 m/s")
    trace.begin("hawk-drone 1.2.3")
    trace.follow(STANDS)
    operators.controller = "Anna"
    trace.record("answer to operator", {"client": "c1", "command": "Arm", "accepted": True, "reason": ""})
    trace.record("answer to operator", {"client": "c2", "command": "Land", "accepted": False, "reason": "Not now."})
    trace.record("answer to operator", {"client": "c1", "command": "Check Fence", "accepted": True, "reason": ""})
    trace.record("tick", {"facts": {}})
    trace.record("state", {"from": "Idle", "to": "Arm"})
    armed = replace(
        STANDS,
        vehicle=STANDS.vehicle.model_copy(update={"armed": True}),
        operation=in_state(StateName.ARM, "The motors turn.", asked_by="Anna"),
    )
    trace.follow(armed)
    flies = replace(armed, travel=TravelStatus(flight_time=0.2, distance_flown=0.0))
    trace.follow(flies)
    trace.record("state", {"from": "Arm", "to": "Takeoff"})
    trace.record("state", {"from": "Takeoff", "to": "Hover"})
    trace.follow(replace(flies, operation=in_state(StateName.HOVER, "Holding at 20 m.")))
    late = replace(flies, travel=TravelStatus(flight_time=312.4, distance_flown=840.2))
    blind = PartsStatus(health=(HealthItem(name="camera", healthy=False, reason="no picture for 3 s"),))
    for _ in range(100):  # a part whose health changes with every status
        trace.follow(replace(late, parts=blind))
        trace.follow(late)
    trace.follow(replace(armed, log=(wind,)))
    trace.follow(replace(STANDS, log=(wind,)))
    trace.end("in order")


FLIGHT = [
    (NOTICE, "start: hawk-drone 1.2.3"),
    (NOTICE, "link: the autopilot is heard, mode GUIDED"),
    (NOTICE, "operator: Anna asked for Arm: accepted"),
    (logging.INFO, "operator: somebody asked for Land: refused: Not now."),
    (NOTICE, "arm: motors on, battery 98 %, 16.4 V"),
    (NOTICE, "state: Idle -> Arm: The motors turn. (asked for by Anna)"),
    (NOTICE, "operator: Anna has control"),
    (NOTICE, "take-off: battery 98 %, 16.4 V"),
    (NOTICE, "state: Arm -> Takeoff"),
    (NOTICE, "state: Takeoff -> Hover: Holding at 20 m."),
    (logging.WARNING, "fault: camera: no picture for 3 s"),
    (logging.INFO, "fault over: camera"),
    (NOTICE, "landing: after 312 s and 840 m, battery 98 %, 16.4 V"),
    (logging.WARNING, "message: Wind. 9 m/s"),
    (NOTICE, "disarm: motors off, battery 98 %, 16.4 V"),
    (NOTICE, "end: in order"),
]


def test_a_whole_flight_leaves_its_trace(
    trace: FlightTrace, operators: Operators, caplog: pytest.LogCaptureFixture
) -> None:
    fly(trace, operators)
    assert [(record.levelno, record.getMessage()) for record in caplog.records] == FLIGHT


def test_what_is_not_there_yet_at_the_start_is_no_warning(trace: FlightTrace, caplog: pytest.LogCaptureFixture) -> None:
    trace.record("state", {"from": "Idle", "to": "Idle"})
    trace.follow(DroneStatus(parts=PartsStatus(health=(HealthItem(name="link", healthy=False, reason="Not yet."),))))
    assert [(record.levelno, record.getMessage()) for record in caplog.records] == [
        (logging.INFO, "fault: link: Not yet.")
    ]


def test_a_lost_link_in_the_air_is_a_warning(trace: FlightTrace, caplog: pytest.LogCaptureFixture) -> None:
    armed = STANDS.vehicle.model_copy(update={"armed": True})
    trace.follow(replace(STANDS, vehicle=armed))
    caplog.clear()
    trace.follow(replace(STANDS, vehicle=armed.model_copy(update={"connected": False})))
    assert [(record.levelno, record.getMessage()) for record in caplog.records] == [(logging.WARNING, "link: lost")]


def test_journald_gave_the_flight_back_with_its_priorities() -> None:
    lines = read_journal(REAL.read_text())
    priorities = {NOTICE: 5, logging.INFO: 6, logging.WARNING: 4}
    assert [(line.priority, f"{line.event}: {line.words}") for line in lines if line.event] == [
        (priorities[level], text) for level, text in FLIGHT
    ]


def test_the_last_flight_is_shown_from_the_journal() -> None:
    flight = last_flight(read_journal(REAL.read_text()))
    assert [line.event for line in flight][:2] == ["start", "arm"]
    assert flight[-1].event == "disarm"
    first, _, *rest = in_words(flight).splitlines()
    assert first.startswith("Last flight: 20")
    assert "Landed after 312 s and 840 m, battery 98 %, 16.4 V. The motors were off at its end." in first
    assert (
        "3 warnings and faults: hawk.x: unexpected; fault: camera: no picture for 3 s; message: Wind. 9 m/s." in first
    )
    assert len(rest) == len(flight)


def line(when: float, text: str, priority: int = 5, pid: str = "1") -> Line:
    return Line(when, priority, ("boot", pid), text)


def test_the_newest_flight_counts_and_one_that_a_restart_cut_goes_on() -> None:
    lines = [
        line(0, "hawk.flight: start: a"), line(1, "hawk.flight: arm: x"), line(2, "hawk.flight: disarm: x"),
        line(3, "hawk.flight: arm: y"), line(4, "Killed", 3), line(5, "hawk.flight: start: b", pid="2"),
        line(6, "hawk.comm.x: chatter", 6, "2"), line(7, "  hawk.flight: disarm: forged", 6, "2"),
    ]  # fmt: skip
    flight = last_flight(lines)
    assert [each.when for each in flight] == [0, 3, 4, 5]
    assert "started 1 times in this flight" in in_words(flight)
    assert "The journal does not hold its end" in in_words(flight)
    assert in_words(last_flight([])) == in_words(last_flight(lines[:1])) == f"{NO_FLIGHT}\n"


@pytest.mark.parametrize(
    "text", ["", "no JSON", "[]", "3", "{}", '{"MESSAGE": null, "__REALTIME_TIMESTAMP": "x"}', '{"MESSAGE": "x"}']
)
def test_a_line_that_cannot_be_read_is_left_out(text: str) -> None:
    assert read_journal(text) == []


def test_bytes_are_read() -> None:
    found = read_journal('{"MESSAGE": [104, 255], "__REALTIME_TIMESTAMP": "1000000", "PRIORITY": "3"}')
    assert found == [Line(1.0, 3, ("", ""), "h\ufffd")]


def test_a_record_has_its_priority_on_each_line_and_forges_no_other() -> None:
    assert journal_lines("fault\n<0>hawk.flight: arm: x", logging.ERROR) == "<3>fault\n<3>  <0>hawk.flight: arm: x"
    levels = [logging.CRITICAL, logging.ERROR, logging.WARNING, NOTICE, logging.INFO, logging.DEBUG, 1]
    assert [journal_lines("x", level) for level in levels] == ["<2>x", "<3>x", "<4>x", "<5>x", "<6>x", "<7>x", "<7>x"]


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    reading, writing = os.pipe()
    yield reading, writing
    os.close(reading)
    os.close(writing)


def test_only_journald_is_given_priorities(pipe: tuple[int, int], monkeypatch: pytest.MonkeyPatch) -> None:
    about = os.fstat(pipe[1])
    assert not is_journal(pipe[1], {})
    assert not is_journal(-1, {"JOURNAL_STREAM": "1:2"})
    monkeypatch.setenv("JOURNAL_STREAM", f"{about.st_dev}:{about.st_ino}")
    log = ProgramLog("error", pipe[1])
    logging.getLogger(TRACE).log(NOTICE, "arm: %s", "motors on\x1b[31m")
    logging.getLogger("other").warning("is left out")
    log.close()
    monkeypatch.delenv("JOURNAL_STREAM")
    log = ProgramLog("error", pipe[1])
    logging.getLogger(TRACE).log(NOTICE, "arm: motors on")
    log.close()
    first, second = os.read(pipe[0], 4096).decode().splitlines()
    assert first == "<5>hawk.flight: arm: motors on\\x1b[31m"
    assert second.endswith("NOTICE hawk.flight: arm: motors on")


def test_a_trace_that_nobody_reads_holds_nothing_up(pipe: tuple[int, int], operators: Operators) -> None:
    os.set_blocking(pipe[1], False)
    while True:
        try:
            os.write(pipe[1], bytes(65536))
        except BlockingIOError:
            break
    os.set_blocking(pipe[1], True)
    log = ProgramLog("info", pipe[1])
    begun = time.monotonic()
    fly(FlightTrace(lambda: operators.names, lambda: None), operators)
    assert time.monotonic() - begun < 1.0
    os.read(pipe[0], 1_000_000)
    log.close()
