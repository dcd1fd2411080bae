"""What the operations manager needs of the world around it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from hawk.comm.status import OperatorDesk
from hawk.ddc.settings import DdcSettings
from hawk.model import FlightSoFar


def _no_record(kind: str, payload: dict[str, Any]) -> None:
    """Record nothing."""


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Everything outside, passed in.

    ``directory`` holds the parameter file. ``record`` is given every tick's inputs, command, answer, request and
    decision. ``count_start`` journals a start in the air and returns how many there were in the last 60 s, this one
    included. ``continues_survey``: a map of an earlier run was read again. ``flight``: the one in which an earlier run
    ended; ``keep_flight`` journals the one under way, None after it. ``speed``: seconds of ``clock`` per real second.
    """

    clock: Callable[[], float]
    desk: OperatorDesk
    directory: Path
    settings: DdcSettings = field(default_factory=DdcSettings)
    utc: Callable[[], datetime] = field(default=lambda: datetime.now(UTC))
    record: Callable[[str, dict[str, Any]], None] = field(default=_no_record)
    count_start: Callable[[], int] = field(default=lambda: 1)
    new_token: Callable[[], str] | None = None
    continues_survey: bool = False
    flight: FlightSoFar | None = None
    keep_flight: Callable[[FlightSoFar | None], None] = field(default=lambda _flight: None)
    speed: float = 1.0
