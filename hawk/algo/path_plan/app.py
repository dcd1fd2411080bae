"""Path Plan App (specification section 12): the next place to fly to, and the verdict on the operator's place."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from hawk.algo.frame import AlgoError, FrameInput
from hawk.algo.ground import CoarseLayers, LotMap, Mask, Place, Window
from hawk.algo.path_plan.beyond import Border
from hawk.algo.path_plan.explore import Exploration, Explorer
from hawk.algo.path_plan.field import InformationField, guessed, information_field, scouting_field
from hawk.algo.path_plan.footprint import Footprint, LeanObserver, ReadableSpeed, Swath, exploring_height
from hawk.algo.path_plan.lot_ground import FenceGuard, OutlinedGround
from hawk.algo.path_plan.lot_route import RouteKeeper
from hawk.algo.path_plan.overview import ExploreScene, GroundPart, Overview, near_tiles, with_margin
from hawk.algo.path_plan.revisit import RevisitScene
from hawk.algo.path_plan.round_flight import RoundFlight
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.topic_interface import AlgorithmTopicInterface
from hawk.algo.vision.rectify import ground_footprint
from hawk.model.operation import Health, StateName
from hawk.model.plans import DesiredPose, ExploreStatus, Inbound, PathPlan, Verdict
from hawk.model.poses import MapPoint, MapPose
from hawk.model.sentences import say

_SHOWN: Final = 12  # waypoints that are published
_NEW_LOT_M2: Final = 60.0
"""Lot found after an exploration that makes it worth another one: four stalls. The map's border moves a little."""
_NEW_LOT_SHARE: Final = 0.02
_BETWEEN_FLIGHTS: Final = frozenset({StateName.IDLE, StateName.CONFIGURE, StateName.ARM, StateName.TAKEOFF})
_YAW_FROM_M: Final = 1.0  # the bearing of a nearer target says nothing


@dataclass(frozen=True, slots=True)
class Plan:
    """The planner's answer to one frame: ``path`` with target, progress and verdicts, and the planner's ``health``."""

    path: PathPlan
    health: Health

    @classmethod
    def failed(cls, reason: str) -> Plan:
        """Return a plan without a target, unhealthy for a reason."""
        return cls(PathPlan(), Health.bad(reason))


