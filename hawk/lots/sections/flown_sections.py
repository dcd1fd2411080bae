"""Sections of the lot that is flown over, with the vehicles that the map of the flight has so far.

The count is that of the survey once it is stored (`hawk.lots.survey.section_looks`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, replace
from typing import Final

import numpy as np
import shapely
from sqlalchemy import Connection

from hawk.lots.plan.queries import all_stalls, sections_of
from hawk.lots.plan.values import Floats, LayoutSection, LayoutStall
from hawk.lots.registration.frames import Move, frame_of
from hawk.lots.registration.georeference import ground_about
from hawk.lots.registration.survey_place import datum_of
from hawk.lots.survey.landing import seen_ground
from hawk.lots.survey.section_counts import SeenGround, Source, count_of
from hawk.lots.survey.section_looks import moved_shapes
from hawk.model.known_lot import FlownCount, FlownSection
from hawk.model.lot_map import TILE_M, OccupancyMap, Stall, StallState, TileKey
from hawk.model.poses import GlobalPose
from hawk.model.vehicles import MapVehicle
from hawk.results.survey_map import SurveyMap

_LEAST_KNOWN: Final = 2
"""Stalls of the plan on the map from which the place of a lot with stalls is known: two fix its turn."""


def flown_sections(
    connection: Connection, lot: str, datum: tuple[float, float], current: OccupancyMap
) -> tuple[FlownSection, ...]:
    """Return the sections of a lot's plan on the map about a datum (latitude, longitude), by their names.

    None is returned of a lot with stalls whose place on the map is not known yet. Takes tens of milliseconds.
    """
    sections = [each for each in sections_of(connection, lot) if _is_area(each)]
    if not sections:
        return ()
    move = _move(frame_of(datum_of(connection, lot), datum), all_stalls(connection, lot), current)
    if move is None:
        return ()
    rings = [move.back(np.array(each.outline, np.float64)) for each in sections]
    seen = _seen(datum, move, _about(current, rings))
    return tuple(_flown(each, ring, seen) for each, ring in zip(sections, rings, strict=True))


def _is_area(section: LayoutSection) -> bool:
    return len(section.outline) > 0 and shapely.Polygon(section.outline).is_valid


def _move(by_receiver: Move, plan: Sequence[LayoutStall], current: OccupancyMap) -> Move | None:
    """Return the move that brings the map onto the lot's frame."""
    if not plan:
        return by_receiver
    there = {stall.id: (stall.north, stall.east) for stall in plan}
    known = [stall for stall in current.stalls.values() if stall.known in there]
    if len(known) < _LEAST_KNOWN:
        return None
    return Move.nearest(_places(known), np.array([there[stall.known] for stall in known], np.float64))


def _places(stalls: Iterable[Stall]) -> Floats:
    return np.array([(stall.north, stall.east) for stall in stalls], np.float64)


def _about(current: OccupancyMap, rings: Iterable[Floats]) -> OccupancyMap:
    """Return the map without the tiles that are not at one of the rings: no other ground is looked at."""
    near = {key for ring in rings for key in _tiles(ring)}
    return replace(current, tiles={key: tile for key, tile in current.tiles.items() if key in near}, mosaic={})


def _tiles(ring: Floats) -> Iterator[TileKey]:
    """Return the tiles about a ring, with those beside them: ground that begins there is seen as a whole."""
    (south, west), (north, east) = ring.min(axis=0).tolist(), ring.max(axis=0).tolist()
    for row in range(math.floor(-north / TILE_M) - 1, math.floor(-south / TILE_M) + 2):
        for column in range(math.floor(west / TILE_M) - 1, math.floor(east / TILE_M) + 2):
            yield row, column


def _seen(datum: tuple[float, float], move: Move, current: OccupancyMap) -> SeenGround:
    """Return what the flight saw so far, in the lot's frame."""
    stalls = [stall for stall in current.stalls.values() if stall.seen]
    taken = [stall for stall in stalls if stall.state is StallState.TAKEN]
    unknown = [stall for stall in stalls if stall.state is StallState.UNKNOWN]
    found: Sequence[Stall | MapVehicle] = taken if current.vehicles is None else [*current.vehicles.values()]
    source: Source = "stalls" if current.vehicles is None else "vehicles"
    survey = SurveyMap.of(GlobalPose(*datum, 0.0), current)
    return SeenGround(
        source,
        _shapes(found, move),
        np.array([each.taken if isinstance(each, Stall) else each.probability for each in found], np.float64),
        np.array([each.last_seen for each in found], np.float64),
        _shapes(unknown, move),
        move.ground(ground_about(datum, seen_ground(survey))),
    )


def _shapes(found: Sequence[Stall | MapVehicle], move: Move) -> Floats:
    shapes = [(each.north, each.east, each.angle, each.width, each.length) for each in found]
    return moved_shapes(np.array(shapes, np.float64).reshape(-1, 5), move)


def _flown(section: LayoutSection, ring: Floats, seen: SeenGround) -> FlownSection:
    sight = seen.sight_of(section)
    count = None
    if sight is not None:
        shares = round(sight.seen_share, 4), round(sight.hidden_share, 4)
        count = FlownCount(**asdict(count_of(section, sight)), seen_share=shares[0], hidden_share=shares[1])
    outline = tuple((north, east) for north, east in np.round(ring, 2).tolist())
    return FlownSection(section.id, section.name, outline, section.capacity, count)
