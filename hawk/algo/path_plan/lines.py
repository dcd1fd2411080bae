"""A whole plan: parallel lines that together show everything expected, and the order in which to fly them.

The secret is the estimate of what is left to fly. For every heading the field is turned once, cut into bands of one
swath, and each band is flown from its first to its last cell that is worth it. The heading of the least total way wins;
only its first line is flown before the estimate is made anew.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.path_plan.field import InformationField
from hawk.algo.path_plan.sweep import Swath
from hawk.algo.path_plan.turned import Axes, Place

_TURN_M = 4.0  # a right angle costs so many metres of way: braking, yaw, speeding up
_LEG_M = 3.0  # so does every leg for its stop
_CELL_SHARE = 0.45  # expected new share from which a cell is flown to

Grid = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Line:
    """A straight way from start to end, (north, east) metres; what it shows, square metres."""

    start: Place
    end: Place
    gain: float

    def reversed(self) -> Line:
        """Return the line flown the other way."""
        return Line(self.end, self.start, self.gain)


@dataclass(frozen=True, slots=True)
class LinePlan:
    """Lines in order with one heading, and the whole way's cost, metres."""

    heading: float
    lines: tuple[Line, ...]
    cost: float


def best_plan(
    field: InformationField, place: Place, yaw: float, swath: Swath, headings: Sequence[float], least_gain: float
) -> LinePlan | None:
    """Return the cheapest plan over the headings (radians, modulo pi), None when nothing is worth a way."""
    wanted = np.where(field.gain >= _CELL_SHARE * field.window.cell_m**2, field.gain, 0).astype(np.float32)
    rows, columns = np.nonzero(wanted)
    if len(rows) == 0:
        return None
    box = (int(rows.min()), int(rows.max()), int(columns.min()), int(columns.max()))
    plans = (_plan(field, wanted, box, place, yaw, swath, heading, least_gain) for heading in headings)
    return min((plan for plan in plans if plan is not None), key=lambda plan: plan.cost, default=None)


def _plan(
    field: InformationField,
    wanted: Grid,
    box: tuple[int, int, int, int],
    place: Place,
    yaw: float,
    swath: Swath,
    heading: float,
    least_gain: float,
) -> LinePlan | None:
    axes, size = _axes_around(field, box, heading)
    gain = axes.turned(field, wanted, (size, size))
    allowed = axes.turned(field, field.allowed, (size, size), cv2.INTER_NEAREST) > 0
    lines = []
    for middle in _middles(gain, swath.width / axes.cell_m):
        line = _line(axes, gain, allowed, middle, swath, least_gain)
        if line is not None:
            lines.append(line)
    if not lines:
        return None
    ordered, cost = _cheapest_order(lines, place, yaw)
    return LinePlan(heading, ordered, cost)


def _axes_around(field: InformationField, box: tuple[int, int, int, int], heading: float) -> tuple[Axes, int]:
    cell = field.window.cell_m
    top, bottom, left, right = box
    north = -(field.window.row + (top + bottom) / 2 + 0.5) * cell
    east = (field.window.column + (left + right) / 2 + 0.5) * cell
    size = math.ceil(math.hypot(bottom - top + 1, right - left + 1)) + 2
    return Axes((north, east), heading, cell, (size - 1) / 2, (size - 1) / 2), size


def _middles(gain: Grid, width: float) -> list[float]:
    """Return the middle columns of bands that cover every column with gain; connected ones are spread evenly."""
    columns = np.flatnonzero(gain.sum(0) > 0)
    if len(columns) == 0:
        return []
    breaks = np.flatnonzero(np.diff(columns) > width / 2)
    firsts = columns[np.concatenate([[0], breaks + 1])]
    lasts = columns[np.concatenate([breaks, [len(columns) - 1]])]
    middles: list[float] = []
    for first, last in zip(firsts, lasts, strict=True):
        extent = float(last - first + 1)
        count = max(1, math.ceil(extent / width - 0.02))
        middles += [float(first) - 0.5 + extent * (i + 0.5) / count for i in range(count)]
    return middles


def _line(
    axes: Axes, gain: Grid, allowed: NDArray[np.bool_], middle: float, swath: Swath, least_gain: float
) -> Line | None:
    half_width, half_depth = swath.width / 2 / axes.cell_m, swath.depth / 2 / axes.cell_m
    band = gain[:, max(math.ceil(middle - half_width - 0.5), 0) : math.floor(middle + half_width + 0.5) + 1].sum(1)
    total = float(band.sum())
    if total < least_gain:
        return None
    rows = np.flatnonzero(band > 0)
    first, last = rows[0] - 0.5 + half_depth, rows[-1] + 0.5 - half_depth
    if first > last:
        first = last = (first + last) / 2
    fitted = _onto_allowed(allowed, middle, half_width, first, last)
    if fitted is None:
        return None
    column, begin, end = fitted
    return Line(axes.place_of(begin, column), axes.place_of(end, column), total)


def _onto_allowed(
    allowed: NDArray[np.bool_], middle: float, half_width: float, first: float, last: float
) -> tuple[float, float, float] | None:
    """Return column, first and last row of the line moved to where the drone may be, the nearest column first."""
    columns = np.arange(max(0, math.ceil(middle - half_width)), min(allowed.shape[1], math.floor(middle + half_width)))
    for column in columns[np.argsort(np.abs(columns - middle), kind="stable")]:
        rows = np.flatnonzero(allowed[:, column])
        if len(rows) == 0:
            continue
        begin, end = np.clip([first, last], rows[0], rows[-1])
        reach = max(half_width, 1.0)
        if abs(begin - first) <= reach and abs(end - last) <= reach:
            exact = middle if abs(column - middle) <= 0.5 else float(column)
            return exact, float(begin), float(end)
    return None


def _cheapest_order(lines: list[Line], place: Place, yaw: float) -> tuple[tuple[Line, ...], float]:
    """Return the lines to and fro from one side or the other, whichever way costs least, with its cost."""
    best: tuple[tuple[Line, ...], float] | None = None
    for from_left in (True, False):
        ordered = lines if from_left else lines[::-1]
        for first_forward in (True, False):
            flown = tuple(line if (i % 2 == 0) == first_forward else line.reversed() for i, line in enumerate(ordered))
            cost = way_cost(flown, place, yaw)
            if best is None or cost < best[1]:
                best = flown, cost
    if best is None:
        raise ValueError("no lines to order")
    return best


def way_cost(lines: Sequence[Line], place: Place, yaw: float) -> float:
    """Return what flying to and along the lines costs from a place with a heading, metres."""
    cost, at, heading = 0.0, place, yaw
    for line in lines:
        for there in (line.start, line.end):
            length = math.dist(at, there)
            if length < 0.5:
                continue
            turn = math.atan2(there[1] - at[1], there[0] - at[0])
            cost += length + _LEG_M + abs(math.remainder(turn - heading, math.tau)) / (math.pi / 2) * _TURN_M
            at, heading = there, turn
    return cost
