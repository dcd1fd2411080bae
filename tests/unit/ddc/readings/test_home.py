"""Home that another station moves: watched, compared, reported, set back, and never flown to outside the fence."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.comm.protocol.commands import Arm, CompulsiveMove, Hold, Land, Resume, ReturnToLaunch, Takeoff
from hawk.comm.topic import Stamped, Topic
from hawk.ddc.acts import Ask, Log, SetHome, SetMode
from hawk.ddc.battery.energy import seconds_home
from hawk.ddc.facts import Facts
from hawk.ddc.keeper.keeper import KeptHome
from hawk.ddc.orders import Cause, CauseKind, ToLand, ToReturn
from hawk.ddc.readings.belief import Belief
from hawk.ddc.readings.home import HOME_TOLERANCE_M, HomeFacts, HomeReading, home_health
from hawk.ddc.readings.instant import Instant
from hawk.ddc.states.base import astray, returning
from hawk.ddc.states.hover import HoverState
from hawk.model.operation import StateName as S
from hawk.model.plans import Fence
from hawk.model.poses import ArmPlace, GlobalPose
from hawk.model.vehicle import CopterMode, LandedState, VehicleState
from tests.unit.ddc.fakes import PLACE, Rig
from tests.unit.ddc.test_decider import asked
from tests.unit.ddc.written_facts import DATUM, FENCE, SETTINGS, decider, flying, found, of_kind

METRE = 1 / 111_097.0
"""Degrees of latitude."""
FAR = HomeFacts(GlobalPose(DATUM.latitude + 300 * METRE, DATUM.longitude, 100.0), 0.1, 300.0, 5.0, is_inside=False)
NEAR = replace(FAR, place=GlobalPose(DATUM.latitude + 60 * METRE, DATUM.longitude, 100.0), away=60.0, is_inside=True)


def north_of(place: GlobalPose, metres: float, up: float = 0.0) -> GlobalPose:
    return GlobalPose(place.latitude + metres * METRE, place.longitude, place.altitude + up)


def with_home(facts: Facts, home: HomeFacts) -> Facts:
    return replace(facts, position=replace(facts.position, autopilot_home=home))


def move_home(rig: Rig, metres: float = 300.0, up: float = 0.0) -> None:
    """Move home as another station does."""
    rig.autopilot.move_home(north_of(PLACE, metres, up))


def away(rig: Rig) -> float:
    """Return how far the autopilot's home is from the arm place, metres."""
    home = rig.autopilot.home
    assert home is not None
    return abs(home.latitude - PLACE.latitude) / METRE


# -- set back -------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.fault(
    "another station moves home in flight (300 m, or up or down)",
    'reported, set back at once (repeated each second), "again at the arm place" after it held 3 s',
)
async def test_a_home_that_was_moved_in_flight_is_set_back_to_the_arm_place(flying: Rig) -> None:
    await flying.run(1)
    move_home(flying)
    await flying.tick(2)
    assert "Home was moved. Home is 300 m from the arm place, outside the fence. Setting it back." in flying.log
    assert flying.autopilot.asked("set_home") == [GlobalPose(PLACE.latitude, PLACE.longitude, PLACE.altitude)]
    assert away(flying) < 0.01
    flying.expect(S.HOVER)
    await flying.run(3.1)
    assert flying.log[-1] == "Home is at the arm place again."
    await flying.run(5)
    assert flying.autopilot.count("set_home") == 1


@pytest.mark.parametrize("up", [60.0, -60.0])
async def test_a_home_that_was_moved_up_or_down_is_set_back(flying: Rig, up: float) -> None:
    await flying.run(1)
    move_home(flying, 0.0, up)
    await flying.tick(2)
    assert "Home is 60 m from the arm place, outside the fence." in flying.log[-1]
    assert flying.autopilot.home == GlobalPose(PLACE.latitude, PLACE.longitude, PLACE.altitude)


