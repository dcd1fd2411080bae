"""Mapper App (specification section 11): the occupancy map, from what vision says frame by frame."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hawk.algo.errors import AlgoError
from hawk.algo.frame import FrameInput
from hawk.algo.mapper import delta
from hawk.algo.mapper.core import MapCore
from hawk.algo.mapper.grid import CoarseLayers
from hawk.algo.mapper.settings import MapperSettings
from hawk.algo.mapper.window import Window
from hawk.algo.topic_interface import AlgorithmTopicInterface
from hawk.algo.vision.seen import Seen
from hawk.model import Health, HealthStatus, Inbound, MapPose, OccupancyMap, Stall

_TOLD_SCALE = 0.07  # an error of the height above which it is told


class SeesLots(Protocol):
    """What the mapper uses of the Vision App."""

    @property
    def seen(self) -> Seen | None:
        """The last frame's results."""
        ...

    def get_park_lot_detected(self) -> bool:
        """Whether a lot is in sight."""
        ...


class MapperApp:
    """Fuses what vision saw into the map. All of it runs on the worker thread."""

    def __init__(self, settings: MapperSettings | None = None, map_id: str = "") -> None:
        self._settings = settings or MapperSettings()
        self._core = MapCore(self._settings, map_id)
        self._vision_app: SeesLots | None = None
        self._topic_interface: AlgorithmTopicInterface | None = None
        self._health = Health.bad("not initialised")
        self._raised = 1.0

    def init(self, vision_app: SeesLots, topic_interface: AlgorithmTopicInterface) -> None:
        """Take references; the map stays as it is (empty, or restored)."""
        self._vision_app = vision_app
        self._topic_interface = topic_interface
        self._health = Health()

    def levelled(self, frame: FrameInput) -> FrameInput:
        """Return the frame with the height above the ground that the ground itself shows, for vision and planner.

        To be called before vision looks at the frame; what was learned from the frames before is used.
        """
        self._raised = self._core.registration.shift.scale
        if frame.pose is None:
            return frame
        return replace(frame, pose=replace(frame.pose, height=frame.pose.height * self._raised))

    def process(self) -> None:
        """Fuse the frame. Raises AlgoError when it cannot be fused; the map is then as it was before."""
        frame, vision = self._interface.frame, self._vision
        seen = vision.seen
        raised, self._raised = self._raised, 1.0
        try:
            if seen is not None and seen.captured == frame.captured and frame.pose is not None:
                _check(frame, seen)
                self._core.fuse(seen, raised)
            self._core.encode(frame.pose)
        except AlgoError as error:
            self._health = Health.bad(str(error))
            raise
        self._health = Health(HealthStatus.HEALTHY, _scale_words(self._core.registration.shift.scale))

    def publish(self) -> None:
        """Publish map and health."""
        self._interface.occupancy_map_pub.publish(self.get_occupancy_map())
        self._interface.mapper_app_health_pub.publish(self.get_health())

    def get_occupancy_map(self) -> OccupancyMap:
        """Return the map: an immutable index."""
        return self._core.index

    def get_health(self) -> Health:
        """Return whether the map can be trusted."""
        return self._health

    def fail(self, reason: str) -> None:
        """Take note of a failure outside the mapper's own knowledge."""
        self._health = Health.bad(reason)

    def coarse(self, window: Window) -> CoarseLayers:
        """Return the coarse layers for planning over a window of `grid.COARSE_M` cells."""
        return self._core.grid.coarse(window)

    def known_extent(self) -> NDArray[np.float64] | None:
        """Return two corners (2, 2) of (north, east) around everything seen, None before the first frame."""
        return self._core.extent()

    def lot_area_m2(self) -> float:
        """Return how much lot is known, square metres."""
        return self._core.grid.lot_area_m2

    def inbound(self, north: float, east: float) -> Inbound:
        """Return whether a place is inside the lot; a place never seen is unknown."""
        return self._core.inbound(north, east)

    def stalls(self) -> Mapping[int, Stall]:
        """Return the stalls that count."""
        return self._core.index.stalls

    def stalls_near(self, north: float, east: float, radius: float) -> list[Stall]:
        """Return the stalls that count within a radius (metres) of a place near the drone."""
        return self._core.stalls_near(north, east, radius)

    def unclear_stalls(self) -> Mapping[int, Stall]:
        """Return the stalls that count whose state is not known."""
        return self._core.unclear

    def corrected(self, pose: MapPose) -> MapPose:
        """Return the pose with the error taken out that registration found: how the map lies about the drone."""
        return self._core.corrected(pose)

    def changes_since(self, version: int) -> delta.MapDelta:
        """Return what changed after a version of the map (0: everything), for the flight journal."""
        return self._core.changes_since(version)

    def restore(self, deltas: Iterable[Mapping[str, bytes]]) -> list[str]:
        """Take up a map from deltas' parts, oldest first; return what could not be read, in words."""
        core = MapCore(self._settings, "")
        problems = core.restore(deltas)
        self._core = core
        return problems

    def start_anew(self, map_id: str) -> None:
        """Forget the map: a new survey."""
        self._core = MapCore(self._settings, map_id)

    @property
    def _interface(self) -> AlgorithmTopicInterface:
        if self._topic_interface is None:
            raise AlgoError("the mapper was not initialised")
        return self._topic_interface

    @property
    def _vision(self) -> SeesLots:
        if self._vision_app is None:
            raise AlgoError("the mapper was not initialised")
        return self._vision_app


def _scale_words(scale: float) -> str:
    """Say that the height is wrong; empty while it is about right."""
    if abs(scale - 1) <= _TOLD_SCALE:
        return ""
    off, way = round(abs(1 - scale) * 100), "nearer" if scale < 1 else "farther"
    return (
        f"the ground is {off} % {way} than the height above the arm place says, and the map is laid so: "
        "check the camera's field of view, and whether the lot lies as high as the arm place"
    )


def _check(frame: FrameInput, seen: Seen) -> None:
    if frame.pose is None or not frame.pose.is_finite() or not math.isfinite(frame.captured):
        raise AlgoError("the pose of the frame is not finite: it is not mapped")
    for name, image in (("lot", seen.lot), ("car", seen.car), ("core", seen.core), ("picture", seen.picture)):
        if image.values.shape[:2] != image.valid.shape or not np.isfinite(image.to_map).all():
            raise AlgoError(f"vision's {name} picture does not fit the ground: it is not mapped")
        if not 1e-3 < image.metres_per_pixel < 10:
            raise AlgoError(f"vision's {name} picture has {image.metres_per_pixel:.4g} m a pixel: it is not mapped")
