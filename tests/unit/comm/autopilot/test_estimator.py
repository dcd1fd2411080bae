"""The position estimator: its own report, and positions that its velocity denies."""

from __future__ import annotations

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hawk.comm.autopilot.estimator import LEAP_M, LeapObserver
from hawk.comm.autopilot.streams import wanted_streams
from hawk.model.frames import EkfPosition
from tests.unit.comm.autopilot.telemetry_rig import IN_AIR, Rig

GLITCHING = 33599
"""Flags of a real ArduCopter while it refuses a GPS that is 25 m off."""
BEFORE_THE_RESET = 32807
"""Flags of the same one in the half second before it takes the new position."""
NO_GPS, NO_AIDING = 37, 167
"""7.5 s and 15 s after GPS was lost."""


@pytest.fixture
def rig() -> Rig:
    made = Rig()
    made.take(made.said.estimator(), made.said.gps(), made.said.system())
    return made


def diagnose(rig: Rig, **estimator: float | None) -> str:
    """Return the fault that a report causes."""
    rig.take(rig.said.estimator(**estimator), rig.said.gps(), rig.said.system())  # type: ignore[arg-type]
    found = rig.topics.diagnostics.value
    assert found is not None
    assert found.global_position_ok is (found.estimator_fault == "")
    return found.estimator_fault


@pytest.mark.fault(
    "EKF_STATUS_REPORT: GPS glitch, no absolute position, constant position, not initialised, variance above 0.8",
    "position unhealthy within 1 s with the reason; no Arm; a task ends by Hover after 2 s",
)
@pytest.mark.parametrize(
    ("report", "words"),
    [
        ({}, ""),
        ({"flags": GLITCHING}, "GPS glitch"),
        ({"flags": BEFORE_THE_RESET}, "GPS glitch"),
        ({"flags": NO_GPS}, "no absolute position"),
        ({"flags": NO_AIDING}, "no absolute position"),
        ({"flags": 831 | 128}, "no absolute position"),
        ({"flags": 831 - 16}, "no absolute position"),
        ({"flags": 1024}, "its estimator is not ready"),
        ({"velocity": 0.8}, ""),
        ({"velocity": 0.81}, "velocity variance 0.8, above 0.8"),
        ({"position": 6.66}, "position variance 6.7, above 0.8"),
        ({"compass": 1.0}, "compass variance 1.0, above 0.8"),
        ({"position": None}, "position variance unknown, above 0.8"),
    ],
)
def test_a_report_that_is_not_well_makes_the_position_unhealthy(
    rig: Rig, report: dict[str, float | None], words: str
) -> None:
    assert diagnose(rig, **report) == words


@pytest.mark.fault(
    "EKF_STATUS_REPORT stops, or never comes",
    "position unhealthy 5 s after the last one, with the reason; no Arm; a task ends by Hover after 2 s",
)
def test_silence_of_the_estimator_is_a_fault_before_its_first_report_and_after_its_last(rig: Rig) -> None:
    silent = Rig()
    silent.take(silent.said.gps(), silent.said.system())
    assert silent.topics.diagnostics.value is not None
    assert silent.topics.diagnostics.value.estimator_fault == "no report of its estimator"
    rig.advance(5.0)
    rig.take(rig.said.gps(), rig.said.system())
    assert rig.topics.diagnostics.value is not None
    assert rig.topics.diagnostics.value.estimator_fault == ""
    rig.advance(0.01)
    rig.take(rig.said.gps(), rig.said.system())
    assert rig.topics.diagnostics.value.estimator_fault == "no report of its estimator"


def test_a_report_without_its_fields_changes_nothing(rig: Rig) -> None:
    rig.take(("EKF_STATUS_REPORT", {"flags": 831}), rig.said.system())
    assert rig.topics.diagnostics.value is not None
    assert rig.topics.diagnostics.value.estimator_fault == ""


def test_a_report_does_not_make_an_old_sys_status_young(rig: Rig) -> None:
    rig.advance(4.0)
    rig.take(rig.said.estimator())
    assert rig.topics.diagnostics.age == pytest.approx(4.0)


def test_the_report_is_asked_for_by_rate() -> None:
    assert wanted_streams(20.0)["EKF_STATUS_REPORT"].message_id == 193


def north_of(rig: Rig) -> float:
    pose = rig.topics.pose.value
    assert pose is not None
    assert pose.map is not None
    return pose.map.north