class PathPlanApp:
    """Plans from the map, frame by frame, on the worker thread."""

    def __init__(self, settings: PathPlanSettings | None = None) -> None:
        """``settings`` None: the usual ones."""
        self._settings = settings or PathPlanSettings()
        self._outlined_settings = self._settings.for_outlined_ground()
        self._outlined: OutlinedGround | None = None
        self._overview = Overview()
        self._lean = LeanObserver(self._settings)
        self._readable = ReadableSpeed(self._settings.exposure_s)
        self._guard = FenceGuard(None)
        self._routes = RouteKeeper(self._settings.near_lot_m)
        self._asked_routes = RouteKeeper(self._settings.near_lot_m)
        self._explorer: Explorer | None = None
        self._round: RoundFlight | None = None
        self._explored_so_far = ExploreStatus()
        self._found_m2 = 0.0
        """Area of the lot when it was last explored, square metres."""
        self._inputs: tuple[LotMap, AlgorithmTopicInterface] | None = None
        self._last = Plan.failed(say("not initialised"))

    def plan(self, frame: FrameInput, lot_map: LotMap) -> Plan:
        """Return the plan for a frame over the map; without a target, and unhealthy, when none can be made."""
        self._last = Plan.failed(say("no plan was made"))
        self._last = self._planned(frame, lot_map)
        return self._last

    def init(self, mapper_app: LotMap, topic_interface: AlgorithmTopicInterface) -> None:
        """Take references for `process` and `publish`."""
        self._inputs = mapper_app, topic_interface
        self._last = replace(self._last, health=Health())

    def process(self) -> None:
        """Plan for the topic interface's frame. Raises AlgoError when it cannot; the plan then has no target."""
        mapper_app, topic_interface = self._initialised
        health = self.plan(topic_interface.frame, mapper_app).health
        if not health.is_healthy:
            raise AlgoError(health.reason)

    def publish(self) -> None:
        """Publish verdict, plan and health."""
        _, topic_interface = self._initialised
        topic_interface.des_loc_inbound_pub.publish(self._last.path.verdict)
        topic_interface.local_pos_pub.publish(self.get_local_pose())
        topic_interface.path_plan_app_health_pub.publish(self.get_health())

    def get_local_pose(self) -> PathPlan:
        """Return the last plan: the next place (map frame), the path from there on, and the exploration's progress."""
        return self._last.path

    def get_health(self) -> Health:
        """Return the planner's health."""
        return self._last.health

    def fail(self, reason: str) -> Plan:
        """Return the plan of a frame that failed: no target is left standing."""
        self._last = Plan.failed(reason)
        return self._last

    def begin(self) -> None:
        """Forget what was explored: the map begins empty."""
        self._overview, self._explorer, self._explored_so_far = Overview(), None, ExploreStatus()
        self._round = None
        self._routes, self._asked_routes = (RouteKeeper(self._settings.near_lot_m) for _ in range(2))
        self._last = Plan(PathPlan(), Health())

    def _planned(self, frame: FrameInput, lot_map: LotMap) -> Plan:
        if frame.pose is not None and not frame.pose.is_finite():
            return Plan.failed(say("the pose of the frame is not finite: no plan is made"))
        if frame.fence != self._guard.fence:
            self._guard, self._overview = FenceGuard(frame.fence), Overview()
        self._take_outline(frame)
        self._take_tours(frame)
        self._readable.take(frame.captured)
        asked = self._verdict(frame, lot_map, frame.asked, self._asked_routes)
        verdict = self._verdict(frame, lot_map, frame.desired, self._routes)
        if frame.state is not StateName.AUTONOMOUS_EXPLORE:
            self._explorer = self._round = None
        elif self._explorer is None:
            self._explorer, self._overview = Explorer(self._exploring), Overview()
        if self._explorer is not None and frame.pose is not None:
            over_known = self._flown_round(frame)
            if over_known is None:
                path = self._explored(self._explorer, frame, frame.pose, lot_map)
            else:
                path = self._flown_again(over_known, frame, frame.pose, lot_map)
            self._explored_so_far = path.explore
            self._found_m2 = lot_map.lot_area_m2()
        else:
            self._explored_so_far = self._since(self._explored_so_far, frame.state, lot_map)
            path = replace(_move(frame, verdict), explore=self._explored_so_far)
        return Plan(replace(path, verdict=verdict, asked=asked), Health())

    def _since(self, explored: ExploreStatus, state: StateName, lot_map: LotMap) -> ExploreStatus:
        """Return what an exploration that is over is worth now: lot that was found since it is not explored."""
        if explored.asked_m2 is None and lot_map.lot_area_m2() > self._found_m2 + max(
            _NEW_LOT_M2, _NEW_LOT_SHARE * self._found_m2
        ):
            return replace(explored, done=False, is_spent=False)
        return replace(explored, is_spent=False) if state in _BETWEEN_FLIGHTS else explored

    def _take_outline(self, frame: FrameInput) -> None:
        """Begin the exploration again when the outline of an operator has changed."""
        before = None if self._outlined is None else self._outlined.ground
        if frame.asked_ground != before:
            self._outlined = None if frame.asked_ground is None else OutlinedGround(frame.asked_ground)
            self._explorer, self._overview = None, Overview()
            self._explored_so_far = replace(self._explored_so_far, done=False, is_spent=False)

    @property
    def _exploring(self) -> PathPlanSettings:
        """Settings of the exploration; an outline has its own."""
        return self._settings if self._outlined is None else self._outlined_settings

    def _verdict(
        self, frame: FrameInput, lot_map: LotMap, place: DesiredPose | None, routes: RouteKeeper
    ) -> Verdict | None:
        """Return the verdict on a place, with the route there when it is inside the lot; None without place or pose."""
        if place is None:
            return None
        inbound = lot_map.inbound(place.north, place.east)
        if inbound is not Inbound.INSIDE:
            return Verdict(place.number, inbound)
        if frame.pose is None:
            return None
        at = (frame.pose.north, frame.pose.east)
        return Verdict(place.number, inbound, routes.route(lot_map, self._guard, at, place))

    def _explored(self, explorer: Explorer, frame: FrameInput, pose: MapPose, lot_map: LotMap) -> PathPlan:
        height = exploring_height(frame.heights, frame.camera, self._settings.cm_per_pixel)
        swath = Swath.of(frame.camera, height, self._settings.good_share)
        self._lean.take(pose, frame.speed)
        scene = self._scene(pose, frame, swath, lot_map)
        if scene is None:
            return PathPlan(explore=ExploreStatus(reason=say("nothing is mapped yet")))
        plan = explorer.plan(scene)
        return self._path(plan, self._outlined_status(plan.status, lot_map), frame, pose, swath)

    def _path(
        self, plan: Exploration, status: ExploreStatus, frame: FrameInput, pose: MapPose, swath: Swath
    ) -> PathPlan:
        status = replace(status, is_spent=status.is_whole and not status.unreached)
        if plan.target is None:
            return PathPlan(explore=status)
        target, heading = _point(plan.target), plan.heading
        if heading is None and math.dist(plan.target, (pose.north, pose.east)) > _YAW_FROM_M:
            # the wide side of the picture lies across the path
            heading = math.atan2(target.east - pose.east, target.north - pose.north)
        yaw = pose.yaw if heading is None else math.remainder(heading - frame.camera.mount_yaw, math.tau)
        on = plan.route if plan.target == plan.route[0] else (plan.target, *plan.route)
        route = tuple(_point(p) for p in on[:_SHOWN])
        return PathPlan(target, swath.height, yaw, route, status, speed=self._readable.limit(swath.depth))

    def _take_tours(self, frame: FrameInput) -> None:
        """Begin the flight over known lots again when other tours are asked for."""
        if self._round is not None and frame.tours != self._round.tours:
            self._round = None

    def _flown_round(self, frame: FrameInput) -> RoundFlight | None:
        """Return the flight over the lots that are surveyed again; None without one, and while a plan is missing."""
        known = {lot.id: lot for lot in frame.known if lot.has_plan}
        if self._round is None and frame.tours and all(tour.lot in known for tour in frame.tours):
            self._round = RoundFlight(self._settings, known, frame.tours)
        return self._round

    def _flown_again(self, over_known: RoundFlight, frame: FrameInput, pose: MapPose, lot_map: LotMap) -> PathPlan:
        height = exploring_height(frame.heights, frame.camera, self._settings.cm_per_pixel)
        swath = Swath.of(frame.camera, height, self._settings.known_share)
        self._lean.take(pose, frame.speed)
        heading = pose.yaw + frame.camera.mount_yaw
        place = (pose.north, pose.east)
        shown = ground_footprint(frame.camera, pose) if not frame.map_problem else ()
        picture = np.array([(point.north, point.east) for point in shown]) if shown else None
        scene = RevisitScene(place, heading, frame.speed, self._footprint(swath), self._guard, picture)
        plan = over_known.plan(scene, lot_map)
        path = self._path(plan, plan.status, frame, pose, swath)
        between = frame.heights.bounded(frame.heights.desired)
        return replace(path, height=between) if over_known.is_between_lots and path.target is not None else path

    def _outlined_status(self, status: ExploreStatus, lot_map: LotMap) -> ExploreStatus:
        """Add what is asked for, and at the end what of it was not looked at."""
        if self._outlined is None:
            return status
        unseen = self._outlined.unseen_m2(lot_map) if status.done else None
        return replace(status, asked_m2=self._outlined.area_m2, unseen_m2=unseen)

    def _footprint(self, swath: Swath) -> Footprint:
        """Return the ground that a swath's picture shows: a rectangle that the drone turns."""
        return Footprint.of(swath, self._settings, self._lean.share)

    def _scene(self, pose: MapPose, frame: FrameInput, swath: Swath, lot_map: LotMap) -> ExploreScene | None:
        """Return the scene of the exploration, None before the first frame is mapped."""
        extent, outlined = lot_map.known_extent(), self._outlined
        if extent is None:
            return None
        if outlined is not None and outlined.extent is not None:
            extent = np.concatenate([extent, outlined.extent])
        place, overview, settings = (pose.north, pose.east), self._overview, self._exploring
        near = near_tiles(overview.whole(extent), place)
        block = overview.missing(place, near)
        layers, fenced = self._layers(lot_map, near)
        lot_known = outlined is not None or lot_map.lot_area_m2() > 0
        if not lot_known:
            layers = guessed(layers, place)
        scouting = None
        area = max(overview.lot_m2, float(layers.lot.sum()) * layers.window.cell_m**2)
        if outlined is None and area < settings.small_lot_pictures * swath.width * swath.depth:
            scouting = scouting_field(layers, fenced, settings.scout_near_lot_m)
        return ExploreScene(
            GroundPart(near, self._field(layers, fenced, lot_known=lot_known)),
            None if block is None else GroundPart(block, self._field(*self._layers(lot_map, block))),
            overview,
            place,
            pose.yaw + frame.camera.mount_yaw,
            frame.speed,
            self._footprint(swath),
            self._guard,
            self._unclear(lot_map),
            scouting,
            lot_known=lot_known,
            is_outlined=outlined is not None,
        )

    def _field(self, layers: CoarseLayers, fenced: Mask, *, lot_known: bool = True) -> InformationField:
        """Return the field; nothing lies beyond what only stands in for a lot."""
        settings = self._exploring
        border = None
        if lot_known and settings.beyond_worth > 0:
            ours = self._guard.ours(layers.window)
            is_flown_to = self._explorer is not None and self._explorer.looks_beyond
            border = Border(ours, settings.beyond_m, settings.beyond_alike_m, settings.beyond_width_m, is_flown_to)
        return information_field(layers, fenced, settings.near_lot_m, border)

    def _unclear(self, lot_map: LotMap) -> dict[int, Place]:
        """Return the places of stalls with unknown state, with an outline only those in it."""
        places = {i: (stall.north, stall.east) for i, stall in lot_map.unclear_stalls().items()}
        outlined = self._outlined
        return places if outlined is None else {i: place for i, place in places.items() if outlined.contains(place)}

    def _layers(self, lot_map: LotMap, tiles: Window) -> tuple[CoarseLayers, Mask]:
        """Return the map about some tiles, and 1 where the fence allows the drone to be."""
        window = with_margin(tiles)
        layers = lot_map.coarse(window)
        return layers if self._outlined is None else self._outlined.on(layers), self._guard.mask(window)

    @property
    def _initialised(self) -> tuple[LotMap, AlgorithmTopicInterface]:
        if self._inputs is None:
            raise AlgoError(say("the path planner was not initialised"))
        return self._inputs


def _move(frame: FrameInput, verdict: Verdict | None) -> PathPlan:
    """Return the plan to fly to the desired pose, without a target when its place is not inside the lot."""
    if verdict is None or frame.desired is None or verdict.inbound is not Inbound.INSIDE:
        return PathPlan()
    target = MapPoint(frame.desired.north, frame.desired.east)
    height = frame.heights.bounded(frame.heights.desired)
    return PathPlan(target=target, height=height, route=verdict.route.points[1:])


def _point(place: Place) -> MapPoint:
    """Return the place in millimetres' precision."""
    return MapPoint(round(float(place[0]), 3), round(float(place[1]), 3))