async def test_a_home_within_the_tolerance_is_left_alone(flying: Rig) -> None:
    await flying.run(1)
    move_home(flying, HOME_TOLERANCE_M - 0.2)
    await flying.run(5)
    assert flying.autopilot.count("set_home") == 0
    assert not any("Home" in line for line in flying.log)


@pytest.mark.nightly
async def test_a_home_that_is_not_taken_is_sent_once_a_second_and_reported_after_three(flying: Rig) -> None:
    await flying.run(1)
    flying.autopilot.keeps_home = False
    move_home(flying)
    await flying.run(2.9)
    assert flying.autopilot.count("set_home") == 3
    assert not any("stays moved" in line for line in flying.log)
    await flying.run(0.3)
    assert "Home stays moved: the drone lands where it would return by itself." in flying.log
    assert not flying.manager.situation().facts.health("home").is_healthy
    await flying.run(10)
    assert sum("stays moved" in line for line in flying.log) == 1
    assert sum("was moved" in line for line in flying.log) == 1


@pytest.mark.nightly
async def test_a_station_that_moves_it_again_and_again_does_not_fill_the_log(flying: Rig) -> None:
    await flying.run(1)
    for _ in range(10):
        move_home(flying)
        await flying.run(1.0)
    assert away(flying) < 0.01
    assert sum("was moved" in line for line in flying.log) == 1


@pytest.mark.slow
@pytest.mark.fault("home moved while a pilot flies", "reported, nothing sent; set back at Resume")
async def test_while_a_pilot_flies_home_is_only_reported(fresh: Rig) -> None:
    await fresh.enter(S.MANUAL)
    move_home(fresh)
    await fresh.run(5)
    assert fresh.autopilot.count("set_home") == 0
    assert "Home was moved. Home is 300 m from the arm place, outside the fence." in fresh.log
    fresh.order(Resume(confirmed=True))
    await fresh.run(1)
    assert fresh.autopilot.count("set_home") == 1
    assert away(fresh) < 0.01


@pytest.mark.nightly
async def test_on_the_ground_disarmed_nothing_is_set(rig: Rig) -> None:
    move_home(rig)
    await rig.run(5)
    assert rig.autopilot.count("set_home") == 0


@pytest.mark.slow
@pytest.mark.fault("home set by another station before Arm (locked: arming does not move it)")
async def test_a_home_that_arming_does_not_move_is_set_before_takeoff(rig: Rig) -> None:
    """A home that another station set stays at the arming (ArduCopter locks it)."""
    rig.order(Arm())
    await rig.until(S.ARM)
    await rig.run(0.2)
    rig.autopilot.keeps_home = False
    move_home(rig, 60.0)
    await rig.run(0.5)
    refused = rig.command(Takeoff())
    assert not refused.accepted
    assert refused.reason == "Home is 60 m from the arm place. It is being set back: wait."
    rig.autopilot.keeps_home = True
    await rig.run(1.0)
    rig.order(Takeoff())


# -- return ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.fault("home is moved and not set back for 10 s", "new tasks are refused at once, then the flight ends")
async def test_a_home_that_stays_moved_refuses_tasks_and_ends_the_flight(flying: Rig) -> None:
    await flying.run(1)
    flying.autopilot.keeps_home = False
    move_home(flying, 40.0)
    await flying.run(1.1)
    assert flying.command(CompulsiveMove(x=20.0, y=0.0)).reason.endswith("It is being set back: wait.")
    await flying.run(8.5)
    flying.expect(S.HOVER)
    await flying.run(1.5)
    assert flying.state is not S.HOVER
    assert any("it cannot be put back: its home" in text for text in flying.log)


