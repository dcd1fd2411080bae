"""From the network's maps to stalls: every core cell votes for its stall's centre; where votes meet, a stall is.

The votes' mean gives place and direction, the spread of the voters gives the size (a uniform distribution of width w
has variance w^2 / 12), the maps under the rectangle give its score and the probability that it is taken.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Final, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision import quads
from hawk.algo.vision.detection import Detection, FloatArray, GroundImage
from hawk.algo.vision.network import CELL_PIXELS, CORE_SHARE, MapArray, NetworkMaps

_CORE_LIMIT = 0.35
_PEAK_LIMIT = 0.25
_PEAK_SIGMA = 1.8
_PEAK_REACH = 4.0
_MINIMUM_VOTERS = 12
_OVERLAP_LIMIT = 0.3
_WIDTH_M = (1.4, 4.6)
_LENGTH_M = (3.0, 9.0)
_SAMPLES = (7, 13)
_BEYOND_CELLS = 15
"""Distance beyond the maps, cells, at which the centre of a stall that is partly visible may lie."""
_LEAST_SHOWN = 0.3
"""Below this visible share of its core a stall is not judged by the core."""
_CORE_OF_STALLS = (0.5, 0.9)
"""Mean core probability within a rectangle at which it is surely none, and fully a stall; islands lie between."""
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


class StateMaps(Protocol):
    """Maps, each (rows, columns), that say whether a stall is taken: see `NetworkMaps`."""

    @property
    def core(self) -> MapArray: ...  # noqa: D102 - as in `NetworkMaps`

    @property
    def taken(self) -> MapArray: ...  # noqa: D102

    @property
    def car(self) -> MapArray: ...  # noqa: D102


def vote(maps: NetworkMaps, cell_m: float, shown: NDArray[np.float32] | None = None) -> Stalls:
    """Return the stalls that the maps show; ``cell_m`` is the side of a cell in metres.

    ``shown`` is 1 in the cells that can be seen, 0 elsewhere; None: all can. Stalls that reach beyond them, or beyond
    the maps, are judged by their visible part, and their centres may lie there.
    """
    shown = np.ones_like(maps.core) if shown is None else shown
    core = maps.core * shown
    rows, columns = np.nonzero(core > _CORE_LIMIT)
    voters = _Voters(maps, core, rows, columns, cell_m)
    size = (core.shape[0] + 2 * _BEYOND_CELLS, core.shape[1] + 2 * _BEYOND_CELLS)
    peaks = _peaks(voters, size)
    if not len(peaks[0]):
        return Stalls(*[np.zeros(0)] * 6)
    found = _gather(voters, peaks, size)
    found = replace(found, column=found.column - _BEYOND_CELLS, row=found.row - _BEYOND_CELLS)
    fits = _between(found.width * cell_m, _WIDTH_M) & _between(found.length * cell_m, _LENGTH_M)
    found = _weigh(found[fits], core, shown)
    return found[quads.suppress(found.corners(), found.score, _OVERLAP_LIMIT)]


def occupancy(maps: StateMaps, stalls: Stalls) -> FloatArray:
    """Return the probability (N,) that each stall is taken, by a logistic regression over `state_features`."""
    log_odds = STATE_WEIGHTS[0] + state_features(maps, stalls) @ STATE_WEIGHTS[1:]
    return np.asarray(1 / (1 + np.exp(-log_odds)))


def state_features(maps: StateMaps, stalls: Stalls) -> FloatArray:
    """Return what the network says of the state of each stall: (N, F), columns as `STATE_FEATURES`."""
    points = sample_points(stalls)
    core, taken, car = (sample(values, points) for values in (maps.core, maps.taken, maps.car))
    inner, middle = _inner(), np.abs(sample_grid()[:, 0]) < _MIDDLE
    weight = core[:, inner] + 1e-3
    said = np.clip((taken[:, inner] * weight).sum(axis=1) / weight.sum(axis=1), _SAID_LEAST, 1 - _SAID_LEAST)
    shown = sample(np.ones_like(maps.car), points)  # 1 but at the picture's edge
    car_share, middle_share = (
        car[:, part].sum(axis=1) / np.maximum(shown[:, part].sum(axis=1), 1e-3)
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


def sample(values: NDArray[Any], points: FloatArray) -> NDArray[Any]:
    """Return the nearest values (...,) at (column, row) points (..., 2); 0 outside."""
    cells = np.rint(points).astype(np.intp)
    rows, columns = values.shape
    inside = (cells[..., 0] >= 0) & (cells[..., 0] < columns) & (cells[..., 1] >= 0) & (cells[..., 1] < rows)
    read = values[np.clip(cells[..., 1], 0, rows - 1), np.clip(cells[..., 0], 0, columns - 1)]
    return np.where(inside, read, 0)


def to_seen(stalls: Stalls, taken: FloatArray, ground: GroundImage) -> tuple[Detection, ...]:
    """Return stalls, given in cells of the raster ``ground``, in metres of the map."""
    if not len(stalls):
        return ()
    linear, side = ground.to_map[:, :2], ground.metres_per_pixel
    place = ground.map_points(np.stack([stalls.column, stalls.row], -1))
    long = np.stack([np.cos(stalls.angle), np.sin(stalls.angle)], -1) @ linear.T
    angle = np.arctan2(long[:, 1], long[:, 0]) % np.pi
    visible = sample(ground.valid, sample_points(stalls)).mean(axis=1)
    table = np.column_stack([place, angle, stalls.width * side, stalls.length * side, stalls.score, taken, visible])
    return tuple(Detection(*line) for line in table.tolist())


class _Voters:
    """Core cells with their votes; rows and columns start `_BEYOND_CELLS` before the maps: all centres are above 0."""

    def __init__(
        self, maps: NetworkMaps, core: NDArray[np.float32], rows: NDArray[Any], columns: NDArray[Any], cell_m: float
    ) -> None:
        self.row, self.column = rows + float(_BEYOND_CELLS), columns + float(_BEYOND_CELLS)
        self.core = core[rows, columns].astype(np.float64)
        area = maps.width[rows, columns] * maps.length[rows, columns] * (CORE_SHARE**2 / cell_m**2)
        self.weight = self.core / area  # all voters of a whole stall together weigh about 1
        self.centre_column = self.column + maps.offset_column[rows, columns]
        self.centre_row = self.row + maps.offset_row[rows, columns]
        self.sine, self.cosine = maps.sine[rows, columns], maps.cosine[rows, columns]


def _peaks(voters: _Voters, size: tuple[int, ...]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return rows and columns of the maxima of the density of votes."""
    cells = _cell(voters, size)
    votes = np.bincount(cells, voters.weight, size[0] * size[1]).reshape(size).astype(np.float32)
    density = cv2.GaussianBlur(votes, (0, 0), _PEAK_SIGMA) * np.float32(2 * np.pi * _PEAK_SIGMA**2)
    highest = cv2.dilate(density, np.ones((7, 7), np.uint8))
    rows, columns = np.nonzero((density == highest) & (density > _PEAK_LIMIT))
    return rows, columns


