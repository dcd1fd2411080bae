"""Cars of a moment on a planned lot: on stalls by their stays, in aisles and on roads by the hour."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime, tzinfo
from typing import Final

import numpy as np
import shapely

from hawk.worlds.plan import PlannedStall, SitePlan, Vehicle
from hawk.worlds.scene.cars import sample_kind
from hawk.worlds.stays import NEAR_M, Demand, LotStays, Stay

_CAR, _MOVING = 31, 32
"""Distinguish the random numbers of cars from others of the same seed."""
_MOVING_S: Final = 60
"""Cars that move are others after this time, seconds."""
_REVERSED: Final = 0.3
"""Share of cars that stand with the tail to the closed end, as in `hawk.worlds.rows`."""
_BUSIEST: Final = 0.7
"""Share of taken stalls at which every planned car in motion is there."""


def number_stalls(plan: SitePlan) -> None:
    """Give each stall without a number the next one."""
    for k, stall in enumerate(plan.stalls):
        if stall.number is None:
            plan.stalls[k] = replace(stall, number=plan.next_number)
            plan.next_number += 1


def stays_of(plan: SitePlan, seed: int, clock: tzinfo) -> LotStays:
    """Return the stays of a plan with numbered stalls: beside the buildings they are sought most."""
    walls = shapely.union_all([shapely.Polygon(one.polygon) for one in plan.buildings if not one.shelter])
    demands = {
        stall.number: Demand(_nearness(stall, walls), accessible=stall.kind == "accessible")
        for stall in plan.stalls
        if stall.number is not None and not stall.closed
    }
    return LotStays(seed, demands, clock)


def park(plan: SitePlan, stays: Mapping[int, Stay], moment: datetime, seed: int) -> None:
    """Replace the vehicles of a plan by those of a moment; ``stays`` are those that cover it, by stall."""
    moving = [vehicle for vehicle, is_parked in zip(plan.vehicles, on_stalls(plan), strict=True) if not is_parked]
    share = len(stays) / max(1, len(plan.stalls))
    plan.vehicles = [
        *(vehicle for number, one in enumerate(moving) if (vehicle := _moving(one, number, share, moment, seed))),
        *(_parked(stall, stay, seed) for stall in plan.stalls if (stay := _stay_on(stall, stays))),
    ]
    plan.stalls = [replace(stall, taken=_stay_on(stall, stays) is not None) for stall in plan.stalls]


def _stay_on(stall: PlannedStall, stays: Mapping[int, Stay]) -> Stay | None:
    return None if stall.number is None else stays.get(stall.number)


def on_stalls(plan: SitePlan) -> list[bool]:
    """Return True for each vehicle of a plan whose centre lies in a stall."""
    tree = shapely.STRtree([shapely.Polygon(stall.corners) for stall in plan.stalls])
    places = [shapely.Point(vehicle.x, vehicle.y) for vehicle in plan.vehicles]
    parked = set(tree.query(places, predicate="intersects")[0].tolist()) if places else set()
    return [k in parked for k in range(len(places))]


def _nearness(stall: PlannedStall, walls: shapely.Geometry) -> float:
    x, y = stall.corners.mean(0)
    away = NEAR_M if walls.is_empty else float(walls.distance(shapely.Point(x, y)))
    return max(0.0, 1.0 - away / NEAR_M)


def _parked(stall: PlannedStall, stay: Stay, seed: int) -> Vehicle:
    """Return the car of a stay: the same at every moment of it."""
    began = int(stay.begin.timestamp())
    return car_on(stall, np.random.default_rng((seed, _CAR, stay.stall, began)), began)


def car_on(stall: PlannedStall, rng: np.random.Generator, key: int = 0) -> Vehicle:
    """Draw a car that stands on a stall; ``key`` as of `Vehicle`."""
    open_end, closed_end = stall.corners[:2], stall.corners[[3, 2]]
    along, across = rng.uniform(0.44, 0.57), 0.5 + rng.normal(0, 0.035)
    front, back = (end[0] + (end[1] - end[0]) * across for end in (open_end, closed_end))
    x, y = front + (back - front) * along
    ahead = closed_end.mean(0) - open_end.mean(0)
    heading = math.atan2(ahead[1], ahead[0]) + rng.normal(0, 0.03) + (math.pi if rng.random() < _REVERSED else 0.0)
    return Vehicle(float(x), float(y), heading, sample_kind(rng, "stall"), key)


def _moving(vehicle: Vehicle, number: int, share: float, moment: datetime, seed: int) -> Vehicle | None:
    """Return the vehicle that passes a place at a moment, None when there is none: fewer while the lot is empty."""
    minute = int(moment.timestamp()) // _MOVING_S
    rng = np.random.default_rng((seed, _MOVING, number, minute))
    if rng.random() >= min(1.0, share / _BUSIEST):
        return None
    return replace(vehicle, kind=sample_kind(rng, "road"), key=minute)
