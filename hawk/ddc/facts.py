"""Facts: everything that decides, as one tick believes it.

One frozen value holds the readings, their ages and the answers to requests. States, guard, judge, preflight and status
are functions of it. `hawk.ddc.senses` gathers it; nothing else reads a topic to decide.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from hawk.ddc.battery.battery import BatteryFacts
from hawk.ddc.readings.belief import GroundFacts
from hawk.ddc.readings.limits import LimitFacts
from hawk.ddc.readings.link import LinkFacts
from hawk.ddc.readings.operator import NO_OPERATOR, OperatorFacts
from hawk.ddc.readings.position import PositionFacts
from hawk.ddc.readings.remote_control import NO_REMOTE_CONTROL, RemoteControlFacts
from hawk.ddc.readings.remote_id import NO_REMOTE_ID, RemoteIdFacts
from hawk.ddc.readings.sight import SightFacts
from hawk.ddc.readings.topic_interface import POSE_TIMEOUT_S, usable_pose
from hawk.ddc.readings.wind import WindFacts
from hawk.ddc.witnesses.witness import WitnessFacts
from hawk.model.known_lot import LotsAhead
from hawk.model.operation import Fall, Health
from hawk.model.plans import Inbound, Verdict
from hawk.model.poses import GlobalPose, MapPose, VehiclePose
from hawk.model.sentences import say
from hawk.model.vehicle import CopterMode, Diagnostics, LandedState, VehicleState


@dataclass(frozen=True, slots=True)
class Answer:
    """Outcome of one request. ``asked``: time of the request, seconds. ``value``: a parameter that was read."""

    name: str
    asked: float
    status: Literal["pending", "done", "failed"]
    reason: str = ""
    """The autopilot's words when it refused."""
    value: float | None = None

    @property
    def is_pending(self) -> bool:
        """True until the answer arrives."""
        return self.status == "pending"

    @property
    def is_done(self) -> bool:
        """True after a positive answer."""
        return self.status == "done"

    @property
    def has_failed(self) -> bool:
        """True after a refusal, or when no answer came."""
        return self.status == "failed"


@dataclass(frozen=True, slots=True)
class KeptFacts:
    """The state of everything that we set in the autopilot, as the keeper found it (`hawk.ddc.keeper`)."""

    lost: str = ""
    """Things that cannot be put back, in words; empty: none."""
    astray: str = ""
    """Reason why the autopilot's RTL would not end at home; empty when it would, as far as is known."""
    astray_ago: float = math.inf
    """Seconds since it would not have ended at home; 0 while it would not."""
    restored: tuple[str, ...] = ()
    """Names of the checks whose parameters are being put back."""
    known: tuple[str, ...] = ()
    """The same, and those whose parameters are put back once no pilot flies."""

    @property
    def lost_words(self) -> str:
        """One sentence on what cannot be put back; empty: nothing."""
        if not self.lost:
            return ""
        return say("Somebody changes the autopilot, and it cannot be put back: {lost}.", lost=self.lost)


