"""Facts written down by hand: a drone that holds at 30 m, all well, and what a test changes of it."""

from __future__ import annotations

from dataclasses import replace

from hawk.config.sections import FenceSettings, FlightSettings, HeightSettings, OperatorSettings
from hawk.ddc.acts import Act, Acts, Step
from hawk.ddc.battery.battery import BatteryFacts
from hawk.ddc.decider import Decider, Decision
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import circle, polygon_fence
from hawk.ddc.fence.plan import FencePlan
from hawk.ddc.orders import Transition
from hawk.ddc.readings.belief import GroundFacts
from hawk.ddc.readings.limits import LimitFacts
from hawk.ddc.readings.link import LinkFacts, VehicleEvent
from hawk.ddc.readings.operator import OperatorFacts
from hawk.ddc.readings.position import PositionFacts
from hawk.ddc.readings.remote_control import RemoteControlFacts
from hawk.ddc.readings.sight import SightFacts
from hawk.ddc.rules.kill import KillTokens
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import Health
from hawk.model.plans import HeightParameters
from hawk.model.poses import ArmPlace, GlobalPose, LocalPose, MapPoint, MapPose, VehiclePose
from hawk.model.vehicle import BatteryInfo, CopterMode, Diagnostics, LandedState, VehicleState

SETTINGS = DdcSettings(FlightSettings(), FenceSettings(), OperatorSettings(), HeightSettings(), 245)
DATUM = GlobalPose(43.26, -79.92, 100.0)
FENCE = polygon_fence(circle(MapPoint(0.0, 0.0), 150.0), 5.0, 100.0, 3.0)
PARTS = (
    "link",
    "position",
    "ground",
    "camera",
    "vision",
    "mapper",
    "planner",
    "recording",
    "requests",
    "tasks",
    "loop",
)


def pose(now: float, north: float = 0.0, east: float = 0.0, height: float = 30.0) -> VehiclePose:
    return VehiclePose(
        time=now,
        global_=DATUM,
        relative_altitude=height,
        local=LocalPose(north, east, -height),
        map=MapPose(north, east, height, 0.0, 0.0, 0.0),
        velocity=(0.0, 0.0, 0.0),
        roll=0.0,
        pitch=0.0,
        yaw=0.0,
    )


def flying(now: float, mode: int = CopterMode.GUIDED) -> Facts:
    """A drone in the air in GUIDED with an operator, everything fresh."""
    return Facts(
        now=now,
        vehicle=VehicleState(True, True, mode, LandedState.IN_AIR, now, now),
        ground=GroundFacts(True, LandedState.IN_AIR, 0.0),
        link=LinkFacts(is_up=True, age=0.1),
        position=PositionFacts(pose(now), 0.05, 0.0, 0.0, DATUM, _arm_place(), MapPoint(0.0, 0.0)),
        diagnostics=Diagnostics(True, True, True, True, 3, 16, 0.9, now, fence_on=True),
        battery=BatteryFacts(BatteryInfo(80.0, 12.0, 10.0, now), 0.5, cells=(3,)),
        limits=LimitFacts(HeightParameters(), FENCE, None, FencePlan("circle", (), 100.0), "", 97.0, FENCE),
        operator=OperatorFacts(True, True, frozenset({"ana"})),
        sight=SightFacts(lot=True),
        remote_control=RemoteControlFacts(age=0.1, channels=8, receiver=True, channel=5, pulse=1800),
        parts=tuple((name, Health()) for name in PARTS),
    )


def without_link(facts: Facts) -> Facts:
    return replace(facts, link=replace(facts.link, is_up=False, age=5.0))


def on_ground(facts: Facts) -> Facts:
    return replace(facts, vehicle=replace(facts.vehicle, armed=False, landed=LandedState.ON_GROUND))


def found(facts: Facts) -> Facts:
    return replace(facts, link=replace(facts.link, events=(VehicleEvent.FOUND,)))


def decider(now: float = 0.0) -> Decider:
    """A program that started on the ground and found the autopilot."""
    made = Decider(SETTINGS, KillTokens(), now)
    made.tick(found(on_ground(flying(now))))
    return made


def follow(program: Decider, facts: Facts, transition: Transition) -> Decision:
    """Make the state of a transition the active one, whatever the present one is."""
    return program._at_once(facts, lambda *_: Step(transition))


def of_kind(acts: Acts, *kinds: type[Act]) -> list[Act]:
    return [act for act in acts if isinstance(act, kinds)]


def _arm_place() -> ArmPlace:
    return ArmPlace(DATUM.latitude, DATUM.longitude, DATUM.altitude, 0.0, 0.0, 0.0)
