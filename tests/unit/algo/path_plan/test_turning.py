from __future__ import annotations

import math

import numpy as np

from hawk.algo.path_plan.footprint import Footprint, Singles
from hawk.algo.path_plan.phases import Turning
from hawk.algo.path_plan.tour import Wanted

PICTURE = Footprint(40.0, 24.0, 19.0, 19.0)
STEP = 0.15


def disc(radius: float = 19.0) -> Singles:
    cells = [(n, e) for n in np.arange(-20, 20, 1.6) for e in np.arange(-20, 20, 1.6) if math.hypot(n, e) <= radius]
    return np.array(cells, np.float32)


def wanted(cells: Singles) -> Wanted:
    return Wanted(cells, np.full(len(cells), 2.56, np.float32), 0.0)


def unseen(cells: Singles, heading: float) -> Singles:
    left, _ = PICTURE.turns_until_shown(cells, heading)
    return cells[left > 0]


def turned(cells: Singles, heading: float, turning: Turning) -> tuple[float, Singles]:
    """Return by how much the drone turned in all, and what it did not see."""
    total = 0.0
    for _ in range(100):
        cells = unseen(cells, heading)
        asked = turning.heading((0.0, 0.0), heading, wanted(cells))
        if asked is None:
            return total, cells
        step = max(-STEP, min(STEP, math.remainder(asked - heading, math.tau)))
        heading, total = heading + step, total + abs(step)
    raise AssertionError("it turns for ever")


def test_it_turns_until_the_disc_is_shown_and_no_farther() -> None:
    total, left = turned(disc(), 0.3, Turning((0.0, 0.0), PICTURE, 30.0, 24))
    assert len(left) * 2.56 < 30
    assert math.radians(70) < total < math.radians(130)


def test_it_turns_by_the_smaller_angle() -> None:
    ahead = disc()[(disc()[:, 0] > 13) & (disc()[:, 1] > 2)]  # before the drone, to the right
    asked = Turning((0.0, 0.0), PICTURE, 10.0, 24).heading((0.0, 0.0), 0.0, wanted(ahead))
    assert asked is not None
    assert asked < 0  # the right-hand side of the picture comes forward
    mirrored = Turning((0.0, 0.0), PICTURE, 10.0, 24).heading((0.0, 0.0), 0.0, wanted(ahead * (1, -1)))
    assert mirrored is not None
    assert mirrored > 0


def test_little_is_not_turned_for() -> None:
    ahead = np.array([[17.0, 0.0]], np.float32)
    assert Turning((0.0, 0.0), PICTURE, 30.0, 24).heading((0.0, 0.0), 0.0, wanted(ahead)) is None
    assert Turning((0.0, 0.0), PICTURE, 2.0, 24).heading((0.0, 0.0), 0.0, wanted(ahead)) is not None


def test_a_drone_that_does_not_turn_and_ground_that_is_never_seen_end_it() -> None:
    turning, plans = Turning((0.0, 0.0), PICTURE, 30.0, 24), 0
    while turning.heading((0.0, 0.0), 0.0, wanted(disc())) is not None:
        plans += 1
    assert plans == 24
    turning, heading = Turning((0.0, 0.0), PICTURE, 30.0, 24), 0.0
    while turning.heading((0.0, 0.0), heading, wanted(disc())) is not None:
        heading += STEP
    assert math.pi < heading < math.pi + 3 * STEP
