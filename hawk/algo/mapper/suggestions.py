"""Suggested stalls: places without marks on which a car stood in several passes.

Cars park on gravel, grass and pavers where nothing shows a stall. Such a place is shown as suggested, beside the stalls
and never counted as one. It is no suggestion on a known stall, nor across the fronts of stalls: a car there stands in
their aisle.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Floats, Grid, Mask, Window
from hawk.algo.mapper.spatial_index import InPicture, SpatialIndex, nearest_pairs, whole_in
from hawk.algo.vision import quads
from hawk.model.lot_map import Stall, StallState

LEVELS: Final = (0.5, 0.7, 0.85)
"""Mean car probability of a cell."""
CAR_WIDTHS_M: Final = (1.3, 2.6)
CAR_LENGTHS_M: Final = (3.2, 6.2)
"""From a city car to a van, mirrors and a cell's rounding included."""
_Box = tuple[float, float, float, float, float]
_FILL = 0.7  # of its box: a car seen from above is a rounded rectangle, a bent blob is none


@dataclass(frozen=True, slots=True)
class CarBoxes:
    """Boxes as arrays of length N, metres and radians: ``angle`` is the direction of the long side in [0, pi)."""

    north: Floats
    east: Floats
    angle: Floats
    width: Floats
    length: Floats

    def __len__(self) -> int:
        return len(self.north)

    def take(self, which: NDArray[np.bool_] | NDArray[np.intp]) -> CarBoxes:
        """Return some of them."""
        return CarBoxes(*(getattr(self, f.name)[which] for f in fields(self)))


def car_boxes(car: Grid, window: Window) -> CarBoxes:
    """Return the cars of a window of cells, of which ``car`` (rows, columns) is the probability (0..1) of a car.

    A car that the window cuts is none: set ``car`` to 0 where nothing was seen.
    """
    boxes: list[_Box] = []
    left = np.ones(car.shape, np.bool_)
    for level in LEVELS:
        above = ((car > level) & left).astype(np.uint8)
        count, labels, stats, _ = cv2.connectedComponentsWithStats(above, connectivity=4)
        found = {label: box for label in range(1, count) if (box := _box(labels, label, stats[label], window.cell_m))}
        boxes += found.values()
        is_car = np.zeros(count, np.bool_)
        is_car[list(found)] = True
        left &= ~is_car[labels]
    column, row, across, width, length = np.array(boxes, np.float64).reshape(-1, 5).T
    north, east = window.centres(row, column)
    return CarBoxes(north, east, across, width, length)


def _box(labels: NDArray[Any], label: int, stats: NDArray[Any], cell_m: float) -> _Box | None:
    """Return (column, row, map angle, width, length) of one connected part, None when it is no whole car."""
    left, top, wide, high, cells = (int(value) for value in stats[: cv2.CC_STAT_AREA + 1])
    least, most = (np.prod(sizes) / cell_m**2 for sizes in zip(CAR_WIDTHS_M, CAR_LENGTHS_M, strict=True))
    at_border = left == 0 or top == 0 or left + wide == labels.shape[1] or top + high == labels.shape[0]
    if at_border or not least * _FILL <= cells <= most:
        return None
    mask: Mask = (labels[top : top + high, left : left + wide] == label).astype(np.uint8)
    (x, y), sides, degrees = cv2.minAreaRect(cv2.findNonZero(mask))
    first, second = (side + 1 for side in sides)  # from the outermost cells' centres to their edges
    width, length = min(first, second) * cell_m, max(first, second) * cell_m
    fits = CAR_WIDTHS_M[0] <= width <= CAR_WIDTHS_M[1] and CAR_LENGTHS_M[0] <= length <= CAR_LENGTHS_M[1]
    if not fits or cells < _FILL * first * second:
        return None
    turn = np.radians(degrees + (0 if first >= second else 90))  # of the long side, from column to row
    angle = float(np.arctan2(np.cos(turn), -np.sin(turn)) % np.pi)  # rows run south, columns east
    return x + left, y + top, angle, width, length


PASSES: Final = 2
"""Passes in which a car stood at a place before it is suggested."""
PASS_M: Final = 40.0
PASS_S: Final = 60.0
"""Metres flown, or seconds, without a look at the place, after which the next look begins another pass."""
WIDTH_M: Final = 2.5
LENGTH_M: Final = 5.0
"""Size of a suggested stall: the usual one in Europe, and a small one in North America."""
SCORE: Final = 0.42
"""Probability that a suggestion is a stall: 11 of 26 on six Dutch places (docs/results/perception.md)."""
AROUND_M: Final = 0.5
"""Length of a suggested stall beyond its car."""
AISLE_M: Final = 6.0
"""Ground before and behind a stall that is its aisle."""

