"""DDC Topic Interface (specification section 15): everything that manager and states may know, in "get" routines.

The secret is which topic a value comes from and how old it may be.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from hawk.comm.autopilot.vehicle import VehicleTopics
from hawk.comm.topic import Topic
from hawk.model.known_lot import LotsAhead
from hawk.model.lot_map import OccupancyMap
from hawk.model.operation import GROUND_STATES, Health, StateName
from hawk.model.pictures import GroundStep, StallSize
from hawk.model.plans import DesiredPose, Fence, HeightParameters, PathPlan, Verdict
from hawk.model.poses import GlobalPose, MapPoint, VehiclePose
from hawk.model.sentences import say
from hawk.model.vehicle import BatteryInfo, Diagnostics, VehicleState

TARGET_POSE_AGE_S = 0.5
"""No target is sent on an older pose, seconds (design, section 6)."""
POSE_TIMEOUT_S = 1.0
"""An older pose makes the position unhealthy, seconds."""
VERDICT_AGE_S = 1.0
"""An older verdict is void, seconds."""


LINK_TIMEOUT_S = 3.0
"""Without a HEARTBEAT (1 Hz) for this time the link is lost, seconds."""
BATTERY_TIMEOUT_S = 5.0
"""A battery reading older than this is not known, seconds."""
DIAGNOSTICS_TIMEOUT_S = 5.0
RESULT_TIMEOUT_S = 2.0
"""Perception that is silent for this time is unhealthy, seconds."""
LOOP_LAG_LIMIT_S = 0.1
"""More lag of the loop than this is unhealthy, seconds."""


def usable_pose(pose: VehiclePose | None, age: float) -> VehiclePose | None:
    """Return the pose if it is young (0.5 s) and whole (finite map pose), else None; ``age`` in seconds."""
    if pose is None or age > TARGET_POSE_AGE_S or pose.map is None or not pose.map.is_finite():
        return None
    return pose


@dataclass(frozen=True, slots=True)
class DdcInputs:
    """Topics of the other rooms, given by the composition root."""

    park_lot_detected: Topic[bool]
    verdict: Topic[Verdict]
    path_plan: Topic[PathPlan]
    occupancy_map: Topic[OccupancyMap]
    footprint: Topic[tuple[MapPoint, ...]]
    vision_health: Topic[Health]
    mapper_health: Topic[Health]
    path_plan_health: Topic[Health]
    camera_health: Topic[Health]
    camera_check: Topic[Health]
    """Health of the camera by its pictures: frozen, turned, mirrored."""
    ground_step: Topic[GroundStep]
    """The drone's motion over ground, as the camera sees it and as the poses report it."""
    stall_size: Topic[StallSize]
    """Usual size of the stalls in a picture, by the reported height."""
    recording_health: Topic[Health]
    requests_health: Topic[Health]
    """Calls into MAVSDK that do not return make it unhealthy."""
    tasks_health: Topic[Health]
    """A long-running task that ended makes it unhealthy."""
    camera_time: Topic[float]
    """When the light of the latest picture was caught, seconds of the daemon's clock."""
    vision_rate: Topic[float]
    """Pictures worked on per second."""
    loop_lag: Topic[float]
    """Lag of the loop, seconds."""
    lots: Topic[LotsAhead]
    """The lots of the store, and the flight over the one that is surveyed again."""
    second_sender: Topic[str]
    """Words for a sender beside the autopilot; empty while there is none."""

    @classmethod
    def create(cls, clock: Callable[[], float]) -> DdcInputs:
        """Make a set of empty topics."""
        return cls(**{name: Topic(name, clock) for name in cls.__slots__})