def _gather(voters: _Voters, peaks: tuple[NDArray[np.intp], NDArray[np.intp]], size: tuple[int, ...]) -> Stalls:
    """Give every vote to the nearest peak within reach, and describe the stall of each peak by its voters."""
    away = np.full(size, 255, np.uint8)
    away[peaks] = 0
    _, nearest = cv2.distanceTransformWithLabels(away, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
    order = np.zeros(len(peaks[0]) + 1, np.intp)
    order[nearest[peaks]] = np.arange(len(peaks[0]))
    owner = order[nearest.reshape(-1)[_cell(voters, size)]]
    apart = np.hypot(voters.centre_column - peaks[1][owner], voters.centre_row - peaks[0][owner])
    mine = apart < _PEAK_REACH
    owner, count = owner[mine], len(peaks[0])

    def total(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(owner, values[mine], count))

    weight = np.maximum(total(voters.weight), 1e-9)
    sine, cosine = total(voters.weight * voters.sine) / weight, total(voters.weight * voters.cosine) / weight
    angle = 0.5 * np.arctan2(sine, cosine)
    column, row = (
        total(voters.weight * voters.centre_column) / weight,
        total(voters.weight * voters.centre_row) / weight,
    )
    turned = np.cos(angle), np.sin(angle)
    from_column, from_row = voters.column[mine] - column[owner], voters.row[mine] - row[owner]
    along = from_column * turned[0][owner] + from_row * turned[1][owner]
    across = -from_column * turned[1][owner] + from_row * turned[0][owner]
    core = voters.core[mine]
    mass = np.maximum(np.bincount(owner, core, count), 1e-9)

    def extent(distance: FloatArray) -> FloatArray:
        return np.asarray(np.sqrt(12 * np.bincount(owner, distance**2 * core, count) / mass + 1) / CORE_SHARE)

    score = np.minimum(weight, 1.0) * np.minimum(np.hypot(sine, cosine), 1.0)
    found = Stalls(column, row, angle, extent(across), extent(along), score)
    return found[np.bincount(owner, minlength=count) >= _MINIMUM_VOTERS]


def _weigh(stalls: Stalls, core: NDArray[np.float32], shown: NDArray[np.float32]) -> Stalls:
    """Lower the score of stalls that the core map itself is unsure of; raise that of stalls that are cut off."""
    points = sample_points(stalls)[:, _inner()]
    share = sample(shown, points).mean(axis=1)
    share = np.where(share >= _LEAST_SHOWN, share, 1.0)
    mean, score = sample(core, points).mean(axis=1) / share, np.minimum(stalls.score / share, 1.0)
    return replace(stalls, score=score * np.interp(mean, _CORE_OF_STALLS, (0.0, 1.0)))


def _inner() -> NDArray[np.bool_]:
    """Return which places of `sample_grid` lie in a stall's core."""
    return np.asarray(np.abs(sample_grid()).max(axis=1) <= CORE_SHARE / 2)


def _cell(voters: _Voters, size: tuple[int, ...]) -> NDArray[np.intp]:
    row = np.clip(np.rint(voters.centre_row), 0, size[0] - 1).astype(np.intp)
    column = np.clip(np.rint(voters.centre_column), 0, size[1] - 1).astype(np.intp)
    return np.asarray(row * size[1] + column, np.intp)


def _between(values: FloatArray, limits: tuple[float, float]) -> NDArray[np.bool_]:
    return (values > limits[0]) & (values < limits[1])


def cell_raster(picture: GroundImage, values: NDArray[Any]) -> GroundImage:
    """Return a network map as a raster on the ground: cell (c, r) lies at picture pixel (2 c, 2 r)."""
    to_map = picture.to_map.copy()
    to_map[:, :2] *= CELL_PIXELS
    return GroundImage(values, to_map, picture.valid[::CELL_PIXELS, ::CELL_PIXELS])
