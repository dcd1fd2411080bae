"""The reported heading against the camera's, by values."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import AutonomousExplore
from hawk.ddc.orders import ToExplore, ToHover
from hawk.ddc.rules import guard
from hawk.ddc.witnesses.heading import AGREES_S, CONFIRM_S, LIMIT_DEG, WINDOW_S, HeadingFacts, HeadingReading
from hawk.ddc.witnesses.witness import WitnessFacts
from hawk.model.operation import Health, StateName
from hawk.model.pictures import GroundStep
from tests.unit.ddc.by_facts import made
from tests.unit.ddc.fakes import Rig
from tests.unit.ddc.written_facts import flying

STEP_S = 0.4


class Flight:
    """Steps of a camera, one every 0.4 s; ``now`` in seconds."""

    def __init__(self) -> None:
        self.reading = HeadingReading()
        self.now = 0.0

    def fly(self, seconds: float, error_deg_s: float = 0.0) -> HeadingFacts:
        """Fly while the reported heading gains ``error_deg_s`` clockwise, degrees a second."""
        for _ in range(round(seconds / STEP_S)):
            turn = -math.radians(error_deg_s) * STEP_S
            self.reading.note(GroundStep(self.now, self.now + STEP_S, (0.0, 0.0), (0.0, 0.0), 0.0, turn, 25.0))
            self.now += STEP_S
        return self.reading.facts(self.now)


def test_before_the_first_step_nothing_is_said() -> None:
    facts = HeadingReading().facts(0.0)
    assert (facts, facts.is_doubted, facts.words) == (HeadingFacts(), False, "")


@pytest.mark.fault(
    "all compasses turn by 25° and more within 30 s, all flags good",
    "reported, the part `position` unhealthy, the task ends by Hover, new tasks are refused, nothing is mapped",
)
@pytest.mark.parametrize("error", [15.0, -15.0])
def test_a_heading_that_turns_away_is_doubted_at_the_limit(error: float) -> None:
    flight = Flight()
    flight.fly(20.0)
    assert not flight.fly(LIMIT_DEG / 15.0, error).is_doubted
    facts = flight.fly(2 * CONFIRM_S + 2 * STEP_S, error)
    assert facts.is_doubted
    assert math.degrees(facts.off) == pytest.approx(math.copysign(40.0, error), abs=8.0)
    assert facts.words == (
        f"The heading is not what the autopilot reports: the camera sees it {abs(math.degrees(facts.off)):.0f}° off."
    )


def turned(*turns: tuple[float, float], gaps: int = 0) -> HeadingReading:
    """Return a reading that saw the ground turn: ends of steps in seconds, and degrees."""
    reading, last = HeadingReading(), 0.0
    for until, degrees in turns:
        since = last + 0.01 if gaps > 0 and last > 0.0 else last
        gaps -= since > last
        reading.note(GroundStep(since, until, (0.0, 0.0), (0.0, 0.0), 0.0, -math.radians(degrees), 25.0))
        last = until
    return reading


def test_turns_count_for_half_a_minute() -> None:
    assert math.degrees(turned((1.0, 10.0), (31.0, 0.0)).facts(31.0).off) == pytest.approx(10.0)
    assert turned((1.0, 10.0), (31.5, 0.0)).facts(31.5).off == 0.0


@pytest.mark.parametrize(
    ("off", "gaps", "doubted"),
    [(24.9, 0, False), (25.1, 0, True), (-25.1, 0, True), (36.9, 1, False), (37.1, 1, True), (49.1, 2, True)],
)
def test_the_limit_is_wider_by_each_gap(off: float, gaps: int, doubted: bool) -> None:
    reading = turned((1.0, off), (2.0, 0.0), (3.0, 0.0), (3.5, 0.0), gaps=gaps)
    assert reading.facts(3.5).is_doubted is doubted


def test_half_a_second_of_disagreement_is_a_doubt() -> None:
    assert not turned((1.0, 30.0), (1.49, 0.0)).facts(1.49).is_doubted
    assert turned((1.0, 30.0), (1.5, 0.0)).facts(2.5).doubted_s == 1.0


@pytest.mark.parametrize(("back", "seconds", "doubted"), [(18.1, 10.0, False), (18.1, 9.9, True), (17.9, 20.0, True)])
def test_it_ends_ten_seconds_after_the_heading_is_back_to_within_twelve_degrees(
    back: float, seconds: float, doubted: bool
) -> None:
    reading = turned((1.0, 30.0), (1.5, 0.0), (2.0, -back), (2.0 + seconds, 0.0))
    assert reading.facts(2.0 + seconds).is_doubted is doubted


def test_a_gap_in_the_comparison_may_hide_a_part_of_a_turn() -> None:
    flight = Flight()
    flight.fly(4.0)
    flight.now += 1.0
    assert not flight.fly(2.4, 15.0).is_doubted, "36° after one gap"
    assert flight.fly(1.2, 15.0).is_doubted


def test_a_turn_beyond_the_limit_must_last() -> None:
    flight = Flight()
    assert not flight.fly(STEP_S, 80.0).is_doubted
    assert not flight.fly(STEP_S, -80.0).is_doubted
    assert not flight.fly(10.0).is_doubted


def test_what_adds_up_over_more_than_the_window_is_none() -> None:
    assert not Flight().fly(10 * WINDOW_S, 0.9 * LIMIT_DEG / WINDOW_S).is_doubted


def test_a_heading_that_stays_off_stays_doubted_and_one_that_comes_back_is_believed_again() -> None:
    flight = Flight()
    flight.fly(4.0, 15.0)
    assert flight.fly(4 * WINDOW_S).is_doubted
    assert flight.fly(4.0, -15.0).is_doubted
    assert flight.fly(AGREES_S - 2.0).is_doubted
    assert not flight.fly(3.0).is_doubted
    assert flight.fly(4.0, 15.0).is_doubted, "the next one is seen as well"


def test_an_agreement_that_is_broken_begins_again() -> None:
    flight = Flight()
    flight.fly(4.0, 15.0)
    flight.fly(4.0, -15.0)
    flight.fly(AGREES_S - 2.0)
    flight.fly(2.0, 15.0)
    flight.fly(2.0, -15.0)
    assert flight.fly(AGREES_S - 2.0).is_doubted


def test_on_the_ground_it_is_forgotten() -> None:
    flight = Flight()
    flight.fly(4.0, 15.0)
    flight.reading.reset()
    assert flight.fly(STEP_S) == HeadingFacts()


@pytest.mark.fault("all compasses turn by 25° and more within 30 s, all flags good")
def test_the_guard_ends_a_task_while_the_heading_is_doubted() -> None:
    facts = flying(10.0)
    doubt = WitnessFacts(heading=HeadingFacts(math.radians(-60.0), 1.0))
    reaction = guard.reaction(replace(facts, witness=doubt), made(ToExplore()))
    assert reaction is not None
    assert isinstance(reaction.transition, ToHover)
    assert reaction.transition.reason == doubt.doubt
    assert guard.reaction(facts, made(ToExplore())) is None
    assert doubt.position_health(Health()) == Health.bad(doubt.doubt)
    assert "60° off" in doubt.doubt
    assert not doubt.misleads_home


@pytest.mark.nightly
async def test_a_drone_whose_heading_is_doubted_goes_on_holding(fresh: Rig) -> None:
    await fresh.enter(StateName.HOVER)
    for _ in range(30):
        now = fresh.clock()
        fresh.inputs.ground_step.publish(GroundStep(now - 0.4, now, (0.0, 0.0), (0.0, 0.0), 0.0, 0.1, 25.0))
        await fresh.run(0.4)
    fresh.expect(StateName.HOVER)
    answer = fresh.command(AutonomousExplore())
    assert not answer.accepted
    assert "heading" in answer.reason


@pytest.mark.slow
@pytest.mark.fault("all compasses turn by 25° and more within 30 s, all flags good")
async def test_the_camera_ends_a_task_and_nothing_is_mapped(fresh: Rig) -> None:
    await fresh.enter(StateName.AUTONOMOUS_EXPLORE)
    for _ in range(12):
        now = fresh.clock()
        fresh.inputs.ground_step.publish(GroundStep(now - 0.4, now, (0.0, 0.0), (0.0, 0.0), 0.0, 0.1, 25.0))
        await fresh.run(0.4)
    fresh.expect(StateName.HOVER)
    assert "The heading is not what the autopilot reports" in (fresh.topics.doubt_pub.value or "")
    assert any("the camera sees it" in entry.text for entry in fresh.manager.log.entries)
