"""Cars that come and leave between two surveys, and how fast the share of taken stalls moves.

A look shows a stall free or taken; a stay that begins and ends between two looks is not seen. The changes that are
seen, corrected for wrong states, are the least number of arrivals. Where stays end at a constant rate, a stall is a
Markov process of two states, whose rates follow from the changes between looks (Kalbfleisch & Lawless 1985).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Self

import numpy as np

from hawk.stats.counts import Counted
from hawk.stats.values import FREE, TAKEN, Bools, Floats, Group, Ints, Panel, capacity_of, summed

LONGEST_GAP_H: Final = 6.0
"""Between surveys of one day that are farther apart nothing is said of arrivals."""
USUAL_CHANGES: Final = 0.8
"""Changes of a stall an hour, until `LEAST_PAIRS` show it: stays of an hour and a half, half of the time."""
USUAL_DRIFT: Final = 0.01
"""Variance of the share of all stalls that demand adds in an hour, until `LEAST_PAIRS` show it: 10 % in an hour."""
LEAST_PAIRS: Final = 3
_MOST_WRONG: Final = 0.45
"""Greatest chance of a wrong state that a correction takes out: at one half nothing would be left."""


@dataclass(frozen=True, slots=True)
class Moves:
    """Stalls of G groups by their states at both surveys of P pairs that follow each other on a day.

    ``table`` (P, G, 2, 2): how many of the ``seen`` stalls (P, G), those with a state at both, were free or taken
    (rows) and are so now (columns), after a correction for wrong states. ``error`` (P, G, 2): standard deviation of
    the changes to taken and to free that wrong states cause. ``capacity`` (P, G): stalls of both layouts. ``hours``
    (P,): between the surveys; ``begin`` (P,): number of the first one.
    """

    begin: Ints = field(repr=False)
    hours: Floats = field(repr=False)
    table: Floats = field(repr=False)
    error: Floats = field(repr=False)
    seen: Floats = field(repr=False)
    capacity: Floats = field(repr=False)

    @classmethod
    def of(cls, panel: Panel, groups: Sequence[Group]) -> Self:
        """Return the moves of groups between all surveys that follow each other within `LONGEST_GAP_H` on a day."""
        begin = _begins(panel)
        there = panel.is_there
        is_state = [there & (panel.state == state) for state in (FREE, TAKEN)]
        table = [[summed(before[:-1] & after[1:], groups)[begin] for after in is_state] for before in is_state]
        raw = _table(*table)
        wrong = _wrong(panel, is_state, groups)
        by_later = [_true(row, wrong[begin + 1]) for row in table]
        by_earlier = [_true(column, wrong[begin]) for column in zip(*by_later, strict=True)]
        found = np.maximum(np.swapaxes(_table(*by_earlier), -1, -2), 0.0)
        total, seen = found.sum(axis=(2, 3)), raw.sum(axis=(2, 3))
        corrected = found * np.where(total > 0, seen / np.maximum(total, 1e-12), 0.0)[..., None, None]
        free, taken = raw[..., FREE, FREE], raw[..., TAKEN, TAKEN]
        to_taken = free * wrong[begin + 1, :, FREE] + taken * wrong[begin, :, TAKEN]
        to_free = taken * wrong[begin + 1, :, TAKEN] + free * wrong[begin, :, FREE]
        capacity = capacity_of(there[begin] & there[begin + 1], groups)
        hours = np.diff(panel.at)[begin] / 3600.0
        error = np.sqrt(np.stack([to_taken, to_free], -1))
        return cls(begin, hours, corrected, error, seen, capacity)


def _begins(panel: Panel) -> Ints:
    """Return the numbers of the surveys that another one follows on the same day, at most `LONGEST_GAP_H` later."""
    days = np.array([local.toordinal() for local in panel.local_times], np.int64)
    gaps = np.diff(panel.at) / 3600.0
    return np.flatnonzero((np.diff(days) == 0) & (gaps > 0) & (gaps <= LONGEST_GAP_H))


def _wrong(panel: Panel, is_state: Sequence[Bools], groups: Sequence[Group]) -> Floats:
    """Return the chances (S, G, 2) that a stall which is free, and one which is taken, is called otherwise.

    ``is_state``: which stalls (S, N) are called free, and taken.
    """
    taken = np.nan_to_num(panel.taken_probability)
    called = [summed(each, groups) for each in is_state]
    truly_taken = [summed(taken * each, groups) for each in is_state]
    truly_free = [every - some for every, some in zip(called, truly_taken, strict=True)]
    chances = [
        np.minimum(missed / np.maximum(right + missed, 1e-9), _MOST_WRONG)
        for right, missed in (truly_free, reversed(truly_taken))
    ]
    return np.stack(chances, -1)


def _true(called: Sequence[Floats], wrong: Floats) -> tuple[Floats, Floats]:
    """Return how many stalls are free, and taken, by the numbers that are ``called`` so and the chances (..., 2) of
    `_wrong`: the product with the inverse of the matrix of these chances.
    """
    free, taken = called
    of_free, of_taken = wrong[..., FREE], wrong[..., TAKEN]
    scale = 1 / (1 - of_free - of_taken)
    return ((1 - of_taken) * free - of_taken * taken) * scale, ((1 - of_free) * taken - of_free * free) * scale


def _table(*rows: Sequence[Floats]) -> Floats:
    """Return rows of numbers (...) as one table (..., 2, 2)."""
    return np.stack([np.stack(row, -1) for row in rows], -2)


def rates(come: Floats, leave: Floats, hours: Floats) -> tuple[Floats, Floats]:
    """Return the rates (1/h) by which free stalls are taken, and taken ones freed.

    ``come``, ``leave``: the shares of free stalls that are taken after some ``hours``, and of taken ones that are free.
    NaN where no rates fit: looks so far apart show chance alone.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        both = np.where(come + leave < 1, -np.log1p(-np.minimum(come + leave, 1.0)) / hours, np.nan)
        part = np.where(come + leave > 0, come / (come + leave), 0.0)
    return both * part, both * (1 - part)


