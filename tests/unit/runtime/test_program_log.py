from __future__ import annotations

import logging
import os
import subprocess
import sys
import threading
from collections.abc import Iterator

import pytest

from hawk.runtime.program_log import LineWriter, ProgramLog
from tests.unit.daemon.full_pipe import full_pipe


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    reading, writing = os.pipe()
    yield reading, writing
    os.close(reading)
    os.close(writing)


def written(reading: int) -> list[str]:
    return os.read(reading, 65536).decode().splitlines()


def test_lines_are_written_in_order_and_the_last_before_the_end(pipe: tuple[int, int]) -> None:
    writer = LineWriter(pipe[1])
    for number in range(50):
        writer.put(f"line {number}")
    writer.close()
    assert written(pipe[0]) == [f"line {number}" for number in range(50)]


def test_what_nobody_reads_is_dropped_and_counted_and_the_end_does_not_wait_for_it() -> None:
    with full_pipe() as descriptor:
        own = os.dup(descriptor)
        writer = LineWriter(own, limit=10)
        for number in range(100):
            writer.put(f"line {number}")
        assert 89 <= writer.dropped <= 90, "one line may be under way"
        writer.close(timeout_s=0.01)
    writer._thread.join()  # the reader has gone, so its write ends; the next test gets this descriptor's number
    os.close(own)


def test_a_gap_is_noted_where_it_is(pipe: tuple[int, int]) -> None:
    writer = LineWriter(pipe[1], limit=0)
    writer.put("lost")
    writer._limit = 10
    writer.put("kept")
    writer.close()
    assert written(pipe[0]) == ["lines missing here, not read in time: 1", "kept"]


def test_a_descriptor_whose_reader_has_gone_stops_nothing() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    writer = LineWriter(writing)
    writer.put("for nobody")
    writer.put("and again")
    writer.close()
    assert not writer._thread.is_alive()
    os.close(writing)


def test_records_warnings_and_faults_of_threads_are_lines(pipe: tuple[int, int]) -> None:
    before = logging.getLogger().handlers[:]
    log = ProgramLog("info", pipe[1])
    try:
        logging.getLogger("a.part").info("it is %d m high", 30)
        logging.getLogger("a.part").debug("nobody %s", "asked")
        logging.getLogger("a.part").info("%d", "no number")
        logging.getLogger("py.warnings").warning("careful")
        thread = threading.Thread(target=lambda: 1 / 0, name="a-thread")
        thread.start()
        thread.join()
    finally:
        log.close()
    text = "\n".join(written(pipe[0]))
    assert "INFO a.part: it is 30 m high" in text
    assert "nobody asked" not in text
    assert "INFO a.part: cannot be shown: '%d'" in text
    assert "careful" in text
    assert "a-thread ended" in text
    assert "ZeroDivisionError" in text
    assert logging.getLogger().handlers == before


ENDS = """
import logging
from hawk.runtime.program_log import ProgramLog
log = ProgramLog("info")
logging.getLogger("x").info("into the full pipe")
log.close()
"""


@pytest.mark.slow
def test_a_process_ends_in_order_although_nobody_reads_its_log() -> None:
    with full_pipe() as stderr:
        ended = subprocess.run([sys.executable, "-c", ENDS], stderr=stderr, timeout=20, check=False)
    assert ended.returncode == 0


@pytest.mark.fault(
    "control characters in anything that is logged: answers of a camera, file names, names of hosts",
    "no line of the log is coloured, erased or forged",
)
def test_nothing_that_a_terminal_obeys_is_written(pipe: tuple[int, int]) -> None:
    log = ProgramLog("info", pipe[1])
    try:
        logging.getLogger("x").warning("%s", "red \x1b[31m\nERROR hawk: forged \u202e \udcff")
        try:
            raise ValueError("\x1b[2J")
        except ValueError:
            logging.getLogger("x").exception("failed")
    finally:
        log.close()
    lines = written(pipe[0])
    assert lines[0].endswith(r"red \x1b[31m")
    assert lines[1] == r"    ERROR hawk: forged \u202e \xff"
    assert lines[-1] == r"ValueError: \x1b[2J"
