"""Flights over a lot whose plan is known: its true stalls, all confirmed, shifted and turned."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from typing import Final

import numpy as np
import shapely

from benchmarks.chain_flight.flight import Flown
from benchmarks.chain_flight.measure import Given, Result
from benchmarks.figures import Figure, Limit
from benchmarks.perception.stall_rows import Boxes
from hawk.algo.vision import quads
from hawk.model.known_lot import KnownLot, KnownStall
from hawk.model.lot_map import Stall, StallState
from hawk.survey.accuracy import NEAR_M, FloatArray
from hawk.worlds.world import World

SHIFT_M: Final = 1.5
TURN: Final = math.radians(1.0)
ABOUT_M: Final = 5.0
"""The plan knows the ground about its stalls: labels of places lack whole rows."""


def plan_of(world: World) -> KnownLot:
    """Return the world's stalls on the map's frame, as a receiver and a compass that err place them; the same each time
    by the world's name.
    """
    places, boxes = _true_places(world)
    rng = np.random.default_rng(zlib.crc32(world.name.encode()))
    turn, shift = TURN * float(rng.choice([-1, 1])), rng.uniform(-SHIFT_M, SHIFT_M, 2)
    cosine, sine = math.cos(turn), math.sin(turn)
    rotation = np.array([[cosine, -sine], [sine, cosine]])
    angle = np.arctan2(boxes.along[:, 0], -boxes.along[:, 1]) + turn
    values = np.column_stack([places @ rotation.T + shift, angle % np.pi, boxes.width, boxes.length])
    stalls = tuple(
        KnownStall(str(k), n, e, a, w, le, is_confirmed=True) for k, (n, e, a, w, le) in enumerate(values.tolist())
    )
    ground = shapely.union_all(shapely.polygons(quads.corners(*values.T))).buffer(ABOUT_M).simplify(0.5)
    pieces = [(part.exterior, *part.interiors) for part in shapely.get_parts(ground)]
    return KnownLot(world.name, stalls, tuple(tuple(tuple(ring.coords[:-1]) for ring in piece) for piece in pieces))


def given(world: World, flown: Flown) -> Given:
    """Compare what came onto the map with the truth."""
    places, _ = _true_places(world)
    stalls = flown.output.occupancy_map.stalls.values()
    known = {int(stall.known): stall for stall in stalls if stall.known and stall.seen}
    states = {k: world.stalls[k].state for k in known if world.stalls[k].state in ("free", "taken")}
    beside = [stall for stall in stalls if not stall.known]
    off = np.array([(stall.north, stall.east) - places[k] for k, stall in known.items()]).reshape(-1, 2)
    off -= np.median(off, axis=0) if len(off) else 0.0  # what the receiver errs by in this flight
    return Given(
        len(places),
        len(known),
        len(states),
        sum(known[k].state is StallState(state) for k, state in states.items()),
        len(beside),
        _false(world, beside),
        float(np.percentile(np.hypot(*off.T), 95)) if len(off) else math.nan,
    )


def plan_figures(results: Sequence[Result]) -> list[Figure]:
    """Return the figures of all flights over known lots."""
    flights = [result.given for result in results if result.given is not None]
    total = {name: sum(getattr(flight, name) for flight in flights) for name in Given.__slots__}
    off = [flight.off_m for flight in flights if math.isfinite(flight.off_m)]
    return [
        Figure("known_judged", "known stalls with a state", _share(total, "judged", "stalls"), limit=Limit(lowest=1.0)),
        Figure(
            "known_state_accuracy", "state of known stalls", _share(total, "right", "named"), limit=Limit(lowest=0.98)
        ),
        Figure(
            "known_false_proposals", "false proposals a stall", _share(total, "false", "stalls"),
            limit=Limit(highest=0.02),
        ),
        Figure("known_proposals", "proposals a stall", _share(total, "proposed", "stalls")),
        Figure("known_off_p95_m", "known stalls off their places, p95, worst flight", max(off, default=None), "m"),
        Figure("known_placed", "flights that found the plan's place", sum(flight.judged > 0 for flight in flights)),
    ]  # fmt: skip


def _share(total: dict[str, float], part: str, whole: str) -> float | None:
    return total[part] / total[whole] if total[whole] else None


def _true_places(world: World) -> tuple[FloatArray, Boxes]:
    corners = np.array([stall.corners for stall in world.stalls]).reshape(-1, 4, 2)
    boxes, (x0, y0) = Boxes.of(corners), world.start()
    return np.column_stack([y0 - boxes.centre[:, 1], boxes.centre[:, 0] - x0]), boxes


def _false(world: World, stalls: Sequence[Stall]) -> int:
    """Return how many of the proposals are counted false alarms, as `hawk.survey.accuracy` counts them; none beyond the
    world's picture.
    """
    (x0, y0), (width, height) = world.start(), world.size_m
    points = shapely.points([(x0 + stall.east, y0 - stall.north) for stall in stalls])
    lots = shapely.union_all([shapely.Polygon(lot).buffer(0) for lot in world.lots])
    labelled = shapely.union_all([shapely.Polygon(stall.corners) for stall in world.stalls])
    wrong = (shapely.distance(points, labelled) < NEAR_M) | ~shapely.contains(lots, points)
    return int((wrong & shapely.contains(shapely.box(0, 0, width, height), points)).sum())
