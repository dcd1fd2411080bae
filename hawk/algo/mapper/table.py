"""The known stalls as one table: a row a stall, so that a frame is fused without a loop over stalls."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from hawk.algo.mapper.evidence import transform_points
from hawk.algo.rows.lot import RowStalls
from hawk.algo.vision import quads
from hawk.algo.vision.detection import Detection
from hawk.model.lot_map import Stall, StallState

Floats = NDArray[np.float64]
Rows = NDArray[Any]
Indices = NDArray[np.intp]
Square = tuple[int, int]

SQUARE_M = 64.0
_WHOLE = 0.9  # visible share
_ACROSS = 0.5  # of the width: half a pitch, beyond it the neighbour is nearer
_ALONG = 0.45  # of the length
_ANGLE = 0.35  # radians
_FAR = 1e3

SMALLEST_M = (2.3, 4.8)
"""Width and length of the smallest stalls of lots without paint, as they are drawn to train on (`training.paved`)."""

STATES = (StallState.UNKNOWN, StallState.FREE, StallState.TAKEN, StallState.SUGGESTED)
"""States by the number in the ``state`` column, and of `shown_state`."""
UNKNOWN, FREE, TAKEN, SUGGESTED = range(4)

STALL_DTYPE = np.dtype(
    [
        ("id", "i8"),
        ("north", "f8"),
        ("east", "f8"),
        ("cos2", "f8"),  # of twice the direction: directions are equal modulo pi
        ("sin2", "f8"),
        ("width", "f8"),
        ("length", "f8"),
        ("solidity", "f8"),  # weight of all looks at the geometry
        ("exists", "f8"),  # log-odds of being a stall
        ("taken", "f8"),  # log-odds of being taken
        ("looks", "f8"),  # independent looks
        ("seen", "i8"),  # frames in which it was found
        ("blurred", "i8"),  # of these, the blurred ones
        ("last_seen", "f8"),
        ("born", "f8"),  # metres that the drone had flown when it was first found
        ("state", "i8"),
        ("inferred", "?"),  # from its row, never found by itself
        ("lone", "?"),  # stands in no row
        ("raised", "?"),  # stands off the ground (`hawk.algo.mapper.stalls`)
        ("lean", "f8"),
        ("lean_looks", "f8"),
        ("plan", "i8"),  # number of the stall in the lot's plan, 1 the first; 0: the plan has it not
        ("given", "?"),  # a person has confirmed it: it stays as it is
        ("extra", "?"),  # found where the plan has none: proposed, not counted
        ("confirmed", "?"),
        ("version", "i8"),  # of the last visible change
        ("touched", "i8"),  # of the last change of anything
    ]
)


_LATER = ("blurred", "raised", "lean", "lean_looks", "plan", "given", "extra")
"""Columns that older journals lack: nothing was known of them."""


def angle_of(rows: Rows) -> Floats:
    """Return directions in [0, pi)."""
    angle = np.arctan2(rows["sin2"], rows["cos2"]) / 2 % np.pi
    return np.where(angle >= np.pi, 0.0, angle)


def corners_of(rows: Rows) -> Floats:
    """Return corners (N, 4, 2) of (north, east)."""
    return quads.corners(*geometry_of(rows))


def geometry_of(rows: Rows) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return north, east, angle, width and length."""
    return rows["north"], rows["east"], angle_of(rows), rows["width"], rows["length"]


def published_size(width: Floats, length: Floats) -> tuple[Floats, Floats]:
    """Return the size at which stalls are published, metres: `SMALLEST_M` at least.

    Where only a car shows a stall, vision finds it little larger than the car.
    """
    return np.maximum(width, SMALLEST_M[0]), np.maximum(length, SMALLEST_M[1])


