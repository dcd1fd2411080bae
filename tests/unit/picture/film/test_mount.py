"""Mounts of a camera of which the log says nothing: the side that the film's motion agrees with."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from hawk.picture.film.clock import ClockFit, SeveralError
from hawk.picture.film.course import Course
from hawk.picture.film.mount import find_mount
from hawk.picture.values import PictureError

FLOWN = Course(
    np.array([0.0, 1.0]), np.full(2, 46.0), np.full(2, -91.0), np.full(2, 100.0), np.full(2, 30.0),
    np.array([(0.1, -0.2, 0.5), (0.1, -0.2, 0.6)]),
)  # fmt: skip


def fits(off_of: dict[tuple[int, bool], float]) -> tuple[list[tuple[int, bool]], Callable[[Course], ClockFit]]:
    """Return the (quarter, is level) that were tried, and a fit that knows some of them by how far each is off."""
    tried: list[tuple[int, bool]] = []

    def fit(course: Course) -> ClockFit:
        roll, pitch, yaw = course.attitude[0]
        is_level = abs(roll) + abs(pitch) < 1e-9
        quarter = round(math.remainder(yaw - 0.5, math.tau) / (math.pi / 2)) % 4
        tried.append((quarter, is_level))
        if (quarter, is_level) not in off_of:
            raise PictureError(f"nowhere {quarter} {is_level}")
        return ClockFit(7.0, "", off_of[quarter, is_level])

    return tried, fit


@pytest.mark.parametrize(
    ("off_of", "is_steadied", "side", "count"),
    [
        ({(0, False): 0.2, (0, True): 0.1, (1, False): 0.01}, True, "nose", 2),
        ({(0, False): 0.1, (0, True): 0.2}, False, "nose", 2),
        ({(1, False): 0.2, (3, True): 0.1}, True, "left", 8),
        ({(1, False): 0.1, (2, True): 0.2}, False, "right", 8),
        ({(2, False): 0.1}, False, "tail", 8),
    ],
)
def test_the_nose_counts_first_and_then_the_side_that_agrees_best(
    off_of: dict[tuple[int, bool], float], is_steadied: bool, side: str, count: int
) -> None:
    tried, fit = fits(off_of)
    mount = find_mount(FLOWN, fit)
    assert (mount.is_steadied, len(tried), len({*tried})) == (is_steadied, count, count)
    assert mount.note.endswith(f"its picture's top to the {side}")
    assert ("held straight down" in mount.note) == is_steadied
    assert mount.fitted.off == min(off for (quarter, _), off in off_of.items() if quarter == 0 or side != "nose")
    swayed = 0.0 if is_steadied else math.hypot(0.1, 0.2)
    assert np.hypot(*mount.course.attitude[0, :2]) == pytest.approx(swayed, abs=1e-3)


def test_the_first_refusal_is_said_where_none_fits_and_several_places_end_the_search() -> None:
    tried, fit = fits({})
    with pytest.raises(PictureError, match="nowhere 0 False"):
        find_mount(FLOWN, fit)
    assert len(tried) == 8

    def several(_: Course) -> ClockFit:
        tried.append((0, False))
        raise SeveralError("several")

    with pytest.raises(SeveralError):
        find_mount(FLOWN, several)
    assert len(tried) == 9
