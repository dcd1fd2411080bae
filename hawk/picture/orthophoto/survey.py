"""A survey of an orthophoto: its stalls on Earth, the ground of its lots, and the ground that was seen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from hawk.algo.mapper.vehicles import SHOWN
from hawk.algo.vision.network import VEHICLE_KINDS
from hawk.exports.values import UNSEEN, LatLon, Observation
from hawk.formats.remote_raster import RemoteRaster
from hawk.lots.registration.georeference import LEAST_PIECE_M2, about
from hawk.lots.survey.landing import JOIN_M, OFF_M, LandingFacts
from hawk.lots.survey.source import Limit, SourceKind
from hawk.model.lot_map import OccupancyMap, Stall, StallState
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from hawk.model.vehicles import MapVehicle
from hawk.picture.limits import UNSEEN_SHARE
from hawk.picture.orthophoto.grid import FloatArray, PixelGrid
from hawk.picture.orthophoto.mosaic import ground_of_box, tiles_of
from hawk.picture.orthophoto.obstacles import standing_on
from hawk.picture.orthophoto.outline import LotOutline
from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.orthophoto.tile_detector import Mask, TileVehicles, program_name, states_of
from hawk.picture.orthophoto.tile_merger import Stalls, merge_tiles
from hawk.picture.orthophoto.windows import AROUND_M, WindowStalls
from hawk.picture.values import (
    COARSE_M,
    LeftOut,
    PictureError,
    PictureSurvey,
    Provenance,
    export_survey,
    id_of,
    is_coarser,
)

_DIGITS: Final = 8
"""Of degrees: a millimetre."""
_SAME_DIGITS: Final = 6
"""Of degrees, to which outlines are the same: a tenth of a metre, for formats that keep fewer digits."""
LARGEST_M: Final = 400.0
"""Side of the largest ground of which a picture is drawn."""


@dataclass(frozen=True, slots=True)
class PictureFrame:
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


@dataclass(frozen=True, slots=True)
class Findings:
    """Findings of a picture's windows, merged: ``stalls`` of all of it. ``left_out``: windows without a result.

    ``model``: SHA-256 of the network's file.
    """

    source: Orthophoto
    results: Sequence[WindowStalls] = field(repr=False)
    stalls: Stalls = field(repr=False)
    provenance: Provenance
    model: str = ""
    left_out: tuple[LeftOut, ...] = ()

    @classmethod
    def of(
        cls,
        source: Orthophoto,
        results: Sequence[WindowStalls],
        *,
        provenance: Provenance | None = None,
        model: str = "",
        left_out: Sequence[LeftOut] = (),
    ) -> Findings:
        """Merge the findings of windows, in any order. ``provenance``: None: that of the picture's file."""
        named = provenance or Provenance(source.path.name, SourceKind.ORTHOPHOTO)
        return cls(source, results, merge_tiles(results, source.grid.metres), named, model, tuple(left_out))

    def chosen(self, stalls: Mask, suggested: Mask, vehicles: Mask) -> Stalls:
        """Return the stalls, suggestions and vehicles of three masks."""
        every = self.stalls
        return Stalls(
            every.corners[stalls],
            every.taken[stalls],
            every.score[stalls],
            every.suggested[suggested],
            None if every.vehicles is None else every.vehicles.chosen(vehicles),
        )

    def counted_on(self, plane: PictureFrame) -> Stalls:
        """Return those whose middle is on the lots of a plane."""
        every = self.stalls
        stalls, suggested, vehicles = (
            plane.has(corners.mean(axis=1)) for corners in (every.corners, every.suggested, every.vehicle_corners)
        )
        return self.chosen(stalls, suggested, vehicles)