def published_geometry(rows: Rows) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return north, east, angle, width and length as they are published."""
    return rows["north"], rows["east"], angle_of(rows), *published_size(rows["width"], rows["length"])


def columns_of(stalls: Detections | RowStalls) -> tuple[tuple[str, Floats], ...]:
    """Return the columns that hold the geometry of stalls, by name."""
    return (
        ("north", stalls.north),
        ("east", stalls.east),
        ("cos2", np.cos(2 * stalls.angle)),
        ("sin2", np.sin(2 * stalls.angle)),
        ("width", stalls.width),
        ("length", stalls.length),
    )


def shown_state(rows: Rows) -> NDArray[np.int64]:
    """Return the states as they are published, by their numbers: `SUGGESTED` for what the plan has not."""
    return np.where(rows["extra"], SUGGESTED, rows["state"])


def seen_blurred(rows: Rows) -> NDArray[np.bool_]:
    """Return True for the stalls that only blurred pictures showed."""
    return np.asarray((rows["seen"] > 0) & (rows["blurred"] >= rows["seen"]))


def probability(log_odds: Floats) -> Floats:
    """Return the probability of log-odds."""
    return np.asarray(1 / (1 + np.exp(-log_odds)))


def to_stall(row: Any, known: str = "", label: str = "") -> Stall:
    """Return one row as a published stall, rounded. ``known``, ``label``: of that stall in the lot's plan."""
    north, east, angle, width, length = published_geometry(row)
    return Stall(
        id=int(row["id"]),
        north=round(float(north), 3),
        east=round(float(east), 3),
        angle=round(float(angle), 4),
        width=round(float(width), 3),
        length=round(float(length), 3),
        taken=round(float(probability(row["taken"])), 3),
        state=STATES[int(shown_state(row))],
        score=round(float(probability(row["exists"])), 3),
        seen=int(row["seen"]),
        last_seen=round(float(row["last_seen"]), 3),
        version=int(row["version"]),
        known=known,
        extra=STATES[int(row["state"])] if row["extra"] else None,
        label=label,
        is_blurred=bool(seen_blurred(row)),
    )


def to_bytes(row: Any) -> bytes:
    """Return one row as JSON."""
    return json.dumps(dict(zip(STALL_DTYPE.names or (), row.item(), strict=True))).encode()


def from_bytes(data: bytes) -> Rows:
    """Return the row, shape (1,). Raises ValueError when it is not one."""
    try:
        values = json.loads(data)
        values = dict.fromkeys(_LATER, 0) | values
        row = np.array([tuple(values[name] for name in STALL_DTYPE.names or ())], STALL_DTYPE)
    except (KeyError, TypeError, UnicodeDecodeError) as error:
        raise ValueError(f"not a stall: {error!r}") from error
    if not all(np.isfinite(row[name]).all() for name in STALL_DTYPE.names or ()):
        raise ValueError("not a stall: a number is not finite")
    return row


class FarStalls:
    """Rows of stalls by the square on which they lie."""

    def __init__(self) -> None:
        self._rows: dict[Square, Rows] = {}
        self._touched: dict[Square, int] = {}

    @property
    def count(self) -> int:
        """Number of rows."""
        return sum(map(len, self._rows.values()))

    def count_in(self, box: NDArray[np.float64]) -> int:
        """Return the number of rows on squares that come into a box, two corners (2, 2) of (north, east)."""
        (top, left), (bottom, right) = np.floor(box / SQUARE_M).astype(np.int64).tolist()
        return sum(len(rows) for (i, j), rows in self._rows.items() if top <= i <= bottom and left <= j <= right)

    def put(self, rows: Rows) -> None:
        """Add rows."""
        i, j = (np.floor(rows[name] / SQUARE_M).astype(np.int64) for name in ("north", "east"))
        for square in set(zip(i.tolist(), j.tolist(), strict=True)):
            here = rows[(i == square[0]) & (j == square[1])]
            known = self._rows.get(square)
            self._rows[square] = here.copy() if known is None else np.concatenate([known, here])
            self._touched[square] = max(self._touched.get(square, 0), int(here["touched"].max()))

    def take(self, north: float, east: float, reach: float) -> Rows:
        """Take out all rows of the squares that lie within reach of a place."""
        found = [square for square in squares_about(north, east, reach) if square in self._rows]
        for square in found:
            del self._touched[square]
        return _joined([self._rows.pop(square) for square in found])

    def about(self, north: float, east: float, reach: float) -> Rows:
        """Return all rows of the squares within reach of a place, and perhaps a few more; they stay."""
        return _joined([self._rows[s] for s in squares_about(north, east, reach) if s in self._rows])

    def since(self, version: int) -> Iterator[Rows]:
        """Yield the rows of every square in which something was touched after a version."""
        for square, touched in self._touched.items():
            if touched > version:
                yield self._rows[square]

    def all(self) -> Rows:
        """Return every row."""
        return _joined(list(self._rows.values()))


