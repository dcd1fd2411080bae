"""Ground still to be learned: expected lot that was not seen well, by coarse cells, and what a tour has to show of it.

The border of a lot is uncertain. Ground beyond it is lot the likelier, the nearer known lot is, and the unlikelier, the
nearer it is to ground known not to be lot. A tour has to show lot that was seen only at a picture's edge whole, and
unseen ground by its likelihood; unlikely ground is left out: a tour that went to see every doubt would never end.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np

from hawk.algo.ground import Bools, CoarseLayers, Floats, Grid, Mask, Place, Window
from hawk.algo.path_plan.beyond import Border, Unlooked, alike_near, looks_alike, unlooked_at, without_patches
from hawk.algo.path_plan.footprint import Footprint, Singles
from hawk.algo.path_plan.grid_search import farthest_in_sight
from hawk.algo.path_plan.lot_ground import without_border

_BRIDGE_CELLS: Final = 3  # width of a corridor: routing looks at every other cell
_BRIDGE_TRIES: Final = 8  # at other places when the shortest line leaves the fence

Cell = tuple[int, int]
"""Column and row."""


def with_bridges(ground: Mask, fenced: Mask, longest: float) -> Mask:
    """Return the ground with corridors between its parts, so that the drone can cross the road that parts them.

    A corridor is the shortest straight line from one part to the next inside the fence (1 in ``fenced``), or else the
    shortest path around what lies outside, of ``longest`` cells at most. ``ground`` is 1 where the drone may be.
    """
    count, labels = cv2.connectedComponents(ground, connectivity=8)
    if count <= 2:  # the background is one of them
        return ground
    bridged = ground.copy()
    reached = labels == 1
    waiting = set(range(2, count))
    while waiting:
        other = (labels > 0) & ~reached
        line = _shortest(reached, other, fenced, longest) or _around(reached, other, fenced, longest)
        if line is None:  # go on from a part that cannot be reached: others may be, from there
            part = waiting.pop()
            reached = labels == part
            continue
        cv2.polylines(bridged, [np.array(line, np.int32)], False, (1,), _BRIDGE_CELLS)
        end = line[-1]
        part = int(labels[end[1], end[0]])
        waiting.discard(part)
        reached |= labels == part
    return np.asarray(bridged & fenced, np.uint8)


def _shortest(reached: Bools, other: Bools, fenced: Mask, longest: float) -> list[Cell] | None:
    """Return the ends of the shortest line inside the fence from reached cells to others."""
    away, nearest = cv2.distanceTransformWithLabels(
        (~reached).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    rows, columns = np.nonzero(other)
    if len(rows) == 0:
        return None
    place_of = np.zeros(int(nearest.max()) + 1, np.intp)
    place_of[nearest[reached]] = np.flatnonzero(reached)
    order = np.argsort(away[rows, columns], kind="stable")
    order = order[away[rows, columns][order] <= longest]
    for pick in order[:: max(1, len(order) // _BRIDGE_TRIES)]:
        end = (int(columns[pick]), int(rows[pick]))
        row, column = divmod(int(place_of[nearest[end[1], end[0]]]), reached.shape[1])
        line = np.zeros(fenced.shape, np.uint8)
        cv2.line(line, (column, row), end, (1,), 1)
        if fenced[line > 0].all():
            return [(column, row), end]
    return None


def _around(reached: Bools, other: Bools, fenced: Mask, longest: float) -> list[Cell] | None:
    """Return the cells of the shortest path inside the fence from reached cells to others.

    The path keeps a cell from what lies outside, so that the whole width of the corridor is inside.
    """
    free = (without_border(fenced) > 0) | reached | other
    waves = [reached]
    while len(waves) <= longest and not (waves[-1] & other).any():
        wave = np.asarray(cv2.dilate(waves[-1].astype(np.uint8), _NEIGHBOURS) > 0) & free
        if (wave == waves[-1]).all():
            return None
        waves.append(wave)
    met = np.argwhere(waves[-1] & other)
    if len(met) == 0:
        return None
    row, column = (int(value) for value in met[0])
    path = [(column, row)]
    for wave in reversed(waves[:-1]):  # a cell of a wave has a neighbour in the one before
        row, column = _neighbour(wave, row, column)
        path.append((column, row))
    return path[::-1]


def _neighbour(wave: Bools, row: int, column: int) -> tuple[int, int]:
    """Return the cell itself, or a neighbour of it, that is in the wave."""
    top, left = max(row - 1, 0), max(column - 1, 0)
    near = np.argwhere(wave[top : row + 2, left : column + 2]) + np.array([top, left])
    nearest = near[int(np.argmin(np.abs(near - (row, column)).sum(1)))]
    return int(nearest[0]), int(nearest[1])


_REACH_M: Final = 10.0  # distance beyond known lot to which more is expected: most of a double row with its aisle
_TURNED: Final = 2.0  # sharpness of the border halfway between known lot and other ground
_SCOUT_M: Final = 30.0
_FAR_M: Final = 1e3
_ALIKE: Final = 0.7  # ground that looks like lot, without stalls near it, leads to lot less often
_SEEN_BADLY: Final = 0.15  # worth of a second look at a place near a picture's edge, against a first look
_LONGEST_BRIDGE_M: Final = 60.0  # across other ground, from one part of the lot to another
_ROUTING_STEP: Final = 2  # cells a routing cell
_DOUBT: Final = 0.3  # probability of lot at and below which unseen ground is ignored
_LEAST_SHARE: Final = 0.1  # of a cell
_GATHERED: Final = 2  # cells a side
_IS_LOT: Final = 0.5  # share of a cell
_IS_SEEN: Final = 0.5
_BEHIND: Final = 4.0  # times: as an opening is seen, what lies behind it is not all worth the rest of it
_OPEN_M: Final = 4.0  # half of a lane
_NEIGHBOURS: Final = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, slots=True)
class InformationField:
    """Expected new lot and where the drone may be, by coarse cells.

    ``gain`` is expected new lot in square metres a cell. ``allowed`` is 1 where the drone may be, ``passable`` the same
    with a cell more for the path and corridors between parts of the lot; ``lot`` shares of known lot, ``well`` of well
    seen, ``seen`` of seen at all.
    """

    window: Window
    gain: Grid
    allowed: Mask
    passable: Mask
    lot: Grid
    well: Grid
    seen: Grid
    beyond: Unlooked | None = None
    """Ground beyond the lot's border that was not looked at; None: it is not looked for."""
    given_up: Grid | None = None
    """Shares of lot and of ground beyond it that were taken out unseen; None: nothing was."""

    @property
    def unseen_lot(self) -> Grid:
        """Share (0..1) of each cell that is known lot and was not seen well."""
        return self.lot - np.minimum(self.lot, self.well)

    def are_allowed(self, places: Floats) -> Bools:
        """Return True for those of places (T, 2) of (north, east) where the drone may be."""
        rows, columns, inside = self.window.cells_at(places)
        return np.asarray(inside & (self.allowed[rows, columns] > 0))

    def corner_towards(self, place: Place, end: Place) -> Place | None:
        """Return the farthest place on the shortest path to ``end`` that a straight line reaches.

        None when there is no path, or the end is next to the drone.
        """
        mask = self.passable[::_ROUTING_STEP, ::_ROUTING_STEP]
        return farthest_in_sight(mask, self.window, _ROUTING_STEP, place, end)


