"""A round over four drawn lots in one fence against the four flights one by one.

All flights begin at the same place, beside the first lot, and end there; each is planned and flown as Survey again does
it, in simulated time, without wind and errors of position. Every stall must be in one picture as a whole.

    python -m benchmarks.round --json out.json
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from benchmarks.exploration.setups import flown
from benchmarks.figures import Figure, Limit, Section, print_and_write
from benchmarks.known_flight import KnownFlight, SeenMap
from benchmarks.options import make_parser, parse_seeds
from hawk.algo.frame import outcome
from hawk.algo.ground import Place
from hawk.algo.path_plan.known_tour import path_inside
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.path_plan.round_tour import RoundScene, round_tour
from hawk.ddc.fence.geometry import polygon_fence
from hawk.model.known_lot import KnownLot, KnownStall
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import Ring
from hawk.worlds.generate import WorldOptions, generate_world

APART_M: Final = 150.0
"""From one lot's corner to the next one's: drawn lots are up to 138 m wide with the ground about them."""
HOME: Final[Place] = (-20.0, -20.0)
LONGEST_S: Final = 3600.0


def drawn_lot(seed: int, corner: Place) -> KnownLot:
    """Return the stalls of a drawn world as a known lot whose world has its south-west corner at a place."""
    world = generate_world(seed, WorldOptions(metres_per_pixel=0.5))
    stalls = []
    for stall in world.stalls:
        places = np.column_stack([world.size_m[1] - stall.corners[:, 1], stall.corners[:, 0]]) + corner
        along = (places[2] + places[3] - places[0] - places[1]) / 2
        length, width = math.hypot(*along), math.dist(places[0], places[1])
        north, east = places.mean(axis=0).tolist()
        angle = math.atan2(along[1], along[0]) % math.pi
        stalls.append(KnownStall(f"{seed}-{stall.id}", north, east, angle, width, length))
    return KnownLot(f"lot {seed}", tuple(stalls), ())


def site_of(lots: Sequence[KnownLot]) -> Fence:
    """Return a fence about all the lots and the place where flights begin."""
    places = np.array([(stall.north, stall.east) for lot in lots for stall in lot.stalls])
    (south, west), (north, east) = np.minimum(places.min(0), HOME) - 30.0, places.max(0) + 30.0
    ring: Ring = ((south, west), (north, west), (north, east), (south, east))
    return polygon_fence(ring, 3.0, 100.0, 3.0)


def flight_over(lots: Sequence[KnownLot], fence: Fence) -> KnownFlight:
    """Plan and fly a round; return the flight, whose distance is that from the start to the last stall."""
    camera, heights = flown().camera, HeightParameters()
    tours = outcome(round_tour(lots, frozenset(), RoundScene(HOME, camera, heights, fence)))
    flight = KnownFlight(tuple(lots), tours, SeenMap(lots, camera), fence, camera, heights)
    flight.fly(HOME, LONGEST_S)
    return flight


def with_path_home(flight: KnownFlight) -> float:
    """Return the distance of a flight and of its path home inside the fence, metres."""
    last = flight.places[-1]
    path = [last, *path_inside(FenceGuard(flight.fence), last, HOME)]
    return flight.distance_m + sum(math.dist(*leg) for leg in pairwise(path))


def measure(seeds: Sequence[int]) -> Section:
    """Fly the round and the lots one by one, and return the figures."""
    corners = [(APART_M * row, APART_M * column) for row in range(2) for column in range(2)]
    lots = [drawn_lot(seed, corner) for seed, corner in zip(seeds, corners, strict=True)]
    fence = site_of(lots)
    together, singles = flight_over(lots, fence), [flight_over([lot], fence) for lot in lots]
    looked = [*together.lot_map.whole_of.values(), *(flight.lot_map.whole for flight in singles)]
    planned = sum(tour.distance_m for tour in together.tours)
    there_m = sum(flight.distance_m for flight in singles)
    singles_m = sum(map(with_path_home, singles))
    return Section(
        "round",
        [
            Figure(
                "round_over_singles",
                "distance of the round by that of its lots one by one, with their lengths there and home",
                with_path_home(together) / singles_m,
                limit=Limit(highest=0.85),
            ),
            Figure("round_over_singles_there", "the same without the lengths home", together.distance_m / there_m),
            Figure(
                "looked_at_min",
                "least share of a lot's stalls that one picture shows whole",
                float(min(each.mean() for each in looked)),
                limit=Limit(lowest=1.0),
            ),
            Figure("round_m", "distance of the round, with the path home", with_path_home(together), "m"),
            Figure("singles_m", "distance of the lots one by one, with their lengths home", singles_m, "m"),
            Figure("round_planned_m", "planned length of the round, without the path home", planned, "m"),
            Figure("round_s", "simulated seconds of the round, without the path home", together.seconds, "s"),
            Figure("round_stalls", "stalls", float(sum(len(lot.stalls) for lot in lots))),
        ],
    )


def main() -> int:
    """Measure, print the figures, and return the exit status: 1 where a limit does not hold."""
    parser = make_parser("benchmarks.round", __doc__)
    parser.add_argument("--seeds", default="1-4", metavar="SEEDS", help="of the four lots (1-4)")
    options = parser.parse_args()
    seeds = parse_seeds(options.seeds)
    if len(seeds) != 4:
        parser.error("--seeds: name four")
    return print_and_write([measure(seeds)], options.json)


if __name__ == "__main__":
    sys.exit(main())
