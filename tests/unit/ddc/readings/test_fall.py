"""A fall is not a landing: motors that went off in the air lock Arm until the operator clears it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest

from hawk.comm.protocol.commands import Arm, ClearKill, Kill
from hawk.ddc.acts import KeepFall, Log, Record
from hawk.ddc.readings.belief import Belief, BeliefReading, Motion
from hawk.ddc.readings.fall import FallReading, fall_words
from hawk.ddc.readings.instant import Instant
from hawk.ddc.rules.kill import KillSwitch
from hawk.model.operation import Fall, StateName
from hawk.model.poses import GlobalPose
from hawk.model.vehicle import CopterMode, LandedState, VehicleState
from tests.unit.ddc.fakes import UTC_START, Rig
from tests.unit.ddc.rules.test_kill import token_of
from tests.unit.ddc.written_facts import flying as flying_facts
from tests.unit.ddc.written_facts import pose

STEP_S = 0.05
HEARTBEAT_S = 1.0
LANDED_S = 0.2
G = 9.81
AIR, LANDING, GROUND = LandedState.IN_AIR, LandedState.LANDING, LandedState.ON_GROUND


def after(
    reading: FallReading, belief: Belief, now: float, place: GlobalPose | None = None, utc: float | None = None
) -> Fall | None:
    """Show it a moment; return the fall that it knows then."""
    posed = None if place is None else replace(pose(now), global_=place)
    age = math.inf if posed is None else 0.0
    reading.update(Instant(now, now if utc is None else utc, belief, pose=posed, pose_age=age))
    return reading.facts()


@dataclass
class World:
    """A drone, what its autopilot says of it (HEARTBEAT each second, landed state each 0.2 s), and what is believed."""

    height: float = 0.0
    """Metres above the arm place."""
    ground: float = 0.0
    """Height of the ground below."""
    drift: float = 0.0
    """The estimate shows so much more."""
    armed: bool = True
    phase: LandedState = GROUND
    heard: bool = True
    posed: bool = True
    now: float = 100.0
    climb: float = 0.0
    late_s: float = 0.0
    """Age of the first HEARTBEAT."""
    ground_reading: BeliefReading = field(default_factory=BeliefReading)
    reading: FallReading = field(default_factory=FallReading)
    fall: Fall | None = None
    said: VehicleState = field(default_factory=VehicleState)
    _moved: float = -1.0
    _seen: Motion = field(default_factory=Motion)

    def tick(self) -> Fall | None:
        self.now += STEP_S
        if self.heard:
            if self.now - self.said.time >= HEARTBEAT_S - 1e-6:
                self.said = replace(
                    self.said, connected=True, armed=self.armed, custom_mode=CopterMode.GUIDED, time=self.now
                )
            if self.now - self.said.landed_time >= LANDED_S - 1e-6:
                landed = self.phase if self.armed else GROUND  # ArduCopter: whatever it does
                self.said = replace(self.said, landed=landed, landed_time=self.now)
            if self.posed:
                self._moved, self._seen = self.now, Motion(self.height + self.drift, self.climb)
        fresh = self.now - self._moved <= 1.0
        belief = self.ground_reading.update(self.said, self._seen if fresh else Motion(), 0.0, self.now)
        place = GlobalPose(43.0, -79.0 + self.now * 1e-6, 100.0) if fresh else None
        self.fall = after(self.reading, belief, self.now, place, UTC_START + self.now)
        return self.fall

    def run(self, seconds: float, climb: float = 0.0, phase: LandedState | None = None) -> None:
        self.phase = self.phase if phase is None else phase
        for _ in range(round(seconds / STEP_S)):
            self.climb = climb
            self.height = max(self.ground, self.height + climb * STEP_S)
            self.tick()

    def drop(self, seconds: float) -> None:
        """Fall freely, and lie where it struck."""
        for _ in range(round(seconds / STEP_S)):
            self.climb -= G * STEP_S
            self.height += self.climb * STEP_S
            if self.height <= self.ground:
                self.height, self.climb = self.ground, 0.0
            self.tick()

    def take_off(self, height: float) -> None:
        self.run(3.0)
        self.run((height - self.height) / 2.5, climb=2.5, phase=AIR)
        self.run(5.0)

    def cut(self) -> None:
        self.armed = False

    def land(self, ground: float = 0.0, sink: float = 1.0, settle_s: float = 1.0) -> None:
        """Sink, stand, and disarm, as ArduCopter's LAND does."""
        self.ground = ground
        self.run((self.height - ground) / sink, climb=-sink, phase=LANDING)
        self.run(settle_s, phase=GROUND)
        self.cut()
        self.run(8.0)


