"""Path Plan App (specification section 12): where to fly next, and whether the operator's place lies in the lot."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hawk.algo.errors import AlgoError
from hawk.algo.frame import FrameInput
from hawk.algo.mapper.grid import CoarseLayers
from hawk.algo.mapper.window import Window
from hawk.algo.path_plan.explore import Explorer, Surroundings, to_point
from hawk.algo.path_plan.fence import FenceGuard
from hawk.algo.path_plan.field import guessed, information_field, scouting_field
from hawk.algo.path_plan.footprint import Footprint
from hawk.algo.path_plan.lean import LeanWatch
from hawk.algo.path_plan.overview import Overview, Part, near_tiles, with_margin
from hawk.algo.path_plan.readable import ReadableSpeed, exploring_height
from hawk.algo.path_plan.route_keeper import RouteKeeper
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.sweep import Swath
from hawk.algo.topic_interface import AlgorithmTopicInterface
from hawk.model import (
    DesiredPose,
    ExploreStatus,
    Fence,
    Health,
    Inbound,
    MapPoint,
    MapPose,
    PathPlan,
    Stall,
    StateName,
    Verdict,
)

_SHOWN = 12  # places of the way on
_YAW_FROM_M = 1.0  # the bearing of what is nearer says nothing


class KnowsMap(Protocol):
    """What the planner uses of the Mapper App."""

    def coarse(self, window: Window) -> CoarseLayers:
        """Return the coarse layers over a window."""
        ...

    def known_extent(self) -> NDArray[np.float64] | None:
        """Return two corners (2, 2) around everything seen."""
        ...

    def lot_area_m2(self) -> float:
        """Return how much lot is known, square metres."""
        ...

    def inbound(self, north: float, east: float) -> Inbound:
        """Return whether a place is inside the lot."""
        ...

    def unclear_stalls(self) -> Mapping[int, Stall]:
        """Return the stalls that count whose state is not known."""
        ...


class PathPlanApp:
    """Plans from the map, frame by frame, on the worker thread."""

    def __init__(
        self, settings: PathPlanSettings | None = None, footprint: Callable[[Swath], Footprint] | None = None
    ) -> None:
        """``footprint`` says what a swath's picture shows; None: a rectangle that the drone turns."""
        self._settings = settings or PathPlanSettings()
        self._footprint = footprint or self._turned_picture
        self._explorer = Explorer(self._settings)
        self._overview = Overview()
        self._lean = LeanWatch(self._settings)
        self._readable = ReadableSpeed(self._settings.exposure_s)
        self._guard = FenceGuard(None)
        self._routes = RouteKeeper(self._settings.near_lot_m)
        self._asked_routes = RouteKeeper(self._settings.near_lot_m)
        self._mapper_app: KnowsMap | None = None
        self._topic_interface: AlgorithmTopicInterface | None = None
        self._health = Health.bad("not initialised")
        self._plan = PathPlan()
        self._exploring = False
        self._explored_so_far = ExploreStatus()

    def init(self, mapper_app: KnowsMap, topic_interface: AlgorithmTopicInterface) -> None:
        """Take references. No place is inbound until the map says so."""
        self._mapper_app = mapper_app
        self._topic_interface = topic_interface
        self._health = Health()

    def process(self) -> None:
        """Plan for the frame. Raises AlgoError when it cannot; the plan then has no target."""
        frame = self._interface.frame
        self._plan = PathPlan()
        try:
            if frame.pose is not None and not frame.pose.is_finite():
                raise AlgoError("the pose of the frame is not finite: no plan is made")
            self._know_fence(frame.fence)
            asked = self._verdict(frame, frame.asked, self._asked_routes)
            self._plan = replace(self._planned(frame), asked=asked)
        except AlgoError as error:
            self._health = Health.bad(str(error))
            raise
        self._health = Health()

    def publish(self) -> None:
        """Publish verdict, plan and health."""
        self._interface.des_loc_inbound_pub.publish(self._plan.verdict)
        self._interface.local_pos_pub.publish(self.get_local_pose())
        self._interface.path_plan_app_health_pub.publish(self.get_health())

    def get_local_pose(self) -> PathPlan:
        """Return where the drone is to fly next (map frame), with the way on and how far the exploration is."""
        return self._plan

    def get_des_pose_inbound(self) -> Inbound:
        """Return the verdict on the operator's place; unknown when there is none."""
        return Inbound.UNKNOWN if self._plan.verdict is None else self._plan.verdict.inbound

    def get_health(self) -> Health:
        """Return whether the plan can be trusted."""
        return self._health

    def fail(self, reason: str) -> None:
        """Take note of a failure outside the planner's own knowledge: no target is left standing."""
        self._health = Health.bad(reason)
        self._plan = PathPlan()

    def _planned(self, frame: FrameInput) -> PathPlan:
        verdict = self._verdict(frame, frame.desired, self._routes)
        self._readable.take(frame.captured)
        exploring = frame.state is StateName.AUTONOMOUS_EXPLORE
        if exploring and not self._exploring:
            self._explorer.start()
            self._overview = Overview()
        self._exploring = exploring
        if exploring and frame.pose is not None:
            plan = self._explored(frame, frame.pose, verdict)
            self._explored_so_far = plan.explore
            return plan
        explore = self._explored_so_far
        if verdict is not None and frame.desired is not None and verdict.inbound is Inbound.INSIDE:
            target = MapPoint(frame.desired.north, frame.desired.east)
            way = verdict.route.points[1:]
            height = frame.heights.bounded(frame.heights.desired)
            return PathPlan(target=target, height=height, route=way, explore=explore, verdict=verdict)
        return PathPlan(explore=explore, verdict=verdict)

    def _verdict(self, frame: FrameInput, place: DesiredPose | None, routes: RouteKeeper) -> Verdict | None:
        """Return whether a place is inside the lot, and the route there when it is; None without place or pose."""
        if place is None:
            return None
        inbound = self._mapper.inbound(place.north, place.east)
        if inbound is not Inbound.INSIDE:
            return Verdict(place.number, inbound)
        if frame.pose is None:
            return None
        at = (frame.pose.north, frame.pose.east)
        return Verdict(place.number, inbound, routes.route(self._mapper, self._guard, at, place))

    def _know_fence(self, fence: Fence | None) -> None:
        if fence != self._guard.fence:
            self._guard = FenceGuard(fence)
            self._overview = Overview()

    def _explored(self, frame: FrameInput, pose: MapPose, verdict: Verdict | None) -> PathPlan:
        height = exploring_height(frame.heights, frame.camera, self._settings.cm_per_pixel)
        swath = Swath.of(frame.camera, height, self._settings.good_share)
        self._lean.take(pose, frame.speed)
        around = self._surroundings(pose, frame, swath)
        if around is None:
            return PathPlan(explore=ExploreStatus(reason="nothing is mapped yet"), verdict=verdict)
        plan = self._explorer.plan(around)
        if plan.target is None:
            return PathPlan(explore=plan.status, verdict=verdict)
        target, heading = to_point(plan.target), plan.heading
        if heading is None and math.dist(plan.target, around.place) > _YAW_FROM_M:
            # the wide side of the picture lies across the way
            heading = math.atan2(target.east - pose.east, target.north - pose.north)
        yaw = pose.yaw if heading is None else math.remainder(heading - frame.camera.mount_yaw, math.tau)
        on = plan.route if plan.target == plan.route[0] else (plan.target, *plan.route)
        way = tuple(to_point(p) for p in on[:_SHOWN])
        speed = self._readable.limit(swath.depth)
        return PathPlan(target, height, yaw, way, plan.status, verdict, speed=speed)

    def _turned_picture(self, swath: Swath) -> Footprint:
        return Footprint.of(swath, self._settings, self._lean.share)

    def _surroundings(self, pose: MapPose, frame: FrameInput, swath: Swath) -> Surroundings | None:
        """Return what is to be learned, None before the first frame; for a lot that seems too small also what may lie
        around it."""
        extent = self._mapper.known_extent()
        if extent is None:
            return None
        place, overview, settings = (pose.north, pose.east), self._overview, self._settings
        near = near_tiles(overview.whole(extent), place)
        block = overview.missing(place, near)
        layers, fenced = self._layers(near)
        lot_known = self._mapper.lot_area_m2() > 0
        if not lot_known:
            layers = guessed(layers, place)
        scouting = None
        area = max(overview.lot_m2, float(layers.lot.sum()) * layers.window.cell_m**2)
        if area < settings.small_lot_pictures * swath.width * swath.depth:
            scouting = scouting_field(layers, fenced, settings.scout_near_lot_m)
        return Surroundings(
            Part(near, information_field(layers, fenced, settings.near_lot_m)),
            None if block is None else Part(block, information_field(*self._layers(block), settings.near_lot_m)),
            overview,
            place,
            pose.yaw + frame.camera.mount_yaw,
            frame.speed,
            self._footprint(swath),
            self._guard,
            {i: (stall.north, stall.east) for i, stall in self._mapper.unclear_stalls().items()},
            scouting,
            lot_known=lot_known,
        )

    def _layers(self, tiles: Window) -> tuple[CoarseLayers, NDArray[np.uint8]]:
        """Return the map about some tiles, and where the fence lets the drone be."""
        window = with_margin(tiles)
        return self._mapper.coarse(window), self._guard.mask(window)

    @property
    def _interface(self) -> AlgorithmTopicInterface:
        if self._topic_interface is None:
            raise AlgoError("the path planner was not initialised")
        return self._topic_interface

    @property
    def _mapper(self) -> KnowsMap:
        if self._mapper_app is None:
            raise AlgoError("the path planner was not initialised")
        return self._mapper_app