def arrivals(comes: Floats, leaves: Floats, taken: Floats, hours: Floats) -> Floats:
    """Return the arrivals at a stall within some hours, by its rates; ``taken``: the chance that it is taken at first.

    The integral of the rate over the time that the stall is free.
    """
    both = comes + leaves
    with np.errstate(divide="ignore", invalid="ignore"):
        settled = comes / both
        free = (1 - settled) * hours - (taken - settled) * (1 - np.exp(-both * hours)) / both
        return np.where(both > 0, comes * free, both)


@dataclass(frozen=True, slots=True)
class Flow:
    """Movement of a lot: ``changes`` of a stall an hour, and the variance of the share, an hour, by ``drift``."""

    changes: float
    drift: float

    @classmethod
    def of(cls, moves: Moves, whole: Counted) -> Self:
        """Return that of a lot, by its moves and its counts with all stalls as one group; the usual one for few."""
        seen = moves.seen[:, 0]
        used = seen >= 1
        if used.sum() < LEAST_PAIRS:
            return cls(USUAL_CHANGES, USUAL_DRIFT)
        table, hours, seen = moves.table[used, 0], moves.hours[used], seen[used]
        free, taken = np.maximum(table.sum(axis=2), 1e-9).T
        comes, leaves = rates(table[:, FREE, TAKEN] / free, table[:, TAKEN, FREE] / taken, hours)
        shown = table[:, FREE, TAKEN] + table[:, TAKEN, FREE]
        flow = np.where(np.isfinite(comes), hours * (comes * free + leaves * taken), shown)
        begin = moves.begin[used]
        step = whole.share[begin + 1, 0] - whole.share[begin, 0]
        noise = whole.variance[begin + 1, 0] + whole.variance[begin, 0]
        drift = np.maximum(step**2 - noise - shown / seen**2, 0.0) / hours
        return cls(float(flow.sum() / (seen @ hours)), float(drift.mean()))

    def walk(self, capacity: Floats) -> Floats:
        """Return the variance of the share that an hour adds to groups of some stalls, (G,)."""
        return np.asarray(self.changes / np.maximum(capacity, 1.0) + self.drift, np.float64)