BEATS = (0.0, 0.3, 0.65, 0.95)
"""Seconds between a HEARTBEAT and the disarming."""


@pytest.mark.fault(
    "the motors go off in the air, by another station, a switch, the crash check: at 1.6 to 60 m, climbing, "
    "sinking, landing, at any moment between two HEARTBEATs",
    "“Motors off in the air”, red, with height, place and UTC; Arm is locked until an operator clears it, "
    "after a restart too",
)
@pytest.mark.parametrize("beat", BEATS)
@pytest.mark.parametrize("height", [1.6, 2.0, 3.0, 5.0, 8.0, 17.7, 30.0, 60.0])
def test_motors_that_go_off_in_the_air_are_a_fall(height: float, beat: float) -> None:
    world = World()
    world.take_off(height)
    world.run(beat)
    world.cut()
    cut_at = world.now
    world.drop(8.0)
    assert world.fall is not None
    assert world.fall.at == pytest.approx(UTC_START + cut_at, abs=0.5)
    assert world.fall.height == pytest.approx(height, abs=0.6)
    assert world.fall.latitude == 43.0


@pytest.mark.fault(
    "the motors go off in the air, by another station, a switch, the crash check: at 1.6 to 60 m, climbing, "
    "sinking, landing, at any moment between two HEARTBEATs"
)
@pytest.mark.parametrize("climb", [3.0, -1.5, -2.4])
@pytest.mark.parametrize("phase", [AIR, LandedState.TAKING_OFF, LANDING])
def test_so_are_those_that_go_off_while_it_climbs_or_sinks(climb: float, phase: LandedState) -> None:
    world = World()
    world.take_off(15.0)
    world.run(2.0, climb=climb, phase=phase)
    height = world.height
    world.cut()
    world.drop(8.0)
    assert world.fall is not None
    assert world.fall.height == pytest.approx(height, abs=1.0)


@pytest.mark.fault(
    "the motors go off in the air, by another station, a switch, the crash check: at 1.6 to 60 m, climbing, "
    "sinking, landing, at any moment between two HEARTBEATs"
)
def test_a_crash_that_the_autopilot_ends_is_a_fall() -> None:
    """It tumbles with its motors on, strikes the ground, and is disarmed two seconds later."""
    world = World()
    world.take_off(12.0)
    world.drop(1.7)
    world.run(2.0)
    world.cut()
    world.run(8.0)
    assert world.fall is not None
    assert world.fall.height == pytest.approx(12.0, abs=0.6)


@pytest.mark.fault(
    "a landing on a hill, in a hollow, with a height that drifted by 13 m, or by a pilot who disarms at once",
    "“Landed”, no lock",
)
@pytest.mark.parametrize("beat", BEATS)
@pytest.mark.parametrize("sink", [0.5, 1.0, 1.5, 2.4])
@pytest.mark.parametrize(("ground", "drift"), [(0.0, 0.0), (6.0, 0.0), (-8.0, 0.0), (0.0, 13.0), (0.0, -13.0)])
def test_a_landing_is_none(ground: float, drift: float, sink: float, beat: float) -> None:
    """On level ground, on a hill, in a hollow, with a height that drifted."""
    world = World()
    world.take_off(20.0)
    world.drift = drift
    world.run(2.0 + beat)
    world.land(ground, sink)
    assert world.fall is None


@pytest.mark.fault(
    "a landing on a hill, in a hollow, with a height that drifted by 13 m, or by a pilot who disarms at once",
)
def test_a_pilot_lands_and_disarms_before_the_autopilot_notices_the_ground() -> None:
    world = World()
    world.take_off(20.0)
    world.run(20.0 / 2.4, climb=-2.4)
    world.run(0.2)
    world.cut()
    world.run(8.0)
    assert world.fall is None


def test_a_dive_that_is_caught_is_forgotten() -> None:
    world = World()
    world.take_off(60.0)
    world.run(6.0, climb=-6.0)
    world.run(6.0)
    world.land()
    assert world.fall is None


def test_a_disarmed_drone_that_keeps_its_height_and_never_landed_is_in_the_air() -> None:
    world = World()
    world.take_off(17.7)
    world.cut()
    world.run(8.0)
    assert world.fall is not None
    assert world.fall.height == pytest.approx(17.7, abs=0.1)


def test_drift_before_a_take_off_that_never_was_is_no_fall() -> None:
    world = World()
    world.run(4.0)
    world.drift = 8.0
    world.run(6.0)
    world.cut()
    world.run(8.0)
    assert world.fall is None


