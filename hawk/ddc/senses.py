"""Senses: gathers the facts of a moment. The one room that decides which reading is believed.

Readings come from the topic interface, outcomes of acts from the performer, the operator from the desk. What must last
before it is believed (a reached reserve, a breach, a fault) is timed here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime

from hawk.comm.protocol.authority import OperatorDesk
from hawk.ddc.battery.charge import ChargeFacts, ChargeReading
from hawk.ddc.battery.chemistry import CHEMISTRIES
from hawk.ddc.battery.energy import DrainReading, HomePath, Reserve, mean_speed
from hawk.ddc.battery.survey import Sighting, SurveyReading
from hawk.ddc.facts import BatteryFacts, Facts, LimitFacts, OperatorFacts, PositionFacts, SightFacts, WindFacts
from hawk.ddc.fence.geometry import BREACH_TOLERANCE_M, area, outside_by, to_map
from hawk.ddc.fence.outline import OutlineFacts
from hawk.ddc.fence.path import length
from hawk.ddc.fence.stored import FenceKeeper, OutlineKeeper
from hawk.ddc.parameters.failsafes import ALL_NAMES
from hawk.ddc.readings.belief import Belief, BeliefReading, Motion
from hawk.ddc.readings.clearance import BelowReading
from hawk.ddc.readings.fall import FallReading
from hawk.ddc.readings.home import HomeFacts, HomeReading, home_health
from hawk.ddc.readings.link import ForeignWrites, Jumps, LinkFacts, LinkReading
from hawk.ddc.readings.remote_control import SWITCH_CHANNEL, RemoteControlReading, remote_control_health
from hawk.ddc.readings.remote_id import remote_id_facts, remote_id_health
from hawk.ddc.readings.topic_interface import BATTERY_TIMEOUT_S, POSE_TIMEOUT_S, DdcTopicInterface
from hawk.ddc.readings.wind import Wind, WindEstimator
from hawk.ddc.requests.flight_log import FlightLog
from hawk.ddc.requests.requests import Outcomes, Requests
from hawk.ddc.requests.service_interface import DdcServiceInterface
from hawk.ddc.settings import DdcSettings
from hawk.ddc.stopwatch import Stopwatch
from hawk.ddc.witnesses.witness import WitnessReading, compass_part
from hawk.model.operation import Fall, Health, StateName
from hawk.model.poses import ArmPlace, GlobalPose, MapPoint
from hawk.model.vehicle import LandedState

WIND_S = 1.0
"""Interval of the wind's estimates, seconds."""
PERCEPTION_PARTS = ("camera", "vision", "mapper", "planner")
"""The parts that flight by sight depends on, in the order of dependence."""

Parts = tuple[tuple[str, Health], ...]


@dataclass(frozen=True, slots=True)
class Sources:
    """Everything that the senses read."""

    clock: Callable[[], float]
    utc: Callable[[], datetime]
    topics: DdcTopicInterface
    service: DdcServiceInterface
    desk: OperatorDesk
    fences: FenceKeeper
    outlines: OutlineKeeper
    log: FlightLog
    requests: Requests
    outcomes: Outcomes
    settings: DdcSettings
    survey: SurveyReading
    fall: Fall | None = None
    """The fall that ended the last flight of an earlier run, as nobody cleared it."""