@pytest.mark.fault(
    "local and global position jump together by 25 m (EKF reset after a GPS glitch) in a task",
    "no pose and no target from the leap on; 0.3 s later (three looks) reported with its metres, Hover at the "
    "new estimate",
)
class TestJump:
    """EKF-local and globe leap together: the drone did not move."""

    @pytest.fixture
    def jumps(self, rig: Rig) -> list[float]:
        rig.arm_here()
        rig.take(rig.said.landed(IN_AIR))
        rig.fly(1.0)
        found: list[float] = []
        rig.topics.estimate_jump.listen(found.append)
        return found

    def test_a_jump_is_reported_together_with_the_first_pose_at_the_new_place(
        self, rig: Rig, jumps: list[float]
    ) -> None:
        """A goal that is formed on the jump must not be formed from the pose of before."""
        at_jump: list[float] = []
        before: list[float] = []
        rig.topics.estimate_jump.listen(lambda _: at_jump.append(north_of(rig)))
        rig.topics.pose.listen(lambda _: before.append(north_of(rig)) if not jumps else None)
        rig.advance()
        for _ in range(20):
            rig.advance()
            rig.take(rig.said.attitude(), rig.said.local(25.0))
            assert north_of(rig) == pytest.approx(25.0 if jumps else 0.0, abs=0.1)
            rig.take(rig.said.world(25.0))  # no local position comes between this and a tick
            assert north_of(rig) == pytest.approx(25.0 if jumps else 0.0, abs=0.1)
        assert jumps == [pytest.approx(25.0, abs=0.05)]
        assert rig.jumps == []
        assert at_jump == [pytest.approx(25.0, abs=0.1)]
        assert before == [pytest.approx(25.0, abs=0.1)]

    def test_a_jump_is_reported_within_half_a_second(self, rig: Rig, jumps: list[float]) -> None:
        rig.fly(0.5, ekf=(0.0, -25.0, 0.0), north=0.0)
        assert len(rig.jumps) == 1  # east has no globe in this rig: EKF-local alone moved
        assert jumps == []
        rig.fly(0.5, ekf=(25.0, -25.0, 0.0), north=25.0)
        assert jumps == [pytest.approx(25.0, abs=0.05)]

    def test_of_a_leap_of_both_by_different_amounts_each_event_has_its_own(self, rig: Rig, jumps: list[float]) -> None:
        rig.fly(1.0, ekf=(25.0, 0.0, 0.0), north=10.0)
        assert rig.jumps == [pytest.approx(15.0, abs=0.05)]
        assert jumps == [pytest.approx(10.0, abs=0.05)]

    @pytest.mark.fault("a position of one datagram is 25 m off", "no event, no pose for 0.3 s")
    def test_a_spike_of_one_sample_is_none(self, rig: Rig, jumps: list[float]) -> None:
        rig.advance()
        rig.take(rig.said.attitude(), rig.said.local(25.0, 0.0, 0.0), rig.said.world(25.0))
        rig.fly(1.0)
        assert jumps == []

    def test_the_distance_flown_meanwhile_is_no_part_of_the_jump(self, rig: Rig, jumps: list[float]) -> None:
        for index in range(20):
            rig.advance()
            north = 0.25 * index + (25.0 if index > 5 else 0.0)
            rig.take(
                rig.said.attitude(),
                rig.said.local(north, velocity=(5.0 if index else 0.0, 0.0, 0.0)),
                rig.said.world(north),
            )
        assert jumps == [pytest.approx(25.0, abs=0.2)]

    @pytest.mark.fault(
        "local and global position jump together by 25 m (EKF reset after a GPS glitch) while the map grows",
        "nothing is mapped until the position is back within 2 m, or until the next Arm; the mapper's health "
        "gives the reason; Explore ends",
    )
    def test_nothing_is_mapped_until_it_is_back(self, rig: Rig, jumps: list[float]) -> None:
        rig.take(rig.said.estimator())
        assert rig.telemetry.map_problem(rig.clock()) == ""
        rig.fly(1.0, ekf=(25.0, 0.0, 0.0), north=25.0)
        assert "jumped by 25 m against the map" in rig.telemetry.map_problem(rig.clock())
        rig.fly(1.0)
        assert jumps == [pytest.approx(25.0, abs=0.05)] * 2
        assert rig.telemetry.map_problem(rig.clock()) == ""

    def test_after_the_next_arming_the_map_belongs_to_the_new_estimate(self, rig: Rig, jumps: list[float]) -> None:
        rig.fly(1.0, ekf=(25.0, 0.0, 0.0), north=25.0)
        assert jumps
        rig.take(rig.said.estimator())
        rig.arm_here((25.0, 0.0, 0.0), 25.0)
        assert rig.telemetry.map_problem(rig.clock()) == ""

    def test_nothing_is_mapped_while_the_estimator_is_not_well(self, rig: Rig, jumps: list[float]) -> None:
        rig.take(rig.said.estimator(flags=GLITCHING))
        assert "GPS glitch" in rig.telemetry.map_problem(rig.clock())
        assert jumps == []


