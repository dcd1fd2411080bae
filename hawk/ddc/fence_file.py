"""The stored fence: GeoJSON (RFC 7946; one Polygon, WGS-84, longitude before latitude), kept over restarts."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from shapely import Polygon

from hawk.comm.messages import LEAST_CORNERS, MOST_CORNERS
from hawk.comm.status import FenceSetup
from hawk.ddc.atomic_file import set_aside, write_atomically
from hawk.ddc.fence import FencePlan, check_plan, fence_setup
from hawk.ddc.geofence import FenceError, Ring
from hawk.ddc.orders import Level
from hawk.ddc.settings import DdcSettings
from hawk.model import Fence, GlobalPose, HeightParameters

FENCE_FILE = "fence.geojson"


class FenceKeeper:
    """Keeps the planned fence: the one that an operator drew, else the configured file's, else a circle.

    A drawn fence that cannot be read again is a `problem`: it keeps the drone on the ground, because nobody knows
    where it would have forbidden to fly.
    """

    def __init__(self, settings: DdcSettings, directory: Path) -> None:
        """Read the files.

        Raises:
            FenceError: The configured file cannot be used.
        """
        self._settings = settings
        self._path = directory / FENCE_FILE
        self._standard = _standard(settings)
        self.plan = self._standard
        self.problem = ""
        """Reason why the drawn fence cannot be used; empty when it can, or when there is none."""
        self._read()
        self.setup: FenceSetup = fence_setup(self.plan, settings, self.problem)
        """The plan as operators see it; another object after each change."""

    @property
    def notice(self) -> tuple[Level, str, str] | None:
        """A message for the start: a drawn fence that cannot be used, or that outranks the configured file."""
        if self.problem:
            return "warning", "The fence that was drawn cannot be used.", self.problem
        if self.plan.source == "drawn" and self._standard.source == "file":
            return "info", "The drawn fence is used, not the settings' file.", f"{self._settings.fence.file}"
        return None

    def build(self, datum: GlobalPose, place: GlobalPose) -> Fence:
        """Return the planned fence in the map frame for a drone that is armed at a place.

        Raises:
            FenceError: Nothing whole is left inside the margin.
        """
        return self.plan.around(datum, place, self._settings.fence)

    def store(self, plan: FencePlan | None) -> None:
        """Write a drawn fence to its file; None renames the file. Blocks on the disk: call it off the loop.

        Raises:
            FenceError: The disk refused.
        """
        try:
            if plan is None:
                set_aside(self._path, "former")
            else:
                write_atomically(self._path, outline_geojson(plan.ring, plan.ceiling))
        except OSError as error:
            raise FenceError(f"The fence could not be stored in {self._path}: {error}") from error

    def use(self, plan: FencePlan | None) -> None:
        """Plan with this fence from the next Arm on; None: with the configured one."""
        self.plan = plan or self._standard
        self.problem = ""
        self.setup = fence_setup(self.plan, self._settings, "")

    def _read(self) -> None:
        if not self._path.exists():
            return
        highest = self._settings.heights.ceiling_m
        try:
            ring, ceiling = read_outline(self._path)
            plan = FencePlan("drawn", ring, highest if ceiling is None else min(ceiling, highest))
            check_plan(plan, self._settings, HeightParameters(0.0, 0.0, 0.0))
        except FenceError as error:
            self.problem = f"The drawn fence cannot be used: {error}"
        else:
            self.plan = plan


def _standard(settings: DdcSettings) -> FencePlan:
    if settings.fence.file is None:
        return FencePlan("circle", (), settings.heights.ceiling_m)
    return FencePlan("file", read_outline(settings.fence.file)[0], settings.heights.ceiling_m)


def read_outline(path: Path) -> tuple[Ring, float | None]:
    """Return the polygon of a GeoJSON file and its property ``ceiling_m``, if it has one. Raises FenceError."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise FenceError(f"fence file {path}: cannot be read: {error}") from error
    polygon, properties = _single_polygon(content, path)
    rings = polygon.get("coordinates")
    if not isinstance(rings, list) or len(rings) != 1:
        raise FenceError(f"fence file {path}: coordinates: draw one ring without holes")
    ceiling = properties.get("ceiling_m")
    if ceiling is not None and not (_is_finite_number(ceiling) and ceiling > 0):
        raise FenceError(f"fence file {path}: ceiling_m: must be metres above 0, not {ceiling!r}")
    return _checked_ring(rings[0], path), None if ceiling is None else float(ceiling)


def outline_geojson(ring: Ring, ceiling: float) -> str:
    """Return (latitude, longitude) vertices and a ceiling (metres above the arm place) as a GeoJSON Feature."""
    positions = [[longitude, latitude] for latitude, longitude in (*ring, ring[0])]
    if _turns_clockwise(ring):
        positions.reverse()  # RFC 7946: an outer ring runs counterclockwise
    feature = {
        "type": "Feature",
        "properties": {"name": "fence", "ceiling_m": ceiling},
        "geometry": {"type": "Polygon", "coordinates": [positions]},
    }
    return json.dumps(feature, indent=1) + "\n"


def _turns_clockwise(ring: Ring) -> bool:
    pairs = zip(ring, (*ring[1:], ring[0]), strict=True)
    return sum((there[1] - here[1]) * (there[0] + here[0]) for here, there in pairs) > 0


def _single_polygon(content: Any, path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    features = content.get("features") if isinstance(content, dict) else None
    found = features if isinstance(features, list) and features else [content]
    if len(found) == 1 and isinstance(found[0], dict):
        geometry = found[0].get("geometry", found[0])
        if isinstance(geometry, dict) and geometry.get("type") == "Polygon":
            properties = found[0].get("properties")
            return geometry, properties if isinstance(properties, dict) else {}
    raise FenceError(f"fence file {path}: must hold exactly one Polygon (WGS-84, longitude before latitude)")


def _checked_ring(ring: Any, path: Path) -> Ring:
    vertices: list[tuple[float, float]] = []
    for number, place in enumerate(ring if isinstance(ring, list) else ()):
        if not (isinstance(place, list) and len(place) >= 2 and all(_is_finite_number(v) for v in place[:2])):
            raise FenceError(f"fence file {path}: coordinates[0][{number}]: must be [longitude, latitude]")
        longitude, latitude = float(place[0]), float(place[1])
        if abs(longitude) > 180 or abs(latitude) > 90:
            raise FenceError(f"fence file {path}: coordinates[0][{number}]: not degrees: {longitude}, {latitude}")
        vertices.append((latitude, longitude))
    if len(vertices) > 1 and vertices[0] == vertices[-1]:
        vertices.pop()
    if not LEAST_CORNERS <= len(vertices) <= MOST_CORNERS:
        raise FenceError(f"fence file {path}: has {len(vertices)} corners; draw {LEAST_CORNERS} to {MOST_CORNERS}")
    if not Polygon(vertices).is_valid:
        raise FenceError(f"fence file {path}: its sides cross or touch each other; draw a simple polygon")
    return tuple(vertices)


def _is_finite_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