class Senses:
    """Gathers facts: `tick` once a tick, `look` for a command between two ticks."""

    def __init__(self, sources: Sources) -> None:
        self._from = sources
        now = sources.clock()
        self._link = LinkReading(sources.topics, sources.service.asked_for)
        self._ground = BeliefReading()
        self._belief = self._believe(now)
        self._fall_watch = FallReading(sources.fall)
        self._fall: Fall | None = None
        self._jumps, self._estimate_jumps = Jumps(), Jumps()
        flight = sources.settings.flight
        self._chemistry = CHEMISTRIES[flight.battery_chemistry]
        self._charge_watch = ChargeReading(self._chemistry, flight.battery_return_v, flight.battery_land_v)
        self._charge = ChargeFacts()
        self._drain = DrainReading(sources.settings.flight.battery_reserve_percent)
        self._charge_known = now
        self._home_path = HomePath()
        self._wind_watch = WindEstimator()
        self._wind: Wind | None = None
        self._wind_at = float("-inf")
        self._strong = Stopwatch()
        self._below = BelowReading(sources.topics, sources.settings.heights.least_clearance_m)
        self._witnesses = WitnessReading(sources.topics)
        self._cells: tuple[int, ...] = ()
        self._reserve: Reserve | None = None
        self._reached = Stopwatch()
        self._breach = Stopwatch()
        self._fault = Stopwatch()
        self._position_trusted = now
        self._home_of: tuple[GlobalPose | None, ArmPlace | None] = (None, None)
        self._home: MapPoint | None = None
        self._home_watch = HomeReading()
        self._remote_control = RemoteControlReading(sources.settings.remote_control)
        self._autopilot_home = HomeFacts()
        vehicle = sources.topics.vehicle
        self._writes = ForeignWrites()
        self._stops = (
            vehicle.foreign_write.listen(self._writes.note),
            vehicle.frame_jump.listen(self._jumps.note),
            vehicle.estimate_jump.listen(self._estimate_jumps.note),
        )

    def close(self) -> None:
        """Stop listening."""
        for stop in self._stops:
            stop()
        self._witnesses.close()

    def tick(self) -> Facts:
        """Return the facts of this tick, with the events since the tick before."""
        now = self._from.clock()
        self._belief = self._believe(now)
        self._link.update(self._belief, now)
        self._watch_fall(now)
        self._below.update(self._belief.vehicle)
        self._witnesses.update(self._belief.vehicle, now)
        self._watch_wind(now)
        self._watch_home(now)
        self._watch_charge(now)
        self._watch_battery(now)
        try:
            self._watch_survey(now)
        except Exception:  # it informs only: the facts that decide are gathered all the same
            self._from.survey.fail()
        self._watch_breach(now)
        self._watch_remote_control(now)
        parts = self._parts()
        self._fault.update(bool(_perception_fault(parts)), now)
        if self._from.topics.get_diagnostics().global_position_ok:
            self._position_trusted = now
        facts = self._gather(now, parts, (self._jumps.take(), self._estimate_jumps.take()))
        return replace(facts, link=self._link.take_events(facts.link))

    def look(self) -> Facts:
        """Return the facts of this moment, without events."""
        now = self._from.clock()
        self._belief = self._believe(now)
        return self._gather(now, self._parts(), (0.0, 0.0))

    # -- gathering -----------------------------------------------------------------------------------------------

    def _gather(self, now: float, parts: Parts, jumps: tuple[float, float]) -> Facts:
        topics, outcomes = self._from.topics, self._from.outcomes
        return Facts(
            now=now,
            utc=self._from.utc().timestamp(),
            vehicle=self._belief.vehicle,
            ground=self._belief.ground,
            link=LinkFacts(
                is_up=self._link.is_up,
                age=topics.get_link_age(),
                mode_changed_at=self._link.mode_changed_at,
                words=self._from.log.autopilot_reason(),
                second_sender=topics.get_second_sender(),
                foreign_writes=self._writes.recent(now),
            ),
            position=self._position(now, jumps),
            diagnostics=topics.get_diagnostics(),
            battery=self._battery(now),
            wind=WindFacts(self._wind, self._strong.read(now)),
            witness=self._witnesses.facts(now),
            limits=self._limits(now),
            operator=self._operator(now),
            sight=self._sight(now, parts),
            remote_control=self._remote_control.read(now),
            remote_id=remote_id_facts(self._from.topics.vehicle.remote_id.value, now),
            parts=(*parts, ("home", home_health(self._autopilot_home)), *self._other_parts(now)),
            answers=self._from.requests.answers(),
            target_refusal=outcomes.target_refusal,
            parameters=self._parameters(),
            fall=self._fall,
            starts_in_air=outcomes.starts_in_air,
        )

    def _position(self, now: float, jumps: tuple[float, float]) -> PositionFacts:
        topics = self._from.topics
        datum, arm_place = self._from.service.datum, topics.vehicle.arm_place.value
        return PositionFacts(
            pose=topics.get_pose(),
            age=topics.get_pose_age(),
            distrusted_s=now - self._position_trusted,
            jump_m=jumps[0],
            estimate_jump_m=jumps[1],
            datum=datum,
            arm_place=arm_place,
            home=self._home_at(datum, arm_place),
            autopilot_home=self._autopilot_home,
            below=self._below.facts(now),
        )

    def _battery(self, now: float) -> BatteryFacts:
        topics = self._from.topics
        return BatteryFacts(
            info=topics.get_battery_info(),
            age=topics.get_battery_age(),
            unknown_s=now - self._charge_known,
            reserve=self._reserve,
            reached_s=self._reached.read(now),
            cells=self._cells,
            charge=self._charge,
            survey=self._from.survey.need,
            short_s=self._from.survey.short_s(now),
        )

    def _limits(self, now: float) -> LimitFacts:
        fences, topics = self._from.fences, self._from.topics
        return LimitFacts(
            heights=topics.get_heights(),
            fence=topics.fence_pub.value,
            breached_s=self._breach.read(now),
            plan=fences.plan,
            plan_problem=fences.problem,
            planned_ceiling=fences.plan.ceiling - self._from.settings.fence.ceiling_margin_m,
            held=self._from.service.held_fence if self._link.is_unbroken else None,
            outline=self._outline(),
        )

    def _outline(self) -> OutlineFacts | None:
        return self._from.outlines.facts(self._from.service.datum, self._from.topics.fence_pub.value)

    def _parameters(self) -> tuple[tuple[str, float], ...]:
        told = self._from.service.parameters
        return tuple((name, float(told[name])) for name in ALL_NAMES if name in told)

    def _operator(self, now: float) -> OperatorFacts:
        desk = self._from.desk
        controller = desk.controller()
        return OperatorFacts(
            is_present=desk.operator_present(now),
            is_controlled=controller is not None,
            clients=desk.controlling_clients(),
            controller=controller or "",
            names=tuple(desk.names().items()),
            given_back_by=desk.given_back_by(),
        )

    def _sight(self, now: float, parts: Parts) -> SightFacts:
        topics = self._from.topics
        occupancy = topics.get_occupancy_map()
        return SightFacts(
            lot=topics.has_lot_word(),
            plan=topics.get_path_plan(),
            plan_time=topics.get_path_plan_time(),
            verdict=topics.get_fresh_verdict(),
            desired=topics.des_pose_pub.value,
            desired_count=self._from.outcomes.desired_count,
            asked=topics.get_asked_verdict(),
            fault=_perception_fault(parts),
            fault_s=self._fault.read(now) or 0.0,
            footprint=topics.get_footprint(),
            counts=occupancy.counts,
            lot_area=occupancy.lot_area_m2,
            vision_rate=topics.get_vision_rate(),
            camera_age=topics.get_camera_age(),
        )

    def _home_at(self, datum: GlobalPose | None, arm_place: ArmPlace | None) -> MapPoint | None:
        if (datum, arm_place) != self._home_of:
            self._home_of = (datum, arm_place)
            self._home = None
            if datum is not None and arm_place is not None:
                self._home = to_map(datum, arm_place.latitude, arm_place.longitude)
        return self._home

    # -- armed and landed ----------------------------------------------------------------------------------------

    def _believe(self, now: float) -> Belief:
        topics = self._from.topics
        place = topics.vehicle.arm_place.latest
        motion = Motion.of(topics.get_pose(), topics.get_pose_age())
        return self._ground.update(topics.get_state(), motion, -math.inf if place is None else place.time, now)

    def _watch_fall(self, now: float) -> None:
        topics = self._from.topics
        place = topics.get_global_pose() if topics.get_pose_age() <= POSE_TIMEOUT_S else None
        utc = self._from.utc().timestamp()
        self._fall = self._fall_watch.update(self._belief, place, now, utc)

    def _is_airborne(self) -> bool:
        vehicle = self._belief.vehicle
        return vehicle.armed and vehicle.landed is not LandedState.ON_GROUND

    def _lasting_doubt(self) -> str:
        return self._belief.ground.lasting_doubt if self._link.is_up else ""

    def _parts(self) -> Parts:
        """Return the health of every part: that of armed and landed stands behind the position's."""
        reported, doubt = dict(self._from.topics.get_part_healths()), self._lasting_doubt()
        witness = self._witnesses.facts(self._from.clock())
        parts = tuple((reported | {"position": witness.position_health(reported["position"])}).items())
        place = 1 + next(index for index, (name, _) in enumerate(parts) if name == "position")
        return (*parts[:place], ("ground", Health.bad(doubt) if doubt else Health()), *parts[place:])

    def _other_parts(self, now: float) -> Parts:
        """Return the parts that not every drone has, and those of the radio."""
        compass = compass_part(self._from.topics.get_diagnostics())
        return (*self._below.part(), *compass, *self._radio_healths(now))

    # -- conditions that must last -------------------------------------------------------------------------------

    def _watch_wind(self, now: float) -> None:
        pose = self._from.topics.get_fresh_pose()
        if not self._is_airborne():
            self._wind_watch.reset()
            self._wind = None
        elif pose is not None:
            self._wind_watch.update(pose)
            if now - self._wind_at >= WIND_S:
                self._wind, self._wind_at = self._wind_watch.estimate(), now
        limit = self._from.settings.flight.maximum_wind_m_s
        self._strong.update(self._wind is not None and self._wind.speed > limit, now)

    def _watch_battery(self, now: float) -> None:
        topics = self._from.topics
        percentage, pose, airborne = self._charge.believed, topics.get_fresh_pose(), self._is_airborne()
        if percentage is not None or not airborne:
            self._charge_known = now
        if not self._belief.vehicle.armed:
            self._drain.reset()  # the next flight may begin with another battery
        home = self._home_at(self._from.service.datum, topics.vehicle.arm_place.value)
        if not airborne:
            self._reserve = None
            self._reached.update(False, now)
        elif percentage is not None and home is not None and pose is not None and pose.map is not None:
            self._drain.update(percentage, now)
            aim = self._return_place(pose.map.point, home)
            path = self._home_path.look(topics.fence_pub.value, pose.map.point, aim, now)
            speed = mean_speed(path, self._from.settings.flight.speed_m_s, self._wind)
            top = topics.get_heights().maximum
            self._reserve = self._drain.reserve(percentage, length(path), pose.map.height, top, speed)
            self._reached.update(self._reserve.is_reached, now)

    def _watch_survey(self, now: float) -> None:
        topics = self._from.topics
        utc, outline = self._from.utc().timestamp(), self._outline()
        self._from.survey.look(
            Sighting(
                now=now,
                utc=utc,
                armed=self._belief.vehicle.armed,
                airborne=self._is_airborne(),
                exploring=topics.curr_state_pub.value is StateName.AUTONOMOUS_EXPLORE,
                charge=self._charge.believed,
                reserve=self._reserve,
                drain=self._drain.measured,
                plan=topics.get_path_plan(),
                lot_area=topics.get_occupancy_map().lot_area_m2,
                heights=topics.get_heights(),
                outline_area=None if outline is None else outline.area,
                fence_area=self._fence_area,
            )
        )

    def _fence_area(self) -> float | None:
        """Return the area of the fence in force, on the ground that of the planned one; None while there is none."""
        fence, pose = self._from.topics.fence_pub.value, self._from.topics.get_pose()
        if fence is not None and self._is_airborne():
            return area(fence)
        return None if pose is None else self._from.fences.planned_area(self._from.service.datum, pose.global_)

    def _return_place(self, place: MapPoint, home: MapPoint) -> MapPoint:
        """Return the farther of the arm place and the autopilot's home: RTL flies to the latter."""
        theirs, datum = self._autopilot_home, self._from.service.datum
        if not theirs.is_moved or theirs.place is None or datum is None:
            return home
        moved = to_map(datum, theirs.place.latitude, theirs.place.longitude)
        return max(home, moved, key=place.distance)

    def _watch_home(self, now: float) -> None:
        topics, said = self._from.topics, self._belief.vehicle
        armed = said.armed or not math.isfinite(said.time)  # nobody is known to be disarmed before the first HEARTBEAT
        vehicle, datum, fence = topics.vehicle, self._from.service.datum, topics.fence_pub.value
        self._autopilot_home = self._home_watch.look(
            vehicle.home.latest, vehicle.arm_place.latest, armed, datum, fence, now
        )

    def _watch_remote_control(self, now: float) -> None:
        channel = self._from.service.parameters.get(SWITCH_CHANNEL)
        is_armed = self._belief.vehicle.armed and self._link.is_up
        self._remote_control.look(self._from.topics.vehicle.remote_control.value, channel, now, is_armed=is_armed)

    def _radio_healths(self, now: float) -> Parts:
        settings, is_armed = self._from.settings, self._belief.vehicle.armed and self._link.is_up
        told = remote_id_facts(self._from.topics.vehicle.remote_id.value, now)
        return (
            ("remote control", remote_control_health(self._remote_control.read(now))),
            ("remote id", remote_id_health(told, settings.remote_id, is_armed=is_armed)),
        )

    def _watch_charge(self, now: float) -> None:
        """Count the battery's cells at rest, and compare its readings. In flight the voltage sags, the count stays."""
        info, armed = self._from.topics.vehicle.battery.fresh(BATTERY_TIMEOUT_S), self._belief.vehicle.armed
        if info is not None and (not armed or not self._cells):
            configured = self._from.settings.flight.battery_cells
            self._cells = self._chemistry.possible_cells(info.voltage, configured, in_flight=armed)
        self._charge = self._charge_watch.update(info, self._cells, now, is_airborne=self._is_airborne())

    def _watch_breach(self, now: float) -> None:
        pose, fence = self._from.topics.get_fresh_pose(), self._from.topics.fence_pub.value
        if not self._is_airborne() or fence is None:
            self._breach.update(False, now)
        elif pose is not None and pose.map is not None:
            beyond = max(outside_by(fence, pose.map.point), pose.map.height - fence.ceiling)
            was_beyond = self._breach.read(now) is not None
            # a breach begins beyond the tolerance and ends inside fence and ceiling
            self._breach.update(beyond > BREACH_TOLERANCE_M or (was_beyond and beyond > 0.0), now)


def _perception_fault(parts: Parts) -> str:
    for name, health in parts:
        if name in PERCEPTION_PARTS and not health.is_healthy:
            return f"{name.capitalize()}: {health.reason}"
    return ""
