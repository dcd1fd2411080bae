"""The steps of a viewer's pictures over simulated links."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable
from dataclasses import dataclass, field

import pytest

from hawk.web.video.viewers import FRESH_S, HOLD_S, LONGEST_HOLD_S, SLOW_S, STEPS, TRIAL_S, LinkPace

SIZES = (80_000, 40_000, 22_000, 13_000, 8_000)
"""Bytes by step, as of a picture of a lot 960 pixels wide."""
FRAME_S = 0.1


@dataclass
class Link:
    """One picture in flight over a link of some bytes a second and some delay."""

    pace: LinkPace
    bytes_per_s: Callable[[float], float]
    delay_s: float = 0.02
    buffer_bytes: int = 0
    """Bytes that the other side's system acknowledges before they have crossed the link."""
    now: float = 1000.0
    steps: list[tuple[float, int]] = field(default_factory=list)
    """Time and step of each picture sent."""
    ages: list[float] = field(default_factory=list)

    def run(self, seconds: float) -> None:
        end = self.now + seconds
        while self.now < end:
            self.steps.append((self.now, self.pace.step))
            took = self.delay_s + max(0, SIZES[self.pace.step] - self.buffer_bytes) / self.bytes_per_s(self.now)
            self.now += took
            self.ages.append(took)
            self.pace.arrived(self.now, took)
            self.now = max(self.now, self.steps[-1][0] + FRAME_S)

    def changes(self, since: float) -> int:
        steps = [step for at, step in self.steps if at >= since]
        return sum(a != b for a, b in itertools.pairwise(steps))


def steady(bytes_per_s: float) -> Callable[[float], float]:
    return lambda _now: bytes_per_s


def test_a_quick_link_takes_whole_pictures_after_the_first() -> None:
    link = Link(LinkPace(), steady(5e6), delay_s=0.001)
    link.run(1.0)
    assert [step for _, step in link.steps[:4]] == [STEPS, 0, 0, 0]


@pytest.mark.fault(
    "a steady link of any speed, a link whose speed changes by 40 %",
    "pictures settle on one size; they change their size at most every 20 s",
)
@pytest.mark.parametrize("is_acknowledged", [True, False])
@pytest.mark.parametrize("kilobytes", [3, 8, 15, 20, 25, 30, 40, 60, 80, 100, 130, 160, 240, 500, 1500])
def test_a_steady_link_settles_on_one_step_and_stays(kilobytes: int, is_acknowledged: bool) -> None:
    link = Link(LinkPace(is_acknowledged=is_acknowledged), steady(kilobytes * 1e3))
    link.run(120.0)
    assert link.changes(since=1060.0) == 0
    settled = link.steps[-1][1]
    takes = link.delay_s + SIZES[settled] / (kilobytes * 1e3)
    assert takes <= SLOW_S or settled == STEPS
    if settled > 0:  # the next larger step would not have been fresh
        assert link.delay_s + SIZES[settled - 1] / (kilobytes * 1e3) > FRESH_S


def test_each_link_between_the_smallest_and_the_whole_has_its_step() -> None:
    settled = set()
    for kilobytes in range(15, 320, 5):
        link = Link(LinkPace(), steady(kilobytes * 1e3))
        link.run(60.0)
        settled.add(link.steps[-1][1])
    assert settled == set(range(STEPS + 1))


@pytest.mark.fault(
    "a link that becomes slow, and recovers",
    "smaller pictures meanwhile, whole ones again within seconds",
)
@pytest.mark.parametrize("is_acknowledged", [True, False])
def test_pictures_become_whole_again_when_the_link_recovers(is_acknowledged: bool) -> None:
    link = Link(LinkPace(is_acknowledged=is_acknowledged), lambda now: 15e3 if 1020 <= now < 1050 else 2e6)
    link.run(20.0)
    assert link.pace.step == 0
    link.run(30.0)
    assert link.pace.step == STEPS
    link.run(HOLD_S + 1.0)
    assert link.pace.step == 0


def test_a_stall_costs_two_small_pictures_where_acknowledgements_show_the_room() -> None:
    pace = LinkPace()
    for now in (1.0, 1.1, 1.2):
        pace.arrived(now, 0.005)
    assert pace.step == 0
    pace.arrived(6.3, 5.0)
    assert pace.step == STEPS
    now = 6.3
    while pace.step > 0:
        now += 0.1
        pace.arrived(now, 0.005)
    assert now - 6.3 <= 0.5


def test_a_larger_step_that_is_too_large_is_tried_ever_more_seldom() -> None:
    """Behind a buffer that swallows small pictures every arrival looks quick until the picture does not fit."""
    link = Link(LinkPace(is_acknowledged=False), steady(10e3), buffer_bytes=22_000)
    link.run(600.0)
    assert {step for at, step in link.steps if at > 1100.0} == {1, 2}
    tried = [at for (_, before), (at, step) in zip(link.steps, link.steps[1:], strict=False) if before == 2 > step]
    gaps = [b - a for a, b in itertools.pairwise(tried)]
    assert 5 * gaps[0] < gaps[-1]
    assert max(gaps) >= LONGEST_HOLD_S
    assert len(tried) <= 5 + 600.0 / LONGEST_HOLD_S
    assert max(link.ages[1:]) < 2.0


def test_a_trial_that_holds_makes_the_next_ones_quick_again() -> None:
    link = Link(LinkPace(is_acknowledged=False), lambda now: 10e3 if now < 1200.0 else 5e6, buffer_bytes=22_000)
    link.run(200.0)
    link.run(LONGEST_HOLD_S + TRIAL_S + 2 * HOLD_S)
    assert link.pace.step == 0


@pytest.mark.fault("a steady link of any speed, a link whose speed changes by 40 %")
@pytest.mark.parametrize("seed", range(5))
def test_a_link_of_changing_speed_does_not_make_the_pictures_flicker(seed: int) -> None:
    rng = random.Random(seed)
    link = Link(LinkPace(), lambda _now: 120e3 * rng.uniform(0.6, 1.4))
    link.run(300.0)
    assert link.changes(since=1010.0) <= 300.0 / 20.0
    assert max(link.ages) <= 2.0


def test_a_delay_within_fresh_does_not_make_pictures_small() -> None:
    link = Link(LinkPace(), steady(5e6), delay_s=0.3)
    link.run(20.0)
    assert link.pace.step == 0


@pytest.mark.parametrize(("seconds", "step"), [(SLOW_S, 0), (1.01 * SLOW_S, 1), (2.0 * SLOW_S, 2), (60.0, STEPS)])
def test_the_slower_a_picture_the_smaller_the_next(seconds: float, step: int) -> None:
    pace = LinkPace(is_acknowledged=False)
    pace.arrived(100.0, seconds)
    assert pace.step == step
