"""Figures of a studied lot against the simulator's history: every stay with its begin and its end."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Final

import numpy as np

from hawk.stats.changes import changes_between
from hawk.stats.counts import count
from hawk.stats.figures import figures
from hawk.stats.flow import Flow, Moves
from hawk.stats.hours import Hours, flown_hours
from hawk.stats.partition import PARTITIONS
from hawk.stats.turnover import least, longest_gap, most
from hawk.stats.values import UNSEEN, Bools, Floats, Group, Panel, groups_of, whole
from hawk.worlds.stays import LotStays

NEAR_H: Final = 1
"""Hours by which a peak may be off: its neighbour."""
_ROUNDING: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Judged:
    """A lot's figures against the truth.

    ``errors``: of the occupancy at each survey, a share. ``moments``, ``hours``: cells (group by survey, by flown hour)
    and how many of them hold the truth. ``brackets``: cells of arrivals, those that hold, and those with an upper end.
    ``changed``: changed stalls that were called so, called ones that changed not, and missed ones. ``unseen``: shares
    of looks without a state. ``wrong``: looks with a wrong state.
    """

    name: str
    surveys: int
    errors: tuple[float, ...]
    moments: tuple[int, int]
    hours: tuple[int, int]
    brackets: tuple[int, int, int]
    changed: tuple[int, int, int]
    peak_is_right: bool
    unseen: float
    wrong: int
    doubts: tuple[str, ...]


class History:
    """The truth of a lot: which of its stored stalls were taken when."""

    def __init__(self, stays: LotStays, true: Mapping[str, int], panel: Panel) -> None:
        """Take the stays; ``true``: the true stall of each stored one, by its id."""
        columns = {true[stall.id]: k for k, stall in enumerate(panel.stalls) if stall.id in true}
        self._panel = panel
        days = sorted({panel.local(survey.at).date() for survey in panel.surveys})
        self._stays: dict[object, list[tuple[int, float, float]]] = {}
        for day in days:
            begin = datetime.combine(day, datetime.min.time(), panel.clock)
            self._stays[day] = [
                (columns[stay.stall], stay.begin.timestamp(), stay.end.timestamp())
                for stay in stays.between(begin, begin + timedelta(days=1))
                if stay.stall in columns
            ]

    def _of(self, at: float) -> list[tuple[int, float, float]]:
        return self._stays[self._panel.local(at).date()]

    def taken(self, at: float) -> Bools:
        """Return which stalls (N,) are taken at a moment."""
        found = np.zeros(len(self._panel.stalls), np.bool_)
        for column, begin, end in self._of(at):
            found[column] |= begin <= at < end
        return found

    def mean(self, begin: float, end: float) -> Floats:
        """Return the share of a time in which each stall (N,) is taken."""
        found = np.zeros(len(self._panel.stalls))
        for column, first, last in self._of(begin):
            found[column] += max(0.0, min(last, end) - max(first, begin))
        return found / (end - begin)

    def arrivals(self, begin: float, end: float) -> Floats:
        """Return how many cars came to each stall (N,) after a moment, until another one."""
        found = np.zeros(len(self._panel.stalls))
        for column, first, _ in self._of(begin):
            found[column] += begin < first <= end
        return found


def judged(name: str, panel: Panel, stays: LotStays, true: Mapping[str, int], doubts: Sequence[str] = ()) -> Judged:
    """Compare the figures of a lot with its history."""
    history = History(stays, true, panel)
    groups = [*whole(panel), *(group for by in PARTITIONS for group in groups_of(panel, by))]
    counted, moves = count(panel, groups), Moves.of(panel, groups)
    hours = flown_hours(panel, counted, Flow.of(moves, counted))
    at_surveys = np.array([history.taken(survey.at) for survey in panel.surveys])
    real = np.array([[row[group.members].mean() for group in groups] for row in at_surveys])
    is_seen = panel.state != UNSEEN
    wrong = int((is_seen & ((panel.state == 1) != at_surveys)).sum())
    return Judged(
        name, len(panel.surveys), tuple(np.abs(counted.share[:, 0] - real[:, 0]).tolist()),
        _held(counted.bounds(), real), _held(hours.bounds(), _true_hours(hours, history, panel, groups)),
        _brackets(moves, history, panel, groups), _changed(panel, at_surveys), _peak_is_right(panel, history),
        float(1 - is_seen.mean()), wrong, tuple(doubts),
    )  # fmt: skip


def _held(bounds: tuple[Floats, Floats], real: Floats) -> tuple[int, int]:
    low, high = bounds
    known = np.isfinite(low) & np.isfinite(high)
    return int(known.sum()), int((known & (low - _ROUNDING <= real) & (real <= high + _ROUNDING)).sum())


def _true_hours(hours: Hours, history: History, panel: Panel, groups: Sequence[Group]) -> Floats:
    """Return the true mean of each group over each flown hour, (K, G)."""
    rows = []
    for day, hour in zip(hours.day, hours.hour, strict=True):
        begin = datetime(day.year, day.month, day.day, hour, tzinfo=panel.clock).timestamp()
        share = history.mean(begin, begin + 3600.0)
        rows.append([share[group.members].mean() for group in groups])
    return np.array(rows)


def _brackets(moves: Moves, history: History, panel: Panel, groups: Sequence[Group]) -> tuple[int, int, int]:
    low, high = least(moves), most(moves, longest_gap(moves))
    at = panel.at
    cells = held = closed = 0
    for line, first in enumerate(moves.begin.tolist()):
        came = history.arrivals(at[first], at[first + 1])
        for k, group in enumerate(groups):
            real, top = float(came[group.members].sum()), float(high[line, k])
            cells += 1
            closed += int(np.isfinite(top))
            held += int(float(low[line, k]) - _ROUNDING <= real and not real > top)
    return cells, held, closed


def _changed(panel: Panel, real: Bools) -> tuple[int, int, int]:
    """Return the changed stalls between surveys that follow each other: found, called falsely, missed."""
    right = false = missed = 0
    number = {stall.id: k for k, stall in enumerate(panel.stalls)}
    for k in range(len(panel.surveys) - 1):
        called = {number[each.id] for each in changes_between(panel, k, k + 1).stalls if each.chance is not None}
        true = set(np.flatnonzero(real[k] != real[k + 1]).tolist())
        right, false, missed = right + len(called & true), false + len(called - true), missed + len(true - called)
    return right, false, missed


def _peak_is_right(panel: Panel, history: History) -> bool:
    """Return whether the peak hour of the first day is the true one of all its hours, or a neighbour of it."""
    day = panel.local(panel.surveys[0].at).date()
    kept = [k for k, survey in enumerate(panel.surveys) if panel.local(survey.at).date() == day]
    peak = figures(part_of(panel, kept)).whole
    if peak is None or peak.peak is None:
        return False
    begin = datetime.combine(day, datetime.min.time(), panel.clock).timestamp()
    shares = [history.mean(begin + hour * 3600.0, begin + (hour + 1) * 3600.0).mean() for hour in range(24)]
    return abs(int(peak.peak.begin[11:13]) - int(np.argmax(shares))) <= NEAR_H


def part_of(panel: Panel, surveys: Sequence[int]) -> Panel:
    """Return a panel of some surveys alone."""
    return Panel(
        panel.lot, panel.name, panel.clock, panel.clock_name, panel.stalls,
        tuple(panel.surveys[k] for k in surveys), panel.left_out,
        panel.taken_probability[surveys], panel.state[surveys], panel.is_there[surveys],
    )  # fmt: skip


def total(found: Iterable[tuple[int, ...]]) -> tuple[int, ...]:
    """Return the sums of tuples of counts."""
    return tuple(sum(column) for column in zip(*found, strict=True))
