"""From the network's maps to stalls or vehicles: every core cell votes for its centre; where votes meet, one is.

The votes' mean gives place and direction, the spread of the voters gives a stall's size (a uniform distribution of
width w has variance w^2 / 12) and their mean a vehicle's, which a crown may hide in part. The maps under the rectangle
give its score, and the probability that a stall is taken.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Final, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision import quads
from hawk.algo.vision.detection import Detection, FloatArray, GroundImage
from hawk.algo.vision.network import CELL_PIXELS, CORE_SHARE, MapArray

_SAMPLES = (7, 13)
_LEAST_SHOWN = 0.3
"""Below this visible share of its core a stall is not judged by the core."""
STATE_FEATURES: Final = ("said", "car", "middle")
"""Log-odds of taken by the network's own output; mean car over the stall, and along the middle fifths of its width: a
neighbour's car and its shadow lie aside."""
STATE_WEIGHTS: Final = np.array([-0.87, 1.09, -2.10, 5.18])
"""Constant and weights of the features, by ``python -m training.states``."""
_MIDDLE = 0.2
_SAID_LEAST = 0.005


@dataclass(frozen=True, slots=True)
class Stalls:
    """Stalls of one frame as arrays of length N; ``column``, ``row``, ``angle``, ``width``, ``length`` in map cells
    (angle: direction of the long side, atan2 of row over column).
    """

    column: FloatArray
    row: FloatArray
    angle: FloatArray
    width: FloatArray
    length: FloatArray
    score: FloatArray

    def __len__(self) -> int:
        return len(self.score)

    def __getitem__(self, which: Any) -> Stalls:
        return Stalls(*(getattr(self, f.name)[which] for f in fields(self)))

    def corners(self) -> FloatArray:
        """Return (N, 4, 2) of (column, row)."""
        return quads.corners(self.column, self.row, self.angle, self.width, self.length)


@dataclass(frozen=True, slots=True)
class VoteRules:
    """Rules by which the cells of one kind of object vote; lengths in cells but for those in metres.

    ``core_limit``: a cell votes from this probability. ``peak_limit``: density of votes at a centre, 1 for a whole
    object. ``reach``: from a centre to its voters' votes. ``beyond``: how far outside the maps the centre of an object
    that is partly visible may lie. ``overlap``: of two that share more than this the better one stays. ``core_of``:
    mean of the core map at which a rectangle is surely none, and fully an object; islands between stalls lie between.
    ``is_size_voted``: the size is the mean of the votes, not the spread of the voters. ``least_voters``: fewer cells
    are no object. ``apart``: side of the square, odd, in which one centre is.
    """

    width_m: tuple[float, float]
    length_m: tuple[float, float]
    beyond: int
    core_limit: float = 0.35
    peak_limit: float = 0.25
    sigma: float = 1.8
    reach: float = 4.0
    overlap: float = 0.3
    core_of: tuple[float, float] = (0.5, 0.9)
    is_size_voted: bool = False
    least_voters: int = 12
    apart: int = 7


STALL_RULES: Final = VoteRules(width_m=(1.4, 4.6), length_m=(3.0, 9.0), beyond=15)


class VoteMaps(Protocol):
    """Maps, each (rows, columns), by which cells vote: see `NetworkMaps`."""

    @property
    def core(self) -> MapArray: ...  # noqa: D102 - as in `NetworkMaps`

    @property
    def sine(self) -> MapArray: ...  # noqa: D102

    @property
    def cosine(self) -> MapArray: ...  # noqa: D102

    @property
    def offset_column(self) -> MapArray: ...  # noqa: D102

    @property
    def offset_row(self) -> MapArray: ...  # noqa: D102

    @property
    def width(self) -> MapArray: ...  # noqa: D102

    @property
    def length(self) -> MapArray: ...  # noqa: D102


class StateMaps(Protocol):
    """Maps, each (rows, columns), that say whether a stall is taken: see `NetworkMaps`."""

    @property
    def core(self) -> MapArray: ...  # noqa: D102 - as in `NetworkMaps`

    @property
    def taken(self) -> MapArray: ...  # noqa: D102

    @property
    def car(self) -> MapArray: ...  # noqa: D102


def vote(
    maps: VoteMaps, cell_m: float, shown: NDArray[np.float32] | None = None, rules: VoteRules = STALL_RULES
) -> Stalls:
    """Return the stalls, or the vehicles by `VEHICLE_RULES`, that the maps show; ``cell_m`` is a cell's side in metres.

    ``shown`` is 1 in the cells that can be seen, 0 elsewhere; None: all can. Objects that reach beyond them, or beyond
    the maps, are judged by their visible part, and their centres may lie there.
    """
    shown = np.ones_like(maps.core) if shown is None else shown
    core = maps.core * shown
    size = (core.shape[0] + 2 * rules.beyond, core.shape[1] + 2 * rules.beyond)
    voters = _Voters(maps, core, cell_m, size, rules)
    peaks = _peaks(voters, size, rules)
    if not len(peaks[0]):
        return Stalls(*[np.zeros(0)] * 6)
    found = _gather(voters, peaks, size, rules)
    found = replace(found, column=found.column - rules.beyond, row=found.row - rules.beyond)
    fits = _between(found.width * cell_m, rules.width_m) & _between(found.length * cell_m, rules.length_m)
    found = _weigh(found[fits], core, shown, rules)
    return found[quads.suppress(found.corners(), found.score, rules.overlap)]


