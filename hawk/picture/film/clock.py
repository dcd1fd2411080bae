"""The moment of a log at which a film begins: where the motion that the film shows agrees with the flight's."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.picture.film.course import Course, FloatArray
from hawk.picture.film.motion import Motion, expected
from hawk.picture.values import PictureError

_GRID_S: Final = 0.1
_FINE_S: Final = 0.02
_GIVEN_S: Final = 5.0
"""About an offset that a person gives."""
_CREATED_S: Final = (90.0, 5.0)
"""About the moment that the film's file names: cameras' clocks are off by some seconds or a minute."""
_LEAST_COVERED: Final = 0.5
_STILL: Final = 0.002
"""Shift within `motion.BETWEEN_S`, focal lengths: 0.5 m/s from 75 m."""
_LARGE: Final = 75
"""Percentile of the shifts above which a disagreement counts no more."""
_AGREES: Final = 0.25
"""Largest mean disagreement, shares of that percentile: a lens that is 20 % off gives some .2."""
_APART_S: Final = 3.0
_CLEARER: Final = 0.06
"""The next best place must disagree by as much more, shares of the same."""
_LEAST: Final = 6
REMEDY: Final = "give the second of the log at which the film begins by --log-offset SECONDS, or name the right log"


@dataclass(frozen=True, slots=True)
class ClockFit:
    """``begin``: time of the log at the film's first frame. ``note``: a sentence on it. ``off``: mean disagreement."""

    begin: float
    note: str
    off: float = 1.0


def fit(
    name: str, motion: Motion, length: float, course: Course, offset_s: float | None, begun: float | None
) -> ClockFit:
    """Return where a film lies in a log.

    Args:
        name: Of the film.
        motion: By the film.
        length: Of the film, seconds.
        course: By the log, with the camera's heights and attitudes.
        offset_s: Seconds from the log's first place to the film's first frame, as a person gives them.
        begun: Unix time of the film's begin by its file, None where it does not say.

    Raises:
        PictureError: The log is too short, no place of it fits, or several do.
    """
    first, last = float(course.time[0]), float(course.time[-1])
    if last - first < _LEAST_COVERED * length:
        raise PictureError(
            f"{name}: the log covers {last - first:.0f} s, the film {length:.0f} s; name the log of the whole flight"
        )
    lowest, highest = first - (1 - _LEAST_COVERED) * length, last - _LEAST_COVERED * length
    if offset_s is not None and not lowest <= first + offset_s <= highest:
        raise PictureError(
            f"--log-offset {offset_s:g}: the log ends after {last - first:.0f} s, and the film lasts {length:.0f} s: "
            "the log does not cover it; name the log of this flight"
        )
    created = begun if begun is not None and course.epoch == 0.0 and lowest <= begun <= highest else None
    guess = first + offset_s if offset_s is not None else created
    if len(motion.time) < _LEAST or np.percentile(np.hypot(*motion.shift.T), _LARGE) < _STILL:
        return _unchecked(name, guess, first)
    search = _Search(motion, course)
    if offset_s is not None and guess is not None:
        return search.best(name, guess - _GIVEN_S, guess + _GIVEN_S, is_given=True)
    try:
        return search.best(name, lowest, highest)
    except SeveralError:
        for about in _CREATED_S if created is not None else ():
            try:
                return search.best(name, (created or 0.0) - about, (created or 0.0) + about)
            except PictureError:
                continue
        raise


class SeveralError(PictureError):
    """Several places of a log fit alike."""


class _Search:
    """Compares a film's motion with every part of a log."""

    def __init__(self, motion: Motion, course: Course) -> None:
        self._motion, self._course = motion, course
        self._cap = float(np.percentile(np.hypot(*motion.shift.T), _LARGE))
        self._first = float(course.time[0])
        self._times = np.arange(self._first, float(course.time[-1]) - motion.between, _GRID_S)
        self._shifts = expected(course, self._times, motion.between)
        self._shifts[~(course.covers(self._times) & course.covers(self._times + motion.between))] = np.nan

    def best(self, name: str, lowest: float, highest: float, *, is_given: bool = False) -> ClockFit:
        """Return the place between two times that fits best. Raises PictureError where none does, or several do."""
        begins = np.arange(lowest, highest + _GRID_S / 2, _GRID_S)
        costs = np.array([self._cost(begin) for begin in begins])
        least = int(costs.argmin())
        if costs[least] > _AGREES:
            raise PictureError(
                f"{name}: the motion that it shows agrees with the log nowhere"
                f"{' near --log-offset' if is_given else ''}: {REMEDY}"
            )
        others = costs[np.abs(begins - begins[least]) > _APART_S]
        if len(others) and others.min() < costs[least] + _CLEARER and not is_given:
            raise SeveralError(f"{name}: the motion that it shows agrees with several parts of the log; {REMEDY}")
        fine = begins[least] + np.arange(-_GRID_S, _GRID_S + _FINE_S / 2, _FINE_S)
        fine_costs = np.array([self._cost(each, is_fine=True) for each in fine])
        begin = float(fine[fine_costs.argmin()])
        note = f"{_begins(begin, self._first)}: there the motion of its pictures agrees best with the flight"
        return ClockFit(begin, note, float(fine_costs.min()))

    def _cost(self, begin: float, *, is_fine: bool = False) -> float:
        """Return the mean disagreement, 0 to 1, where the film begins at ``begin``."""
        times = self._motion.time + begin
        shifts = self._between(times) if is_fine else self._nearest(times)
        off = np.hypot(*(shifts - self._motion.shift).T) / self._cap
        return float(np.minimum(np.nan_to_num(off, nan=1.0), 1.0).mean())

    def _nearest(self, times: FloatArray) -> FloatArray:
        at = np.rint((times - self._first) / _GRID_S).astype(np.intp)
        is_inside: NDArray[np.bool_] = (at >= 0) & (at < len(self._times))
        shifts = np.full((len(times), 2), np.nan)
        shifts[is_inside] = self._shifts[at[is_inside]]
        return shifts

    def _between(self, times: FloatArray) -> FloatArray:
        sides = [np.interp(times, self._times, self._shifts[:, k], np.nan, np.nan) for k in (0, 1)]
        return np.column_stack(sides)


def _unchecked(name: str, guess: float | None, first: float) -> ClockFit:
    if guess is None:
        raise PictureError(f"{name}: shows no motion by which its clock is fitted to the log's; {REMEDY}")
    return ClockFit(guess, f"{_begins(guess, first)}; it shows no motion that would check it")


def _begins(begin: float, first: float) -> str:
    when = "" if begin < 1e8 else f" ({datetime.fromtimestamp(begin, UTC):%Y-%m-%d %H:%M:%S} UTC)"
    return f"The film begins {begin - first:.2f} s after the log's first place{when}"
