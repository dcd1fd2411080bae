"""Log-odds of a stall at each place of a row, by all that is known of the ground there.

Layers of the ground are read in a strip along the row. Of a stall that begins at a step of the strip they give what the
network says of its inside and its rims, of the lot and of cars, and what was found there, beside it and at its back. A
logistic regression turns that into log-odds (`python -m training.rows` fits it).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.algo.rows.fit import Finds, Row
from hawk.algo.vision import quads
from hawk.algo.vision.detection import FloatArray

STEPS: Final = 12
"""Steps of a strip a stall."""
BEYOND: Final = 4
"""Stalls that a strip reaches past the last finds of its row."""
_DEPTH: Final[FloatArray] = np.linspace(-0.55, 0.55, 12)
"""Places across a strip, in lengths of a stall."""
_INNER, _RIM = 0.35, 0.46
"""Of those, the inside of a stall lies within the first, its ends beyond the second."""
_ALIKE: Final = 0.3
"""Radians by which the direction of a find may differ from the row's."""
_IN_LINE: Final = 0.35
"""Lengths by which a find may lie aside of the row."""
_SUPPORT: Final = 0.4
"""Pitches from a find at which it says nothing of a stall any more."""

_NO_FIND: Final = 0.1
"""Below this there is no find."""

FEATURES: Final = (
    "core", "core less rims", "core at the ends", "found", "found squared", "lot", "lot squared", "car",
    "car less rims", "found at the back", "found beside", "found on both sides",
)  # fmt: skip
WEIGHTS: Final = np.array([-4.39, 1.83, 3.18, -1.8, 1.4, -0.44, 0.79, -0.66, 0.53, -0.25, 1.07, 2.15, 1.88])
"""Constant and weight of each feature."""


@dataclass(frozen=True, slots=True)
class Ground:
    """Probabilities of stall core, car and lot (0..1), 0 where nothing was ``seen`` (0 or 1), at any places."""

    core: NDArray[np.floating] = field(repr=False)
    car: NDArray[np.floating] = field(repr=False)
    lot: NDArray[np.floating] = field(repr=False)
    seen: NDArray[np.floating] = field(repr=False)


GroundAt = Callable[[FloatArray], Ground]
"""Returns the ground at places (..., 2)."""


@dataclass(frozen=True, slots=True)
class Strip:
    """The stalls that may stand in a row: one begins at each of M steps of ``step`` metres.

    ``t`` (M,) are their centres along the row, ``features`` (M, F), ``seen`` (M,) the shares of them that were seen.
    """

    t: FloatArray
    step: float
    features: FloatArray
    seen: FloatArray

    def is_bare(self, shown_from: float) -> NDArray[np.bool_]:
        """Return True (M,) where no find shows a stall, nor the ground by a mean core of ``shown_from``."""
        return (self.features[:, FEATURES.index("found")] < _NO_FIND) & (self.features[:, 0] < shown_from)

    def log_odds(self, weights: FloatArray = WEIGHTS) -> FloatArray:
        """Return the log-odds (M,) that a stall begins at each step."""
        return np.asarray(weights[0] + self.features @ weights[1:])


def strip(row: Row, ground_at: GroundAt, finds: Finds) -> Strip:
    """Read the ground along a row, `BEYOND` stalls past its ends."""
    step = row.pitch / STEPS
    margin = row.pitch * (BEYOND + 0.5)
    count = int(np.ceil((row.high - row.low + 2 * margin) / step))
    t = np.asarray(row.low - margin + (np.arange(count) + 0.5) * step, np.float64)
    places = row.centres(t)[:, None] + _DEPTH[:, None] * row.length * row.sides(t)[:, None]
    ground = ground_at(places)
    centre = t[: count - STEPS + 1] + (STEPS - 1) / 2 * step
    inner, ends = np.abs(_DEPTH) <= _INNER, np.abs(_DEPTH) > _RIM
    core, car = (_sums(layer[:, inner].mean(1)) for layer in (ground.core, ground.car))
    lot, seen = (_mean(_sums(layer.mean(1)), 0, STEPS) for layer in (ground.lot, ground.seen))
    found = _found(row, finds, centre)
    features = [
        _mean(core, 2, STEPS - 2),
        _mean(core, 4, STEPS - 4) - _rims(core),
        _mean(_sums(ground.core[:, ends].mean(1)), 2, STEPS - 2),
        found[0],
        found[0] ** 2,
        lot,
        lot**2,
        _mean(car, 2, STEPS - 2),
        _mean(car, 2, STEPS - 2) - _rims(car),
        *found[1:],
    ]
    return Strip(centre, step, np.column_stack(features), seen)


def _sums(profile: NDArray[np.floating]) -> FloatArray:
    return np.concatenate([[0.0], np.cumsum(profile, dtype=np.float64)])


def _mean(sums: FloatArray, first: int, end: int) -> FloatArray:
    """Return the mean of the steps ``first`` to ``end`` of each stall, cut off at the strip's ends."""
    begin = np.arange(len(sums) - STEPS)
    low, high = (np.clip(begin + at, 0, len(sums) - 1) for at in (first, end))
    return np.asarray((sums[high] - sums[low]) / np.maximum(high - low, 1))


def _rims(sums: FloatArray) -> FloatArray:
    return (_mean(sums, -1, 1) + _mean(sums, STEPS - 1, STEPS + 1)) / 2


def _found(row: Row, finds: Finds, centre: FloatArray) -> list[FloatArray]:
    """Return how surely a stall was found at each centre (M,), at its back, beside it, and on both its sides."""
    alike = quads.angle_between(row.angle, finds.angle) < _ALIKE
    some = finds[alike & (np.abs(row.place(finds.centres)[1]) < 1.5 * row.length)]

    def in_line(back: float) -> tuple[FloatArray, FloatArray]:
        """Return places along the row and scores of the finds ``back`` lengths behind it."""
        t, aside = row.place(some.centres - back * row.length * row.side)
        near = np.abs(aside) < _IN_LINE * row.length
        return t[near], some.score[near]

    def support(found: tuple[FloatArray, FloatArray], beside: float) -> FloatArray:
        t, score = found
        apart = np.abs(t[:, None] + beside * row.pitch - centre) / (_SUPPORT * row.pitch)
        return np.asarray((score[:, None] * np.clip(1 - apart, 0, 1)).max(axis=0, initial=0.0))

    own = in_line(0)
    before, after = (np.maximum(support(own, side), 0.7 * support(own, 2 * side)) for side in (1, -1))
    back = np.maximum(support(in_line(1), 0), support(in_line(-1), 0))
    return [support(own, 0), back, np.maximum(before, after), np.minimum(before, after)]
