"""Memory of the flights before: the rest of the survey, its outline, and the drain of the battery."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from hawk.model.limits import Outline
from hawk.model.operation import FlightDrain, SurveyLeft


def _forget(_: object) -> None:
    """Keep nothing."""


@dataclass(frozen=True, slots=True)
class SurveyMemory:
    """Results of earlier flights, and where this one leaves its own: see `FlightJournal.set_left` and the like."""

    left: SurveyLeft | None = None
    drains: tuple[FlightDrain, ...] = ()
    keep_left: Callable[[SurveyLeft], None] = field(default=_forget)
    keep_drains: Callable[[tuple[FlightDrain, ...]], None] = field(default=_forget)
    outline: Outline | None = None
    """As an operator left it in this survey: without polygons when it was cleared, None when it was never set."""
    keep_outline: Callable[[Outline], None] = field(default=_forget)