def is_in(rows: Rows, box: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which rows (N,) lie in a box, two corners (2, 2) of (north, east), metres."""
    places = np.column_stack([rows["north"], rows["east"]])
    return np.asarray(((places >= box[0]) & (places <= box[1])).all(1), np.bool_)


def square_of(north: float, east: float) -> Square:
    """Return the square in which a place lies."""
    return math.floor(north / SQUARE_M), math.floor(east / SQUARE_M)


def squares_about(north: float, east: float, reach: float) -> list[Square]:
    """Return the squares that come within reach (metres) of a place."""
    low, high = (math.floor((north + d) / SQUARE_M) for d in (-reach, reach))
    left, right = (math.floor((east + d) / SQUARE_M) for d in (-reach, reach))
    return [
        (i, j)
        for i in range(low, high + 1)
        for j in range(left, right + 1)
        if math.hypot(_beyond(i, north), _beyond(j, east)) <= reach
    ]


def _beyond(index: int, place: float) -> float:
    """Distance along one axis from a place to the square of an index, 0 inside."""
    return max(index * SQUARE_M - place, place - (index + 1) * SQUARE_M, 0.0)


def _joined(parts: list[Rows]) -> Rows:
    return np.concatenate(parts) if parts else np.zeros(0, STALL_DTYPE)


@dataclass(frozen=True, slots=True)
class Detections:
    """Stalls seen in one frame: arrays of equal length, fields as `Detection`.

    ``lean`` is the share of the drone's movement by which a stall moves against the ground; NaN: not measured.
    """

    north: Floats
    east: Floats
    angle: Floats
    width: Floats
    length: Floats
    score: Floats
    taken: Floats
    visible: Floats
    lean: Floats

    @classmethod
    def of(cls, stalls: Sequence[Detection]) -> Detections:
        """Gather stalls; one with a number that is not finite or a size that no stall has is left out."""
        rows = [(s.north, s.east, s.angle, s.width, s.length, s.score, s.taken, s.visible) for s in stalls]
        table = np.array(rows, np.float64).reshape(-1, 8)
        sane = np.isfinite(table).all(1) & (table[:, 3] > 0.5) & (table[:, 4] > 0.5)
        whole = np.column_stack([table, np.full(len(table), np.nan)])[sane]
        return cls(*whole.T)

    def __len__(self) -> int:
        return len(self.north)

    def take(self, index: NDArray[np.bool_] | NDArray[np.intp]) -> Detections:
        """Return some of them."""
        return Detections(*(getattr(self, f.name)[index] for f in fields(self)))

    @property
    def is_whole(self) -> NDArray[np.bool_]:
        """True for those that lie in the picture as a whole."""
        return self.visible > _WHOLE

    def with_leans(self, leans: Floats) -> Detections:
        """Return them with the leans of those that are whole, as many as these."""
        lean = self.lean.copy()
        lean[self.is_whole] = leans
        return replace(self, lean=lean)

    def moved(self, correction: Floats) -> Detections:
        """Return them with places and directions corrected by a rigid (2, 3) map-to-map affine."""
        centre = transform_points(correction, np.stack([self.north, self.east], -1))
        turn = float(np.arctan2(correction[1, 0], correction[0, 0]))
        return replace(self, north=centre[:, 0], east=centre[:, 1], angle=(self.angle + turn) % np.pi)


def pair(
    known: tuple[Floats, Floats, Floats, Floats, Floats], found: tuple[Floats, Floats, Floats]
) -> tuple[Indices, Indices]:
    """Return indices of pairs (known, found), one-to-one, with the least sum of squared distances.

    ``known`` is north, east, angle, width, length; ``found`` north, east, angle. A pair must agree within half a width
    across, 0.45 of the length along, and 20 degrees.
    """
    north, east, angle, width, length = known
    if len(north) == 0 or len(found[0]) == 0:
        none = np.zeros(0, np.intp)
        return none, none
    d_north, d_east = found[0][None] - north[:, None], found[1][None] - east[:, None]
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = np.abs(d_north * cos + d_east * sin) / length[:, None]
    across = np.abs(d_east * cos - d_north * sin) / width[:, None]
    turn = quads.angle_between(found[2][None], angle[:, None])
    allowed = (across < _ACROSS) & (along < _ALONG) & (turn < _ANGLE)
    cost = (across / _ACROSS) ** 2 + (along / _ALONG) ** 2 + (turn / _ANGLE) ** 2
    rows, columns = np.flatnonzero(allowed.any(1)), np.flatnonzero(allowed.any(0))
    if len(rows) == 0:
        return rows, columns
    cost = np.where(allowed, cost, _FAR)[np.ix_(rows, columns)]
    r, c = linear_sum_assignment(cost)
    good = cost[r, c] < _FAR
    return rows[r[good]], columns[c[good]]