_SAME_M = 1.0
_SAME_ANGLE = 0.35
_SOLID = 8  # looks of which the place is the mean
_LEFT = 0.3  # mean car probability along the car below which it has left
_TOUCH = 0.1  # overlap with a stall
_ACROSS = 0.5  # radians between car and stall from which the car stands across
_BESIDE_M = 1.0

CarAt = Callable[[Floats], Floats]
"""Takes places (N, 2) of (north, east) and returns the mean car probability there, 0 where nothing was seen."""
Geometry = tuple[Floats, Floats, Floats, Floats, Floats]
"""Stalls: north, east, angle, width and length, each (N,)."""


@dataclass(frozen=True, slots=True)
class Suggestion:
    """A place on which a car stands, metres and radians. It is shown after `PASSES`.

    ``flown_m``, ``time`` and ``version`` are those of the last look, ``born_m`` is the distance flown at the first one.
    """

    id: int
    north: float
    east: float
    angle: float
    length: float
    looks: int
    passes: int
    born_m: float
    flown_m: float
    time: float
    version: int

    @property
    def is_shown(self) -> bool:
        """True when it is part of the map."""
        return self.passes >= PASSES

    def to_stall(self) -> Stall:
        """Return it as published: ``seen`` is the number of passes, and it is taken."""
        return Stall(
            id=self.id,
            north=round(self.north, 3),
            east=round(self.east, 3),
            angle=round(self.angle, 4),
            width=WIDTH_M,
            length=round(self.length, 3),
            taken=1.0,
            state=StallState.SUGGESTED,
            score=SCORE,
            seen=self.passes,
            last_seen=round(self.time, 3),
            version=self.version,
        )

    def to_bytes(self) -> bytes:
        """Return it as JSON."""
        return json.dumps(asdict(self)).encode()

    @classmethod
    def from_bytes(cls, data: bytes) -> Suggestion:
        """Return the suggestion. Raises ValueError when it is none."""
        try:
            read = cls(**json.loads(data))
            numbers = (read.north, read.east, read.angle, read.length, read.born_m, read.flown_m, read.time)
            is_sound = all(math.isfinite(number) for number in numbers)
        except (TypeError, UnicodeDecodeError) as error:
            raise ValueError(f"not a suggestion: {error!r}") from error
        if not is_sound:
            raise ValueError("not a suggestion: a number is not finite")
        return read


@dataclass(frozen=True, slots=True)
class Sight:
    """One look: the cars, the evidence beneath them, the stalls about them, metres flown, time, and map version."""

    cars: CarBoxes
    car_at: CarAt
    in_picture: InPicture
    stalls: Geometry
    flown_m: float
    time: float
    version: int


class Suggestions(SpatialIndex[Suggestion]):
    """The places on which cars stand."""

    def look(self, sight: Sight, middle: tuple[float, float], reach: float, next_id: int) -> int:
        """Take one look in at the ground within reach (metres) of a place; return the next free id."""
        here = self.about(*middle, reach)
        boxes = sight.cars
        outlines = quads.corners(boxes.north, boxes.east, boxes.angle, boxes.width, boxes.length)
        cars = boxes.take(whole_in(sight.in_picture, outlines))
        cars = cars.take(~on_stalls(_places(cars), cars.angle, cars.length, sight.stalls))
        seen, fresh = _pairs(here, cars)
        for one, car in seen:
            self.put(_looked(one, cars, car, sight))
        for car in fresh:
            self.put(_begun(next_id, cars, car, sight))
            next_id += 1
        matched = {one.id for one, _ in seen}
        for one in _left([one for one in here if one.id not in matched], sight):
            self.remove(one.id, sight.version)
        self._make_room(middle, reach, sight)
        return next_id

    def restore(self, suggestion: Suggestion, version: int) -> None:
        """Restore one of an earlier run; the next look at it begins another pass."""
        self.put(replace(suggestion, born_m=0.0, flown_m=0.0, version=version))

    def _make_room(self, middle: tuple[float, float], reach: float, sight: Sight) -> None:
        """Remove the places that known stalls have come to cover."""
        about = self.about(*middle, reach)
        angle, length = (np.array([getattr(one, name) for one in about], np.float64) for name in ("angle", "length"))
        for k in np.flatnonzero(on_stalls(_places(about), angle, length, sight.stalls)).tolist():
            self.remove(about[k].id, sight.version)