@pytest.mark.nightly
async def test_a_return_waits_until_home_is_back(flying: Rig) -> None:
    await flying.run(1)
    flying.autopilot.keeps_home = False
    move_home(flying)
    flying.order(ReturnToLaunch())
    await flying.run(1.5)
    flying.expect(S.RETURN_TO_LAUNCH)
    assert flying.detail == "Returning home: home was moved, it is set back first."
    assert flying.autopilot.mode == CopterMode.GUIDED
    flying.autopilot.keeps_home = True
    await flying.run(1.2)
    assert flying.autopilot.mode == CopterMode.RTL


@pytest.mark.slow
@pytest.mark.fault(
    "home cannot be set back and lies outside the fence; the drone returns by itself",
    "reported after 3 s; led home by targets 3 s after the return began, Land there",
)
async def test_a_return_by_itself_lands_where_home_stays_outside_the_fence(flying: Rig) -> None:
    await flying.run(1)
    flying.autopilot.keeps_home = False
    move_home(flying)
    await flying.run(5)
    flying.desk.present = False
    await flying.until(S.LAND)
    assert CopterMode.RTL not in flying.autopilot.asked("set_mode")
    assert flying.log[-1].endswith("Home is 300 m from the arm place, outside the fence. Landing.")


@pytest.mark.slow
@pytest.mark.fault(
    "home cannot be set back, outside the fence or inside; the operator returns",
    "reported after 3 s; led home by targets 3 s after the return began, Land there",
)
@pytest.mark.parametrize("metres", [300.0, 60.0], ids=["outside", "inside"])
async def test_where_home_stays_moved_the_operators_return_is_led_home_and_lands_there(
    flying: Rig, metres: float
) -> None:
    flying.order(CompulsiveMove(x=40.0, y=0.0))
    await flying.until(S.HOVER)
    flying.autopilot.keeps_home = False
    move_home(flying, metres)
    flying.order(ReturnToLaunch())
    await flying.run(4)
    flying.expect(S.RETURN_TO_LAUNCH)
    assert flying.autopilot.mode == CopterMode.GUIDED
    assert "The autopilot's return would not end at home: leading it there." in flying.log
    await flying.until(S.LAND, 60)
    await flying.until(S.IDLE, 90)
    assert math.hypot(flying.autopilot.north, flying.autopilot.east) < 3.0
    assert CopterMode.RTL not in flying.autopilot.asked("set_mode")


@pytest.mark.fault(
    "home cannot be set back, and the drone cannot be led (no position, no charge)",
    "Land where it is; Hover with the reason when the operator asked",
)
async def test_where_it_cannot_be_led_the_operators_return_holds(flying: Rig) -> None:
    await flying.run(1)
    flying.autopilot.keeps_home = False
    flying.autopilot.position_good = False
    move_home(flying)
    flying.order(ReturnToLaunch())
    await flying.run(3.5)
    flying.expect(S.HOVER)
    assert "outside the fence. Land, or move the drone. Holding." in flying.log[-1]
    flying.order(Land())
    await flying.run(0.2)
    assert flying.autopilot.mode == CopterMode.LAND


@pytest.mark.slow
@pytest.mark.fault(
    "the autopilot's RTL began with a moved home, home is back",
    "BRAKE, then RTL again: home as it is at the begin of RTL counts",
)
async def test_an_rtl_of_the_autopilot_that_began_with_a_moved_home_begins_again(flying: Rig) -> None:
    """RTL flies to home as it was when RTL began, whatever it is set to later."""
    await flying.run(1)
    flying.autopilot.keeps_home = False
    move_home(flying)
    flying.autopilot.change_mode(CopterMode.RTL)
    await flying.run(1.5)
    flying.expect(S.RETURN_TO_LAUNCH)
    flying.autopilot.keeps_home = True
    await flying.run(3)
    assert flying.autopilot.asked("set_mode")[-2:] == [CopterMode.BRAKE, CopterMode.RTL]
    flying.expect(S.RETURN_TO_LAUNCH)
    await flying.until(S.IDLE, 90)
    assert abs(flying.autopilot.north) < 1.0


