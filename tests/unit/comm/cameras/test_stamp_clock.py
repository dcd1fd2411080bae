from __future__ import annotations

import random
from collections.abc import Iterator

import pytest

from hawk.comm.cameras.stamp_clock import Placed, StampClock
from tests.sweep import sweep

DELAY = 0.05
FAULT_S = 0.12
"""A picture is placed .5 m off at 4 m/s."""


class Camera:
    """Pictures at a rate, with the camera's clock off by ``offset`` and delays with jitter."""

    def __init__(self, fps: float, seed: int = 1, latency_s: float = 0.0) -> None:
        self.interval = 1.0 / fps
        self.now = 100.0
        self.offset = 5000.0
        self.delay = DELAY
        self.arrived = 0.0
        self._random = random.Random(seed)
        self.clock = StampClock(latency_s)

    def picture(self) -> tuple[float, Placed]:
        """Return the true time of a picture, and where its stamp places it."""
        self.now += self.interval * self._random.uniform(0.95, 1.05)
        self.arrived = max(self.arrived + 0.001, self.now + self.delay + self._random.expovariate(1 / 0.01))
        return self.now, self.clock.take(self.now + self.offset, self.arrived)

    def picture_of(self, stamp: float) -> None:
        """Let a picture come whose stamp is that of the one before; the first one may be a new one."""
        self.now += self.interval
        found = self.clock.take(stamp, self.now + self.delay)
        assert found.stands
        assert found.time is None

    def run(self, seconds: float) -> Iterator[tuple[float, Placed]]:
        for _ in range(max(1, round(seconds / self.interval))):
            yield self.picture()


def check(placed: list[tuple[float, Placed]]) -> int:
    """Return the number of pictures left out; every other one is placed right."""
    for true, found in placed:
        if found.time is not None:
            assert abs(found.time - DELAY - true) < FAULT_S
    return sum(found.time is None for _, found in placed)


@pytest.mark.fault(
    "the camera's clock steps by .2 s to a day, forward or back, at 3 to 30 pictures a second",
    "no picture is placed by the old clock: four to eight are left out, then the new one is used; where "
    "missing pictures hide the step, four seconds are left out",
)
@sweep("fps", [3.0, 10.0, 30.0])
@sweep("step", [-0.2, -0.35, -0.5, -0.9, -3.0, -86400.0, 0.2, 0.35, 0.5, 0.9, 3.0, 86400.0])
def test_a_step_of_the_cameras_clock_places_no_picture_wrongly(fps: float, step: float) -> None:
    camera = Camera(fps)
    assert check(list(camera.run(10.0))) == 0
    camera.offset += step
    after = list(camera.run(20.0))
    assert 0 < check(after) <= 13, "the next pictures are placed again"
    (reported,) = [found.stepped_s for _, found in after if found.stepped_s is not None]
    assert reported == pytest.approx(step, abs=0.1)
    assert camera.clock.has_stepped == (step < 0)


def busy(camera: Camera, seconds: float, least: float, most: float) -> list[tuple[float, Placed]]:
    """Pictures on a busy computer: most are missing, and the delay of the others rises and falls."""
    found = []
    end = camera.now + seconds
    while camera.now < end:
        camera.now += camera.interval * camera._random.choice((0, 0, 1, 2, 5, 8))
        camera.delay = DELAY + camera._random.uniform(least, most)
        found.append(camera.picture())
    camera.delay = DELAY
    return found


@pytest.mark.slow
@pytest.mark.fault(
    "pictures are missing and late by .1 to .7 s on a busy computer",
    "no step is reported, no picture is placed wrongly",
)
@sweep("fps", [10.0, 30.0])
@sweep("least", [0.1, 0.3])
@sweep("seed", range(20))
def test_a_busy_computer_is_no_step(fps: float, least: float, seed: int) -> None:
    camera = Camera(fps, seed)
    check(list(camera.run(10.0)))
    after = busy(camera, 20.0, least, least + 0.4) + list(camera.run(10.0))
    assert [found.stepped_s for _, found in after if found.stepped_s is not None] == []
    assert not camera.clock.has_stepped
    check(after)


