"""Mapper App (specification section 11): fuses vision's results into the occupancy map, frame by frame."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hawk.algo.frame import AlgoError, FrameInput
from hawk.algo.ground import CoarseLayers, Window
from hawk.algo.mapper.core import MapCore, MapperSettings
from hawk.algo.mapper.delta import MapDelta
from hawk.algo.mapper.register import Shift
from hawk.algo.topic_interface import AlgorithmTopicInterface
from hawk.algo.vision.detection import FrameGround, FrameVision, VisionResult
from hawk.model.lot_map import OccupancyMap, Stall
from hawk.model.operation import Health
from hawk.model.plans import Inbound
from hawk.model.sentences import say


@dataclass(frozen=True, slots=True)
class Fused:
    """The map after a frame: an immutable index, the correction of the pose that it is made with, the health."""

    occupancy_map: OccupancyMap = field(repr=False)
    shift: Shift
    health: Health


class MapperApp:
    """Keeps the map, on the worker thread only. It is the `LotMap` that the planner reads."""

    def __init__(self, settings: MapperSettings | None = None, map_id: str = "") -> None:
        self._settings = settings or MapperSettings()
        self._core = MapCore(self._settings, map_id)
        self._vision_app: FrameVision | None = None
        self._topic_interface: AlgorithmTopicInterface | None = None
        self._health = Health.bad(say("not initialised"))

    def init(self, vision_app: FrameVision, topic_interface: AlgorithmTopicInterface) -> None:
        """Take references; the map stays as it is (empty, or restored)."""
        self._vision_app = vision_app
        self._topic_interface = topic_interface
        self._health = Health()

    def fuse(self, frame: FrameInput, seen: VisionResult) -> Fused:
        """Fuse vision's result for the frame, unless its position does not fit the map.

        Raises AlgoError when it cannot be fused; the map is then unchanged.
        """
        ground = seen.ground
        try:
            mappable = frame.pose is not None and not frame.map_problem
            if mappable and ground is not None and ground.captured == frame.captured:
                _check(frame, ground)
                self._core.know(frame.known)
                self._core.fuse(ground)
            self._core.encode(frame.pose)
        except AlgoError as error:
            self.fail(str(error))
            raise
        if frame.pose is not None and frame.map_problem:
            return self.fail(frame.map_problem)
        self._health = Health()
        return self._fused()

    def finish(self) -> OccupancyMap:
        """Do at once all the work that frames do piece by piece; return the map. For maps without a flight."""
        self._core.finish()
        return self._core.index

    def fail(self, reason: str) -> Fused:
        """Return the map as it is, with the reason as health."""
        self._health = Health.bad(reason)
        return self._fused()

    def process(self) -> None:
        """Fuse the topic interface's frame as the Vision App saw it (specification: process). Raises AlgoError."""
        if self._vision_app is None or self._topic_interface is None:
            raise AlgoError(say("the mapper was not initialised"))
        self.fuse(self._topic_interface.frame, self._vision_app.seen)

    def publish(self) -> None:
        """Publish map and health (specification: publish)."""
        if self._topic_interface is None:
            raise AlgoError(say("the mapper was not initialised"))
        self._topic_interface.occupancy_map_pub.publish(self.get_occupancy_map())
        self._topic_interface.mapper_app_health_pub.publish(self.get_health())

    def get_occupancy_map(self) -> OccupancyMap:
        """Return the map: an immutable index."""
        return self._core.index

    def get_health(self) -> Health:
        """Return the health of the map."""
        return self._health

    def coarse(self, window: Window) -> CoarseLayers:
        """Return the coarse layers for planning over a window of `hawk.algo.ground.COARSE_M` cells."""
        return self._core.grid.coarse(window)

    def known_extent(self) -> NDArray[np.float64] | None:
        """Return two corners (2, 2) of (north, east) around everything seen, None before the first frame."""
        return self._core.grid.extent()

    def lot_area_m2(self) -> float:
        """Return the area of known lot, square metres."""
        return self._core.grid.lot_area_m2

    def inbound(self, north: float, east: float) -> Inbound:
        """Return the verdict on a place (metres, map frame); a place never seen is unknown."""
        return self._core.inbound(north, east)

    def unclear_stalls(self) -> Mapping[int, Stall]:
        """Return the valid stalls with unknown state, by id."""
        return self._core.published.unclear

    def stalls_near(self, north: float, east: float, radius: float) -> list[Stall]:
        """Return the valid stalls within a radius (metres) of a place near the drone."""
        return self._core.stalls_near(north, east, radius)

    def plan_places(self, lot: str) -> NDArray[np.float64] | None:
        """Return the stalls (N, 5) of the plan of a lot on the map, as `KnownMap` has them."""
        return self._core.plan_places(lot)

    def changes_since(self, version: int) -> MapDelta:
        """Return the changes after a version of the map (0: everything), for the flight journal."""
        return self._core.changes_since(version)

    def restore(self, deltas: Iterable[Mapping[str, bytes]], *, has_same_cars: bool = True) -> list[str]:
        """Replace the map by that of deltas' parts, oldest first; return the parts that cannot be read, in words.

        ``has_same_cars``: the map is so young that its cars are still there.
        """
        core = MapCore(self._settings, "")
        problems = core.restore(deltas, has_same_cars=has_same_cars)
        self._core = core
        return problems

    def begin(self, map_id: str) -> None:
        """Begin an empty map under another id."""
        self._core = MapCore(self._settings, map_id)

    def _fused(self) -> Fused:
        return Fused(self._core.index, self._core.registration.shift, self._health)


def _check(frame: FrameInput, ground: FrameGround) -> None:
    if frame.pose is None or not frame.pose.is_finite() or not math.isfinite(frame.captured):
        raise AlgoError(say("the pose of the frame is not finite: it is not mapped"))
    for name in ("lot", "car", "core", "taken", "picture"):
        image = getattr(ground, name)
        if image.values.shape[:2] != image.valid.shape or not np.isfinite(image.to_map).all():
            raise AlgoError(say("vision's {name} picture does not fit the ground: it is not mapped", name=name))
        if not 1e-3 < image.metres_per_pixel < 10:
            raise AlgoError(
                say(
                    "vision's {name} picture has {scale:.3f} m a pixel: it is not mapped",
                    name=name,
                    scale=image.metres_per_pixel,
                )
            )