@pytest.mark.slow
@pytest.mark.fault(
    "home cannot be set back and lies outside the fence; the autopilot's own RTL",
    "led home after 3 s, Land there",
)
async def test_an_rtl_of_the_autopilot_to_a_home_that_stays_outside_ends_by_landing(flying: Rig) -> None:
    await flying.run(1)
    flying.autopilot.keeps_home = False
    move_home(flying)
    flying.autopilot.change_mode(CopterMode.RTL)
    await flying.until(S.LAND, 60)
    await flying.tick(2)
    assert flying.autopilot.mode == CopterMode.LAND
    assert abs(flying.autopilot.north) < 3.0


@pytest.mark.nightly
async def test_a_home_that_is_moved_during_rtl_is_set_back_and_rtl_goes_on(flying: Rig) -> None:
    flying.order(CompulsiveMove(x=60, y=0))
    await flying.until(S.HOVER)
    flying.order(ReturnToLaunch())
    await flying.run(2)
    move_home(flying)
    await flying.run(4)
    flying.expect(S.RETURN_TO_LAUNCH)
    assert flying.autopilot.asked("set_mode")[-1] == CopterMode.RTL
    assert flying.autopilot.asked("set_mode").count(CopterMode.RTL) == 1
    await flying.until(S.IDLE, 90)
    assert abs(flying.autopilot.north) < 1.0


@pytest.mark.fault("the program ends in the air while home lies outside the fence", "Land")
async def test_at_the_end_of_the_program_the_drone_lands_where_home_is_outside(flying: Rig) -> None:
    await flying.run(1)
    flying.autopilot.keeps_home = False
    move_home(flying)
    await flying.tick(2)
    assert await flying.manager.shutdown_in_air()
    assert flying.autopilot.asked("set_mode")[-1] == CopterMode.LAND
    flying.expect(S.LAND)


async def test_hold_ends_a_return_that_waits(flying: Rig) -> None:
    await flying.run(1)
    flying.autopilot.keeps_home = False
    move_home(flying)
    flying.order(ReturnToLaunch())
    await flying.run(1)
    flying.order(Hold())
    await flying.run(3)
    flying.expect(S.HOVER)


# -- reserve and preflight --------------------------------------------------------------------------------------------


@pytest.mark.fault("home moved farther away", "the battery reserve counts the farther place")
async def test_the_reserve_counts_the_distance_to_the_autopilots_home(flying: Rig) -> None:
    flying.autopilot.keeps_home = False
    await flying.run(1)
    before = flying.manager.situation().facts.battery.reserve
    move_home(flying, 100.0)
    await flying.run(0.2)
    after = flying.manager.situation().facts.battery.reserve
    assert before is not None
    assert after is not None
    top = flying.manager.situation().facts.limits.heights.maximum
    speed = flying.settings.flight.speed_m_s
    farther = seconds_home(100.0, 30.0, top, speed) - seconds_home(0.0, 30.0, top, speed)
    assert after.needed - before.needed == pytest.approx(1.3 * farther * 100 / 900, rel=0.02)


@pytest.mark.fault(
    "home set by another station before Arm (locked: arming does not move it)",
    "Arm refused outside the fence; inside it is set after arming, Takeoff refused until then",
)
@pytest.mark.parametrize(
    ("metres", "passed", "value"),
    [(0.0, True, "at the drone"), (60.0, True, "60 m away; Arm sets it here"), (300.0, False, "300 m away, outside")],
)
async def test_home_is_checked_before_arm(rig: Rig, metres: float, passed: bool, value: str) -> None:
    move_home(rig, metres)
    await rig.run(0.2)
    found_item = next(item for item in rig.manager.situation().checks if item.name == "Home")
    assert found_item.passed is passed
    assert value in found_item.value
    assert rig.command(Arm()).accepted is passed


