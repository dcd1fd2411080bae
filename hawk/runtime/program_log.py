"""The program's log, written by threads of its own: a terminal or journal that is not read never holds the loop up.

A write to a full pipe blocks until somebody reads. So every thread hands its lines to a bounded queue, which drops and
counts what it has no room for, and one daemon thread for each descriptor writes. `logging.handlers.QueueListener` does
not fit: its end waits for a write that may never return.
"""

from __future__ import annotations

import contextlib
import logging
import os
import threading
from collections import deque
from collections.abc import Mapping
from typing import Any, Final

from hawk.runtime.repeated_log import plain_lines

FORMAT: Final = "%(asctime)s %(levelname)s %(name)s: %(message)s"
JOURNAL_FORMAT: Final = "%(name)s: %(message)s"
"""journald has time and priority of its own."""
TRACE: Final = "hawk.flight"
"""Logger of the flight's trace (`hawk.daemon.flight_trace`): it is written whatever ``log.level`` says."""
NOTICE: Final = 25
"""Level of what is worth finding again in a journal, between info and warning: syslog's notice."""
_PRIORITIES: Final = ((logging.CRITICAL, 2), (logging.ERROR, 3), (logging.WARNING, 4), (NOTICE, 5), (logging.INFO, 6))
"""Levels and syslog's priorities; anything below is 7, debug."""
LINES: Final = 2000
"""Lines that wait at most."""
CLOSE_S: Final = 1.0
"""Real seconds for the last lines at the end."""
STANDARD_OUTPUT, STANDARD_ERROR = 1, 2


class LineWriter:
    """Writes lines to a descriptor on a thread of its own."""

    def __init__(self, descriptor: int, limit: int = LINES) -> None:
        self._descriptor = descriptor
        self._limit = limit
        self._lines: deque[str] = deque()
        self._ready = threading.Condition()
        self._closing = False
        self.dropped = 0
        """Lines for which there was no room."""
        self._thread = threading.Thread(target=self._run, name=f"lines-{descriptor}", daemon=True)
        self._thread.start()

    def put(self, line: str) -> None:
        """Take a line without its line end; never blocks. Called on any thread."""
        with self._ready:
            if len(self._lines) >= self._limit:
                self.dropped += 1
            else:
                self._lines.append(line)
                self._ready.notify()

    def close(self, timeout_s: float = CLOSE_S) -> None:
        """Write the waiting lines and end the thread; one that nobody reads from is left behind."""
        with self._ready:
            self._closing = True
            self._ready.notify()
        self._thread.join(timeout_s)

    def _run(self) -> None:
        missing = 0
        while True:
            with self._ready:
                while not self._lines and not self._closing:
                    self._ready.wait()
                if not self._lines:
                    return
                line, dropped = self._lines.popleft(), self.dropped
            if dropped > missing:
                line = f"lines missing here, not read in time: {dropped - missing}\n{line}"
                missing = dropped
            with contextlib.suppress(OSError):  # nobody is there to read any more
                _write(self._descriptor, f"{line}\n".encode(errors="backslashreplace"))


def is_journal(descriptor: int, environment: Mapping[str, str] = os.environ) -> bool:
    """Return True when a descriptor leads to journald: systemd names its device and inode (systemd.exec(5))."""
    try:
        about = os.fstat(descriptor)
    except OSError:
        return False
    return environment.get("JOURNAL_STREAM") == f"{about.st_dev}:{about.st_ino}"


def journal_lines(text: str, level: int) -> str:
    """Return lines for journald: each with its priority (sd-daemon(3)), those of one record after the first indented.

    A line of a record can thus be taken for no other record, whatever somebody has written into it.
    """
    prefix = f"<{next((number for least, number in _PRIORITIES if level >= least), 7)}>"
    first, *rest = text.splitlines() or [""]
    return "\n".join([f"{prefix}{first}", *(f"{prefix}  {line}" for line in rest)])


class _PlainFormatter(logging.Formatter):
    """Prints nothing that a terminal obeys; a message's later lines are indented, so that they pass for no others."""

    def __init__(self, pattern: str, indent: str = "") -> None:
        super().__init__(pattern)
        self._indent = indent

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - logging's name
        record.message = record.message.replace("\n", f"\n{self._indent}")
        return super().formatMessage(record)

    def format(self, record: logging.LogRecord) -> str:
        return plain_lines(super().format(record))


class _LineHandler(logging.Handler):
    """Formats on the thread that logs, and hands the line over."""

    def __init__(self, writer: LineWriter, *, to_journal: bool = False) -> None:
        super().__init__()
        self._writer = writer
        self._to_journal = to_journal
        self.setFormatter(_PlainFormatter(JOURNAL_FORMAT) if to_journal else _PlainFormatter(FORMAT, "    "))

    def emit(self, record: logging.LogRecord) -> None:
        try:
            text = self.format(record)
            self._writer.put(journal_lines(text, record.levelno) if self._to_journal else text)
        except Exception:  # logging's own answer is a print that may block
            self._writer.put(f"{record.levelname} {record.name}: cannot be shown: {record.msg!r}")


class ProgramLog:
    """Takes over the log of the whole process, Python's warnings and faults of threads, until `close`."""

    def __init__(self, level: str, descriptor: int = STANDARD_ERROR) -> None:
        """``level``: debug, info, warning or error."""
        self._writer = LineWriter(descriptor)
        self._handler = _LineHandler(self._writer, to_journal=is_journal(descriptor))
        logging.addLevelName(NOTICE, "NOTICE")
        logging.getLogger(TRACE).setLevel(logging.INFO)
        root = logging.getLogger()
        self._former = root.handlers[:], root.level
        root.handlers[:] = [self._handler]
        root.setLevel(level.upper())
        logging.captureWarnings(True)
        self._thread_hook, threading.excepthook = threading.excepthook, _log_thread_fault

    @property
    def dropped(self) -> int:
        """Lines that nobody read in time."""
        return self._writer.dropped

    def close(self) -> None:
        """Write what waits, for a second at most, and give the log back."""
        threading.excepthook = self._thread_hook
        logging.captureWarnings(False)
        root = logging.getLogger()
        root.handlers[:], level = self._former
        root.setLevel(level)
        self._writer.close()


def _log_thread_fault(fault: Any) -> None:
    if fault.exc_type is not SystemExit:
        name = fault.thread.name if fault.thread is not None else "a thread"
        about = (fault.exc_type, fault.exc_value, fault.exc_traceback)
        logging.getLogger(__name__).error("%s ended", name, exc_info=about)


def _write(descriptor: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(descriptor, view) :]