def without_obstacles(findings: Findings, outline: LotOutline | None) -> tuple[Findings, tuple[str, ...]]:
    """Return findings without those on the roads and buildings of a file of outlines, with a note on each cause."""
    if outline is None:
        return findings, ()
    grid, notes = findings.source.grid, []
    lots = PictureFrame(grid, outline.in_metres(grid))
    for cause, grounds in outline.obstacles.in_metres(grid).items():
        every = findings.stalls
        stalls, suggested, vehicles = (
            standing_on(quads, grid.metres, grounds)
            for quads in (every.corners, every.suggested, every.vehicle_corners)
        )
        counts = [
            int((gone & lots.has(quads.mean(axis=1))).sum())
            for gone, quads in ((stalls, every.corners), (vehicles, every.vehicle_corners))
        ]
        findings = replace(findings, stalls=findings.chosen(~stalls, ~suggested, ~vehicles))
        if any(counts):
            notes.append(f"On {cause}, {counts[0]} stalls and {counts[1]} vehicles of the lots are not counted.")
    return findings, tuple(notes)


def to_survey(findings: Findings, outline: LotOutline | None = None) -> PictureSurvey:
    """Return the survey of a picture.

    Args:
        findings: Those of its windows.
        outline: The lots that limit it; stalls whose middle lies outside are not counted. None: all ground.
    """
    plane = PictureFrame(findings.source.grid, None if outline is None else outline.in_metres(findings.source.grid))
    stalls = findings.counted_on(plane)
    outside = len(findings.stalls) - len(stalls)
    largest = LARGEST_M
    if outline is not None and len(outline.lots) == 1 and outline.lots[0].facts.is_named:
        title = findings.provenance.title or outline.lots[0].facts.name
        findings = replace(findings, provenance=replace(findings.provenance, title=title))
    elif outline is not None and len(outline.lots) > 1:
        largest = 0.0  # each lot has a picture of its own
    mapped = survey_of(findings, plane, stalls, outline, largest)
    of_stalls = _notes(stalls, outside, has_picture=mapped.ground is not None or not largest)
    of_outline = () if outline is None else outline.notes
    return replace(mapped, notes=(*mapped.notes, *of_outline, *of_stalls))


def survey_of(
    findings: Findings, plane: PictureFrame, stalls: Stalls, outline: LotOutline | None, largest: float = LARGEST_M
) -> PictureSurvey:
    """Return the survey of a part of a picture.

    Args:
        findings: Those of the picture, with the windows near that part.
        plane: The picture with the lots of that part.
        stalls: Those that count there.
        outline: The same lots on Earth; None: all ground.
        largest: Side of the largest ground of which a picture is drawn, metres.
    """
    source, results, provenance = findings.source, findings.results, findings.provenance
    found = _found_lots(results, stalls, plane) if outline is None else []
    box = _box_of(plane)
    origin = _origin(source.grid, box)
    ground = ground_of_box(source, box, origin, largest)
    seen_m2 = round(sum(seen_of(part, plane) for part in results), 1)
    limits = tuple(_limits(plane, seen_m2, len(findings.left_out)))
    place, program = _place_name(source, outline), program_name(findings.model)
    ids = id_of(place), id_of(f"{place} {source.identity} {program}")
    lots = _on_earth(found, source.grid) if outline is None else outline.outline()
    on_earth = _on_earth_of(stalls.corners, source.grid, origin)
    tiles, mosaic = ({}, {}) if ground is None else tiles_of(ground, lots, origin)
    vehicles = None if stalls.vehicles is None else _vehicles_on_map(stalls.vehicles, source.grid, origin)
    current = OccupancyMap(tiles, mosaic, _on_map(stalls, on_earth), version=1, map_id=ids[1], vehicles=vehicles)
    landed = replace(_landed(source, provenance, origin, current, program), pictures=provenance.source(limits))
    capacity = outline.lots[0].facts.capacity if outline is not None and len(outline.lots) == 1 else None
    landed = replace(landed, outline=lots if lots.polygons else None, capacity=capacity)
    exported = export_survey(landed, ids, lots, _exported(stalls, on_earth, landed.utc))
    return PictureSurvey(exported, landed, ground, seen_m2, source.crs, findings.left_out, source.notes)


