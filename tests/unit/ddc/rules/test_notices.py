"""Ground that is not as high as the arm place is reported once, with what to do about Min."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.comm.autopilot.terrain import Terrain
from hawk.ddc.acts import Log
from hawk.ddc.facts import Facts
from hawk.ddc.readings.clearance import BelowFacts
from hawk.ddc.rules.notices import GroundNotices
from tests.unit.ddc.fakes import Rig
from tests.unit.ddc.written_facts import flying, on_ground


def over(ground: float | None, doubt: str = "") -> Facts:
    """A drone at 30 m over ground of this height, Min 15 m."""
    facts = flying(100.0)
    below = BelowFacts(Terrain(100.0, 20.0, ground, 50.0, doubt))
    return replace(facts, position=replace(facts.position, below=below))


def messages(reports: GroundNotices, *grounds: float | None) -> list[str]:
    acts = [act for ground in grounds for act in reports.tick(over(ground))]
    return [act.text for act in acts if isinstance(act, Log)]


@pytest.mark.fault(
    "the ground rises or sinks by a third of Min",
    "reported once, with the Min that clears the declared obstacle",
)
def test_risen_and_sunken_ground_are_reported_once() -> None:
    reports = GroundNotices(None)
    assert messages(reports, 0.0, 4.9, -4.9) == []
    risen = "The ground here is 6 m higher than the arm place: raise Min."
    assert messages(reports, 5.9, 5.1, 6.0, 4.0, 6.0, 9.0) == [risen]
    assert messages(reports, -6.0, -7.0) == ["The ground here is 6 m lower than the arm place."]
    assert messages(reports, 0.0, 6.0) == [risen]


@pytest.mark.parametrize(
    ("obstacle", "advice"),
    [
        (2.0, "Min clears an obstacle of 2 m on it by 7 m."),
        (9.0, "raise Min to 20 m, so that it clears an obstacle of 9 m on it."),
    ],
)
def test_the_declared_obstacle_stands_on_the_risen_ground(obstacle: float, advice: str) -> None:
    assert messages(GroundNotices(obstacle), 6.0) == [f"The ground here is 6 m higher than the arm place: {advice}"]


def test_what_is_not_known_or_not_believed_is_not_reported() -> None:
    reports = GroundNotices(None)
    assert messages(reports, None) == []
    assert reports.tick(over(12.0, "its distance does not follow the height")) == ()
    assert reports.tick(on_ground(over(12.0))) == ()


async def test_over_rising_ground_the_operator_reads_it(flying: Rig) -> None:
    flying.autopilot.below = lambda _north, _east: 6.0
    await flying.run(2.0)
    assert flying.log.count("The ground here is 6 m higher than the arm place: raise Min.") == 1