def information_field(
    layers: CoarseLayers, fenced: Mask, near_lot_m: float, border: Border | None = None
) -> InformationField:
    """Return the field for the map's coarse layers.

    ``fenced`` is 1 inside the fence; the drone may be ``near_lot_m`` metres from the lot, and where the border is flown
    to from ground near it that looks like one. ``border`` None: what lies beyond the lot is not looked for.
    """
    cell = layers.window.cell_m
    is_lot = _known_lot(layers)
    to_lot = _distance(is_lot) * cell
    new = (1 - layers.seen) + _SEEN_BADLY * np.maximum(layers.seen - layers.well, 0)
    gain = (new * _likely_lot(layers, is_lot, to_lot) * cell**2).astype(np.float32)
    beyond, to_ground = None, to_lot
    if border is not None:
        to_alike = _distance(alike_near(layers, to_lot, border)) * cell
        beyond = unlooked_at(layers, to_lot, to_alike, border)
        to_ground = np.minimum(to_lot, to_alike) if border.is_flown_to else to_lot
    allowed = ((to_ground <= near_lot_m) & (fenced > 0)).astype(np.uint8)
    passable = np.where(fenced > 0, cv2.dilate(allowed, _NEIGHBOURS), 0).astype(np.uint8)
    passable = with_bridges(passable, fenced, _LONGEST_BRIDGE_M / cell)
    return InformationField(layers.window, gain, allowed, passable, layers.lot, layers.well, layers.seen, beyond)


