"""The reported height against GNSS, camera and rangefinder, by values, and what a doubt of it leads to."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from hawk.comm.autopilot.terrain import Terrain
from hawk.comm.protocol.commands import AutonomousExplore
from hawk.ddc.facts import Facts
from hawk.ddc.motion import Goal
from hawk.ddc.orders import Cause, CauseKind, ToExplore, ToHover, ToLand, ToReturn
from hawk.ddc.rules import guard
from hawk.ddc.rules.notices import WitnessNotices
from hawk.ddc.states.base import returning
from hawk.ddc.states.hover import STRAYS_S, raised
from hawk.ddc.witnesses.height import AGREES_S, SETTLED_S, SILENT_S, WINDOW_S, HeightFacts, HeightReading
from hawk.ddc.witnesses.witness import COMPASS_LOST, WitnessFacts, compass_part
from hawk.model.operation import Health
from hawk.model.pictures import GroundStep, StallSize
from hawk.model.vehicle import Diagnostics, GnssHeight
from tests.unit.ddc.by_facts import at, made, targets, texts
from tests.unit.ddc.fakes import Rig
from tests.unit.ddc.written_facts import flying

STEP_S = 0.5


class Beginning:
    """A drone that stands: GNSS and the reported height agree."""

    def __init__(self, height: float = 20.0) -> None:
        self.reading = HeightReading()
        self.now, self.height, self.off = 0.0, height, 0.0
        self.reading.note_gnss(0.0, 100.0, 1.0, 100.0)
        self.reading.stand()


class Flight(Beginning):
    """A drone whose reported height is ``off`` above the true one; each witness may be silent."""

    def fly(
        self, seconds: float, drift: float = 0.0, *, gnss: bool = True, camera: bool = True, ground: float | None = None
    ) -> HeightFacts:
        """``drift``: m/s by which the reported height rises on its own. The autopilot holds what it reports."""
        for _ in range(round(seconds / STEP_S)):
            before = self.height - self.off
            self.off += drift * STEP_S
            true = self.height - self.off
            if camera:
                stretch = math.log(before / true)
                self.reading.note(GroundStep(self.now, self.now + STEP_S, (0.0, 0.0), (0.0, 0.0), stretch, 0.0, before))
            self.now += STEP_S
            if gnss:
                self.reading.note_gnss(self.now, 100.0 + true, 1.0, 100.0 + self.height)
            if ground is not None:
                self.reading.note_range(self.now, ground + self.off)
            facts = self.facts()
        return facts

    def facts(self) -> HeightFacts:
        return self.reading.look(self.now, self.height)


def test_before_a_reading_nothing_is_said() -> None:
    facts = HeightReading().look(5.0, None)
    assert (facts, facts.off, facts.words, facts.is_doubted) == (HeightFacts(), 0.0, "", False)


@pytest.mark.fault(
    "the barometer drifts by 0.5 m/s, up or down, and the height and climb with it, all flags good",
    "reported at 4 m by two of GNSS altitude, camera and rangefinder; the task ends by Hover, which keeps the "
    "true height up to the ceiling; new tasks are refused; a return that is needed becomes Land while the "
    "drone is lower than reported",
)
def test_a_barometer_that_drifts_is_doubted_by_gnss_and_camera() -> None:
    flight = Flight()
    assert not flight.fly(6.0, 0.5).is_doubted
    facts = flight.fly(6.0, 0.5)
    assert facts.is_doubted
    assert facts.off == pytest.approx(6.0, abs=1.2)
    assert facts.words == "The height is not what the autopilot reports: 20 m, truly about 15 m."
    assert flight.fly(1.0, 0.5).doubted_s == pytest.approx(facts.doubted_s + 1.0 if facts.doubted_s else 0.0)


def test_a_barometer_that_falls_is_doubted_too() -> None:
    facts = Flight().fly(14.0, -0.5)
    assert facts.is_doubted
    assert facts.off == pytest.approx(-6.0, abs=1.5)


@pytest.mark.fault("GNSS altitude wanders by 3 m, or the ground slopes: one witness alone", "no alarm")
@pytest.mark.parametrize("silent", ["gnss", "camera"])
def test_one_witness_is_none(silent: str) -> None:
    assert not Flight(40.0).fly(20.0, 0.5, **{silent: False}).is_doubted


def test_the_rangefinder_is_the_second_witness() -> None:
    flight = Flight(40.0)
    assert flight.fly(14.0, 0.5, gnss=False, camera=False, ground=1.0).by_range == pytest.approx(6.75)
    assert not flight.facts().is_doubted
    assert Flight(40.0).fly(14.0, 0.5, camera=False, ground=1.0).is_doubted


def test_witnesses_that_contradict_each_other_doubt_nothing() -> None:
    flight = Flight()
    for k in range(20):
        flight.now += 1.0
        flight.reading.note_gnss(flight.now, 120.0 - 0.5 * k, 1.0, 120.0)
        flight.reading.note(GroundStep(flight.now - 1, flight.now, (0.0, 0.0), (0.0, 0.0), -0.02, 0.0, 20.0))
        assert not flight.facts().is_doubted


@pytest.mark.fault("GNSS altitude wanders by 3 m, or the ground slopes: one witness alone")
def test_the_wander_of_gnss_and_a_slope_are_no_doubt() -> None:
    flight = Flight()
    for k in range(300):
        flight.now += 1.0
        flight.reading.note_gnss(flight.now, 120.0 + 3.0 * math.sin(k / 40), 1.5, 120.0)
        flight.reading.note(
            GroundStep(flight.now - 1, flight.now, (0.0, 0.0), (0.0, 0.0), 0.1 / 60 * math.cos(k / 30), 0.0, 20.0)
        )
        assert not flight.facts().is_doubted


def test_a_receiver_with_a_bad_altitude_or_silent_ones_are_no_witness() -> None:
    flight = Flight()
    flight.fly(2.0)
    flight.reading.note_gnss(flight.now, 50.0, 9.0, 120.0)
    assert flight.facts().by_gnss == pytest.approx(0.0)
    flight.reading.note_range(flight.now, 0.0)
    late = flight.reading.look(flight.now + SILENT_S + 0.1, 20.0)
    assert (late.by_gnss, late.by_camera, late.by_range) == (None, None, None)
    flight.reading.note_gnss(flight.now + SILENT_S + 1.0, 117.0, None, 120.0)
    assert flight.reading.look(flight.now + SILENT_S + 1.0, 20.0).by_gnss == pytest.approx(3.0), "taken as it is"


def test_the_cameras_own_error_is_forgotten() -> None:
    flight = Flight(40.0)
    flight.fly(10.0, 0.2, gnss=False)
    assert flight.facts().by_camera == pytest.approx(2.0, abs=0.2)
    assert flight.fly(WINDOW_S + 2.0, gnss=False).by_camera == pytest.approx(0.0, abs=0.05)


def test_a_doubt_ends_when_the_witnesses_agree_for_a_while() -> None:
    flight = Flight()
    flight.fly(13.0, 0.5)
    assert flight.fly(13.0, -0.5).is_doubted
    assert flight.fly(5.0).is_doubted
    assert flight.fly(1.0, 6.0).is_doubted
    flight.fly(1.0, -6.0)
    assert flight.fly(AGREES_S - 1.0).is_doubted
    assert not flight.fly(15.0).is_doubted


def test_a_doubt_stays_without_witnesses_and_ends_on_the_ground() -> None:
    flight = Flight()
    before = flight.fly(13.0, 0.5)
    flight.now += 60.0
    silent = flight.facts()
    assert silent.is_doubted
    assert silent.off == pytest.approx(before.off), "the height is as wrong as it was"
    assert WitnessFacts(height=silent).misleads_home
    flight.reading.stand()
    assert not flight.facts().is_doubted


def test_gnss_counts_from_where_it_stood() -> None:
    reading = HeightReading()
    reading.note_gnss(0.0, 103.0, 1.0, 100.0)
    reading.stand()
    reading.note_gnss(10.0, 103.0, 1.0, 108.0)
    assert reading.look(10.0, 8.0).by_gnss == pytest.approx(8.0)
    smoothed = HeightReading()
    smoothed.note_gnss(0.0, 103.0, 1.0, 100.0)
    smoothed.note_gnss(3.0, 103.0, 1.0, 108.0)
    assert smoothed.look(3.0, 8.0).by_gnss == pytest.approx(8.0 * (1.0 - math.exp(-1.0))), "in 3 s"


@pytest.mark.parametrize(("accuracy", "taken"), [(None, True), (4.9, True), (5.0, True), (5.1, False)])
def test_the_worst_accuracy_that_is_taken(accuracy: float | None, taken: bool) -> None:
    reading = HeightReading()
    reading.note_gnss(0.0, 100.0, 1.0, 100.0)
    reading.note_gnss(10.0, 100.0, accuracy, 106.0)
    assert reading.look(10.0, 6.0).by_gnss == (6.0 if taken else None)


def contradicting(gnss: float, ground: float, seconds: float = 2.0) -> HeightFacts:
    """GNSS and the rangefinder are off by so much at once, for a time."""
    reading = HeightReading()
    reading.note_gnss(0.0, 100.0, 1.0, 100.0)
    reading.note_range(0.0, 0.0)
    facts = reading.look(0.0, 20.0)
    for tick in range(round(seconds * 16) + 1):
        now = 10.0 + tick / 16
        reading.note_gnss(now, 100.0, 1.0, 100.0 + gnss)
        reading.note_range(now, ground)
        facts = reading.look(now, 20.0)
    return facts


@pytest.mark.parametrize(
    ("gnss", "ground", "doubted"),
    [
        (4.0, 2.5, True),
        (2.5, 4.0, True),
        (-4.0, -2.5, True),
        (3.9, 3.9, False),
        (6.0, 2.4, False),
        (-6.0, -2.4, False),
        (6.0, -6.0, False),
    ],
)
def test_how_far_two_witnesses_must_be_off(gnss: float, ground: float, doubted: bool) -> None:
    assert contradicting(gnss, ground).is_doubted is doubted


def test_a_second_must_pass_before_it_is_doubted() -> None:
    assert not contradicting(6.0, 6.0, 1.0 - 1 / 16).is_doubted
    assert contradicting(6.0, 6.0, 1.0).doubted_s == 0.0


def test_what_is_off_is_the_mean_of_those_that_agree_on_the_side() -> None:
    assert HeightFacts(6.0, 5.0, 1.0, doubted_s=0.0).off == 5.5
    assert HeightFacts(-6.0, -5.0, 2.5, doubted_s=0.0).off == -5.5
    assert HeightFacts(2.5, 6.5, None, doubted_s=0.0).off == 4.5
    assert HeightFacts(6.0, 5.0, 1.0).off == 0.0
    assert HeightFacts(30.0, 30.0, None, 20.0, 0.0).words.endswith("20 m, truly about 0 m.")


@pytest.mark.parametrize("silent_s", [SILENT_S, SILENT_S + 0.1])
def test_a_witness_counts_for_five_seconds(silent_s: float) -> None:
    reading = HeightReading()
    reading.note_gnss(10.0, 100.0, 1.0, 100.0)
    reading.note(GroundStep(9.0, 10.0, (0.0, 0.0), (0.0, 0.0), 0.0, 0.0, 20.0))
    reading.note_range(10.0, 0.0)
    late = reading.look(10.0 + silent_s, 20.0)
    expected = 0.0 if silent_s <= 5.0 else None
    assert (late.by_gnss, late.by_camera, late.by_range) == (expected, expected, expected)


def test_a_minute_of_camera_and_rangefinder_counts() -> None:
    reading = HeightReading()
    reading.note(GroundStep(0.0, 1.0, (0.0, 0.0), (0.0, 0.0), math.log(2.0), 0.0, 20.0))
    for time, ground in ((1.0, 3.0), (2.0, 5.0)):
        reading.note_range(time, ground)
    for now, camera, ranged in ((61.0, 10.0, 4.0), (61.5, 0.0, 2.0)):
        reading.note(GroundStep(now - 1, now, (0.0, 0.0), (0.0, 0.0), 0.0, 0.0, 20.0))
        reading.note_range(now, 7.0)
        found = reading.look(now, 20.0)
        assert found.by_camera == pytest.approx(camera)
        assert found.by_range == ranged


@pytest.mark.fault(
    "the barometer drifts by 0.5 m/s, all flags good, and GNSS altitude, or every witness, goes silent in the doubt"
)
def test_an_error_that_stays_is_none_the_less_when_gnss_goes_silent() -> None:
    flight = Flight(40.0)
    flight.fly(24.0, 0.5)
    assert flight.fly(WINDOW_S + 5.0).off == pytest.approx(12.0)
    assert flight.fly(SILENT_S + 1.0, gnss=False).off == pytest.approx(12.0, abs=0.2), "the camera saw all of it"
    assert flight.fly(2 * AGREES_S, gnss=False).is_doubted


def test_an_error_that_camera_and_rangefinder_saw_is_not_over_after_the_window() -> None:
    flight = Flight(40.0)
    flight.fly(24.0, 0.5, gnss=False, ground=1.0)
    later = flight.fly(WINDOW_S + 2 * AGREES_S, gnss=False, ground=1.0)
    assert later.off == pytest.approx(12.0, abs=0.3)
    flight.fly(24.0, -0.5, gnss=False, ground=1.0)
    assert not flight.fly(2 * AGREES_S, gnss=False, ground=1.0).is_doubted, "and it is back"


def test_a_witness_that_comes_in_a_doubt_does_not_know_by_how_much() -> None:
    flight = Flight(40.0)
    flight.fly(24.0, 0.5, camera=False, ground=1.0)
    facts = flight.fly(SILENT_S + 2 * AGREES_S, gnss=False)
    assert (facts.by_gnss, facts.by_camera, facts.by_range) == (None, None, None)
    assert facts.is_doubted
    assert facts.off == pytest.approx(12.0, abs=1.0)


def test_a_camera_that_was_silent_when_the_doubt_began_does_not_know_either() -> None:
    flight = Flight(40.0)
    flight.fly(4.0)
    flight.fly(24.0, 0.5, camera=False, ground=1.0)
    assert flight.fly(SILENT_S + 2 * AGREES_S, gnss=False).by_camera is None


def test_gnss_that_comes_in_a_doubt_is_not_taken_for_right() -> None:
    flight = Flight(40.0)
    flight.reading = HeightReading()
    flight.fly(24.0, 0.5, gnss=False, ground=1.0)
    facts = flight.fly(5.0, ground=1.0)
    assert facts.by_gnss is None
    assert facts.off == pytest.approx(12.0, abs=0.3)


def test_words_without_a_reported_height() -> None:
    facts = HeightFacts(by_gnss=6.0, by_camera=5.0, doubted_s=1.0)
    assert facts.words == "The height is not what the autopilot reports: 6 m off."
    assert HeightFacts(by_gnss=1.0, doubted_s=1.0).off == 1.0


# -- the size of the stalls --------------------------------------------------------------------------------------------


class Sizes(Beginning):
    """A camera that sees stalls of 2.5 m twice a second. ``off``: metres by which ``height`` is above the true one."""

    def fly(self, seconds: float, drift: float = 0.0, *, width: float = 2.5, gnss: bool = True) -> HeightFacts:
        """Fly while the reported height gains ``drift`` m/s on the true one."""
        for _ in range(round(seconds / 0.5)):
            self.now, self.off = self.now + 0.5, self.off + 0.5 * drift
            if gnss:
                self.reading.note_gnss(self.now, 100.0 + self.height - self.off, 1.0, 100.0 + self.height)
            self.reading.note_size(StallSize(self.now, width * self.height / (self.height - self.off), self.height))
            facts = self.reading.look(self.now, self.height)
        return facts


@pytest.mark.fault(
    "the barometer drifts by 0.05 m/s, too slowly for the camera's minute",
    "doubted at 4 m by GNSS altitude and the size of the stalls",
)
def test_a_drift_that_is_too_slow_for_the_cameras_minute_is_doubted_by_size_and_gnss() -> None:
    flight = Sizes()
    flight.fly(120.0)
    assert not flight.fly(60.0, 0.05).is_doubted, "3 m"
    facts = flight.fly(40.0, 0.05)
    assert facts.is_doubted
    assert facts.off == pytest.approx(5.0, abs=0.6)
    assert facts.by_camera is None


def test_the_size_alone_is_no_doubt_and_with_the_growth_it_is_one_witness() -> None:
    flight = Sizes()
    flight.fly(60.0)
    facts = flight.fly(20.0, 0.5, gnss=False)
    assert facts.by_size is not None
    assert facts.by_size > 5.0
    assert not facts.is_doubted
    flight.reading.note(GroundStep(flight.now - 1, flight.now, (0.0, 0.0), (0.0, 0.0), math.log(2.0), 0.0, 20.0))
    facts = flight.fly(2.0, gnss=False)
    assert facts.by_camera == pytest.approx(10.0)
    assert (len(facts.votes), facts.is_doubted) == (1, False)
    assert HeightFacts(by_camera=1.0, by_size=3.0).votes == (3.0,)
    assert HeightFacts(by_camera=-4.0, by_size=-3.0).votes == (-4.0,)
    assert HeightFacts(by_camera=1.0, by_size=-3.0).votes == (1.0,), "the growth is the exact one"
    assert HeightFacts(by_size=-3.0).votes == (-3.0,)
    assert HeightFacts(by_gnss=5.0, by_camera=-4.0, by_size=3.0, by_range=1.0).votes == (5.0, -4.0, 1.0)


@pytest.mark.parametrize(("width", "off"), [(2.94, None), (2.96, 3.108), (2.18, None), (2.17, -3.041)])
def test_rows_of_other_widths_explain_fifteen_hundredths_of_the_height(width: float, off: float | None) -> None:
    flight = Sizes()
    flight.fly(60.0)
    assert flight.fly(8.0, width=width).by_size == (None if off is None else pytest.approx(off, abs=0.001))


def test_a_usual_size_needs_ten_readings_of_half_a_minute_ago() -> None:
    early, late = Sizes(), Sizes()
    early.fly(SETTLED_S - 0.5)
    late.fly(SETTLED_S + 0.5)
    assert early.fly(5.0, width=5.0).by_size is None
    assert late.fly(5.0, width=5.0).by_size == pytest.approx(10.0)
    assert late.reading.look(late.now + SILENT_S, 20.0).by_size == pytest.approx(10.0)
    assert late.reading.look(late.now + SILENT_S + 0.1, 20.0).by_size is None


def test_two_sizes_in_five_seconds_are_too_few() -> None:
    flight = Sizes()
    flight.fly(60.0)
    for since, found in ((5.5, None), (1.0, None), (1.0, 10.0)):
        flight.now += since
        flight.reading.note_size(StallSize(flight.now, 5.0, 20.0))
        assert flight.reading.look(flight.now, 20.0).by_size == found


def test_a_size_that_other_rows_explain_ends_no_doubt() -> None:
    flight = Sizes(40.0)
    flight.fly(60.0)
    assert not flight.fly(15.0, 0.37).is_doubted, "5.5 m of 40 m: less than fifteen hundredths"
    since = flight.now - 1.0
    flight.reading.note(GroundStep(since, flight.now, (0.0, 0.0), (0.0, 0.0), math.log(40.0 / 34.5), 0.0, 40.0))
    assert flight.fly(3.0).is_doubted
    facts = flight.fly(60.0, gnss=False)
    assert facts.by_size is None
    assert facts.is_doubted
    assert facts.off == pytest.approx(5.5, abs=0.5)


def test_sizes_are_compared_at_like_heights_because_a_lot_may_lie_lower_than_the_arm_place() -> None:
    """A lot 5 m below: at 15 m stalls seem 0.75 times as wide, at 60 m 0.92 times, and nothing is wrong."""
    flight = Sizes(15.0)
    flight.fly(60.0, width=2.5 * 15.0 / 20.0)
    flight.height = 60.0
    facts = flight.fly(25.0, width=2.5 * 60.0 / 65.0)
    assert facts.by_size is None
    facts = flight.fly(60.0, width=2.5 * 60.0 / 65.0)
    assert facts.by_size is None
    assert flight.fly(8.0, width=2.5).by_size is None
    assert flight.fly(8.0, width=3.0).by_size == pytest.approx(60.0 * (1.0 - 60.0 / 65.0 / 1.2), abs=0.01)


def test_what_is_seen_in_doubt_becomes_never_usual() -> None:
    flight = Sizes()
    flight.fly(60.0)
    assert flight.fly(12.0, 0.5).is_doubted
    facts = flight.fly(300.0)
    assert facts.is_doubted
    assert facts.by_size == pytest.approx(6.0, abs=0.1)
    flight.reading.stand()
    assert flight.fly(5.0).by_size is None


# -- reactions ---------------------------------------------------------------------------------------------------------


def doubted(facts: Facts, off: float = 6.0) -> Facts:
    return replace(facts, witness=WitnessFacts(height=HeightFacts(off, off, None, 30.0, 1.0)))


def low(facts: Facts) -> Facts:
    return replace(facts, battery=replace(facts.battery, reached_s=5.0))


def test_a_doubt_ends_a_task_and_makes_the_position_unhealthy() -> None:
    facts = doubted(flying(0.0))
    found = guard.reaction(facts, made(ToExplore()))
    assert found is not None
    assert isinstance(found.transition, ToHover)
    assert found.transition.reason == "The height is not what the autopilot reports: 30 m, truly about 24 m."
    assert facts.witness.position_health(Health()).reason == found.transition.reason


@pytest.mark.fault("the barometer drifts by 0.5 m/s, up or down, and the height and climb with it, all flags good")
def test_a_drone_that_is_lower_than_reported_lands_in_place_of_a_return() -> None:
    cause = Cause("The program ends.", CauseKind.ALWAYS)
    found = guard.reaction(low(doubted(flying(0.0))), made(ToHover()))
    assert found is not None
    assert isinstance(found.transition, ToLand)
    assert isinstance(returning(doubted(flying(0.0)), cause), ToLand)
    higher = guard.reaction(low(doubted(flying(0.0), -6.0)), made(ToHover()))
    assert higher is not None
    assert isinstance(higher.transition, ToReturn)
    assert isinstance(returning(doubted(flying(0.0), -6.0), cause), ToReturn)


@pytest.mark.fault("the barometer drifts by 0.5 m/s, up or down, and the height and climb with it, all flags good")
def test_hover_keeps_the_true_height() -> None:
    state = made(ToHover())
    assert targets(state.process(flying(0.05)))[0].height == 30.0
    assert targets(state.process(doubted(flying(0.1), 6.0)))[0].height == 36.0
    assert targets(state.process(doubted(flying(0.15), -6.0)))[0].height == 24.0
    begun = made(ToHover())
    begun.process(at(doubted(flying(0.05), 6.0)))
    assert targets(begun.process(at(doubted(flying(0.1), 7.0))))[0].height == 31.0


@pytest.mark.fault(
    "the barometer drifts by 0.5 m/s, all flags good, and GNSS altitude, or every witness, goes silent in the doubt",
    "the doubt stays and the drone keeps its height: it does not sink by what was known",
)
def test_hover_does_not_sink_when_the_witnesses_go_silent() -> None:
    flight, state = Flight(40.0), made(ToHover())

    def height(now: float, facts: HeightFacts) -> float:
        seen = replace(at(flying(now), height=40.0), witness=WitnessFacts(height=facts))
        return targets(state.process(seen))[0].height

    flight.fly(12.0, 0.5)  # the height is doubted already when the drone begins to hold
    assert height(0.05, flight.facts()) == pytest.approx(40.0)
    risen = height(0.1, flight.fly(12.0, 0.5))
    assert risen == pytest.approx(46.0, abs=0.6)
    flight.now += 60.0
    assert height(0.15, flight.facts()) == pytest.approx(risen, abs=0.6)


def test_the_true_height_is_kept_between_min_and_ceiling() -> None:
    goal = Goal(0.0, 0.0, 30.0, 0.0)
    assert raised(doubted(flying(0.0), -20.0), goal, 0.0) == replace(goal, height=15.0)
    assert raised(doubted(flying(0.0), 67.0), goal, 0.0) == replace(goal, height=97.0)
    assert raised(doubted(flying(0.0), 67.1), goal, 0.0) is None


def test_a_height_that_cannot_be_kept_below_the_ceiling_ends_in_a_landing() -> None:
    state = made(ToHover())
    state.process(flying(0.05))
    for now in (1.0, 1.0 + STRAYS_S):
        facts = doubted(flying(now), 70.0)
        state.process(facts)
    step = state.transition_next_state(facts)
    assert isinstance(step.transition, ToLand)
    assert step.transition.cause is not None
    assert step.transition.cause.text.endswith("It cannot be held below the ceiling.")


# -- compasses ---------------------------------------------------------------------------------------------------------


@pytest.mark.fault(
    "all compasses fail in flight",
    "reported, part `compass` unhealthy, the flight goes on; Arm is refused on the ground",
)
def test_compasses_that_fail_are_reported_once_and_shown() -> None:
    reports, hover = WitnessNotices(), made(ToHover())
    lost = replace(flying(0.0), diagnostics=replace(flying(0.0).diagnostics, compass_ok=False))
    works = replace(flying(0.0), diagnostics=replace(flying(0.0).diagnostics, compass_ok=True))
    assert reports.tick(flying(0.0), hover) == ()
    assert texts(reports.tick(lost, hover)) == [COMPASS_LOST]
    assert reports.tick(lost, hover) == ()
    assert texts(reports.tick(works, hover)) == ["A compass works again."]
    assert compass_part(Diagnostics()) == ()
    assert compass_part(works.diagnostics) == (("compass", Health()),)
    assert compass_part(lost.diagnostics) == (("compass", Health.bad(COMPASS_LOST)),)
    assert guard.reaction(lost, made(ToExplore())) is None, "it flies on well"


# -- the whole state machine -------------------------------------------------------------------------------------------


@pytest.mark.nightly
async def test_a_drifting_barometer_is_found_by_gnss_and_rangefinder(holding: Rig) -> None:
    """A rangefinder that follows the drone down and GNSS that follows it too, while the reported height stays."""
    topics = holding.autopilot.topics
    for k in range(40):
        now, sunk = holding.clock(), 0.25 * max(0, k - 4)
        topics.terrain.publish(Terrain(now, distance=30.0 - sunk, ground=sunk, most=50.0))
        topics.terrain.publish(Terrain(now + 0.01, distance=1.0, ground=29.0, most=50.0, doubt="stuck"))
        topics.gnss_height.publish(GnssHeight(now, 130.0 - sunk, 1.0, 130.0))
        await holding.run(0.5)
    facts = holding.manager.situation().facts
    assert facts.witness.height.by_range == pytest.approx(8.75)
    assert "truly about" in facts.health("position").reason
    assert "truly about" in holding.command(AutonomousExplore()).reason
    assert any("The height is not what the autopilot reports" in line for line in holding.log)
    assert holding.autopilot.height > 35.0, "the target went up by as much"
