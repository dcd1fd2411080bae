"""A place as telemetry makes it: which messages it needs, how old they may be, how a leap moves it, and its numbers."""

from __future__ import annotations

import pytest

from hawk.model.poses import GlobalPose, VehiclePose
from tests.unit.comm.autopilot.telemetry_rig import IN_AIR, ON_GROUND, UP, WALL, Rig


@pytest.fixture
def rig() -> Rig:
    return Rig()


def hover(rig: Rig, north: float = 0.0, east: float = 0.0, up: float = 0.0, world: bool = True) -> None:
    """Stand at one place for a second, as the estimate says it and, with ``world``, on the globe too."""
    for _ in range(20):
        rig.advance()
        rig.take(rig.said.attitude(), rig.said.local(north, east, -up))
        if world:
            rig.take(rig.said.world(north, up, east))


def in_the_air(rig: Rig) -> None:
    rig.arm_here()
    rig.take(rig.said.landed(IN_AIR))
    hover(rig)


@pytest.mark.parametrize("missing", ["attitude", "local"])
def test_a_pose_at_a_moment_needs_position_and_attitude(rig: Rig, missing: str) -> None:
    in_the_air(rig)
    for _ in range(8):
        rig.advance()
        rig.take(rig.said.local() if missing == "attitude" else rig.said.attitude(), rig.said.world())
    assert rig.telemetry.pose_at(rig.clock()) is None
    rig.take(rig.said.attitude() if missing == "attitude" else rig.said.local())
    assert rig.telemetry.pose_at(rig.clock()) is not None


def test_no_pose_is_given_while_the_tie_to_the_map_is_in_doubt_though_everything_is_heard(rig: Rig) -> None:
    in_the_air(rig)
    published: list[VehiclePose] = []
    rig.topics.pose.listen(published.append)
    hover(rig, north=50.0, world=False)
    assert rig.telemetry.pose_at(rig.clock()) is None
    assert published == []
    hover(rig, north=50.0)
    assert rig.telemetry.pose_at(rig.clock()) is not None


@pytest.mark.parametrize(("age", "known"), [(0.95, True), (1.05, False)])
def test_before_arming_a_place_on_the_globe_is_good_for_a_second(rig: Rig, age: float, known: bool) -> None:
    rig.take(rig.said.heartbeat(), rig.said.landed(ON_GROUND))
    rig.fly(0.5)
    for _ in range(round(age / 0.05)):
        rig.advance()
        rig.take(rig.said.attitude(), rig.said.local())
    assert (rig.telemetry.pose_at(rig.clock()) is not None) is known


def test_places_on_the_globe_are_exact(rig: Rig) -> None:
    rig.take(rig.said.heartbeat(), rig.said.landed(ON_GROUND))
    rig.fly(0.5)
    fields = {"lat": 432_609_001, "lon": -799_192_003, "alt": 123_457, "time_boot_ms": rig.said.ms + 50}
    rig.advance()
    rig.take(("GLOBAL_POSITION_INT", fields), rig.said.attitude(), rig.said.local())
    rig.take(("HOME_POSITION", {"latitude": 432_609_005, "longitude": -799_192_007, "altitude": 98_765}))
    pose = rig.topics.pose.value
    assert pose is not None
    assert pose.global_ == GlobalPose(43.2609001, -79.9192003, 123.457)
    assert rig.topics.home.value == GlobalPose(43.2609005, -79.9192007, 98.765)


@pytest.mark.parametrize(
    ("north", "east", "up", "metres"),
    [(1.5, 0.0, 0.0, 1.5), (0.0, -1.5, 0.0, 1.5), (0.0, 0.0, 1.5, 1.5), (2.0, -3.0, 6.0, 7.0)],
)
def test_a_leap_of_the_estimate_is_published_with_its_length_in_space(
    rig: Rig, north: float, east: float, up: float, metres: float
) -> None:
    in_the_air(rig)
    leaps: list[float] = []
    rig.topics.estimate_jump.listen(leaps.append)
    hover(rig, north, east, up)
    assert leaps == [pytest.approx(metres, abs=0.1)]
    assert rig.jumps == [], "the estimate leapt, its frame did not"


@pytest.mark.parametrize(
    ("leaps", "metres"),
    [
        ([(0.0, 1.5), (0.0, 3.0)], "3"),
        ([(0.0, -3.0)], "3"),
        ([(3.0, -4.0)], "5"),
        ([(3.0, 4.0), (0.0, 4.0)], "4"),
        ([(3.0, 4.0), (3.0, 0.0)], "3"),
    ],
)
def test_leaps_add_up_north_and_east_until_the_position_is_back(
    rig: Rig, leaps: list[tuple[float, float]], metres: str
) -> None:
    in_the_air(rig)
    for north, east in leaps:
        hover(rig, north, east)
    rig.take(rig.said.estimator())
    problem = rig.telemetry.map_problem(rig.clock())
    assert problem == f"the position jumped by {metres} m against the map: nothing is mapped until it is back"
    hover(rig)
    assert rig.telemetry.map_problem(rig.clock()) == ""


def test_a_leap_up_is_no_leap_on_the_map(rig: Rig) -> None:
    in_the_air(rig)
    hover(rig, up=6.0)
    rig.take(rig.said.estimator())
    assert rig.telemetry.map_problem(rig.clock()) == ""


@pytest.mark.slow
def test_a_link_whose_delay_changes_makes_no_leap_of_a_flight_at_speed(rig: Rig) -> None:
    """The autopilot's clock is placed on ours by the least delay of 30 s: it moves when all messages come later."""
    in_the_air(rig)
    leaps: list[float] = []
    rig.topics.estimate_jump.listen(leaps.append)
    north, delay, at_first = 0.0, 0.0, rig.telemetry.from_boot(0.0)
    assert at_first is not None
    for wanted in (0.0, 0.3, 0.0):
        rig.clock.advance(max(0.0, wanted - delay))
        sooner = max(0.0, delay - wanted)
        rig.said.boot += sooner
        north += 5.0 * sooner
        delay = wanted
        for _ in range(700):
            rig.advance()
            north += 5.0 * 0.05
            rig.take(rig.said.attitude(), rig.said.local(north, velocity=(5.0, 0.0, 0.0)), rig.said.world(north))
            assert rig.telemetry.tie.offset.sure
        assert rig.telemetry.from_boot(0.0) == pytest.approx(at_first + delay, abs=1e-6), "it moves with the delay"
    assert leaps == []


@pytest.mark.parametrize("shift", [(5.0, 0.0, 0.0), (0.0, -5.0, 0.0), (0.0, 0.0, 5.0)])
def test_a_leap_that_the_frames_take_up_is_not_of_the_estimate(rig: Rig, shift: tuple[float, float, float]) -> None:
    """EKF-local moves its origin: the local position leaps, the place on the globe stays."""
    in_the_air(rig)
    leaps: list[float] = []
    rig.topics.estimate_jump.listen(leaps.append)
    rig.fly(1.0, ekf=shift)
    assert rig.jumps == [pytest.approx(5.0, abs=0.05)]
    assert leaps == []


@pytest.mark.parametrize("speed", [1.0, 4.0])
def test_a_boot_is_known_by_its_moment_on_this_computers_clocks(speed: float) -> None:
    """On a clock that runs faster than the real one, 100 s of the autopilot are fewer of this computer."""
    fast = Rig(speed)
    fast.arm_here()
    boot = fast.places[0].boot
    assert boot.boot_id == "host"
    assert boot.seconds == pytest.approx(UP - 100.0 / speed, abs=1)
    assert boot.utc == pytest.approx(WALL - 100.0 / speed, abs=1)