def occupancy(maps: StateMaps, stalls: Stalls) -> FloatArray:
    """Return the probability (N,) that each stall is taken, by a logistic regression over `state_features`."""
    log_odds = STATE_WEIGHTS[0] + state_features(maps, stalls) @ STATE_WEIGHTS[1:]
    return np.asarray(1 / (1 + np.exp(-log_odds)))


def state_features(maps: StateMaps, stalls: Stalls) -> FloatArray:
    """Return what the network says of the state of each stall: (N, F), columns as `STATE_FEATURES`."""
    cells = Cells.nearest(sample_points(stalls), maps.core.shape)
    core, taken, car = (cells.read(values) for values in (maps.core, maps.taken, maps.car))
    inner, middle = _inner(), np.abs(sample_grid()[:, 0]) < _MIDDLE
    weight = core[:, inner] + 1e-3
    said = np.clip((taken[:, inner] * weight).sum(axis=1) / weight.sum(axis=1), _SAID_LEAST, 1 - _SAID_LEAST)
    car_share, middle_share = (
        car[:, part].sum(axis=1) / np.maximum(cells.is_inside[:, part].sum(axis=1), 1e-3)
        for part in (np.ones_like(middle), middle)
    )
    return np.column_stack([np.log(said / (1 - said)), car_share, middle_share])


def sample_grid() -> FloatArray:
    """Return the places (K, 2) within a stall where maps are read: shares of width and length, -0.5..0.5."""
    across, along = ((np.arange(n) + 0.5) / n - 0.5 for n in _SAMPLES)
    return np.stack(np.meshgrid(across, along), axis=-1).reshape(-1, 2)


def sample_points(stalls: Stalls) -> FloatArray:
    """Return the places (N, K, 2), (column, row), of `sample_grid` in each stall."""
    grid = sample_grid()
    long = np.stack([np.cos(stalls.angle), np.sin(stalls.angle)], -1)
    wide = np.stack([-long[:, 1], long[:, 0]], -1)
    centre = np.stack([stalls.column, stalls.row], -1)
    return np.asarray(
        centre[:, None]
        + grid[None, :, :1] * (wide * stalls.width[:, None])[:, None]
        + grid[None, :, 1:] * (long * stalls.length[:, None])[:, None]
    )


