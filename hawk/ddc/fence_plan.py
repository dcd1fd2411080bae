"""Which fence the next Arm puts in force, before it is laid on the map: in WGS-84, with its ceiling."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from hawk.config import FenceSettings
from hawk.ddc.geofence import FenceError, Ring, area, check_outline, extent, polygon_fence, ring_from_map, ring_to_map
from hawk.ddc.settings import DdcSettings
from hawk.ddc.words import metres
from hawk.model import Fence, GlobalPose, HeightParameters


@dataclass(frozen=True, slots=True)
class FencePlan:
    """The autopilot's limit. ``ring`` has (latitude, longitude) corners, none for a circle around the arm place.

    ``ceiling`` is the autopilot's, metres above the arm place.
    """

    source: Literal["drawn", "file", "circle"]
    ring: Ring
    ceiling: float

    @property
    def origin(self) -> GlobalPose:
        """A datum of the fence's own. What is measured on it holds on any datum near the fence."""
        return GlobalPose(*self.ring[0], 0.0)

    def on_map(self, datum: GlobalPose, settings: FenceSettings) -> Fence:
        """Return the polygon laid on the map with our limit inside it. Raises FenceError."""
        return polygon_fence(ring_to_map(datum, self.ring), settings.margin_m, self.ceiling, settings.ceiling_margin_m)


@dataclass(frozen=True, slots=True)
class Measures:
    """What becomes of a planned polygon: our limit (latitude, longitude), extent and area of the autopilot's."""

    inner: Ring
    north_south: float
    east_west: float
    area: float


def check_plan(plan: FencePlan, settings: DdcSettings, heights: HeightParameters) -> Measures:
    """Check everything that can be said of a drawn fence wherever the drone is. Raises FenceError naming the field."""
    origin = plan.origin
    outer = ring_to_map(origin, plan.ring)
    check_outline(outer)
    _check_ceiling(plan.ceiling, settings, heights)
    fence = plan.on_map(origin, settings.fence)
    whole = Fence(outer, outer, 0.0, 0.0)
    return Measures(ring_from_map(origin, fence.polygon), *extent(whole), area(outer))


def _check_ceiling(ceiling: float, settings: DdcSettings, heights: HeightParameters) -> None:
    highest, margin = settings.heights.ceiling_m, settings.fence.ceiling_margin_m
    if ceiling > highest:
        raise FenceError(f"Ceiling: {metres(ceiling)} is above the highest allowed, {metres(highest)}: lower it.")
    needed = heights.maximum + margin
    if ceiling < needed:
        raise FenceError(
            f"Ceiling: {metres(ceiling)} is too low for flying up to {heights.maximum:g} m, which needs {needed:g} m: "
            "raise it, or lower Max first."
        )