def test_a_height_that_jumps_is_no_fall() -> None:
    world = World()
    world.take_off(20.0)
    world.run(15.0, climb=-1.0, phase=LANDING)
    world.drift = -30.0
    world.land()
    assert world.fall is None


@pytest.mark.parametrize(("sink", "kept"), [(2.4, 10.0), (3.0, 20.0)])
def test_the_place_of_before_is_kept_while_it_sinks_faster_than_any_descent(sink: float, kept: float) -> None:
    """It is the height from which it fell: a fast descent may be the beginning of a fall."""
    world = World()
    world.take_off(20.0)
    world.run(10.0 / sink, climb=-sink)
    world.cut()
    world.climb = -3.5
    world.drop(5.0)
    assert world.fall is not None
    assert world.fall.height == pytest.approx(kept, abs=1.0)


def test_a_height_that_leaps_while_nothing_is_seen_is_no_fall() -> None:
    """61 m a second: no drone falls so fast."""
    world = World()
    world.take_off(20.0)
    world.run(15.0, climb=-1.0, phase=LANDING)
    world.heard = False
    world.run(1.5)
    world.drift = -92.0
    world.heard = True
    world.land()
    assert world.fall is None


@pytest.mark.fault(
    "the autopilot is not heard from 17.7 m on, and is disarmed when it is heard again",
    "within 12 s, faster than any landing: “Motors off in the air”; later: “Landed”",
)
@pytest.mark.parametrize(("silent_s", "falls"), [(2.0, True), (6.0, True), (11.0, True), (13.0, False), (60.0, False)])
@pytest.mark.parametrize("posed", [True, False])
def test_a_flight_whose_end_was_not_heard(silent_s: float, falls: bool, posed: bool) -> None:
    """17.7 m are 12 s of a landing: who is down earlier fell. ``posed``: poses come again with the link."""
    world = World()
    world.take_off(17.7)
    world.heard = False
    world.cut()
    world.drop(silent_s)
    world.heard, world.posed = True, posed
    world.height, world.climb = 0.0, 0.0
    world.run(1.0)
    assert (world.fall is not None) is falls


def test_the_height_above_another_arm_place_counts_for_nothing() -> None:
    reading, ground = FallReading(), BeliefReading()
    said = VehicleState(True, False, 0, GROUND, 1.0, 1.0)
    ground.update(said, Motion(0.0, 0.0), -50.0, 1.0)
    for index, armed in enumerate((True, True, True, False, False)):
        now = 2.0 + index * 0.1
        said = replace(said, armed=armed, time=now, landed=GROUND, landed_time=now)
        belief = ground.update(said, Motion(10.0, 0.0), -50.0, now)
        assert after(reading, belief, now) is None


def test_the_place_follows_it_for_some_seconds_and_arming_ends_it() -> None:
    world = World()
    world.take_off(10.0)
    world.cut()
    world.drop(3.0)
    first = world.fall
    world.run(1.0)
    then = world.fall
    assert first is not None
    assert then is not None
    assert (then.longitude or 0.0) > (first.longitude or 0.0)
    assert (then.at, then.height) == (first.at, first.height)
    world.run(10.0)
    later = world.fall
    world.run(10.0)
    assert world.fall == later
    world.armed = True
    world.run(2.0)
    assert world.fall is None


def test_the_place_follows_for_five_seconds_after_the_motors_went_off() -> None:
    reading, changed = FallReading(), []
    before: Fall | None = None
    for step in range(161):
        now = 1.0 + step / 16
        armed = now <= 5.0
        said = replace(flying_facts(now).ground, armed_said=armed, landed_said=AIR, landed_age=0.0)
        belief = Belief(VehicleState(True, armed, 4, AIR, now, now), said, Motion(10.0, 0.0))
        fall = after(reading, belief, now, GlobalPose(43.0, now, 100.0), UTC_START + now)
        if fall != before:
            changed.append(now)
        before = fall
    assert (changed[0], changed[-1]) == (5.0 + 1 / 16, 10.0 + 1 / 16)


def end_of_a_flight(*seen: tuple[float, float | None]) -> Fall | None:
    """Return what is found of a drone that was seen at these times at these heights, and is disarmed at the last one.

    It stands on the ground then, as far as it is seen.
    """
    reading = FallReading()
    ground = replace(flying_facts(0.0).ground, armed_said=True, landed_said=AIR, landed_age=0.0)
    for now, height in seen:
        belief = Belief(VehicleState(True, True, 4, AIR, now, now), ground, Motion(height, 0.0))
        assert after(reading, belief, now) is None
    now += 0.05
    belief = Belief(VehicleState(True, False, 4, GROUND, now, now), ground, Motion(height, 0.0))
    return after(reading, belief, now)


