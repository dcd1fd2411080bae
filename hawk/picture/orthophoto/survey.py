"""A survey of an orthophoto: its stalls on Earth, the ground of its lots, and the ground that was seen."""

from __future__ import annotations

import uuid
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from hawk.exports.values import UNSEEN, ExportRecord, LatLon, Observation
from hawk.lots.registration.georeference import about
from hawk.lots.survey.landing import JOIN_M, LEAST_M2, OFF_M
from hawk.lots.survey.source import Limit, SourceKind
from hawk.lots.values import fitting_name
from hawk.model.lot_map import StallState
from hawk.model.plans import Outline
from hawk.picture.limits import UNSEEN_SHARE, source_of
from hawk.picture.nadir import program_name, states_of
from hawk.picture.orthophoto.grid import FloatArray, PixelGrid
from hawk.picture.orthophoto.mosaic import ground_of_box
from hawk.picture.orthophoto.outline import LotOutline
from hawk.picture.orthophoto.seams import Stalls, merged
from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.orthophoto.windows import AROUND_M, WindowStalls
from hawk.picture.values import COARSE_M, NO_STALLS, LeftOut, Mapped, PictureError, is_coarser

_DIGITS: Final = 8
"""Of degrees: a millimetre."""
_SAME_DIGITS: Final = 6
"""Of degrees, to which outlines are the same: a tenth of a metre, for formats that keep fewer digits."""
LARGEST_M: Final = 400.0
"""Side of the largest ground of which a picture is drawn."""


@dataclass(frozen=True, slots=True)
class _Plane:
    """Places of a picture in metres: (column, row) times the metres of a pixel in its middle."""

    grid: PixelGrid
    lots: NDArray[np.object_] | None = field(repr=False)
    """The lots that limit the work; None: all ground counts."""

    def has(self, places: FloatArray) -> NDArray[np.bool_]:
        """Return which places (N, 2) of (column, row) are on the lots."""
        if self.lots is None:
            return np.ones(len(places), np.bool_)
        inside = np.zeros(len(places), np.bool_)
        points = shapely.points(places * np.array(self.grid.metres))
        inside[shapely.STRtree(self.lots).query(points, predicate="intersects")[0]] = True
        return inside


def to_survey(
    source: Orthophoto,
    results: Sequence[WindowStalls],
    *,
    outline: LotOutline | None = None,
    model: str = "",
    left_out: Sequence[LeftOut] = (),
) -> Mapped:
    """Return the survey of a picture.

    Args:
        source: The picture.
        results: The findings of its windows, in any order.
        outline: The lots that limit it; stalls whose middle lies outside are not counted. None: all ground.
        model: SHA-256 of the network's file.
        left_out: Windows that could not be looked at.
    """
    plane = _Plane(source.grid, None if outline is None else outline.in_metres(source.grid))
    every = merged(results, source.grid.metres)
    is_in = plane.has(every.corners.mean(axis=1))
    suggested = every.suggested[plane.has(every.suggested.mean(axis=1))]
    stalls = Stalls(every.corners[is_in], every.taken[is_in], every.score[is_in], suggested)
    found = _found_lots(results, stalls, plane) if outline is None else _lots_in_picture(plane)
    box = _box_of(plane)
    origin = _origin(source.grid, box)
    lots = _on_earth(found, source.grid) if outline is None else outline.outline()
    seen_m2 = round(sum(_seen_m2(part, plane) for part in results), 1)
    pictures = source_of(SourceKind.ORTHOPHOTO, source.path.name, tuple(_limits(plane, seen_m2, len(left_out))))
    survey = _survey(source, _place_name(source, outline), origin, lots, _exported(stalls, source, origin), model)
    ground = ground_of_box(source, box, origin, LARGEST_M)
    return Mapped(
        replace(survey, pictures=pictures),
        ground,
        seen_m2,
        source.crs,
        tuple(left_out),
        (*source.notes, *_notes(stalls, len(every) - len(stalls), has_picture=ground is not None)),
        tuple(stalls.score.tolist()),
    )


