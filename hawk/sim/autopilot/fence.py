"""The autopilot's geofence: its uploaded items, and the test of a place against them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum, IntFlag

import shapely

from hawk.sim.autopilot.parameters import Parameters
from hawk.sim.geometry import Flat, Vector


class FenceType(IntFlag):
    """FENCE_TYPE."""

    NONE = 0
    ALT_MAX = 1
    CIRCLE = 2
    POLYGON = 4
    ALT_MIN = 8


FENCE_WORDS = {
    FenceType.ALT_MAX: "Max Alt",
    FenceType.CIRCLE: "Circle",
    FenceType.POLYGON: "Polygon",
    FenceType.ALT_MIN: "Min Alt",
}


class FenceCommand(IntEnum):
    """MAV_CMD_NAV_FENCE_*."""

    INCLUSION_VERTEX = 5001
    EXCLUSION_VERTEX = 5002
    INCLUSION_CIRCLE = 5003
    EXCLUSION_CIRCLE = 5004


@dataclass(frozen=True, slots=True)
class FenceItem:
    """One item of the upload: ``parameter`` is the vertex count of its polygon, or the radius in metres."""

    command: int
    parameter: float
    latitude: float
    longitude: float


STORAGE_BYTES = 560
"""ArduCopter's memory for a fence on boards with 16 kB for parameters (libraries/StorageManager)."""
MAX_ITEMS = STORAGE_BYTES // 8
_HEAD_BYTES, _POLYGON_BYTES, _VERTEX_BYTES, _CIRCLE_BYTES = 4, 2, 8, 13


class FenceError(Exception):
    """The items do not make a fence."""


class FenceStorageError(FenceError):
    """The fence does not fit into the autopilot's memory."""


class FenceOverrunError(FenceError):
    """The fence fills the memory to the last byte: ArduCopter takes it, has no room for its end mark, and stops."""


class Fence:
    """Polygons and circles on the ground (NED metres in the world), and the parameters' own circle and heights."""

    def __init__(self) -> None:
        self.items: tuple[FenceItem, ...] = ()
        self._inside: list[shapely.Geometry] = []
        self._outside: list[shapely.Geometry] = []
        self._followed: float | None = None
        self._on = False

    def is_on(self, parameters: Parameters) -> bool:
        """Return True when the fence is enabled: by a change of FENCE_ENABLE, or by a switch or command since."""
        if parameters["FENCE_ENABLE"] != self._followed:
            self._followed = parameters["FENCE_ENABLE"]
            self._on = bool(self._followed)
        return self._on

    def switch(self, on: bool, parameters: Parameters) -> None:
        """Turn the fence on or off without a change of FENCE_ENABLE, as MAV_CMD_DO_FENCE_ENABLE and a switch do."""
        self.is_on(parameters)
        self._on = on

    def boot(self) -> None:
        """Forget a switch: FENCE_ENABLE counts after a boot."""
        self._followed = None

    def load(self, items: Sequence[FenceItem], places: Sequence[Flat]) -> None:
        """Load an upload; ``places`` are the items' places (north, east). Raises FenceError and keeps the old one."""
        needed = _HEAD_BYTES
        inside: list[shapely.Geometry] = []
        outside: list[shapely.Geometry] = []
        index = 0
        while index < len(items):
            command, parameter = items[index].command, items[index].parameter
            target = inside if command in (FenceCommand.INCLUSION_VERTEX, FenceCommand.INCLUSION_CIRCLE) else outside
            if command in (FenceCommand.INCLUSION_VERTEX, FenceCommand.EXCLUSION_VERTEX):
                count = int(parameter) if math.isfinite(parameter) else 0
                group = items[index : index + count]
                if count < 3 or len(group) < count or any(item.command != command for item in group):
                    raise FenceError(f"polygon of {count} vertices at item {index}")
                target.append(shapely.Polygon(places[index : index + count]))
                index += count
                needed += _POLYGON_BYTES + count * _VERTEX_BYTES
            elif command in (FenceCommand.INCLUSION_CIRCLE, FenceCommand.EXCLUSION_CIRCLE):
                target.append(shapely.Point(places[index]).buffer(parameter, quad_segs=64))
                index += 1
                needed += _CIRCLE_BYTES
            else:
                raise FenceError(f"command {command} at item {index} is not a fence command")
        if needed > STORAGE_BYTES:
            raise FenceStorageError(f"{needed} bytes of {STORAGE_BYTES}")
        if needed == STORAGE_BYTES:
            raise FenceOverrunError(f"{needed} bytes and an end mark, of {STORAGE_BYTES}")
        self.items, self._inside, self._outside = tuple(items), inside, outside
        for geometry in (*inside, *outside):
            shapely.prepare(geometry)

    def breaches(self, place: Vector, home: Vector, parameters: Parameters) -> FenceType:
        """Return the enabled fences that a place (NED metres in the world) is outside of."""
        if not self.is_on(parameters):
            return FenceType.NONE
        types = FenceType(parameters.flag("FENCE_TYPE") & 15)
        height = home[2] - place[2]
        found = FenceType.NONE
        if types & FenceType.ALT_MAX and height > parameters["FENCE_ALT_MAX"]:
            found |= FenceType.ALT_MAX
        if types & FenceType.ALT_MIN and height < parameters["FENCE_ALT_MIN"]:
            found |= FenceType.ALT_MIN
        if types & FenceType.CIRCLE and math.dist(place[:2], home[:2]) > parameters["FENCE_RADIUS"]:
            found |= FenceType.CIRCLE
        if types & FenceType.POLYGON and not self._polygons_hold(place[0], place[1]):
            found |= FenceType.POLYGON
        return found

    def _polygons_hold(self, north: float, east: float) -> bool:
        """ArduPilot needs every inclusion area to hold the place (FENCE_OPTIONS bit 1 unset)."""
        if any(not shapely.contains_xy(area, north, east) for area in self._inside):
            return False
        return not any(shapely.contains_xy(area, north, east) for area in self._outside)


def fence_words(types: FenceType) -> str:
    """Return the names of fences as ArduPilot joins them."""
    return " and ".join(word for kind, word in FENCE_WORDS.items() if types & kind)