class DdcTopicInterface:
    """Reads the latest values; publishes desired pose, state, fence, heights and home for the algorithms."""

    def __init__(self, vehicle: VehicleTopics, inputs: DdcInputs, clock: Callable[[], float]) -> None:
        self.vehicle = vehicle
        """The autopilot's topics, for those that must hear every message."""
        self._inputs = inputs
        self._clock = clock
        self.des_pose_pub: Topic[DesiredPose | None] = Topic("des_pose", clock)
        self.asked_place_pub: Topic[DesiredPose | None] = Topic("asked_place", clock)
        """The place of a Route Request: numbered apart from the desired poses."""
        self.curr_state_pub: Topic[StateName] = Topic("curr_state", clock)
        self.fence_pub: Topic[Fence] = Topic("fence", clock)
        self.heights_pub: Topic[HeightParameters] = Topic("heights", clock)
        self.home_pub: Topic[MapPoint] = Topic("home", clock)
        self.taken_plan_pub: Topic[str] = Topic("taken_plan", clock)
        """Id of the changed plan of the lot that who has control took last (`hawk.model.known_lot.PlanOffer`)."""
        self.doubt_pub: Topic[str] = Topic("doubt", clock)
        """Why the reported place is doubted; empty while it is not."""

    def init(self) -> None:
        """Nothing is desired yet, nor asked about."""
        self.des_pose_pub.publish(None)
        self.asked_place_pub.publish(None)

    @property
    def ground_step(self) -> Topic[GroundStep]:
        """The drone's motion over ground by the camera, for those that must hear every message."""
        return self._inputs.ground_step

    @property
    def stall_size(self) -> Topic[StallSize]:
        """Usual size of the stalls in a picture, for those that must hear every message."""
        return self._inputs.stall_size

    # -- the specification's access programs ---------------------------------------------------------------------

    def get_state(self) -> VehicleState:
        """Return the autopilot's state; a disconnected one before its first heartbeat."""
        return self.vehicle.state.value or VehicleState()

    def may_fly(self) -> bool:
        """Return True while the autopilot says "armed", and in every state of a flight.

        A HEARTBEAT that says "disarmed" may be a late one (`hawk.ddc.readings.belief`): alone it ends no flight.
        """
        state = self.curr_state_pub.value
        return self.get_state().armed or (state is not None and state not in GROUND_STATES)

    def get_global_pose(self) -> GlobalPose | None:
        """Return the pose in WGS-84 degrees and metres above sea level, None before the first one."""
        pose = self.vehicle.pose.value
        return None if pose is None else pose.global_

    def get_diagnostics(self) -> Diagnostics:
        """Return the autopilot's summary of its sensors; everything bad when it is old or never came."""
        return self.vehicle.diagnostics.fresh(DIAGNOSTICS_TIMEOUT_S) or Diagnostics()

    def get_battery_info(self) -> BatteryInfo | None:
        """Return the battery; None when its charge is unknown or older than 5 s."""
        battery = self.vehicle.battery.fresh(BATTERY_TIMEOUT_S)
        if battery is None or battery.percentage is None or not math.isfinite(battery.percentage):
            return None
        return battery

    def get_occupancy_map(self) -> OccupancyMap:
        """Return the map; an empty one before the first."""
        return self._inputs.occupancy_map.value or OccupancyMap()

    def get_lots_ahead(self) -> LotsAhead:
        """Return the lots of the store; none before it was read."""
        return self._inputs.lots.value or LotsAhead()

    def get_vision_health(self) -> Health:
        """Health of the Vision App; unhealthy when it said nothing lately."""
        return self._lately(self._inputs.vision_health)

    def get_mapper_health(self) -> Health:
        """Health of the Mapper App; unhealthy when it said nothing lately."""
        return self._lately(self._inputs.mapper_health)

    def get_path_plan_health(self) -> Health:
        """Health of the Path Plan App; unhealthy when it said nothing lately."""
        return self._lately(self._inputs.path_plan_health)

    # -- ours ----------------------------------------------------------------------------------------------------

    def get_part_healths(self) -> tuple[tuple[str, Health], ...]:
        """Return the health of every part under its name, in the order in which they depend on each other."""
        return (
            ("link", self._heard_link_health()),
            ("position", self.get_position_health()),
            ("camera", self.get_camera_health()),
            ("vision", self.get_vision_health()),
            ("mapper", self.get_mapper_health()),
            ("planner", self.get_path_plan_health()),
            ("recording", self.get_recording_health()),
            ("requests", self._inputs.requests_health.value or Health()),
            ("tasks", self._inputs.tasks_health.value or Health()),
            ("loop", self._loop_health()),
        )

    def get_link_health(self) -> Health:
        """Health of the link to the autopilot: whether it is heard."""
        state = self.vehicle.state.value
        if state is None:
            return Health.bad(say("No autopilot found yet."))
        if not state.connected or self.get_link_age() > LINK_TIMEOUT_S:
            return Health.bad(say("No word from the autopilot."))
        return Health()

    def get_second_sender(self) -> str:
        """Return words for a sender beside the autopilot; empty while there is none."""
        return self._inputs.second_sender.value or ""

    def get_position_health(self) -> Health:
        """Health of the position: fresh, and good by the autopilot's own judgement."""
        if self.get_pose_age() > POSE_TIMEOUT_S:
            return Health.bad(say("No position from the autopilot."))
        diagnostics = self.get_diagnostics()
        if diagnostics.estimator_fault:
            fault = diagnostics.estimator_fault
            return Health.bad(say("The autopilot does not trust its position: {fault}.", fault=fault))
        if not diagnostics.global_position_ok:
            return Health.bad(say("The autopilot trusts no position."))
        return Health()

    def get_camera_health(self) -> Health:
        """Health of the camera as it says itself; when it is well, as its pictures show it."""
        own = self._inputs.camera_health.value or Health.bad(say("No camera yet."))
        check = self._inputs.camera_check.value
        return own if not own.is_healthy or check is None or check == Health() else check

    def get_recording_health(self) -> Health:
        """Health of the recording, as it says itself."""
        return self._inputs.recording_health.value or Health.bad(say("No recording yet."))

    def get_link_age(self) -> float:
        """Return seconds since the autopilot's last heartbeat, infinite before the first."""
        state = self.vehicle.state.value
        return math.inf if state is None else max(0.0, self._clock() - state.time)

    def get_pose(self) -> VehiclePose | None:
        """Return the latest pose however old it is; ask `get_pose_age`."""
        return self.vehicle.pose.value

    def get_fresh_pose(self) -> VehiclePose | None:
        """Return the pose if it is young and whole enough to send a target on (0.5 s, finite map pose)."""
        return usable_pose(self.vehicle.pose.value, self.get_pose_age())

    def get_pose_age(self) -> float:
        """Return seconds since the moment of the latest pose, infinite when there is none."""
        pose = self.vehicle.pose.value
        return math.inf if pose is None else max(0.0, self._clock() - pose.time)

    def get_battery_age(self) -> float:
        """Return seconds since the last battery reading, infinite when there was none."""
        return self.vehicle.battery.age

    def get_fresh_verdict(self) -> Verdict | None:
        """Return the verdict on the desired pose if it is no older than 1 s."""
        return self._inputs.verdict.fresh(VERDICT_AGE_S)

    def get_asked_verdict(self) -> Verdict | None:
        """Return the verdict on the place of a Route Request if it is no older than 1 s."""
        plan = self._inputs.path_plan.fresh(VERDICT_AGE_S)
        return None if plan is None else plan.asked

    def get_heights(self) -> HeightParameters:
        """Return the travel heights in force; the defaults before the first."""
        return self.heights_pub.value or HeightParameters()

    def get_path_plan(self) -> PathPlan | None:
        """Return the plan if it is young enough to fly by."""
        return self._inputs.path_plan.fresh(RESULT_TIMEOUT_S)

    def get_path_plan_time(self) -> float:
        """Return when the last plan was published, seconds; minus infinity before the first."""
        latest = self._inputs.path_plan.latest
        return -math.inf if latest is None else latest.time

    def get_footprint(self) -> tuple[MapPoint, ...]:
        """Return the corners of what the camera sees now; empty when it is not known."""
        return self._inputs.footprint.fresh(RESULT_TIMEOUT_S) or ()

    def get_vision_rate(self) -> float | None:
        """Return the pictures worked on per second."""
        return self._inputs.vision_rate.value

    def get_camera_age(self) -> float | None:
        """Return the age of the latest picture's light, seconds."""
        captured = self._inputs.camera_time.value
        return None if captured is None else max(0.0, self._clock() - captured)

    def has_lot_word(self) -> bool | None:
        """Return True when a lot is in sight; None when vision is silent."""
        return self._inputs.park_lot_detected.fresh(RESULT_TIMEOUT_S)

    def _heard_link_health(self) -> Health:
        """Return the health that is shown: a second sender is a fault, but the autopilot is heard all the same."""
        health, second = self.get_link_health(), self.get_second_sender()
        return Health.bad(second) if health.is_healthy and second else health

    def _loop_health(self) -> Health:
        lag = self._inputs.loop_lag.value
        if lag is not None and lag > LOOP_LAG_LIMIT_S:
            return Health.bad(say("The program is {late:.0f} ms late.", late=lag * 1000))
        return Health()

    def _lately(self, topic: Topic[Health]) -> Health:
        health = topic.fresh(RESULT_TIMEOUT_S)
        if health is not None:
            return health
        return Health.bad(say("No result yet.") if topic.latest is None else say("No result lately."))
