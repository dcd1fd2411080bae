"""Moment of a survey: who says it, whether it is sure, and that it has been.

Whatever a survey's time decides asks here, the queries of `hawk.lots.survey.order` too: which survey is the last one,
what a live feed gives, what statistics count, what is due.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

AHEAD_S: Final = 600.0
"""Seconds by which a moment may be later than a computer's clock: by more, one of both is wrong."""
_AHEAD_OF_UTC_S: Final = 14 * 3600.0
"""A clock without a zone, which is taken as UTC, may be ahead of it by so much (UTC+14)."""


class MomentSource(StrEnum):
    """Source of a moment; the value is what a sentence calls it. ``EXIF``: GNSS's time, or a clock with its zone."""

    GNSS = "GNSS"
    EXIF = "the photographs' tags"
    CAMERA = "the camera's clock"
    TAG = "its tag DateTime"
    FILE = "its file's time of change"
    PERSON = "--taken"
    AUTOPILOT = "the autopilot's GNSS"
    COMPUTER = "this computer's clock"


_SURE: Final = {MomentSource.GNSS, MomentSource.EXIF, MomentSource.PERSON, MomentSource.AUTOPILOT}
_WITHOUT_ZONE: Final = {MomentSource.CAMERA, MomentSource.TAG}


@dataclass(frozen=True, slots=True)
class CaptureTime:
    """A moment, Unix seconds, with its source; not ``is_sure`` where its source or a second witness leaves a doubt."""

    value: float
    source: MomentSource
    is_sure: bool

    @classmethod
    def said(cls, value: float, source: MomentSource, now: float) -> CaptureTime:
        """Return a moment that a source says; ``now``: Unix seconds of a clock here. What has not been is not sure."""
        return cls(value, source, source in _SURE and has_been(value, now))

    def is_possible(self, now: float) -> bool:
        """Return False for a moment that has not been at ``now``, whatever the zone of its clock."""
        return bool(has_been(self.value - (_AHEAD_OF_UTC_S if self.source in _WITHOUT_ZONE else 0.0), now))


def has_been(value: Any, now: Any) -> Any:
    """Return False for a moment that is later than ``now``, Unix seconds: numbers, or columns of the store."""
    return value <= now + AHEAD_S