@dataclass(frozen=True, slots=True)
class Facts:
    """All facts of one moment. Times in seconds of the daemon's clock, lengths in metres, map frame."""

    now: float
    utc: float = 0.0
    """Wall clock, Unix seconds."""
    vehicle: VehicleState = VehicleState()
    """The autopilot's state as it is believed (`hawk.ddc.readings.belief`); disconnected before the first HEARTBEAT."""
    ground: GroundFacts = GroundFacts()
    link: LinkFacts = LinkFacts()
    position: PositionFacts = field(default_factory=PositionFacts)
    diagnostics: Diagnostics = Diagnostics()
    battery: BatteryFacts = field(default_factory=BatteryFacts)
    wind: WindFacts = field(default_factory=WindFacts)
    witness: WitnessFacts = field(default_factory=WitnessFacts)
    """Second witnesses of the place."""
    limits: LimitFacts = field(default_factory=LimitFacts)
    operator: OperatorFacts = NO_OPERATOR
    sight: SightFacts = field(default_factory=SightFacts)
    remote_control: RemoteControlFacts = NO_REMOTE_CONTROL
    remote_id: RemoteIdFacts = NO_REMOTE_ID
    parts: tuple[tuple[str, Health], ...] = ()
    """Health of every part by name, in the order of dependence."""
    answers: tuple[Answer, ...] = field(default=())
    """Requests under way, and those that ended lately."""
    target_refusal: str = ""
    """Reason why the last target was not sent; empty when it was."""
    parameters: tuple[tuple[str, float], ...] = ()
    """Latest values that the autopilot sent, to us or to another station, of the parameters that decide."""
    fall: Fall | None = None
    """The last flight ended with its motors off in the air; None while armed, and after a landing."""
    starts_in_air: int | None = None
    """Starts in the air within the restart window, this one included; None until they are counted."""
    lots: LotsAhead = field(default_factory=LotsAhead)
    """Lots that can be surveyed again."""
    kept: KeptFacts = KeptFacts()
    """The keeper's word; the decider adds it to what the senses gathered."""

    @property
    def is_astray(self) -> bool:
        """True while the autopilot's RTL would not end at home, as far as is known."""
        return bool(self.kept.astray) or self.position.autopilot_home.is_moved

    @property
    def is_airborne(self) -> bool:
        """True when the drone is believed armed and not believed on the ground."""
        return self.vehicle.armed and not self.is_on_ground

    @property
    def is_on_ground(self) -> bool:
        """True when the ground is believed; an unknown, old or contradicted landed state is "in the air"."""
        return self.vehicle.landed is LandedState.ON_GROUND

    @property
    def is_unheard(self) -> bool:
        """True when the drone was armed when last heard, and is not heard now."""
        return self.vehicle.armed and not self.link.is_up

    @property
    def is_guided(self) -> bool:
        """True when the last HEARTBEAT shows GUIDED."""
        return self.vehicle.custom_mode == CopterMode.GUIDED

    @property
    def pose(self) -> VehiclePose | None:
        """The pose if it is young (0.5 s) and whole (finite map pose), else None."""
        return usable_pose(self.position.pose, self.position.age)

    @property
    def place(self) -> MapPose | None:
        """Map pose of `pose`."""
        pose = self.pose
        return None if pose is None else pose.map

    @property
    def last_place(self) -> MapPose | None:
        """The latest map pose, of any age: for display."""
        pose = self.position.pose
        return None if pose is None else pose.map

    @property
    def global_place(self) -> GlobalPose | None:
        """The latest pose in WGS-84, of any age."""
        pose = self.position.pose
        return None if pose is None else pose.global_

    @property
    def height(self) -> float | None:
        """Metres above the arm place; None before the first arm, and while there is no pose of the last second."""
        pose = self.position.pose
        return None if pose is None or self.position.age > POSE_TIMEOUT_S else pose.relative_altitude

    @property
    def height_over_ground(self) -> float | None:
        """Metres above the ground below; None without a rangefinder that is believed."""
        height, ground = self.height, self.position.below.ground
        return None if height is None or ground is None else height - ground

    @property
    def is_breached(self) -> bool:
        """True while the drone is beyond our fence or ceiling."""
        return self.limits.breached_s is not None

    def health(self, part: str) -> Health:
        """Return the health of a part; unhealthy when the part is unknown."""
        return next((health for name, health in self.parts if name == part), Health.bad(say("not known")))

    def ceiling(self, on_ground: bool) -> float:
        """Return our ceiling, metres above the arm place.

        In the air it is that of the fence in force, on the ground that of the planned fence.
        """
        fence = self.limits.fence
        return self.limits.planned_ceiling if on_ground or fence is None else fence.ceiling

    def verdict(self, number: int) -> Verdict | None:
        """Return the fresh verdict on the desired pose of that number."""
        verdict = self.sight.verdict
        return verdict if verdict is not None and verdict.number == number else None

    def is_confirmed_inside(self, number: int) -> bool:
        """Return True when a fresh verdict on that number says inside and has a route."""
        verdict = self.verdict(number)
        return verdict is not None and verdict.inbound is Inbound.INSIDE and not verdict.route.refused

    def answer(self, name: str, asked: float) -> Answer:
        """Return the outcome of the request of that name and time.

        A request that is not known any more has failed: nothing waits for ever.
        """
        for answer in self.answers:
            if answer.name == name and answer.asked == asked:
                return answer
        return Answer(name, asked, "pending") if asked >= self.now else Answer(name, asked, "failed", say("no answer"))