def scouting_field(layers: CoarseLayers, fenced: Mask, near_lot_m: float) -> InformationField:
    """Return the field for looking around a lot that seems too small to be the whole; arguments as above.

    All unseen ground near the lot is of interest, whatever lies between.
    """
    cell = layers.window.cell_m
    to_lot = _distance(_known_lot(layers)) * cell
    gain = ((1 - layers.seen) * np.exp(-to_lot / _SCOUT_M) * cell**2).astype(np.float32)
    allowed = ((to_lot <= near_lot_m) & (fenced > 0)).astype(np.uint8)
    return InformationField(layers.window, gain, allowed, allowed, layers.lot, layers.well, layers.seen)


def guessed(layers: CoarseLayers, place: Place) -> CoarseLayers:
    """Return the layers for looking for a lot while none is known.

    Ground that looks like lot stands in for it, or else the ground below the drone, when the window shows it.
    """
    lot = layers.likely
    if not (lot > 0).any():
        lot = np.zeros(layers.window.shape, np.float32)
        rows, columns, inside = layers.window.cells_at(np.array([place]))
        lot[rows[inside], columns[inside]] = 1.0
    return replace(layers, lot=lot)


def share_of(
    field: InformationField, footprint: Footprint, least_m2: float, border: float, open_end_m2: float = 0.0
) -> Grid:
    """Return the share (0..1) of each cell that a tour has to show, as far as a picture from an allowed place can.

    Args:
        field: The field.
        footprint: Ground that a picture shows.
        least_m2: Least area of a patch, square metres.
        border: Weight (0..1) of the cells round the lot, whatever they look like.
        open_end_m2: Worth of a stretch of unseen ground along known lot, square metres; its cells may exceed 1.
    """
    area = field.window.cell_m**2
    likely = np.maximum(field.gain / area - _DOUBT, 0) / (1 - _DOUBT)
    lot = np.maximum(field.lot, border * cv2.dilate(field.lot, _NEIGHBOURS))
    share = np.maximum(likely, lot - np.minimum(lot, field.well)).astype(np.float32)
    share = np.where(_in_sight(field, footprint), share, 0)
    kept = _without_small(share, least_m2 / area)
    return kept if open_end_m2 <= 0 else np.maximum(kept, _open_ends(field, share, open_end_m2 / area))


def with_beyond(share: Grid, field: InformationField, footprint: Footprint, least_m2: float, worth: float) -> Grid:
    """Return the shares with the ground beyond the lot's border that was not looked at.

    Where the lot may go on is worth what lies behind it too: each patch ``worth`` (0..1) of all of its ground, near and
    far, and no cell more than four times its own. Patches with less than ``least_m2`` square metres near the lot,
    and what no picture from an allowed place shows, are left out.
    """
    if field.beyond is None or worth <= 0:
        return share
    near = (field.beyond.near > 0) & _in_sight(field, footprint)
    near = without_patches(near, least_m2 / field.window.cell_m**2)
    _, labels = cv2.connectedComponents(field.beyond.all, connectivity=8)
    sizes = np.bincount(labels.ravel())
    behind = sizes / np.maximum(np.bincount(labels[near], minlength=len(sizes)), 1)
    each = worth * np.minimum(behind, _BEHIND)
    return np.maximum(share, np.where(near, each[labels], 0)).astype(np.float32)