@pytest.mark.parametrize(("metres_a_second", "falls"), [(1.5, False), (1.6, True), (60.0, True), (61.0, False)])
def test_how_fast_a_drone_that_was_not_seen_came_down(metres_a_second: float, falls: bool) -> None:
    found = end_of_a_flight((10.0, 4.0 * metres_a_second), (14.0, 0.0))
    assert (found is not None) is falls


@pytest.mark.parametrize(("stood_s", "falls"), [(1.5, False), (1.4375, True)])
def test_a_drone_that_stood_armed_for_a_second_and_a_half_has_landed(stood_s: float, falls: bool) -> None:
    """Its height drifted, and the autopilot never said that it was landing."""
    reading = FallReading()
    air = replace(flying_facts(0.0).ground, armed_said=True, landed_said=AIR, landed_age=0.0)
    now = 10.0
    for said in (air, *(replace(air, landed_said=GROUND) for _ in range(round(stood_s * 16) + 1))):
        after(reading, Belief(VehicleState(True, True, 4, AIR, now, now), said, Motion(10.0, 0.0)), now)
        now += 1 / 16
    off = Belief(VehicleState(True, False, 4, GROUND, now, now), air, Motion(10.0, 0.0))
    assert (after(reading, off, now) is not None) is falls


def test_a_drone_that_climbed_fell_from_where_it_was() -> None:
    reading = FallReading()
    ground = replace(flying_facts(0.0).ground, armed_said=True, landed_said=AIR, landed_age=0.0)
    after(reading, Belief(VehicleState(True, True, 4, AIR, 10.0, 10.0), ground, Motion(10.0, 3.0)), 10.0)
    off = Belief(VehicleState(True, False, 4, AIR, 10.1, 10.1), ground, Motion(10.0, 0.0))
    found = after(reading, off, 10.1)
    assert found is not None
    assert found.height == 10.0


def test_a_height_that_is_not_known_is_no_drop() -> None:
    assert end_of_a_flight((10.0, None), (14.0, 0.0)) is None
    assert end_of_a_flight((10.0, 20.0), (14.0, None)) is None
    assert end_of_a_flight((10.0, 20.0), (11.0, 0.0)) is None, "it was seen all the time"


def test_nothing_is_judged_of_a_flight_of_which_nothing_was_seen() -> None:
    reading = FallReading()
    armed = Belief(VehicleState(True, True, 4, AIR, 1.0, 1.0), flying_facts(1.0).ground)
    assert after(reading, armed, 1.0) is None
    assert after(reading, replace(armed, vehicle=replace(armed.vehicle, armed=False)), 1.1) is None


def test_a_fall_of_an_earlier_run_lasts_until_the_next_arming() -> None:
    kept = Fall(UTC_START, 43.0, -79.0, 17.7)
    world = World(armed=False, reading=FallReading(kept))
    world.run(3.0)
    assert world.fall == kept


def test_words() -> None:
    assert fall_words(Fall(0.0)) == "1970-01-01 00:00:00 UTC"
    assert fall_words(Fall(0.0, 43.26, None)) == "1970-01-01 00:00:00 UTC"
    assert fall_words(Fall(0.0, height=3.0)) == "at 3.0 m, 1970-01-01 00:00:00 UTC"
    assert fall_words(Fall(0.0, 43.26, -79.92)) == "near 43.260000, -79.920000, 1970-01-01 00:00:00 UTC"
    assert (
        fall_words(Fall(60.0, 43.26, -79.92, 17.66)) == "at 17.7 m, near 43.260000, -79.920000, 1970-01-01 00:01:00 UTC"
    )


class TestTheLock:
    def test_a_fall_locks_once_and_stays_cleared(self) -> None:
        switch, fall = KillSwitch(), Fall(5.0, 43.0, -79.0, 10.0)
        facts = replace(flying_facts(1.0), fall=fall)
        assert switch.follow(flying_facts(1.0)) == ()
        kept, reported, record = switch.follow(facts)
        assert (kept, switch.fall, switch.is_killed, switch.state) == (KeepFall(fall), fall, True, "none")
        assert isinstance(reported, Log)
        assert reported.level == "error"
        assert isinstance(record, Record)
        assert dict(record.payload) == {"at": 5.0, "latitude": 43.0, "longitude": -79.0, "height": 10.0}
        assert switch.follow(facts) == ()
        moved = replace(fall, latitude=43.1)
        assert switch.follow(replace(facts, fall=moved)) == (KeepFall(moved),)
        assert switch.fall == moved
        assert switch.clear() == (KeepFall(None),)
        assert not switch.is_killed
        assert switch.follow(facts) == ()
        assert switch.clear() == ()
        assert KeepFall(Fall(9.0)) in switch.follow(replace(facts, fall=Fall(9.0)))

    def test_the_next_flight_of_another_station_does_not_clear_it(self) -> None:
        switch = KillSwitch()
        switch.follow(replace(flying_facts(1.0), fall=Fall(5.0)))
        assert switch.follow(flying_facts(2.0)) == ()
        assert switch.is_killed