@dataclass(frozen=True, slots=True)
class Cells:
    """Cells of maps by ``index`` (...) into the flat map; ``is_inside`` (...) is False beyond the maps."""

    index: NDArray[np.intp]
    is_inside: NDArray[np.bool_]

    @classmethod
    def nearest(cls, points: FloatArray, size: tuple[int, ...]) -> Cells:
        """Return the cells nearest to (column, row) points (..., 2) of maps of ``size``, (rows, columns)."""
        rows, columns = size
        column, row = (np.rint(points[..., k]).astype(np.intp) for k in (0, 1))
        is_inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
        return cls(np.where(is_inside, row * columns + column, 0), is_inside)

    def read(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return the values of each map of (rows, columns); 0 outside."""
        return np.where(self.is_inside, values.reshape(*values.shape[:-2], -1)[..., self.index], 0)


def sample(values: NDArray[Any], points: FloatArray) -> NDArray[Any]:
    """Return the nearest values at (column, row) points (..., 2), of each map of (rows, columns); 0 outside."""
    return Cells.nearest(points, values.shape[-2:]).read(values)


def to_seen(stalls: Stalls, taken: FloatArray, ground: GroundImage) -> tuple[Detection, ...]:
    """Return stalls, given in cells of the raster ``ground``, in metres of the map."""
    if not len(stalls):
        return ()
    side = ground.metres_per_pixel
    place, angle = ground.map_points(np.stack([stalls.column, stalls.row], -1)), ground.map_angle(stalls.angle)
    visible = sample(ground.valid, sample_points(stalls)).mean(axis=1)
    table = np.column_stack([place, angle, stalls.width * side, stalls.length * side, stalls.score, taken, visible])
    return tuple(Detection(*line) for line in table.tolist())


class _Voters:
    """Core cells with their votes; rows and columns start ``beyond`` cells before the maps: all centres are above 0.

    ``cell``: that of each vote in flat maps of ``size``.
    """

    def __init__(
        self, maps: VoteMaps, core: NDArray[np.float32], cell_m: float, size: tuple[int, int], rules: VoteRules
    ) -> None:
        at = np.flatnonzero(core > rules.core_limit)
        self.row, self.column = (each + float(rules.beyond) for each in np.divmod(at, core.shape[1]))
        self.core = core.reshape(-1)[at].astype(np.float64)
        self.width, self.length = (each.reshape(-1)[at] / cell_m for each in (maps.width, maps.length))
        self.weight = self.core / (self.width * self.length * CORE_SHARE**2)  # all of a whole one weigh about 1
        self.centre_column = self.column + maps.offset_column.reshape(-1)[at]
        self.centre_row = self.row + maps.offset_row.reshape(-1)[at]
        self.sine, self.cosine = maps.sine.reshape(-1)[at], maps.cosine.reshape(-1)[at]
        row = np.clip(np.rint(self.centre_row), 0, size[0] - 1).astype(np.intp)
        self.cell = row * size[1] + np.clip(np.rint(self.centre_column), 0, size[1] - 1).astype(np.intp)


def _peaks(voters: _Voters, size: tuple[int, int], rules: VoteRules) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return rows and columns of the maxima of the density of votes."""
    votes = np.bincount(voters.cell, voters.weight, size[0] * size[1]).reshape(size).astype(np.float32)
    density = cv2.GaussianBlur(votes, (0, 0), rules.sigma) * np.float32(2 * np.pi * rules.sigma**2)
    highest = cv2.dilate(density, np.ones((rules.apart, rules.apart), np.uint8))
    rows, columns = np.divmod(np.flatnonzero((density == highest) & (density > rules.peak_limit)), size[1])
    return rows, columns


def _gather(
    voters: _Voters, peaks: tuple[NDArray[np.intp], NDArray[np.intp]], size: tuple[int, int], rules: VoteRules
) -> Stalls:
    """Give every vote to the nearest peak within reach, and describe the object of each peak by its voters."""
    away = np.full(size, 255, np.uint8)
    away[peaks] = 0
    _, nearest = cv2.distanceTransformWithLabels(away, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
    order = np.zeros(len(peaks[0]) + 1, np.intp)
    order[nearest[peaks]] = np.arange(len(peaks[0]))
    owner = order[nearest.reshape(-1)[voters.cell]]
    apart = np.hypot(voters.centre_column - peaks[1][owner], voters.centre_row - peaks[0][owner])
    mine = apart < rules.reach
    owner, votes, count = owner[mine], voters.weight[mine], len(peaks[0])
    weight = np.maximum(np.bincount(owner, votes, count), 1e-9)

    def mean(values: NDArray[Any]) -> FloatArray:
        return np.asarray(np.bincount(owner, votes * values[mine], count) / weight)

    sine, cosine = mean(voters.sine), mean(voters.cosine)
    angle = 0.5 * np.arctan2(sine, cosine)
    column, row = mean(voters.centre_column), mean(voters.centre_row)
    if rules.is_size_voted:
        width, length = mean(voters.width), mean(voters.length)
    else:
        from_column, from_row = voters.column[mine] - column[owner], voters.row[mine] - row[owner]
        width, length = _spread(from_column, from_row, voters.core[mine], owner, angle)
    score = np.minimum(weight, 1.0) * np.minimum(np.hypot(sine, cosine), 1.0)
    found = Stalls(column, row, angle, width, length, score)
    return found[np.bincount(owner, minlength=count) >= rules.least_voters]


def _spread(
    from_column: FloatArray, from_row: FloatArray, core: FloatArray, owner: NDArray[np.intp], angle: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return width and length of each object by the spread of its cells, which lie so far from its centre."""
    cosine, sine = np.cos(angle)[owner], np.sin(angle)[owner]
    mass = np.maximum(np.bincount(owner, core, len(angle)), 1e-9)

    def extent(distance: FloatArray) -> FloatArray:
        return np.asarray(np.sqrt(12 * np.bincount(owner, distance**2 * core, len(angle)) / mass + 1) / CORE_SHARE)

    return extent(from_row * cosine - from_column * sine), extent(from_column * cosine + from_row * sine)


def _weigh(stalls: Stalls, core: NDArray[np.float32], shown: NDArray[np.float32], rules: VoteRules) -> Stalls:
    """Lower the score of stalls that the core map itself is unsure of; raise that of stalls that are cut off."""
    cells = Cells.nearest(sample_points(stalls)[:, _inner()], core.shape)
    share = cells.read(shown).mean(axis=1)
    share = np.where(share >= _LEAST_SHOWN, share, 1.0)
    mean, score = cells.read(core).mean(axis=1) / share, np.minimum(stalls.score / share, 1.0)
    return replace(stalls, score=score * np.interp(mean, rules.core_of, (0.0, 1.0)))


def _inner() -> NDArray[np.bool_]:
    """Return which places of `sample_grid` lie in a stall's core."""
    return np.asarray(np.abs(sample_grid()).max(axis=1) <= CORE_SHARE / 2)


def _between(values: FloatArray, limits: tuple[float, float]) -> NDArray[np.bool_]:
    return (values > limits[0]) & (values < limits[1])


def cell_raster(picture: GroundImage, values: NDArray[Any]) -> GroundImage:
    """Return a network map as a raster on the ground: cell (c, r) lies at picture pixel (2 c, 2 r)."""
    to_map = picture.to_map.copy()
    to_map[:, :2] *= CELL_PIXELS
    return GroundImage(values, to_map, picture.valid[::CELL_PIXELS, ::CELL_PIXELS])