def _places(those: list[Suggestion] | CarBoxes) -> Floats:
    """Return centres (N, 2)."""
    if isinstance(those, CarBoxes):
        return np.column_stack([those.north, those.east])
    return np.array([(one.north, one.east) for one in those], np.float64).reshape(-1, 2)


def _pairs(known: list[Suggestion], cars: CarBoxes) -> tuple[list[tuple[Suggestion, int]], list[int]]:
    """Return the known places with the number of the car that stands there, and the numbers of the other cars."""
    angles = np.array([one.angle for one in known], np.float64), cars.angle
    found = nearest_pairs(_places(known), _places(cars), angles, _SAME_M, _SAME_ANGLE)
    taken = set(found.values())
    return [(known[one], car) for one, car in found.items()], [car for car in range(len(cars)) if car not in taken]


def _begun(number: int, cars: CarBoxes, car: int, sight: Sight) -> Suggestion:
    return Suggestion(
        id=number,
        north=float(cars.north[car]),
        east=float(cars.east[car]),
        angle=float(cars.angle[car]),
        length=float(length_about(cars)[car]),
        looks=1,
        passes=1,
        born_m=sight.flown_m,
        flown_m=sight.flown_m,
        time=sight.time,
        version=sight.version,
    )


def _looked(one: Suggestion, cars: CarBoxes, car: int, sight: Sight) -> Suggestion:
    """Return the place after another look: the mean of its looks."""
    share = 1 / min(one.looks + 1, _SOLID)
    turn = (float(cars.angle[car]) - one.angle + math.pi / 2) % math.pi - math.pi / 2
    length = float(length_about(cars)[car])
    again = sight.flown_m - one.flown_m >= PASS_M or sight.time - one.time >= PASS_S
    return replace(
        one,
        north=one.north + (float(cars.north[car]) - one.north) * share,
        east=one.east + (float(cars.east[car]) - one.east) * share,
        angle=(one.angle + turn * share) % math.pi,
        length=one.length + (length - one.length) * share,
        looks=one.looks + 1,
        passes=one.passes + again,
        flown_m=sight.flown_m,
        time=sight.time,
        version=sight.version,
    )


def _left(those: list[Suggestion], sight: Sight) -> list[Suggestion]:
    """Return the places in the picture that no car covers any more."""
    if not those:
        return []
    middle = _places(those)
    angle = np.array([one.angle for one in those])
    along = np.stack([np.cos(angle), np.sin(angle)], -1)
    steps = np.array([-1.2, -0.6, 0.0, 0.6, 1.2])
    points = middle[:, None] + steps[:, None] * along[:, None]
    inside = sight.in_picture(points.reshape(-1, 2)).reshape(points.shape[:2]).all(1)
    cover = sight.car_at(points.reshape(-1, 2)).reshape(points.shape[:2]).mean(1)
    return [one for one, is_left in zip(those, (inside & (cover < _LEFT)).tolist(), strict=True) if is_left]


def length_about(cars: CarBoxes) -> Floats:
    """Return the lengths of the stalls that cars need, (N,)."""
    return np.maximum(cars.length + AROUND_M, LENGTH_M)


def on_stalls(places: Floats, angle: Floats, length: Floats, stalls: Geometry) -> NDArray[np.bool_]:
    """Return which places for cars (N, 2) lie on a known stall, or across the fronts of some, (N,).

    ``stalls`` are arrays of two coordinates in metres, angle, width and length, as those of the places.
    """
    result = np.zeros(len(places), np.bool_)
    if not len(places) or not len(stalls[0]):
        return result
    x, y, stall_angle, width, stall_length = stalls
    centre = np.column_stack([x, y])
    i, j = quads.near_pairs(places, centre, float(stall_length.max()) / 2 + AISLE_M + _BESIDE_M)
    offset = places[i] - centre[j]
    along = np.abs(offset[:, 0] * np.cos(stall_angle[j]) + offset[:, 1] * np.sin(stall_angle[j]))
    across = np.abs(quads.cross(stall_angle[j], offset))
    before = (along < stall_length[j] / 2 + AISLE_M) & (across < width[j] / 2 + _BESIDE_M)
    in_aisle = before & (quads.angle_between(angle[i], stall_angle[j]) > _ACROSS)
    mine = quads.corners(places[:, 0], places[:, 1], angle, np.full(len(places), WIDTH_M), np.maximum(length, LENGTH_M))
    on_stall = quads.overlap_more(mine[i], quads.corners(x, y, stall_angle, width, stall_length)[j], _TOUCH)
    result[i[in_aisle | on_stall]] = True
    return result
