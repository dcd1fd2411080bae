"""The senses of second witnesses: what they hear in flight, and that on the ground everything begins again."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.comm.autopilot.terrain import Terrain
from hawk.comm.autopilot.vehicle import VehicleTopics
from hawk.ddc.orders import ToExplore, ToHover, Transition
from hawk.ddc.readings.belief import Belief
from hawk.ddc.readings.instant import Instant
from hawk.ddc.readings.topic_interface import DdcInputs, DdcTopicInterface
from hawk.ddc.rules import guard
from hawk.ddc.rules.notices import WitnessNotices
from hawk.ddc.witnesses.witness import ALONE, ALONE_S, LOW_M, WitnessFacts, WitnessReading
from hawk.model.pictures import GroundStep, StallSize
from hawk.model.vehicle import CopterMode, GnssHeight, LandedState, VehicleState
from tests.manual_clock import ManualClock
from tests.unit.ddc.by_facts import made, texts
from tests.unit.ddc.written_facts import flying


class Rig:
    """The witnesses between topics of their own."""

    def __init__(self) -> None:
        self.clock = ManualClock(100.0)
        self.vehicle = VehicleTopics.create(self.clock)
        self.inputs = DdcInputs.create(self.clock)
        self.reading = WitnessReading(DdcTopicInterface(self.vehicle, self.inputs, self.clock))

    def be(self, *, armed: bool = True, landed: LandedState = LandedState.IN_AIR) -> None:
        now = self.clock()
        vehicle = VehicleState(True, armed, int(CopterMode.GUIDED), landed, now, now)
        self.reading.update(Instant(now, belief=Belief(vehicle)))

    def hear(self, ground: float = 2.0, doubt: str = "") -> None:
        """Hear the camera, GNSS and the rangefinder."""
        self.clock.advance(0.5)
        now = self.clock()
        self.inputs.ground_step.publish(GroundStep(now - 0.5, now, (1.0, 0.0), (1.0, 0.0), 0.0, 0.0, 20.0))
        self.vehicle.gnss_height.publish(GnssHeight(now, 120.0, 1.0, 120.0))
        self.vehicle.terrain.publish(Terrain(now, distance=18.0, ground=ground, most=50.0, doubt=doubt))

    def heard(self) -> tuple[bool, bool, bool]:
        """Return whether camera, GNSS and rangefinder were heard."""
        self.be()
        facts = self.reading.facts(Instant(self.clock()))
        assert (facts.height.by_camera is not None) is (facts.place.camera_age < 1.0)
        height = facts.height
        return height.by_camera is not None, height.by_gnss is not None, height.by_range is not None


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_before_take_off_only_gnss_is_heard(rig: Rig) -> None:
    rig.hear()
    assert rig.heard() == (False, True, False)


@pytest.mark.parametrize(
    ("armed", "landed"), [(True, LandedState.ON_GROUND), (False, LandedState.IN_AIR), (False, LandedState.ON_GROUND)]
)
def test_on_the_ground_everything_begins_again(rig: Rig, armed: bool, landed: LandedState) -> None:
    rig.be()
    rig.hear()
    rig.be(armed=armed, landed=landed)
    assert rig.heard() == (False, True, False)
    rig.be(armed=armed, landed=landed)
    rig.hear()
    assert rig.heard() == (False, True, False)


def test_in_the_air_all_are_heard(rig: Rig) -> None:
    rig.be()
    rig.hear()
    assert rig.heard() == (True, True, True)


def test_the_size_of_stalls_is_heard_in_the_air_only(rig: Rig) -> None:
    def size() -> float | None:
        for count in range(90):
            rig.clock.advance(0.5)
            rig.inputs.stall_size.publish(StallSize(rig.clock(), 2.5 if count < 75 else 5.0, 20.0))
        rig.be()
        return rig.reading.facts(Instant(rig.clock())).height.by_size

    assert size() is None
    assert size() == pytest.approx(10.0)
    rig.be(landed=LandedState.ON_GROUND)
    assert size() is None
    assert size() == pytest.approx(10.0)
    rig.reading.close()
    assert size() is None


def test_a_rangefinder_that_is_not_believed_is_not_heard(rig: Rig) -> None:
    rig.be()
    rig.hear(doubt="stuck")
    assert rig.heard() == (True, True, False)


def test_after_the_end_nothing_is_heard(rig: Rig) -> None:
    rig.be()
    rig.reading.close()
    rig.hear()
    assert rig.heard() == (False, False, False)


# -- a position without a second witness -------------------------------------------------------------------------------


@pytest.mark.fault(
    "the camera recognises no ground for 10 s in the air: a walk of GNSS would not be seen",
    "reported; the part `witness` is unhealthy; no task ends",
)
def test_a_camera_that_compares_nothing_for_ten_seconds_leaves_the_position_alone(rig: Rig) -> None:
    def alone() -> tuple[bool, dict[str, bool]]:
        rig.be()
        instant = Instant(rig.clock())
        parts = {name: health.is_healthy for name, health in rig.reading.parts(instant)}
        return rig.reading.facts(instant).is_alone, parts

    rig.be(landed=LandedState.ON_GROUND)
    assert rig.reading.parts(Instant(rig.clock())) == ()
    rig.clock.advance(60.0)
    rig.be(landed=LandedState.ON_GROUND)
    rig.clock.advance(ALONE_S - 0.1)
    assert alone() == (False, {"witness": True})
    rig.clock.advance(0.2)
    assert alone() == (True, {"witness": False})
    rig.hear()
    assert alone() == (False, {"witness": True})
    rig.clock.advance(ALONE_S)
    assert alone() == (True, {"witness": False})
    assert not rig.reading.facts(Instant(rig.clock())).doubt


@pytest.mark.parametrize(("height", "is_alone"), [(LOW_M - 0.1, False), (LOW_M, True)])
def test_a_drone_that_takes_off_or_lands_is_too_low_for_a_second_witness(
    rig: Rig, height: float, is_alone: bool
) -> None:
    for _ in range(2):
        rig.clock.advance(ALONE_S)
        now = rig.clock()
        vehicle = VehicleState(True, True, int(CopterMode.GUIDED), LandedState.IN_AIR, now, now)
        flown = flying(0.0).pose
        assert flown is not None
        pose = replace(flown, time=now, relative_altitude=height)
        rig.reading.update(Instant(now, belief=Belief(vehicle), pose=pose))
    assert rig.reading.facts(Instant(rig.clock())).is_alone is is_alone


def test_it_is_reported_once_and_so_is_its_end() -> None:
    reports, hover = WitnessNotices(), made(ToHover())
    facts = flying(0.0)
    blind = replace(facts, witness=WitnessFacts(unseen_s=ALONE_S))
    assert reports.tick(replace(facts, witness=WitnessFacts(unseen_s=ALONE_S - 0.1)), hover) == ()
    assert texts(reports.tick(blind, hover)) == [ALONE]
    assert reports.tick(blind, hover) == ()
    assert texts(reports.tick(facts, hover)) == ["The position has a second witness again."]
    reports.tick(blind, hover)
    down = replace(facts, vehicle=replace(facts.vehicle, landed=LandedState.ON_GROUND))
    assert reports.tick(down, hover) == (), "down, nobody misses it"


@pytest.mark.parametrize("transition", [ToExplore(), ToHover()])
def test_a_missing_witness_ends_nothing(transition: Transition) -> None:
    blind = replace(flying(0.0), witness=WitnessFacts(unseen_s=60.0))
    assert guard.reaction(blind, made(transition)) is None
