"""Which lot is it? By place alone: the outline of a survey against the outlines of the known lots.

All is judged in metres about the survey, so that neither latitude nor the date line matters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from shapely.geometry.base import BaseGeometry

from hawk.lots.registration.georeference import ground_about, shared_area
from hawk.model.plans import Outline

ALIKE: Final = 0.50
"""Common share of both outlines from which one that a person gave among others is that lot, whatever else it overlaps.
"""
SAME_SHARE: Final = 0.30
"""Overlap from which a lot is meant, of the smaller of both areas: half of a lot is that lot."""
NEAR_M: Final = 300.0
"""A lot nearer than this may be meant although nothing overlaps: GNSS and outlines err."""
_LEAST_M2: Final = 1.0
_APART: Final = 0.01
"""Degrees of latitude, over 1.1 km: in a plane about a place circles of latitude bend by 180 m in 20 km at `_POLAR`."""
_POLAR: Final = 80.0


@dataclass(frozen=True, slots=True)
class Parcel:
    """A known lot and its outline, WGS-84."""

    id: str
    outline: Outline


@dataclass(frozen=True, slots=True)
class Candidate:
    """A lot that may be meant: ``overlap`` of the smaller area, 0 to 1, and ``distance`` between both, metres."""

    lot: str
    overlap: float
    distance: float


class Answer(StrEnum):
    """Answer to "which lot is it?"."""

    KNOWN = "known"
    NEW = "new"
    ASK = "ask"
    NOTHING = "nothing"
    """The survey has no ground that could be anywhere."""


@dataclass(frozen=True, slots=True)
class Decision:
    """``candidates``, the best first: the lot for KNOWN, those to choose from for ASK, else none."""

    answer: Answer
    candidates: tuple[Candidate, ...] = ()

    @property
    def lot(self) -> str | None:
        """The known lot."""
        return self.candidates[0].lot if self.answer is Answer.KNOWN else None


def which_lot(outline: Outline, lots: Sequence[Parcel], beside: Sequence[Outline] | None = None) -> Decision:
    """Return the lot that a survey's outline means.

    One lot that overlaps by `SAME_SHARE` is it; two are a question. Without one, a lot within `NEAR_M` is a question,
    and else the lot is a new one.

    Args:
        outline: The survey's.
        lots: The known lots.
        beside: Outlines that a person gave of other lots near by, with this one. A lot that is more like one of them
            is not meant, one that is the same but for `ALIKE` is, and a lot near by is no question: such outlines do
            not err. None: nobody gave any.
    """
    corners = [corner for ring in outline.polygons for corner in ring]
    centre = corners[0] if corners else (0.0, 0.0)
    ground = ground_about(centre, outline)
    if ground.area < _LEAST_M2:
        return Decision(Answer.NOTHING)
    may_be_near = (lot for lot in lots if not _is_apart(outline, lot.outline))
    near = sorted(
        (found for lot in may_be_near if (found := _candidate(centre, ground, lot)) is not None),
        key=lambda found: (-found.overlap, found.distance, found.lot),
    )
    if beside is not None:
        near = _among(centre, ground, near, {lot.id: lot.outline for lot in lots}, beside)
    same = tuple(found for found in near if found.overlap >= SAME_SHARE)
    if len(same) == 1:
        return Decision(Answer.KNOWN, same)
    if candidates := same or tuple(near):
        return Decision(Answer.ASK, candidates)
    return Decision(Answer.NEW)


def _among(
    centre: tuple[float, float],
    ground: BaseGeometry,
    near: Sequence[Candidate],
    outlines: Mapping[str, Outline],
    beside: Sequence[Outline],
) -> list[Candidate]:
    """Return those of the lots near by that an outline may mean, which a person gave among others."""
    others = [ground_about(centre, each) for each in beside]
    alike: dict[Candidate, float] = {}
    for each in near:
        if each.overlap >= SAME_SHARE:
            lot = ground_about(centre, outlines[each.lot])
            likeness = _likeness(ground, lot)
            if all(_likeness(other, lot) <= likeness for other in others):
                alike[each] = likeness
    best = max(alike, key=lambda each: alike[each], default=None)
    return [*alike] if best is None or alike[best] < ALIKE else [best]


def _likeness(one: BaseGeometry, other: BaseGeometry) -> float:
    common = shared_area(one, other)
    return common / max(float(one.area + other.area) - common, _LEAST_M2)


def _is_apart(one: Outline, other: Outline) -> bool:
    """Return whether two outlines lie beyond `NEAR_M` by their latitudes alone: of ten thousand lots most do."""
    (south, north), (low, high) = (
        (min(latitudes, default=0.0), max(latitudes, default=0.0))
        for latitudes in ([corner[0] for ring in outline.polygons for corner in ring] for outline in (one, other))
    )
    return max(abs(south), abs(north)) < _POLAR and (low > north + _APART or high < south - _APART)


def _candidate(centre: tuple[float, float], ground: BaseGeometry, lot: Parcel) -> Candidate | None:
    """Return how near a lot is; None beyond `NEAR_M`."""
    other = ground_about(centre, lot.outline)
    if other.is_empty:
        return None
    distance = float(ground.distance(other))
    if distance >= NEAR_M:
        return None
    smaller = max(min(ground.area, other.area), _LEAST_M2)
    return Candidate(lot.id, min(1.0, shared_area(ground, other) / smaller), distance)
