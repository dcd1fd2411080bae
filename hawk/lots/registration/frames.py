"""Frames of lots and surveys, metres north and east of a datum each: rigid moves between them, and pairs of stalls."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from hawk.lots.plan.values import LayoutStall
from hawk.lots.registration.georeference import about
from hawk.lots.values import Detection

if TYPE_CHECKING:
    from sqlalchemy import RowMapping

MATCH_M: Final = 1.0
"""Two stalls farther apart are not one."""
FITS: Final = 1 / 3
"""Share of a stall's width and length by which a find is off it at most: two that are alike overlap by half then."""
_STEP: Final = 0.25
"""Share of a stall's width from which a find that is off by more, or less, than the finds beside it lies between two
stalls: of 8,358 stalls seen again at 12 places, 99.9 % are off their place by less (docs/results/lots.md)."""
_BESIDE_M: Final = 12.0
"""Finds this near in a row are off alike: by the error of the map."""
_IN_ROW: Final = 0.5
"""Share of a stall's length by which stalls of its row lie off it, along it."""
_ALIKE: Final = 0.2
"""Radians by which the directions of two stalls that are one may differ."""
_ARM: Final = 0.001
"""Degrees of latitude over which the turn between two frames is measured."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Move:
    """A rigid move: a ``turn`` about the origin, radians clockwise, then a shift, metres."""

    north: float = 0.0
    east: float = 0.0
    turn: float = 0.0

    @classmethod
    def stored(cls, row: Mapping[str, Any] | RowMapping) -> Move:
        """Return the move that the row of a placed survey keeps."""
        return cls(row["north"], row["east"], row["turn"])

    @classmethod
    def nearest(cls, here: Floats, there: Floats) -> Move:
        """Return the move that brings places nearest to others, both (N, 2): least squares; N is at least 1."""
        one, other = here - here.mean(axis=0), there - there.mean(axis=0)
        crossed = float((one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]).sum())
        turn = math.atan2(crossed, float((one * other).sum()))
        north, east = (there.mean(axis=0) - cls(turn=turn).of(here.mean(axis=0)[None])[0]).tolist()
        return cls(north, east, turn)

    def of(self, places: Floats) -> Floats:
        """Return places (N, 2) of (north, east) after the move."""
        cosine, sine = math.cos(self.turn), math.sin(self.turn)
        turned = places @ np.array([[cosine, sine], [-sine, cosine]])
        return np.asarray(turned + np.array([self.north, self.east]), np.float64)

    def after(self, first: Move) -> Move:
        """Return this move and another one before it as one move."""
        ((north, east),) = self.of(np.array([[first.north, first.east]])).tolist()
        return Move(north, east, first.turn + self.turn)

    def back(self, places: Floats) -> Floats:
        """Return places (N, 2) as they were before the move."""
        return Move(turn=-self.turn).of(places - np.array([self.north, self.east]))

    def stalls(self, stalls: Sequence[Detection]) -> tuple[Detection, ...]:
        """Return stalls after the move."""
        places = self.of(np.array([(stall.north, stall.east) for stall in stalls]).reshape(-1, 2)).tolist()
        return tuple(
            replace(stall, north=north, east=east, angle=(stall.angle + self.turn) % math.pi)
            for stall, (north, east) in zip(stalls, places, strict=True)
        )

    def ground(self, ground: BaseGeometry) -> BaseGeometry:
        """Return ground after the move."""
        return shapely.transform(ground, self.of)


def frame_of(datum: tuple[float, float], other: tuple[float, float]) -> Move:
    """Return the move that brings the frame about ``other`` onto the one about ``datum`` (latitude, longitude).

    North differs between two places: their meridians meet at a pole. Right to a millimetre for datums 100 m apart.
    """
    shifts, turns = frames_of(datum, np.array([other], np.float64))
    return Move(float(shifts[0, 0]), float(shifts[0, 1]), float(turns[0]))


def frames_of(datum: tuple[float, float], others: Floats) -> tuple[Floats, Floats]:
    """Return the moves of `frame_of` for others (N, 2): shifts (N, 2), metres, and turns (N,), radians clockwise."""
    origin = about(datum, others)[:, :2]
    apart = about(datum, others + np.array([_ARM, 0.0]))[:, :2] - origin
    return origin, np.arctan2(apart[:, 1], apart[:, 0])


def turned(places: Floats, turns: Floats) -> Floats:
    """Return places (N, 2) of (north, east), each turned about the origin by its own of turns (N,), radians."""
    cosine, sine = np.cos(turns), np.sin(turns)
    return np.column_stack(
        (places[:, 0] * cosine - places[:, 1] * sine, places[:, 0] * sine + places[:, 1] * cosine)
    )  # fmt: skip


def same_stalls(known: Sequence[LayoutStall], placed: Sequence[Detection]) -> dict[int, str]:
    """Return which known stall each placed one is: the nearest within `MATCH_M` of about the same direction.

    The result is a survey's stall id -> a stored stall's UUID, each at most once; nearer pairs come first.
    """
    if not known or not placed:
        return {}
    there = np.array([(stall.north, stall.east) for stall in known])
    here = np.array([(stall.north, stall.east) for stall in placed])
    tree = shapely.STRtree(shapely.points(there))
    mine, theirs = tree.query(shapely.points(here), predicate="dwithin", distance=MATCH_M)
    away = np.hypot(*(here[mine] - there[theirs]).T)
    same: dict[int, str] = {}
    paired: set[str] = set()
    for number in np.argsort(away, kind="stable").tolist():
        found, stored = placed[mine[number]], known[theirs[number]]
        if found.id in same or stored.id in paired or _between(found.angle, stored.angle) > _ALIKE:
            continue
        same[found.id] = stored.id
        paired.add(stored.id)
    return same


def is_in_place(known: Floats, placed: Floats) -> NDArray[np.bool_]:
    """Return which pairs of a known stall and a find are one, both (N, 5): north, east, angle, width, length.

    A find that is off its stall by more than `FITS` is another stall, and so is one that lies between two stalls: it is
    off by another distance across than the finds beside it in its row. Those show the error of the map beside a change,
    so that the ids of a row keep their order, and none goes to its neighbour.
    """
    away = placed[:, :2] - known[:, :2]
    along, across = _along_and_across(away, known[:, 2])
    fits = (np.abs(across) <= FITS * known[:, 3]) & (np.abs(along) <= FITS * known[:, 4])
    points = shapely.points(known[:, :2])
    own, other = shapely.STRtree(points).query(points, predicate="dwithin", distance=_BESIDE_M)
    off_row, _ = _along_and_across(known[other, :2] - known[own, :2], known[own, 2])
    is_row = (own != other) & fits[other] & (np.abs(off_row) < _IN_ROW * known[own, 4])
    own, other = own[is_row], other[is_row]
    _, across_beside = _along_and_across(away[other], known[own, 2])
    usual = np.zeros(len(known))
    having, first = np.unique(own, return_index=True)
    for k, group in zip(having.tolist(), np.split(across_beside, first[1:]), strict=True) if len(having) else ():
        usual[k] = np.median(group)
    is_between = np.minimum(np.abs(across), np.abs(across - usual)) > _STEP * known[:, 3]
    return np.asarray(fits & ~is_between)


def _along_and_across(away: Floats, angle: Floats) -> tuple[Floats, Floats]:
    """Return vectors (N, 2) of (north, east) along and across directions (N,), radians clockwise from north."""
    north, east = np.cos(angle), np.sin(angle)
    return away[:, 0] * north + away[:, 1] * east, away[:, 1] * north - away[:, 0] * east


def _between(first: float, second: float) -> float:
    """Return the angle between two directions without a sense, radians."""
    apart = abs(first - second) % math.pi
    return min(apart, math.pi - apart)