async def fallen(rig: Rig) -> None:
    """Another station disarms the drone by force at 17.7 m."""
    drone = rig.autopilot
    drone.height = 17.7
    await rig.run(1.0)
    drone.say("Crash: Disarming", 2)
    drone.armed, drone.landed = False, LandedState.ON_GROUND
    await fall_down(rig)


async def fall_down(rig: Rig) -> None:
    """The motors are off: the drone falls to the ground."""
    drone, sink = rig.autopilot, 0.0
    drone.stuck = True
    while drone.height > 0.0:
        sink += G * STEP_S
        drone.height = max(0.0, drone.height - sink * STEP_S)
        drone.velocity = (0.0, 0.0, sink)
        drone.publish()
        rig.clock.advance(STEP_S)
        rig.manager.process()
    await rig.run(6.0)


class TestOnTheRealManager:
    @pytest.mark.slow
    async def test_motors_that_somebody_cut_in_the_air_are_shown_as_cut(
        self, flying: Rig, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        async def cut() -> None:
            flying.autopilot.armed, flying.autopilot.landed = False, LandedState.ON_GROUND

        monkeypatch.setattr(flying.autopilot, "kill", cut)
        flying.manager.handle_now("ana", Kill(token=token_of(flying)))
        await flying.tick(2)
        await fall_down(flying)
        status = flying.manager.status.value
        assert status is not None
        assert status.operation.checks[0].value.startswith("off in the air at "), "it fell, too"
        assert (status.operation.killed, status.operation.kill_state, status.operation.fallen) == (
            True,
            "confirmed",
            False,
        )

    @pytest.mark.slow
    @pytest.mark.fault(
        "the motors go off in the air, by another station, a switch, the crash check: at 1.6 to 60 m, "
        "climbing, sinking, landing, at any moment between two HEARTBEATs"
    )
    async def test_it_is_reported_in_red_and_arm_is_locked_until_it_is_cleared(self, flying: Rig) -> None:
        await fallen(flying)
        flying.expect(StateName.IDLE)
        assert not any("Landed" in text for text in flying.log)
        (reported,) = [entry for entry in flying.manager.log.entries if "in the air at" in entry.text]
        assert reported.level == "error"
        assert reported.text.startswith("Motors off in the air at 17.")
        assert reported.details == "Crash: Disarming"
        status = flying.manager.status.value
        assert status is not None
        assert status.operation.detail == "Motors off in the air."
        assert status.operation.killed
        assert status.operation.fallen
        motors = status.operation.checks[0]
        assert (motors.name, motors.passed, motors.remedy_command) == ("Motors", False, "Clear Kill")
        assert motors.value.startswith("off in the air at 17.")
        answer = flying.command(Arm())
        assert not answer.accepted
        assert answer.reason == "The motors went off in the air: look at the drone, then clear it."
        assert all(flying.kept_falls)
        flying.autopilot.stuck = False
        flying.order(ClearKill())
        assert flying.kept_falls[-1:] == [None]
        await flying.run(1.0)
        assert flying.command(Arm()).accepted

    @pytest.mark.fault(
        "the motors go off in the air, by another station, a switch, the crash check: at 1.6 to 60 m, "
        "climbing, sinking, landing, at any moment between two HEARTBEATs"
    )
    async def test_a_program_that_starts_again_keeps_the_lock(self, tmp_path: Path) -> None:
        kept = Fall(UTC_START, 43.26, -79.92, 17.7)
        rig = Rig(tmp_path, fall=kept)
        await rig.run(2.0)
        assert rig.kept_falls == [kept]
        assert not rig.command(Arm()).accepted
        (reported,) = [entry for entry in rig.manager.log.entries if "in the air" in entry.text]
        assert reported.level == "error"
        rig.order(ClearKill())
        await rig.run(1.0)
        assert rig.command(Arm()).accepted
        await rig.close()

    @pytest.mark.slow
    async def test_a_landing_locks_nothing(self, flying: Rig) -> None:
        flying.autopilot.change_mode(CopterMode.LAND)
        await flying.until(StateName.IDLE)
        await flying.run(6.0)
        assert flying.kept_falls == []
        assert flying.command(Arm()).accepted