def check_ground(mapped: Mapped, source: Orthophoto, *, has_lots: bool) -> None:
    """Refuse a survey that saw no ground though every window was looked at. Raises PictureError."""
    if mapped.area_m2 or mapped.left_out:
        return
    words = "where the outlines lie: see that they are of this place" if has_lots else "it is black, white or empty"
    raise PictureError(f"{source.path.name}: shows no ground: {words}, or export the picture again")


def _limits(plane: _Plane, seen_m2: float, left_out: int) -> Iterator[Limit]:
    """Yield what limits a survey. ``seen_m2``: ground of the lots that was seen; ``left_out``: number of windows."""
    if is_coarser(max(plane.grid.metres), COARSE_M):
        yield Limit.COARSE
    lots_m2 = 0.0 if plane.lots is None else float(shapely.union_all(plane.lots).area)
    if left_out or seen_m2 < (1 - UNSEEN_SHARE) * lots_m2:
        yield Limit.PARTLY


def _notes(stalls: Stalls, outside: int, *, has_picture: bool) -> Iterator[str]:
    if not has_picture:
        yield f"No picture of it is drawn (lot.png): that is done of ground up to {LARGEST_M:.0f} m a side."
    if outside:
        yield f"{outside} stalls whose middle lies outside the outlines are not counted."
    if len(stalls.suggested):
        yield f"Cars stand where no stall is marked: {len(stalls.suggested)} places are not counted."


def _place_name(source: Orthophoto, outline: LotOutline | None) -> str:
    """Return what names the ground of a survey: the picture, with the lots that limit it: a city has many."""
    place = source.path.resolve().as_uri()
    if outline is None:
        return place
    rounded = (shapely.transform(lot, lambda at: np.round(at, _SAME_DIGITS)) for lot in outline.lots)
    lots = sorted(shapely.to_wkt(shapely.normalize(lot), rounding_precision=_SAME_DIGITS) for lot in rounded)
    return " ".join([place, *lots])


def _survey(
    source: Orthophoto, place: str, origin: LatLon, outline: Outline, stalls: tuple[Observation, ...], model: str
) -> ExportRecord:
    """Return what files have. ``place``: text by which the lot has its id: a picture may show many."""
    program = program_name(model)
    return ExportRecord(
        lot=_title(source.path),
        lot_id=str(uuid.uuid5(uuid.NAMESPACE_URL, place)) if stalls else "",
        survey=str(uuid.uuid5(uuid.NAMESPACE_URL, f"{place} {source.identity} {program}")),
        began=source.taken.value,
        ended=source.taken.value,
        time_is_sure=source.taken.is_sure,
        layout=None,
        software=f"hawk-drone {program}",
        is_simulated=False,
        accuracy=None,
        is_pinned=False,
        origin=origin,
        outline=outline,
        stalls=stalls,
        doubt="" if stalls else NO_STALLS,
    )


def _title(path: Path) -> str:
    return fitting_name(path.stem) or "orthophoto"


def _exported(stalls: Stalls, source: Orthophoto, origin: LatLon) -> tuple[Observation, ...]:
    if not len(stalls):
        return ()
    degrees = np.round(source.grid.on_earth(stalls.corners.reshape(-1, 2)), _DIGITS)
    metres = about(origin, degrees)[:, :2].reshape(-1, 4, 2)
    across, along = metres[:, 1] - metres[:, 0], metres[:, 2] - metres[:, 1]
    turn = np.degrees(np.arctan2(along[:, 1], along[:, 0])) % 180
    corners = degrees.reshape(-1, 4, 2)
    middles = np.round(corners.mean(axis=1), _DIGITS)
    states = states_of(stalls.taken)
    return tuple(
        Observation(
            id=str(k + 1),
            label="",
            kind="",
            state=UNSEEN if states[k] is StallState.UNKNOWN else str(states[k]),
            taken=round(float(stalls.taken[k]), 3),
            looked=source.taken.value,
            seen=1,
            place=_place(middles[k]),
            corners=tuple(_place(corner) for corner in corners[k]),
            width=round(float(np.hypot(*across[k])), 2),
            length=round(float(np.hypot(*along[k])), 2),
            direction=round(float(turn[k]), 1) % 180,
            is_confirmed=False,
        )
        for k in range(len(stalls))
    )