@pytest.mark.fault(
    "the position creeps away from its own velocity (3 m in 2 s)",
    "position unhealthy within 1 s with the reason; no Arm; a task ends by Hover after 2 s",
)
def test_an_estimate_that_creeps_away_from_its_velocity_is_not_trusted(rig: Rig) -> None:
    rig.arm_here()
    for index in range(60):
        rig.advance()
        rig.take(rig.said.attitude(), rig.said.local(0.1 * index), rig.said.world(0.1 * index))  # 2 m/s, says 0
    assert diagnose(rig) == "its position creeps"
    rig.fly(3.0, ekf=(5.9, 0.0, 0.0), north=5.9)
    assert diagnose(rig) == ""


@given(
    st.lists(
        st.tuples(
            st.floats(0.02, 0.3),
            st.tuples(st.floats(-15, 15), st.floats(-15, 15), st.floats(-3, 3)),
            st.floats(-0.05, 0.05),
        ),
        max_size=60,
    )
)
def test_flight_of_any_kind_neither_leaps_nor_creeps(
    steps: list[tuple[float, tuple[float, float, float], float]],
) -> None:
    """Positions that follow their velocities, with noise of centimetres."""
    watch = LeapObserver()
    time, place, velocity = 0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for dt, following, noise in steps:
        time += dt
        place = tuple(p + (a + b) / 2 * dt for p, a, b in zip(place, velocity, following, strict=True))  # type: ignore[assignment]
        velocity = following
        assert not watch.look(EkfPosition(time, place[0] + noise, place[1], place[2], *velocity))
        assert not watch.creeps
    assert watch.settle() == (0.0, 0.0, 0.0)


@given(st.tuples(*[st.floats(-60, 60)] * 3), st.floats(0.02, 0.5))
def test_a_leap_is_measured_to_the_centimetre(leap: tuple[float, float, float], dt: float) -> None:
    assume(abs(math.hypot(*leap) - LEAP_M) > 0.01)
    watch = LeapObserver()
    found = []
    for index in range(10):
        moved = leap if index > 4 else (0.0, 0.0, 0.0)
        sample = EkfPosition(index * dt, moved[0] + index * dt * 3.0, moved[1], moved[2], 3.0, 0.0, 0.0)
        found.append(watch.look(sample))
    assert any(found) is (math.hypot(*leap) > LEAP_M)
    if any(found):
        assert watch.settle() == pytest.approx(leap, abs=0.01)


def test_samples_a_second_apart_are_not_compared_and_a_repeated_one_is_ignored() -> None:
    watch = LeapObserver()
    assert not watch.look(EkfPosition(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert not watch.look(EkfPosition(1.0, 25.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert not watch.look(EkfPosition(1.0, 50.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert not watch.look(EkfPosition(1.1, 25.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert watch.look(EkfPosition(1.2, 50.0, 0.0, 0.0, 0.0, 0.0, 0.0))


def standing(time: float, north: float) -> EkfPosition:
    """A sample that says that the drone stands."""
    return EkfPosition(time, north, 0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(("metres", "leaps"), [(1.0, False), (-1.0, False), (1.01, True), (-1.01, True)])
def test_more_than_a_metre_is_a_leap(metres: float, leaps: bool) -> None:
    watch = LeapObserver()
    watch.look(standing(0.0, 0.0))
    assert watch.look(standing(0.5, metres)) is leaps
    assert watch.settle() == ((metres, 0.0, 0.0) if leaps else (0.0, 0.0, 0.0))
    assert watch.settle() == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(("apart", "compared"), [(0.99, True), (1.0, False)])
def test_samples_less_than_a_second_apart_are_compared(apart: float, compared: bool) -> None:
    watch = LeapObserver()
    watch.look(standing(0.0, 0.0))
    assert watch.look(standing(apart, 25.0)) is compared


def creeping(step_m: float, steps: int) -> LeapObserver:
    """A watch that saw a position move every half second, until that many steps were done."""
    watch = LeapObserver()
    for index in range(steps + 1):
        assert not watch.look(standing(0.5 * index, step_m * index))
    return watch


def test_an_estimate_creeps_by_more_than_three_metres_within_two_seconds() -> None:
    assert not creeping(0.75, 4).creeps, "3.0 m"
    assert creeping(0.76, 4).creeps
    watch = creeping(0.7, 5)
    assert watch.creeps, "a step of two seconds ago counts: 3.5 m"
    watch.look(standing(3.0, 3.5))
    assert not watch.creeps, "one of 2.5 s ago does not: 2.8 m"


def test_after_a_gap_it_does_not_creep() -> None:
    watch = creeping(0.76, 4)
    watch.look(standing(3.0, 3.04))
    assert not watch.creeps


def test_a_boot_makes_the_report_void(rig: Rig) -> None:
    rig.arm_here()
    assert rig.telemetry.map_problem(rig.clock()) == ""
    rig.said.boot = 0.0
    rig.fly(2.0)
    assert rig.boots == 1
    assert "no report of its estimator" in rig.telemetry.map_problem(rig.clock())