async def test_an_old_home_does_not_pass(rig: Rig) -> None:
    rig.autopilot.topics.home.publish(PLACE)
    rig.clock.advance(10.1)
    rig.autopilot._home_reported = rig.clock()
    await rig.tick(2)
    found_item = next(item for item in rig.manager.situation().checks if item.name == "Home")
    assert (found_item.passed, found_item.value) == (False, "not known")


async def test_a_carried_drone_arms_at_its_new_place_and_nothing_was_moved(tmp_path: Path, rig: Rig) -> None:
    """After a battery swap the arm place of the last flight is still known when "armed" is heard."""
    del tmp_path
    rig.order(Arm())
    await rig.until(S.ARM)
    await rig.run(1)
    rig.autopilot.armed = False
    await rig.until(S.IDLE)
    rig.autopilot.north = 60.0
    await rig.run(1)
    rig.autopilot.armed = True  # by a pilot, before the arm place is published
    rig.autopilot.move_home(north_of(PLACE, 60.0))
    await rig.run(0.3)
    assert rig.autopilot.count("set_home") == 0
    assert not any("moved" in line for line in rig.log)


# -- facts written down -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("home", [HomeFacts(), HomeFacts(DATUM, 99.0), replace(FAR, away=1.0, moved_s=None)])
def test_a_home_that_is_unknown_or_right_changes_no_return(home: HomeFacts) -> None:
    made = decider()
    made.tick(found(flying(1.0)))
    acts = made.command(with_home(flying(1.1), home), "ana", ReturnToLaunch(confirmed=True)).acts
    acts += made.tick(with_home(flying(1.2), home)).acts
    assert asked(acts) == [SetMode(CopterMode.RTL)]


def test_without_a_link_no_home_is_sent() -> None:
    made = decider()
    made.tick(found(flying(1.0)))
    facts = with_home(flying(2.0), FAR)
    acts = made.tick(replace(facts, link=replace(facts.link, is_up=False))).acts
    assert not [ask for ask in of_kind(acts, Ask) if isinstance(ask, Ask) and isinstance(ask.request, SetHome)]


def test_a_landing_that_nobody_caused_gets_no_cause() -> None:
    assert astray(with_home(flying(1.0), FAR), None) is None
    because = astray(with_home(flying(1.0), FAR), Cause("The battery is needed.", CauseKind.RESERVE, "12 %"))
    words = "The battery is needed. Home is 300 m from the arm place, outside the fence."
    assert because == Cause(words, CauseKind.RESERVE, "12 %")


def test_a_return_that_cannot_wait_lands_where_home_is_outside() -> None:
    cause = Cause("The program ends.", CauseKind.ALWAYS)
    assert isinstance(returning(with_home(flying(1.0), FAR), cause), ToLand)
    assert returning(with_home(flying(1.0), NEAR), cause) == ToReturn(cause, straight="the program cannot lead it")


def test_a_home_of_ten_seconds_is_young_enough() -> None:
    assert home_health(HomeFacts(DATUM, 10.0, 0.1)).is_healthy
    assert home_health(HomeFacts(DATUM, 99.0, None)).is_healthy, "on the ground nothing depends on it"


def test_the_health_of_home() -> None:
    assert home_health(HomeFacts()).is_healthy
    assert home_health(FAR).reason == "Home is 300 m from the arm place, outside the fence."
    assert home_health(NEAR).reason == "Home is 60 m from the arm place."
    assert home_health(HomeFacts(DATUM, 10.1, 0.1)).reason == "No home position from the autopilot."


class Heard:
    """The reading, and HOME_POSITION as it hears it."""

    def __init__(self) -> None:
        self._home: Topic[GlobalPose] = Topic("home", lambda: 0.0)
        self._reading = HomeReading(self._home)

    def look(
        self,
        home: Stamped[GlobalPose],
        arm: Stamped[ArmPlace],
        now: float,
        *,
        armed: bool = True,
        fence: Fence | None = FENCE,
    ) -> HomeFacts:
        self._home.latest = home
        vehicle = VehicleState(True, armed, CopterMode.GUIDED, LandedState.IN_AIR, now, now)
        self._reading.update(Instant(now, belief=Belief(vehicle), arm=arm, datum=DATUM, fence=fence))
        return self._reading.facts()