def _landed(
    source: Orthophoto, provenance: Provenance, origin: LatLon, current: OccupancyMap, program: str
) -> LandingFacts:
    """Return a survey as one after a landing."""
    ended, is_sure = provenance.moment(source.taken.value)
    return LandingFacts(
        name=f"orthophoto {current.map_id}",
        datum=GlobalPose(*origin, 0.0),
        current=current,
        outline=None,
        seconds=0.0,
        utc=ended,
        time_is_sure=is_sure or (provenance.ended is None and source.taken.is_sure),
        program=program,
        title=provenance.lot,
    )


def check_ground(mapped: PictureSurvey, source: Orthophoto, *, has_lots: bool) -> None:
    """Refuse a survey that saw no ground though every window was looked at. Raises PictureError."""
    if mapped.area_m2 or mapped.left_out:
        return
    words = "where the outlines lie: see that they are of this place" if has_lots else "it is black, white or private"
    raise PictureError(f"{source.path.name}: shows no ground: {words}, or export the picture again")


def _limits(plane: PictureFrame, seen_m2: float, left_out: int) -> Iterator[Limit]:
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
    place = str(source.path) if isinstance(source.path, RemoteRaster) else source.path.resolve().as_uri()
    if outline is None:
        return place
    rounded = (shapely.transform(lot, lambda at: np.round(at, _SAME_DIGITS)) for lot in outline.shapes)
    lots = sorted(shapely.to_wkt(shapely.normalize(lot), rounding_precision=_SAME_DIGITS) for lot in rounded)
    return " ".join([place, *lots])


@dataclass(frozen=True, slots=True)
class _OnEarth:
    """Stalls or vehicles (N,) on Earth: ``corners`` (N, 4, 2) and ``middle`` (N, 2), degrees; ``metres`` (N, 2) north
    and east of the origin; ``width``, ``length`` (N,), metres; ``angle`` (N,) of the long side, radians clockwise from
    north.
    """

    corners: FloatArray
    middle: FloatArray
    metres: FloatArray
    width: FloatArray
    length: FloatArray
    angle: FloatArray


def _on_earth_of(quads: FloatArray, grid: PixelGrid, origin: LatLon) -> _OnEarth:
    """``quads`` (N, 4, 2), (column, row)."""
    degrees = np.round(grid.on_earth(quads.reshape(-1, 2)), _DIGITS) if len(quads) else np.zeros((0, 2))
    corners, metres = degrees.reshape(-1, 4, 2), about(origin, degrees)[:, :2].reshape(-1, 4, 2)
    across, along = metres[:, 1] - metres[:, 0], metres[:, 2] - metres[:, 1]
    return _OnEarth(
        corners=corners,
        middle=np.round(corners.mean(axis=1), _DIGITS),
        metres=metres.mean(axis=1),
        width=np.hypot(*across.T),
        length=np.hypot(*along.T),
        angle=np.arctan2(along[:, 1], along[:, 0]) % np.pi % np.pi,  # -0.0 is 0, not pi
    )


def _exported(stalls: Stalls, on_earth: _OnEarth, looked_at: float) -> tuple[Observation, ...]:
    states = states_of(stalls.taken)
    turn = np.degrees(on_earth.angle)
    return tuple(
        Observation(
            id=str(k + 1),
            label="",
            kind="",
            state=UNSEEN if states[k] is StallState.UNKNOWN else str(states[k]),
            taken_probability=round(float(stalls.taken[k]), 3),
            looked_at=looked_at,
            picture_count=1,
            place=_place(on_earth.middle[k]),
            corners=tuple(_place(corner) for corner in on_earth.corners[k]),
            width=round(float(on_earth.width[k]), 2),
            length=round(float(on_earth.length[k]), 2),
            direction=round(float(turn[k]), 1) % 180,
            is_confirmed=False,
            score=float(stalls.score[k]),
        )
        for k in range(len(stalls))
    )


