"""Armed and landed are believed only while they are young and nothing contradicts them."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.comm.protocol.commands import Arm, Disarm, Hold, Land, ReturnToLaunch, Takeoff
from hawk.ddc.readings.belief import BeliefReading, Motion
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode, LandedState, VehicleState
from tests.unit.ddc.fakes import Rig
from tests.unit.ddc.written_facts import pose

S = StateName


def late(rig: Rig, *, armed: bool | None = None, landed: LandedState | None = None) -> None:
    """Let a datagram of before come now, after those of this moment."""
    said = rig.autopilot.topics.state.value
    assert said is not None
    now = rig.clock()
    if armed is not None:
        said = replace(said, armed=armed, time=now)
    if landed is not None:
        said = replace(said, landed=landed, landed_time=now)
    rig.autopilot.topics.state.publish(said)
    rig.manager.process()


@pytest.mark.fault(
    "EXTENDED_SYS_STATE stops after Arm, the drone climbs",
    "State Arm is left for Hover: by height (3 m) or climb (1 m/s) at the next tick, else after 2 s; guard, "
    "Hold and RTL work; health part `ground` and one message within 0.5 s",
)
class TestTheLandedStateStopsAfterArm:
    """EXTENDED_SYS_STATE stops on the ground; somebody else takes the drone up to 8 m."""

    @pytest.fixture
    async def up(self, fresh: Rig) -> Rig:
        await fresh.enter(S.ARM)
        fresh.autopilot.landed_flows = False
        fresh.autopilot.climb_to = 8.0
        await fresh.run(6.0)
        assert fresh.autopilot.height == pytest.approx(8.0)
        return fresh

    @pytest.mark.slow
    async def test_it_is_in_the_air(self, up: Rig) -> None:
        up.expect(S.HOVER)
        assert "Not known to stand on the ground. Holding." in up.log
        assert up.manager.situation().facts.is_airborne
        up.order(Hold())
        up.order(ReturnToLaunch())
        await up.run(1.0)
        assert up.autopilot.mode == CopterMode.RTL

    @pytest.mark.slow
    async def test_the_guard_acts(self, up: Rig) -> None:
        up.desk.present = False
        await up.run(0.2)
        up.expect(S.COMMUNICATION_LOST)

    @pytest.mark.slow
    @pytest.mark.fault(
        "Disarm is asked for in the air while the landed state is old or wrong",
        "It is refused and never sent",
    )
    async def test_a_disarm_is_refused_and_never_sent(self, up: Rig) -> None:
        assert not up.command(Disarm()).accepted
        up.order(Land())
        await up.tick()
        assert not up.command(Disarm()).accepted
        await up.run(1.0)
        assert up.autopilot.count("disarm") == 0

    @pytest.mark.slow
    async def test_it_is_shown_and_the_flight_goes_on(self, up: Rig) -> None:
        shown = [text for text in up.log if text.endswith("It counts as in the air.")]
        assert len(shown) == 1
        assert shown[0].startswith("The autopilot says that it is on the ground, but")
        health = up.manager.situation().facts.health("ground")
        assert health.reason == "The autopilot does not say whether it is on the ground."
        assert all(health.is_healthy for name, health in up.manager.situation().facts.parts if name != "ground")
        up.autopilot.landed_flows = True
        await up.tick()
        assert up.manager.situation().facts.health("ground").is_healthy


class TestInTheAir:
    """The drone holds at 30 m; one word of before comes late, or goes on for ever."""

    async def test_one_late_disarmed_ends_no_flight(self, flying: Rig) -> None:
        late(flying, armed=False)
        flying.expect(S.HOVER)
        assert flying.manager.situation().facts.is_airborne
        await flying.run(1.0)
        flying.expect(S.HOVER)
        assert not any("Landed" in text for text in flying.log)

    @pytest.mark.fault(
        'One HEARTBEAT "disarmed" of before comes late in the air, with or without a late "on the ground"',
        "No state changes, no arm place moves",
    )
    async def test_a_late_disarmed_with_a_late_landed_ends_no_flight(self, flying: Rig) -> None:
        late(flying, armed=False, landed=LandedState.ON_GROUND)
        flying.expect(S.HOVER)
        assert not flying.manager.situation().facts.is_on_ground
        assert flying.command(Hold()).accepted

    async def test_the_mode_of_such_a_heartbeat_ends_no_task(self, fresh: Rig) -> None:
        await fresh.enter(S.COMPULSIVE_MOVE)
        late(fresh, armed=False)
        state = fresh.autopilot.topics.state.value
        assert state is not None
        fresh.autopilot.topics.state.publish(replace(state, custom_mode=CopterMode.STABILIZE))
        fresh.manager.process()
        fresh.expect(S.COMPULSIVE_MOVE)
        assert fresh.manager.situation().facts.is_guided
        await fresh.run(1.0)
        fresh.expect(S.COMPULSIVE_MOVE)

    @pytest.mark.fault(
        'The landed state says "on the ground" at 30 m for ever',
        "It is not believed; shown after 0.5 s; the flight goes on",
    )
    async def test_a_landed_state_that_lies_for_ever_is_a_fault_that_is_shown(self, flying: Rig) -> None:
        flying.autopilot.landed = LandedState.ON_GROUND
        await flying.run(1.0)
        flying.expect(S.HOVER)
        facts = flying.manager.situation().facts
        assert (facts.vehicle.landed, facts.ground.landed_said) == (LandedState.UNDEFINED, LandedState.ON_GROUND)
        assert facts.health("ground").reason == "The autopilot says that it is on the ground, but its height is 30 m."
        reported = flying.manager.status.value
        assert reported is not None
        assert reported.vehicle.landed == "UNDEFINED"
        flying.order(ReturnToLaunch())
        await flying.run(1.0)
        flying.expect(S.RETURN_TO_LAUNCH)

    async def test_it_goes_on_when_the_landed_state_stops(self, flying: Rig) -> None:
        flying.autopilot.landed_flows = False
        await flying.run(5.0)
        flying.expect(S.HOVER)
        facts = flying.manager.situation().facts
        assert facts.is_airborne
        assert facts.ground.landed_age == pytest.approx(5.0, abs=0.1)

    @pytest.mark.slow
    @pytest.mark.fault(
        "EXTENDED_SYS_STATE stops in flight",
        'The flight goes on, "in the air"; shown after 3 s; the landing ends 5 s after HEARTBEAT says "disarmed"',
    )
    async def test_without_the_landed_state_a_landing_ends_five_seconds_after_disarmed(self, flying: Rig) -> None:
        flying.autopilot.landed_flows = False
        await flying.run(3.0)
        flying.autopilot.armed, flying.autopilot.height = False, 0.0
        await flying.run(4.5)
        flying.expect(S.HOVER)
        await flying.run(1.0)
        flying.expect(S.IDLE)

    @pytest.mark.slow
    async def test_a_landing_is_believed_at_once(self, flying: Rig) -> None:
        flying.order(Land())
        await flying.until(S.IDLE)
        assert not flying.autopilot.armed
        assert flying.manager.situation().facts.ground.doubt == ""


class TestOnTheGround:
    @pytest.mark.slow
    @pytest.mark.fault(
        "Height drifts by metres on the ground",
        "State Arm stays; no doubt below 3 m above the arm place",
    )
    async def test_drift_does_not_make_a_standing_drone_fly(self, fresh: Rig) -> None:
        await fresh.enter(S.ARM)
        for height in (1.0, 2.5, -2.0, -6.0):
            fresh.autopilot.height = height
            fresh.autopilot.publish()
            await fresh.run(1.0)
            fresh.expect(S.ARM)
            assert fresh.manager.situation().facts.is_on_ground

    async def test_a_drone_in_the_air_by_its_height_leaves_arm(self, fresh: Rig) -> None:
        """The landed state goes on to say "on the ground", wrongly."""
        await fresh.enter(S.ARM)
        fresh.autopilot.height = 8.0
        await fresh.tick(2)
        fresh.expect(S.HOVER)
        assert fresh.command(ReturnToLaunch()).accepted

    @pytest.mark.slow
    async def test_a_hill_is_no_air(self, fresh: Rig) -> None:
        """Armed a second time 10 m higher: the height above the first arm place counts for nothing."""
        await fresh.enter(S.ARM)
        fresh.autopilot.armed = False
        await fresh.run(3.0)
        fresh.autopilot.height = 10.0
        await fresh.run(3.0)
        assert fresh.manager.situation().facts.is_on_ground
        fresh.autopilot.armed = True
        await fresh.run(1.0)
        fresh.expect(S.ARM)

    @pytest.mark.fault("No landed state before Arm", "Arm is refused")
    async def test_arm_is_refused_before_the_landed_state_is_heard(self, fresh: Rig) -> None:
        fresh.autopilot.landed = LandedState.UNDEFINED
        await fresh.run(3.0)
        answer = fresh.command(Arm())
        assert not answer.accepted
        assert "on the ground" in answer.reason

    async def test_a_disarm_while_arming_only_stops_the_arming(self, fresh: Rig) -> None:
        await fresh.run(2.0)
        fresh.autopilot.silent.add("arm")
        fresh.order(Arm())
        await fresh.run(0.3)
        fresh.autopilot.landed_flows = False
        await fresh.run(2.5)
        fresh.order(Disarm())
        fresh.expect(S.IDLE)
        assert fresh.autopilot.count("disarm") == 0

    async def test_taken_off_by_somebody_else_while_heights_are_saved(self, fresh: Rig) -> None:
        await fresh.enter(S.CONFIGURE)
        fresh.autopilot.put_in_air(8.0)
        await fresh.tick()
        fresh.expect(S.HOVER)

    @pytest.mark.slow
    async def test_a_take_off_that_the_landed_state_denies_is_seen_by_its_height(self, fresh: Rig) -> None:
        await fresh.enter(S.ARM)
        fresh.autopilot.landed_flows = False
        fresh.order(Takeoff())
        await fresh.until(S.HOVER)
        assert fresh.autopilot.height == pytest.approx(35.0, abs=2.0)


# -- the comparison alone ---------------------------------------------------------------------------------------------

AIR, GROUND = LandedState.IN_AIR, LandedState.ON_GROUND
UP = Motion(8.0, 0.0)
DOWN = Motion(0.0, 0.0)


def said(now: float, *, armed: bool, landed: LandedState, landed_time: float | None = None) -> VehicleState:
    return VehicleState(True, armed, CopterMode.GUIDED, landed, now, now if landed_time is None else landed_time)


def flown() -> BeliefReading:
    """A reading that saw a drone armed on the ground, then in the air, until 10 s."""
    reading = BeliefReading()
    reading.update(said(0.0, armed=False, landed=GROUND), DOWN, -math.inf, 0.0)
    reading.update(said(1.0, armed=True, landed=GROUND), DOWN, 1.0, 1.0)
    believed = reading.update(said(10.0, armed=True, landed=AIR), UP, 1.0, 10.0)
    assert (believed.vehicle.armed, believed.vehicle.landed, believed.ground.doubt) == (True, AIR, "")
    return reading


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        (Motion(8.0, 0.0), "its height is 8 m"),
        (Motion(3.1, None), "its height is 3 m"),
        (Motion(0.0, 1.1), "it climbs at 1.1 m/s"),
        (Motion(None, -1.5), "it sinks at 1.5 m/s"),
        (Motion(3.0, 1.0), ""),
        (Motion(-20.0, -1.0), ""),
        (Motion(), ""),
    ],
)
def test_height_and_climb_speak_against_the_ground(motion: Motion, words: str) -> None:
    believed = flown().update(said(11.0, armed=True, landed=GROUND), motion, 1.0, 11.0)
    assert believed.vehicle.landed is (LandedState.UNDEFINED if words else GROUND)
    assert believed.ground.doubt == (f"The autopilot says that it is on the ground, but {words}." if words else "")


def test_an_old_landed_is_unknown() -> None:
    reading = flown()
    believed = reading.update(said(12.0, armed=True, landed=GROUND, landed_time=10.0), DOWN, 1.0, 12.0)
    assert believed.vehicle.landed is GROUND
    believed = reading.update(said(12.1, armed=True, landed=GROUND, landed_time=10.0), DOWN, 1.0, 12.1)
    assert believed.vehicle.landed is LandedState.UNDEFINED
    assert believed.ground.doubt == "The autopilot does not say whether it is on the ground."
    assert believed.ground.landed_age == pytest.approx(2.1)


def test_an_old_landed_is_no_doubt_while_the_link_is_silent() -> None:
    believed = flown().update(said(10.0, armed=True, landed=AIR, landed_time=10.0), UP, 1.0, 14.0)
    assert (believed.vehicle.landed, believed.ground.doubt) == (LandedState.UNDEFINED, "")


@pytest.mark.parametrize(
    ("landed", "motion", "words"),
    [
        (AIR, DOWN, "also that it flies"),
        (LandedState.UNDEFINED, DOWN, "not that it is on the ground"),
        (GROUND, UP, "its height is 8 m"),
        (GROUND, Motion(0.0, 2.0), "it climbs at 2.0 m/s"),
    ],
)
def test_a_disarmed_that_something_contradicts_is_believed_after_five_seconds(
    landed: LandedState, motion: Motion, words: str
) -> None:
    reading = flown()
    for second in range(11, 16):
        believed = reading.update(said(float(second), armed=False, landed=landed), motion, 1.0, float(second))
        assert believed.vehicle.armed
        assert believed.ground.doubt == f"The autopilot says that it is disarmed, but {words}."
    assert not reading.update(said(16.0, armed=False, landed=landed), motion, 1.0, 16.0).vehicle.armed


def test_silence_does_not_make_a_disarmed_believed() -> None:
    reading = flown()
    last = said(11.0, armed=False, landed=AIR)
    assert all(reading.update(last, UP, 1.0, 11.0 + second).vehicle.armed for second in range(60))


def test_one_armed_begins_the_five_seconds_again() -> None:
    reading = flown()
    for second in range(11, 40):
        armed = second % 4 == 0
        assert reading.update(said(float(second), armed=armed, landed=AIR), UP, 1.0, float(second)).vehicle.armed


def test_a_fall_confirms_that_the_motors_are_off() -> None:
    reading = flown()
    falling = Motion(30.0, -4.5)
    believed = reading.update(said(11.0, armed=False, landed=GROUND), falling, 1.0, 11.0)
    assert not believed.vehicle.armed
    assert believed.vehicle.landed is LandedState.UNDEFINED, "it falls yet"


@pytest.mark.parametrize(
    ("climb", "is_fall"), [(-4.01, True), (-4.0, False), (0.0, False), (4.01, False), (None, False)]
)
def test_a_drone_that_sinks_faster_than_any_mode_falls(climb: float | None, is_fall: bool) -> None:
    assert Motion(30.0, climb).is_fall is is_fall
    believed = flown().update(said(11.0, armed=False, landed=GROUND), Motion(30.0, climb), 1.0, 11.0)
    assert believed.vehicle.armed is not is_fall


@pytest.mark.parametrize(("published", "counts"), [(19.0, True), (18.99, False)])
def test_an_arm_place_of_a_second_before_armed_is_of_this_flight(published: float, counts: bool) -> None:
    reading = BeliefReading()
    reading.update(said(0.0, armed=False, landed=GROUND), DOWN, -math.inf, 0.0)
    believed = reading.update(said(20.0, armed=True, landed=GROUND), UP, published, 20.0)
    assert believed.vehicle.landed is (LandedState.UNDEFINED if counts else GROUND)


def test_of_a_drone_that_was_armed_before_its_first_word_every_arm_place_counts() -> None:
    believed = BeliefReading().update(said(50.0, armed=True, landed=GROUND), UP, 0.0, 50.0)
    assert believed.vehicle.landed is LandedState.UNDEFINED


def test_a_doubt_is_timed_from_its_beginning_and_the_next_one_begins_again() -> None:
    reading = flown()
    words = ((11.0, AIR), (12.0, GROUND), (14.5, GROUND), (15.0, AIR), (16.0, GROUND), (16.5, GROUND))
    beliefs = [reading.update(said(now, armed=True, landed=landed), UP, 1.0, now) for now, landed in words]
    assert [bool(belief.ground.doubt) for belief in beliefs] == [False, True, True, False, True, True]
    assert [belief.ground.doubted_s for belief in beliefs] == [0.0, 0.0, 2.5, 0.0, 0.0, 0.5]


def test_the_first_word_is_believed() -> None:
    for armed in (True, False):
        believed = BeliefReading().update(said(5.0, armed=armed, landed=AIR), UP, -math.inf, 5.0)
        assert believed.vehicle.armed is armed
        assert bool(believed.ground.doubt) is not armed


def test_before_the_first_heartbeat_nothing_is_doubted() -> None:
    believed = BeliefReading().update(VehicleState(), Motion(), -math.inf, 5.0)
    assert (believed.vehicle, believed.ground.doubt) == (VehicleState(), "")


def test_an_old_pose_and_one_that_is_not_finite_say_nothing() -> None:
    here = pose(10.0, height=8.0)
    assert Motion.of(here, 1.0) == Motion(8.0, 0.0)
    assert Motion.of(here, 1.1) == Motion.of(None, 0.0) == Motion()
    broken = replace(here, relative_altitude=math.nan, velocity=(0.0, 0.0, math.inf))
    assert Motion.of(broken, 0.0) == Motion()


@pytest.mark.slow
@pytest.mark.fault(
    "Late, repeated, reordered HEARTBEAT and EXTENDED_SYS_STATE in any order while the height is known",
    'Never "disarmed", never "on the ground"',
)
@given(
    words=st.lists(
        st.tuples(
            st.sampled_from([0.0, 0.05, 0.3]),  # seconds to the next datagram
            st.sampled_from(["true", "late", "repeated"]),
            st.booleans(),
            st.sampled_from(LandedState),
        ),
        min_size=10,
        max_size=60,
    ),
    height=st.floats(3.1, 120.0),
    climb=st.floats(-3.0, 3.0),
)
def test_no_order_of_datagrams_lands_a_drone_that_flies(
    words: list[tuple[float, str, bool, LandedState]], height: float, climb: float
) -> None:
    """Late words say anything; a true HEARTBEAT and landed state come at least every second."""
    reading = flown()
    now, truth, heard = 10.0, 10.0, said(10.0, armed=True, landed=AIR)
    for wait, kind, armed, landed in words:
        now += wait
        if kind == "true" or now - truth > 1.0:
            truth, heard = now, said(now, armed=True, landed=AIR)
        elif kind == "late":
            heard = replace(heard, armed=armed, landed=landed, time=now, landed_time=now)
        # a repeated datagram brings what was heard already
        believed = reading.update(heard, Motion(height, climb), 1.0, now).vehicle
        assert believed.armed
        assert believed.landed is not GROUND


@pytest.mark.slow
@given(
    heights=st.lists(st.floats(-8.0, 2.9), min_size=5, max_size=40),
    climbs=st.lists(st.floats(-0.9, 0.9), min_size=40, max_size=40),
    armed=st.lists(st.booleans(), min_size=40, max_size=40),
)
def test_no_drift_lifts_a_drone_that_stands(heights: list[float], climbs: list[float], armed: list[bool]) -> None:
    reading = BeliefReading()
    for step, height in enumerate(heights):
        now = 0.2 * step
        heard = said(now, armed=armed[step], landed=GROUND)
        believed = reading.update(heard, Motion(height, climbs[step]), now, now)
        assert believed.vehicle == heard
        assert believed.ground.doubt == ""