class TestReading:
    ARM = Stamped(ArmPlace(DATUM.latitude, DATUM.longitude, DATUM.altitude, 0.0, 0.0, 0.0), 10.0)

    def look(self, heard: Heard, metres: float, now: float, time: float | None = None) -> HomeFacts:
        home = Stamped(north_of(DATUM, metres), now if time is None else time)
        return heard.look(home, self.ARM, now)

    def test_a_reading_from_before_the_arming_says_nothing(self) -> None:
        facts = self.look(Heard(), 300.0, 11.0, time=9.9)
        assert facts.away is None
        assert facts.moved_s is None
        assert facts.age == pytest.approx(1.1)

    def test_moved_counts_from_the_first_wrong_reading_until_it_has_been_right_for_a_while(self) -> None:
        heard = Heard()
        assert self.look(heard, 0.0, 11.0).moved_s is None
        assert self.look(heard, 300.0, 12.0).moved_s == 0.0
        assert self.look(heard, 0.0, 13.0).moved_s == pytest.approx(1.0)
        assert self.look(heard, 300.0, 14.0).moved_s == pytest.approx(2.0)
        assert self.look(heard, 0.0, 15.0).moved_s == pytest.approx(3.0)
        assert self.look(heard, 0.0, 17.9).moved_s == pytest.approx(5.9)
        assert self.look(heard, 0.0, 18.0).moved_s is None

    @pytest.mark.parametrize(
        ("metres", "up", "moved", "inside"),
        [
            (0.0, 0.0, False, True),
            (2.9, 0.0, False, True),
            (3.1, 0.0, True, True),
            (144.0, 0.0, True, True),
            (151.0, 0.0, True, False),
            (0.0, 4.9, True, True),
            (0.0, 5.1, True, False),
            (0.0, -5.1, True, False),
        ],
    )
    def test_tolerances(self, metres: float, up: float, moved: bool, inside: bool) -> None:
        home = Stamped(north_of(DATUM, metres, up), 11.0)
        facts = Heard().look(home, self.ARM, 11.0)
        assert (facts.is_moved, facts.is_inside) == (moved, inside)
        assert facts.away == pytest.approx(math.hypot(metres, up), abs=0.05)

    def test_without_a_fence_a_moved_home_misleads(self) -> None:
        home = Stamped(north_of(DATUM, 60.0), 11.0)
        assert Heard().look(home, self.ARM, 11.0, fence=None).misleads

    def test_the_arm_place_of_an_earlier_arming_is_not_compared(self) -> None:
        heard = Heard()
        home = Stamped(north_of(DATUM, 60.0), 21.0)
        heard.look(home, self.ARM, 20.0, armed=False)
        assert heard.look(home, self.ARM, 21.0).away is None

    def test_the_same_place_tied_again_is_no_new_arming(self) -> None:
        heard = Heard()
        assert self.look(heard, 300.0, 11.0).moved_s == 0.0
        again = Stamped(replace(self.ARM.value, ekf_x=9.0), 12.0)
        assert heard.look(Stamped(north_of(DATUM, 300.0), 11.5), again, 12.5).moved_s == 1.5


def test_without_an_arm_place_a_moved_home_is_reported_and_nothing_is_sent() -> None:
    facts = with_home(flying(1.0), FAR)
    facts = replace(facts, position=replace(facts.position, arm_place=None))
    acts = KeptHome().tick(facts, HoverState(0.0, SETTINGS))
    assert not any(isinstance(act, Ask) for act in acts)
    assert any(isinstance(act, Log) for act in acts)