def _on_map(stalls: Stalls, on_earth: _OnEarth) -> dict[int, Stall]:
    """Return the stalls in the map frame about the survey's origin."""
    states = states_of(stalls.taken)
    table = np.column_stack(
        [on_earth.metres, on_earth.angle, on_earth.width, on_earth.length, stalls.taken, stalls.score]
    )
    return {
        number: Stall(number, north, east, angle, width, length, taken, state, score, seen=1, last_seen=0.0, version=1)
        for number, (state, (north, east, angle, width, length, taken, score)) in enumerate(
            zip(states, table.tolist(), strict=True), 1
        )
    }


def _vehicles_on_map(vehicles: TileVehicles, grid: PixelGrid, origin: LatLon) -> dict[int, MapVehicle]:
    """Return the vehicles that are sure enough, in the map frame about the survey's origin."""
    shown = vehicles.chosen(vehicles.probability >= SHOWN)
    on_earth = _on_earth_of(shown.corners, grid, origin)
    table = np.column_stack([on_earth.metres, on_earth.angle, on_earth.width, on_earth.length, shown.probability])
    return {
        number: MapVehicle(number, VEHICLE_KINDS[kind], north, east, angle, width, length, said, 1, 0.0, 0.0, 1)
        for number, (kind, (north, east, angle, width, length, said)) in enumerate(
            zip(shown.kind.tolist(), table.tolist(), strict=True), 1
        )
    }


def _place(values: FloatArray) -> LatLon:
    return float(values[0]), float(values[1])


def _origin(grid: PixelGrid, box: tuple[float, float, float, float]) -> LatLon:
    """Return the middle of a part of the picture, given in metres, on Earth."""
    left, top, right, bottom = box
    middle = np.array([((left + right) / 2, (top + bottom) / 2)]) / np.array(grid.metres)
    return _place(np.round(grid.on_earth(middle)[0], _DIGITS))


def _box_of(plane: PictureFrame) -> tuple[float, float, float, float]:
    """Return left, top, right and bottom of the ground that counts, metres."""
    whole = np.array([0.0, 0.0, plane.grid.columns, plane.grid.rows]) * np.tile(plane.grid.metres, 2)
    if plane.lots is not None and len(plane.lots):
        bounds = shapely.total_bounds(plane.lots) + np.array([-1, -1, 1, 1]) * AROUND_M
        whole = np.concatenate([np.maximum(whole[:2], bounds[:2]), np.minimum(whole[2:], bounds[2:])])
    left, top, right, bottom = (float(value) for value in whole)
    return left, top, max(right, left), max(bottom, top)


def _cell_m(part: WindowStalls, grid: PixelGrid) -> tuple[FloatArray, FloatArray]:
    """Return the upper left corner of a window's core, and the sides of its cells, metres."""
    core = np.array(part.window.core, np.float64) * np.tile(grid.metres, 2)
    return core[:2], (core[2:] - core[:2]) / np.array(part.seen.shape[::-1])


def seen_of(part: WindowStalls, plane: PictureFrame) -> float:
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


def _found_lots(results: Sequence[WindowStalls], stalls: Stalls, plane: PictureFrame) -> list[Polygon]:
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
    parts = [part for part in shapely.get_parts([ground]) if isinstance(part, Polygon) and part.area >= LEAST_PIECE_M2]
    return [Polygon(part.exterior) for part in parts]


def _on_earth(lots: Sequence[Polygon], grid: PixelGrid) -> Outline:
    rings = []
    for lot in lots:
        ring = np.round(grid.on_earth(np.array(lot.exterior.coords[:-1]) / np.array(grid.metres)), _DIGITS)
        rings.append(tuple(_place(corner) for corner in ring))
    return Outline(tuple(rings))
