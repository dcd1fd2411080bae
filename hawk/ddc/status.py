"""Status: the heartbeat's content as a function of facts, and what other rooms read after a tick."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import UTC, datetime
from functools import lru_cache

from hawk.comm.protocol import heartbeat
from hawk.comm.topic import Topic
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import Ring
from hawk.ddc.requests.flight_log import FlightLog, Trail
from hawk.ddc.requests.requests import Outcomes
from hawk.ddc.rules.judge import options
from hawk.ddc.rules.needs import Situation
from hawk.model.lot_map import free_interval
from hawk.model.operation import Health, HealthStatus
from hawk.model.plans import LotLook, RoundLot
from hawk.model.poses import MapPoint

HEARTBEAT_S = 0.2
"""Interval of the statuses: 5 Hz."""


class Reporter:
    """Publishes statuses. Home and the trail follow every tick."""

    def __init__(
        self,
        log: FlightLog,
        trail: Trail,
        outcomes: Outcomes,
        setups: Callable[[], tuple[heartbeat.FenceSetup, heartbeat.OutlineSetup]],
        topic: Topic[heartbeat.DroneStatus],
    ) -> None:
        """``setups`` returns planned fence and outline as operators see them; each the same object until it changes."""
        self._log = log
        self._trail = trail
        self._outcomes = outcomes
        self._setups = setups
        self._topic = topic
        self._sequence = 0
        self._next = -math.inf

    def follow(self, facts: Facts) -> None:
        """Add this tick to the trail."""
        if facts.link.is_up:
            self._trail.update(facts.last_place, facts.is_airborne, facts.now)

    def is_due(self, now: float, tick_s: float) -> bool:
        """Return True at the tick that is nearest to the time of the next status."""
        if now < self._next - 0.5 * tick_s:
            return False
        self._next = now + HEARTBEAT_S if now - self._next > HEARTBEAT_S else self._next + HEARTBEAT_S
        return True

    def report(self, situation: Situation, own: Health) -> None:
        """Publish a status; ``own`` is the manager's health."""
        self._topic.publish(self._status(situation, own))

    def _status(self, situation: Situation, own: Health) -> heartbeat.DroneStatus:
        facts, (fence, outline) = situation.facts, self._setups()
        self._sequence += 1
        utc = datetime.fromtimestamp(facts.utc, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        return heartbeat.DroneStatus(
            stamp=heartbeat.StatusStamp(sequence=self._sequence, time=facts.now, utc=utc),
            operation=self._operation(situation),
            vehicle=vehicle_status(facts),
            pose=pose_status(facts),
            site=site_status(situation),
            travel=self._travel(situation),
            perception=perception_status(facts),
            parts=parts_status(facts, own),
            fence_setup=fence,
            outline_setup=outline,
            log=self._log.entries,
            trail=self._trail.points,
            trail_id=self._trail.identity,
        )

    def _operation(self, situation: Situation) -> heartbeat.OperationStatus:
        state, facts, locks = situation.state, situation.facts, situation.interlocks
        return heartbeat.OperationStatus(
            state=state.identity,
            detail=state.detail(facts),
            asked_by=state.asked_by or None,
            user_error=self._outcomes.user_error,
            user_error_text=self._outcomes.user_error_text,
            options=options(situation),
            checks=situation.checks if state.on_ground else (),
            killed=locks.is_killed,
            fallen=locks.fall is not None and locks.kill_state == "none",  # motors that were cut fell, too
            kill_state=locks.kill_state,
            return_in=state.return_in(facts),
        )

    def _travel(self, situation: Situation) -> heartbeat.TravelStatus:
        facts, goal = situation.facts, situation.state.goal
        return heartbeat.TravelStatus(
            target=None if goal is None else heartbeat.Point.of(goal.point),
            route=_points(situation.state.route(facts)),
            flight_time=self._trail.flight_time(facts.now),
            distance_flown=self._trail.distance,
        )


def vehicle_status(facts: Facts) -> heartbeat.VehicleStatus:
    """Return autopilot, link and battery."""
    vehicle, battery, reserve = facts.vehicle, facts.battery.info, facts.battery.reserve
    heard, survey = math.isfinite(vehicle.time), facts.battery.survey
    home = survey.home if survey is not None else None
    return heartbeat.VehicleStatus(
        ardupilot_state=vehicle.mode,
        armed=vehicle.armed if heard else None,
        connected=facts.link.is_up,
        landed=vehicle.landed.name,
        link_age=facts.link.age,
        battery_percentage=None if battery is None else battery.percentage,
        battery_age=facts.battery.age,
        voltage=None if battery is None else battery.voltage,
        battery_time_left=None if reserve is None else reserve.time_left,
        time_home=None if reserve is None else reserve.seconds_home,
        battery_needed_home=home if reserve is None else reserve.needed,
        battery_needed_survey=None if survey is None else survey.percent,
        battery_left=None if survey is None else survey.left,
        survey_basis=None if survey is None else survey.basis,
        survey_share=None if survey is None else survey.share,
        survey_batteries=None if survey is None else survey.batteries,
        survey_time_left=None if survey is None else survey.seconds,
        satellites=facts.diagnostics.satellites,
    )


def pose_status(facts: Facts) -> heartbeat.PoseStatus:
    """Return pose and velocity."""
    pose = facts.position.pose
    if pose is None:
        return heartbeat.PoseStatus()
    (north, east, down), wind = pose.velocity, facts.wind.estimate
    return heartbeat.PoseStatus(
        relative_altitude=pose.relative_altitude,
        latitude=pose.global_.latitude,
        longitude=pose.global_.longitude,
        local_position_x=None if pose.local is None else pose.local.x,
        local_position_y=None if pose.local is None else pose.local.y,
        north=None if pose.map is None else pose.map.north,
        east=None if pose.map is None else pose.map.east,
        yaw=pose.yaw,
        roll=pose.roll,
        pitch=pose.pitch,
        speed=math.hypot(north, east),
        climb=-down,
        pose_age=facts.position.age,
        height_above_ground=facts.height_over_ground,
        wind_speed=None if wind is None else wind.speed,
        wind_from=None if wind is None else wind.from_direction,
    )


def site_status(situation: Situation) -> heartbeat.SiteStatus:
    """Return home, map origin and the limits of the flight."""
    limits, position, plan = situation.facts.limits, situation.facts.position, situation.facts.sight.plan
    fence, datum, heights, outline = limits.fence, position.datum, limits.heights, limits.outline
    return heartbeat.SiteStatus(
        home=None if position.home is None else heartbeat.Point.of(position.home),
        datum=None if datum is None else (datum.latitude, datum.longitude),
        fence=() if fence is None else _ring(fence.polygon),
        fence_limit=() if fence is None else _ring(fence.autopilot_polygon),
        fence_zones=() if fence is None else tuple(_ring(zone) for zone in fence.zones),
        fence_zone_limits=() if fence is None else tuple(_ring(zone) for zone in fence.autopilot_zones),
        ceiling=situation.facts.ceiling(situation.state.on_ground),
        heights=(heights.minimum, heights.desired, heights.maximum),
        outline_area=None if outline is None else round(outline.area, 1),
        outline_outside=None if outline is None else round(outline.outside, 1),
        again_distance=situation.facts.lots.tour_m if outline is not None and outline.lots else None,
        again_lots=() if outline is None else _round(outline.lots, () if plan is None else plan.explore.lots),
        plan_offer=None if (offer := situation.facts.lots.offer) is None else heartbeat.PlanOfferStatus.of(offer),
    )


def _round(lots: tuple[RoundLot, ...], looks: tuple[LotLook, ...]) -> tuple[heartbeat.RoundLotStatus, ...]:
    seen = {look.lot: look.seen for look in looks}
    return tuple(
        heartbeat.RoundLotStatus(
            lot=lot.id, name=lot.name, seen=seen.get(lot.id, 1.0 if lot.is_over else 0.0), is_over=lot.is_over
        )
        for lot in lots
    )


def perception_status(facts: Facts) -> heartbeat.PerceptionStatus:
    """Return the results of vision, mapper and planner."""
    sight, plan = facts.sight, facts.sight.plan
    left_out = None if plan is None else plan.explore.left_out
    return heartbeat.PerceptionStatus(
        vision_rate=sight.vision_rate,
        camera_age=sight.camera_age,
        footprint=_points(sight.footprint),
        park_lot_detected=sight.lot,
        lot_area=sight.lot_area,
        free=sight.counts.free,
        taken=sight.counts.taken,
        unknown=sight.counts.unknown,
        suggested=sight.counts.suggested,
        free_range=free_interval(sight.counts, None if plan is None else plan.explore),
        explored=None if plan is None else plan.explore.seen,
        explore_done=plan is not None and plan.explore.done,
        outline_unseen=None if plan is None or facts.limits.outline is None else plan.explore.unseen_m2,
        left_out=None if left_out is None else heartbeat.LeftOutStatus.of(left_out),
        remaining=None if plan is None else plan.explore.remaining_m,
    )


def parts_status(facts: Facts, own: Health) -> heartbeat.PartsStatus:
    """Return the health of each part; a fault of the manager itself is shown as that of the loop."""
    shown = tuple((name, own if name == "loop" and not own.is_healthy else health) for name, health in facts.parts)
    items = tuple(heartbeat.HealthItem(name=name, healthy=h.is_healthy, reason=h.reason) for name, h in shown)
    well = own.is_healthy and all(item.healthy for item in items if item.name != "loop")
    return heartbeat.PartsStatus(health=items, health_status=HealthStatus.HEALTHY if well else HealthStatus.UNHEALTHY)


def _points(places: tuple[MapPoint, ...]) -> tuple[heartbeat.Point, ...]:
    return tuple(map(heartbeat.Point.of, places))


@lru_cache(maxsize=4)
def _ring(corners: Ring) -> tuple[heartbeat.Point, ...]:
    """Return corners to the centimetre: they are sent five times a second."""
    return tuple(heartbeat.Point(north=round(north, 2), east=round(east, 2)) for north, east in corners)