def test_after_a_step_in_a_gap_the_pictures_come_back_in_four_seconds() -> None:
    camera = Camera(10.0)
    check(list(camera.run(10.0)))
    camera.now += 1.0
    camera.offset -= 0.6
    after = list(camera.run(10.0))
    assert check(after) <= 40
    assert [found.stepped_s for _, found in after if found.stepped_s is not None] == [pytest.approx(-0.6, abs=0.05)]


@sweep("fps", [10.0, 30.0])  # where the gap and the step leave the usual interval, nothing shows it
@sweep("step", [-0.2, -0.9, 0.9])
@sweep("gap", [0.7, 2.3])
def test_a_step_in_a_gap_is_noticed_too(fps: float, step: float, gap: float) -> None:
    camera = Camera(fps)
    list(camera.run(10.0))
    camera.now += max(gap, 3 * camera.interval)
    camera.offset += step
    check(list(camera.run(10.0)))


@pytest.mark.fault("pictures come .2 to .9 s late, in bursts", "no step; they are placed by their stamps")
@sweep("fps", [3.0, 10.0, 30.0])
@sweep("more", [0.2, 0.5, 0.9])
@sweep("seed", range(5))
def test_a_delay_in_transit_is_no_step(fps: float, more: float, seed: int) -> None:
    camera = Camera(fps, seed)
    list(camera.run(10.0))
    for _ in range(3):
        camera.delay = DELAY + more
        late = list(camera.run(1.0))
        camera.delay = DELAY
        check(late + list(camera.run(3.0)))


def test_pictures_that_are_dropped_are_no_step() -> None:
    camera = Camera(10.0)
    for _ in range(50):
        camera.now += camera._random.choice((0.0, 0.1, 0.2, 0.5))
        assert check([camera.picture()]) == 0
    assert not camera.clock.has_stepped


def test_a_single_stamp_ahead_moves_nothing() -> None:
    camera = Camera(10.0)
    list(camera.run(5.0))
    camera.offset += 0.7
    assert camera.picture()[1] == Placed(None)
    camera.offset -= 0.7
    after = list(camera.run(20.0))
    assert check(after) <= 5


def test_a_repeated_stamp_is_no_step() -> None:
    clock = StampClock()
    assert [clock.take(5.0, 1.0 + n / 10).stepped_s for n in range(5)] == [None] * 5


def test_the_configured_latency_is_taken_off() -> None:
    camera = Camera(10.0, latency_s=0.03)
    for true, found in camera.run(10.0):
        assert found.time is not None
        assert found.time == pytest.approx(true + DELAY - 0.03, abs=0.06)


def test_at_a_higher_speed_real_delays_count_as_often() -> None:
    clock = StampClock(speed=8.0)
    for n in range(20):
        clock.take(n / 10, n / 10 + 0.01)
    assert clock.take(2.0, 2.0 - 0.5).stepped_s is None
    assert not clock.has_stepped


def test_stamps_ahead_that_disagree_are_no_step() -> None:
    camera = Camera(10.0)
    list(camera.run(5.0))
    for ahead in (0.7, 5.0, 20.0):
        camera.offset += ahead
        assert camera.picture()[1] == Placed(None)
    assert not camera.clock.has_stepped


@pytest.mark.parametrize("fps", [3.0, 10.0, 30.0])
def test_a_clock_that_stands_still_places_no_picture(fps: float) -> None:
    camera = Camera(fps)
    assert check(list(camera.run(10.0))) == 0
    stopped = camera.now + camera.offset
    for _ in range(round(40.0 * fps)):
        camera.picture_of(stopped)
    true, placed = camera.picture()
    assert placed.time is None or abs(placed.time - DELAY - true) < FAULT_S
    check(list(camera.run(10.0)))


@pytest.mark.fault("the camera's clock stands still, or counts whole seconds only")
def test_stamps_of_whole_seconds_place_the_first_picture_of_each() -> None:
    clock, placed = StampClock(), []
    for n in range(300):
        true = 100.0 + n / 10
        found = clock.take(float(int(true)), true + DELAY)
        assert found.stands == (n % 10 != 0)
        placed += [] if found.time is None else [found.time - DELAY - true]
    assert len(placed) >= 25
    assert max(map(abs, placed)) < 0.01