def _place(values: FloatArray) -> LatLon:
    return float(values[0]), float(values[1])


def _origin(grid: PixelGrid, box: tuple[float, float, float, float]) -> LatLon:
    """Return the middle of a part of the picture, given in metres, on Earth."""
    left, top, right, bottom = box
    middle = np.array([((left + right) / 2, (top + bottom) / 2)]) / np.array(grid.metres)
    return _place(np.round(grid.on_earth(middle)[0], _DIGITS))


def _box_of(plane: _Plane) -> tuple[float, float, float, float]:
    """Return left, top, right and bottom of the ground that counts, metres."""
    whole = np.array([0.0, 0.0, plane.grid.columns, plane.grid.rows]) * np.tile(plane.grid.metres, 2)
    if plane.lots is not None and len(plane.lots):
        bounds = shapely.total_bounds(plane.lots) + np.array([-1, -1, 1, 1]) * AROUND_M
        whole = np.concatenate([np.maximum(whole[:2], bounds[:2]), np.minimum(whole[2:], bounds[2:])])
    left, top, right, bottom = (float(value) for value in whole)
    return left, top, max(right, left), max(bottom, top)


def _lots_in_picture(plane: _Plane) -> list[Polygon]:
    return [] if plane.lots is None else list(plane.lots)


def _cell_m(part: WindowStalls, grid: PixelGrid) -> tuple[FloatArray, FloatArray]:
    """Return the upper left corner of a window's core, and the sides of its cells, metres."""
    core = np.array(part.window.core, np.float64) * np.tile(grid.metres, 2)
    return core[:2], (core[2:] - core[:2]) / np.array(part.seen.shape[::-1])


def _seen_m2(part: WindowStalls, plane: _Plane) -> float:
    """Return the ground of a window's core that was seen, on the lots, square metres."""
    corner, side = _cell_m(part, plane.grid)
    if plane.lots is None:
        return float(part.seen.sum() * side.prod())
    core = shapely.box(*corner, *(corner + side * np.array(part.seen.shape[::-1])))
    near = plane.lots[shapely.STRtree(plane.lots).query(core, predicate="intersects")]
    ground = shapely.union_all(near).intersection(core)
    shapely.prepare(ground)
    unseen = corner + (np.argwhere(~part.seen)[:, ::-1] + 0.5) * side
    return float(ground.area - shapely.contains_xy(ground, *unseen.T).sum() * side.prod())


def _found_lots(results: Sequence[WindowStalls], stalls: Stalls, plane: _Plane) -> list[Polygon]:
    """Return the ground of the lots that was found, metres: outer rings, islands and drives closed."""
    metres = np.array(plane.grid.metres)
    pieces = [Polygon(corners * metres) for corners in stalls.corners]
    for part in sorted(results, key=lambda each: each.window.core[1::-1]):
        corner, side = _cell_m(part, plane.grid)
        rings, _ = cv2.findContours(part.lot.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
        # a contour runs through the middles of its outermost cells
        pieces += [
            Polygon(corner + (ring.reshape(-1, 2) + 0.5) * side).buffer(float(side.max()) / 2, join_style="mitre")
            for ring in rings
            if len(ring) > 2
        ]
    ground = shapely.union_all(pieces).buffer(JOIN_M / 2).buffer(-JOIN_M / 2).simplify(OFF_M)
    parts = [part for part in shapely.get_parts([ground]) if isinstance(part, Polygon) and part.area >= LEAST_M2]
    return [Polygon(part.exterior) for part in parts]


def _on_earth(lots: Sequence[Polygon], grid: PixelGrid) -> Outline:
    rings = []
    for lot in lots:
        ring = np.round(grid.on_earth(np.array(lot.exterior.coords[:-1]) / np.array(grid.metres)), _DIGITS)
        rings.append(tuple(_place(corner) for corner in ring))
    return Outline(tuple(rings))