def left_out(field: InformationField, footprint: Footprint) -> Floats:
    """Return square metres a cell (4, H, W) that were not looked at, in the order of `hawk.model.plans.LeftOut`."""
    layers = np.zeros((4, *field.lot.shape))
    if field.beyond is not None:
        missing, shown = field.unseen_lot, _in_sight(field, footprint)
        ours = field.beyond.ours > 0
        layers[0], layers[1] = missing * ~ours, missing * (ours & ~shown)
        layers[3] = (field.beyond.near > 0) & shown
    if field.given_up is not None:
        layers[2] = field.given_up
    return layers * field.window.cell_m**2


def gathered(share: Grid, window: Window) -> tuple[Singles, Singles]:
    """Return places (N, 2) of (north, east) and square metres (N,) wanted of a window's cells, 2 x 2 of them as one."""
    rows, columns = (size - size % _GATHERED for size in share.shape)
    whole = share[:rows, :columns].reshape(rows // _GATHERED, _GATHERED, columns // _GATHERED, _GATHERED).sum((1, 3))
    row, column = np.nonzero(whole)
    middle = (_GATHERED - 1) / 2
    places = np.column_stack(window.centres(row * _GATHERED + middle, column * _GATHERED + middle))
    return places.astype(np.float32), (whole[row, column] * window.cell_m**2).astype(np.float32)


def _known_lot(layers: CoarseLayers) -> Bools:
    return layers.lot > 0.5 * np.maximum(layers.seen, 0.3)


def _likely_lot(layers: CoarseLayers, is_lot: Bools, to_lot: Grid) -> Grid:
    """Return the probability of being lot: as seen where it was seen, elsewhere by what is nearest."""
    known = layers.seen > 0.5
    alike = looks_alike(layers)
    to_other = np.maximum(_distance(known & ~is_lot & ~alike) * layers.window.cell_m, 0.5)
    to_alike = _distance(alike) * layers.window.cell_m
    expected = np.maximum(_beyond(to_lot, to_other), _ALIKE * _beyond(to_alike, to_other))
    seen = layers.lot / np.maximum(layers.seen, 1e-3)
    return np.where(known, seen, expected).astype(np.float32)


def _beyond(to_lot: Grid, to_other: Grid) -> Grid:
    """Return the probability that unseen ground is lot, by its distances to known lot and to other ground, metres."""
    return np.asarray(np.exp(-to_lot / _REACH_M) / (1 + (to_lot / to_other) ** _TURNED), dtype=np.float32)


def _distance(mask: Bools) -> Grid:
    """Return the distance of each cell to the nearest in the mask, cells."""
    if not mask.any():
        return np.full(mask.shape, _FAR_M, np.float32)
    return np.asarray(cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5), dtype=np.float32)


def _in_sight(field: InformationField, footprint: Footprint) -> Bools:
    """Return the ground that a picture from an allowed place can show, whatever its heading."""
    if not field.allowed.any():
        return np.zeros(field.allowed.shape, np.bool_)
    away = cv2.distanceTransform(1 - field.allowed, cv2.DIST_L2, 5)
    return np.asarray(away * field.window.cell_m <= min(footprint.width, footprint.depth) / 2)


def _open_ends(field: InformationField, share: Grid, worth: float) -> Grid:
    """Return the cells that nobody saw, along known lot for some metres: ``worth`` whole cells a stretch."""
    known_lot = ((field.lot > _IS_LOT) & (field.seen > _IS_SEEN)).astype(np.uint8)
    beside = cv2.dilate(known_lot, _NEIGHBOURS) > 0
    unseen = np.maximum(field.seen, field.well) <= _IS_SEEN  # ground that was looked at well may stay unclear for ever
    front = beside & unseen & (share > _LEAST_SHARE)
    _, labels = cv2.connectedComponents(front.astype(np.uint8), connectivity=8)
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    is_open = sizes * field.window.cell_m >= _OPEN_M
    each = np.where(is_open, worth / np.maximum(sizes, 1), 0.0)
    return np.asarray(each[labels], np.float32)


def _without_small(share: Grid, least: float) -> Grid:
    """Leave out patches of fewer than ``least`` whole cells."""
    _, labels = cv2.connectedComponents((share > _LEAST_SHARE).astype(np.uint8), connectivity=8)
    sums = np.bincount(labels.ravel(), weights=share.ravel())
    sums[0] = 0.0  # cells of no patch
    return np.where(sums[labels] >= least, share, 0).astype(np.float32)
