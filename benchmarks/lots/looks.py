"""Surveys of a world with the errors of a receiver and a compass: from one picture of it, or flown.

One picture shows the whole lot from high up, as a perfect flight would see it; the errors shift and turn it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from benchmarks.chain_flight.measure import ORIGIN
from benchmarks.frames import camera_model
from benchmarks.lots.visits import APART_M, Visit
from benchmarks.perception.eyes import boxes_of_maps
from benchmarks.world_lots import north_east
from hawk.algo.rows.fit import Rectangles
from hawk.algo.vision import decode
from hawk.algo.vision.detection import FloatArray
from hawk.algo.vision.network import StallNetwork
from hawk.lots.registration.frames import Move
from hawk.lots.values import Detection, FinishedSurvey
from hawk.model.lot_map import StallState
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from hawk.picture.orthophoto.tile_detector import GROUND_M
from hawk.results.survey_map import to_global
from hawk.worlds.camera import WorldCamera
from hawk.worlds.world import World

HEIGHT_M: Final = 250.0
"""From there trees and cars lean little."""
LEAST_SCORE: Final = 0.5
SAME_M: Final = 1.2
"""A found stall farther from a true one, after the receiver's and the compass's error, is not that one."""
GNSS_M: Final = 0.5
_DURATION_S: Final = 600.0
_AROUND_M: Final = 4.0


@dataclass(frozen=True, slots=True)
class Look:
    """A survey with the truth, by the ids of its stalls.

    ``true`` is the id of the true stall that each is; ``at`` where each lies among the true ones, metres (north, east).
    """

    survey: FinishedSurvey = field(repr=False)
    true: dict[int, int] = field(repr=False)
    at: dict[int, tuple[float, float]] = field(default_factory=dict, repr=False)


def datum_of(world: World, visit: Visit) -> GlobalPose:
    """Return the origin of the map as the receiver gives it: the drone's start, off by the bias."""
    x, y = world.start()
    aside = APART_M if visit.is_next_door else 0.0
    ((latitude, longitude),) = to_global(ORIGIN, np.array([[visit.bias[0] - y, x + aside + visit.bias[1]]])).tolist()
    return GlobalPose(latitude, longitude, 0.0)


class StillEye:
    """Surveys worlds by one picture each."""

    def __init__(self, network: StallNetwork) -> None:
        self._network = network

    def look(self, world: World, visit: Visit) -> Look:
        """Return the survey."""
        size = world.size_m
        maps = self._network.run(_picture(world))
        found, score = boxes_of_maps(maps)
        taken = decode.occupancy(maps, _in_cells(found))
        seen_to = size[0] * visit.part
        kept = (score >= LEAST_SCORE) & (found.centres[:, 0] < seen_to)
        found, score, taken = found[kept], score[kept], taken[kept]
        places, angle = on_map(world, found)
        datum, move = datum_of(world, visit), _turned_about_middle(world, visit.compass)
        ended = visit.at.timestamp()
        stalls = tuple(
            Detection(
                id=k, north=n, east=e, angle=a, width=w, length=le, taken_probability=t,
                state=StallState.TAKEN if t >= 0.5 else StallState.FREE, score=s, picture_count=1, looked_at=ended,
            )
            for k, (n, e, a, w, le, t, s) in enumerate(
                np.column_stack([
                    move.of(places), (angle + visit.compass) % np.pi, found.width, found.length, taken, score,
                ]).tolist(), 1,
            )
        )  # fmt: skip
        ground = shapely.box(0, 0, seen_to, size[1])
        lots = shapely.union_all([shapely.Polygon(lot).buffer(0) for lot in world.lots])
        if lots.is_empty and len(found):  # labels without outlines: the ground of what was found
            lots = shapely.MultiPoint(found.centres).convex_hull.buffer(_AROUND_M)
        survey = FinishedSurvey(
            name=f"{visit.number:06d}-still", datum=datum, began=ended - _DURATION_S, ended=ended, time_is_sure=True,
            outline=_outline(world, lots.intersection(ground), datum, move), stalls=stalls, program="benchmark",
            seen_ground=_outline(world, ground, datum, move),
        )  # fmt: skip
        return looked(survey, world, places)


def on_map(world: World, found: Rectangles) -> tuple[FloatArray, FloatArray]:
    """Return places (N, 2) about the drone's start, metres (north, east), and directions (N,)."""
    return north_east(found.centres, world.start()), (np.pi / 2 + found.angle) % np.pi


def looked(survey: FinishedSurvey, world: World, places: FloatArray) -> Look:
    """Return a survey with the truth; ``places`` (N, 2) of its stalls are without the compass's error."""
    ids = [stall.id for stall in survey.stalls]
    true = _true_places(world)
    moved = (places + _shift(true, places)).tolist() if len(places) and len(true) else []
    at = {k: (north, east) for k, (north, east) in zip(ids, moved, strict=False)}
    return Look(survey, true_ids(world, places, ids), at)


def true_ids(world: World, places: FloatArray, ids: list[int]) -> dict[int, int]:
    """Return the true stall that each place (N, 2) is; none is two. A small shift of all is taken out first."""
    true = _true_places(world)
    if not len(places) or not len(true):
        return {}
    shift = _shift(true, places)
    away, nearest = cKDTree(true).query(places + shift)
    found: dict[int, int] = {}
    for k in np.argsort(away).tolist():
        stall = world.stalls[int(nearest[k])].id
        if away[k] < SAME_M and stall not in found.values():
            found[ids[k]] = stall
    return found


def _shift(true: FloatArray, places: FloatArray) -> FloatArray:
    shift = np.zeros(2)
    for _ in range(6):
        away, nearest = cKDTree(true).query(places + shift)
        near = away < SAME_M
        if not near.any():
            break
        shift = shift + np.median(true[nearest[near]] - places[near] - shift, axis=0)
    return shift


def _true_places(world: World) -> FloatArray:
    centres = np.array([stall.corners.mean(axis=0) for stall in world.stalls]).reshape(-1, 2)
    return north_east(centres, world.start())


def _turned_about_middle(world: World, turn: float) -> Move:
    """Return the turn of a picture by a compass's error: about the place below the camera, the middle of the world."""
    middle = north_east(np.array([world.size_m]) / 2, world.start())
    ((north, east),) = (middle - Move(turn=turn).of(middle)).tolist()
    return Move(north, east, turn)


def _picture(world: World) -> NDArray[np.uint8]:
    width, height = (round(side / GROUND_M) for side in world.size_m)
    model = camera_model(width, height, HEIGHT_M / GROUND_M)
    middle = world.size_m[0] / 2, world.size_m[1] / 2
    return WorldCamera(world, model).render(*middle, HEIGHT_M, 0.0, 0.0, 0.0, rng=np.random.default_rng(0))


def _in_cells(found: Rectangles) -> decode.Stalls:
    cell = 2 * GROUND_M
    column, row = ((found.centres - GROUND_M / 2) / cell).T
    return decode.Stalls(column, row, found.angle, found.width / cell, found.length / cell, np.ones(len(found)))


def _outline(world: World, ground: shapely.Geometry, datum: GlobalPose, move: Move) -> Outline:
    rings = []
    for part in shapely.get_parts(ground):
        if isinstance(part, shapely.Polygon) and not part.is_empty:
            places = move.of(north_east(np.array(part.exterior.coords[:-1]), world.start()))
            rings.append(tuple((float(a), float(b)) for a, b in to_global(datum, places)))
    return Outline(tuple(rings))
