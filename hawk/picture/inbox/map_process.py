"""The process that maps one flight: ``hawk-drone map`` within the bounds of its box. No picture ends the inbox."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from hawk.picture.film.app import FILMS
from hawk.picture.film.recording import SUFFIX as RECORDING
from hawk.picture.inbox.folder import SURVEY
from hawk.picture.inbox.journal import PICTURES, Flight

LONGEST_S: Final = 12 * 3600.0
"""Real seconds after which a mapping is ended: some thousand photographs take less on a small computer."""
_LOOK_S: Final = 0.2
_MAPPED: Final = (0, 3)
"""Exit statuses of a survey: of all pictures, and without some."""


class LeftOutPicture(BaseModel):
    """A picture that was not mapped, and why."""

    model_config = ConfigDict(extra="ignore", frozen=True)
    name: str
    reason: str


class MapReport(BaseModel):
    """The report that the command prints, as far as an inbox uses it."""

    model_config = ConfigDict(extra="ignore", frozen=True)
    lot_name: str
    stalls: int
    free: int
    taken: int
    unknown: int
    free_range: tuple[int, int] | None
    time_is_sure: bool
    notes: tuple[str, ...]
    left_out: tuple[LeftOutPicture, ...]
    store: str
    stored_survey: Annotated[str, Field(min_length=1)]


@dataclass(frozen=True, slots=True)
class MapResult:
    """End of a mapping. ``report``: None where there is no survey; ``words`` say why then.

    ``signal``: that ended the process, 0 for none. ``is_stopped``: the inbox ended it.
    """

    report: MapReport | None
    words: str = ""
    signal: int = 0
    is_stopped: bool = False


class MapProcess:
    """Maps flights one after the other, each in a process of its own."""

    def __init__(self, store: Path, options: Mapping[str, str], stop: threading.Event, lock: int) -> None:
        """``options``: values by their names, each passed on where the source has a use for it; ``lock``: descriptor
        that the process keeps open.
        """
        self._command = (sys.executable, "-m", "hawk.cli", "map", "--json", "--resume", "--store", str(store))
        self._options = options
        self._stop = stop
        self._lock = lock

    def __call__(self, flight: Flight, home: Path) -> MapResult:
        """Map the pictures in a flight's folder. Raises OSError where no process can be started."""
        identity = {"id": flight.id, "name": flight.name, "datum": flight.datum}
        own = ["--flight", json.dumps(identity), "--parent-pid", str(os.getpid()), "--out", str(home / SURVEY)]
        options = [text for name in _options(flight.source) for text in self._option(name)]
        source = str(home / PICTURES / flight.source)
        with subprocess.Popen(
            [*self._command, *options, *own, "--", source],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            pass_fds=(self._lock,),
        ) as process:
            with contextlib.suppress(OSError):  # where memory is short, this process ends first
                Path(f"/proc/{process.pid}/oom_score_adj").write_text("1000", "ascii")
            return self._wait(process)

    def _option(self, name: str) -> tuple[str, ...]:
        return (f"--{name}", self._options[name]) if name in self._options else ()

    def _wait(self, process: subprocess.Popen[bytes]) -> MapResult:
        ends = time.monotonic() + LONGEST_S
        while True:
            try:
                said, complained = process.communicate(timeout=_LOOK_S)
                break
            except subprocess.TimeoutExpired:
                if self._stop.is_set() or time.monotonic() > ends:
                    process.kill()
                    process.communicate()
                    words = f"Mapping took more than {LONGEST_S / 3600:.0f} hours: map fewer pictures at once"
                    return MapResult(None, words, is_stopped=self._stop.is_set())
        return _result(process.returncode, said, complained, is_stopped=self._stop.is_set())


def _options(source: str) -> tuple[str, ...]:
    """Return the names of the options that a source has a use for, as `hawk.picture.sources` has them."""
    suffix = Path(source).suffix.lower()
    if not source:
        return ("model", "memory", "height", "lenses", "calibration", "place")
    if suffix == RECORDING:
        return ("model", "memory", "height")
    if suffix in FILMS:
        return ("model", "memory", "height", "lenses", "calibration", "hfov", "focal35")
    return ("model", "memory")


def _result(status: int, said: bytes, complained: bytes, *, is_stopped: bool) -> MapResult:
    """Return the result by the exit status and the lines that a process wrote."""
    last = _last_line(said)
    if status in _MAPPED:
        try:
            return MapResult(MapReport.model_validate_json(last))
        except ValidationError as error:
            return MapResult(None, f"The report of the mapping cannot be read: {error.errors()[0]['msg']}")
    if status < 0:
        return MapResult(None, f"Mapping was ended by {_name(-status)}", -status, is_stopped)
    with contextlib.suppress(ValueError, KeyError, TypeError):
        return MapResult(None, str(json.loads(last)["text"]), is_stopped=is_stopped)
    return MapResult(None, _last_line(complained) or f"Mapping ended with status {status}", is_stopped=is_stopped)


def _name(number: int) -> str:
    with contextlib.suppress(ValueError):
        return f"{signal.Signals(number).name} (most often because memory was short)"
    return f"signal {number}"


def _last_line(output: bytes) -> str:
    lines = output.decode("utf-8", "replace").strip().splitlines()
    return lines[-1] if lines else ""
