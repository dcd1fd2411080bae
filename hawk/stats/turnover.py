"""Turnover and length of stay as brackets: at least what changes of state show, at most the Markov estimate.

Neither is a point: a stay between two surveys is not seen. The estimate is right for exponential stays and too high for
log-normal ones, as long as surveys are close (docs/statistics.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Final

import numpy as np

from hawk.lots.answers import Count
from hawk.stats.flow import Moves, arrivals, rates
from hawk.stats.values import DEVIATIONS, FREE, TAKEN, Figure, Floats

LONGEST: Final = 0.5
"""Share of the mean stay from which a gap between two surveys hides too many stays for an upper end."""

MOST_ERROR: Final = 1.0
"""Standard deviation of a number's logarithm from which its upper end says nothing."""
_STEP: Final = 0.01
"""Step of a chance by which a slope is taken."""
CLOSE_H: Final = 0.75
"""Longest gap between surveys that shows the mean stay. Where surveys were an hour or more apart, the estimate was 1.5
to 3.5 h in drawn lots whose stays took 1.8 and 2.0 h: short stays between long ones are hidden."""
LEAST_DEPARTURES: Final = 30
"""Departures from which a mean stay is known to a fifth or so."""


@dataclass(frozen=True, slots=True)
class Bracket:
    """Ends between which a figure lies. `high`: null where nothing limits it; `low`: null where nothing is known."""

    low: Figure | None
    high: Figure | None


@dataclass(frozen=True, slots=True)
class Turnover:
    """Cars that came to a group of stalls in the `hours` between surveys, and how long they stayed.

    `arrivals`: cars; `per_stall_hour`: cars a stall in an hour; `stay_hours`: by Little's law the stall-hours taken
    over the arrivals. `pairs` of surveys are behind it, of which `open_pairs` have no upper end.
    """

    hours: Figure
    pairs: Count
    open_pairs: Count
    arrivals: Bracket
    per_stall_hour: Bracket
    stay_hours: Bracket


_UNKNOWN: Final = Bracket(None, None)
NO_TURNOVER: Final = Turnover(0.0, 0, 0, _UNKNOWN, _UNKNOWN, _UNKNOWN)
"""Turnover of what no pair of surveys is behind."""


def turnover(moves: Moves, longest_h: float | None) -> list[Turnover]:
    """Return the brackets of each group over all pairs of surveys. ``longest_h``: `longest_gap` of the lot."""
    used = moves.seen >= 1
    pairs, hours = used.sum(axis=0), used.T.astype(np.float64) @ moves.hours
    came = np.where(used, moves.table[..., FREE, TAKEN], 0.0).sum(axis=0)
    wrong = np.sqrt(np.where(used, moves.error[..., 0] ** 2, 0.0).sum(axis=0))
    low = np.maximum(came - DEVIATIONS * wrong, 0.0)
    expected, variance = markov(moves, longest_h)
    is_open = (used & np.isnan(expected)).sum(axis=0)
    high = np.maximum(_top(np.where(used, expected, 0.0).sum(axis=0), np.where(used, variance, 0.0).sum(axis=0)), low)
    stall_hours = np.where(used, moves.capacity, 0.0).T @ moves.hours
    before, after = moves.table[..., TAKEN, :].sum(axis=-1), moves.table[..., :, TAKEN].sum(axis=-1)
    share = (before + after) / 2 / np.maximum(moves.seen, 1e-9)
    taken_hours = np.where(used, share * moves.capacity, 0.0).T @ moves.hours
    return [
        _turnover(*each)
        for each in zip(
            hours.tolist(), pairs.tolist(), is_open.tolist(), low.tolist(), high.tolist(), stall_hours.tolist(),
            taken_hours.tolist(), strict=True,
        )
    ]  # fmt: skip


def _turnover(
    hours: float, pairs: int, is_open: int, low: float, high: float, stall_hours: float, taken_hours: float
) -> Turnover:
    if not pairs:
        return NO_TURNOVER
    top = high if math.isfinite(high) else None
    per_stall = Bracket(low / stall_hours, None if top is None else top / stall_hours)
    stay = Bracket(taken_hours / top if top else None, taken_hours / low if low > 0 else None)
    return Turnover(hours, pairs, is_open, Bracket(low, top), per_stall, stay)


def least(moves: Moves) -> Floats:
    """Return the least numbers of arrivals (P, G): changes from free to taken that wrong states do not explain."""
    return np.maximum(moves.table[..., FREE, TAKEN] - DEVIATIONS * moves.error[..., 0], 0.0)


def most(moves: Moves, longest_h: float | None) -> Floats:
    """Return the greatest numbers of arrivals (P, G) by the Markov estimate; NaN: no end."""
    return np.maximum(_top(*markov(moves, longest_h)), least(moves))


def _top(expected: Floats, variance: Floats) -> Floats:
    """Return the upper end of a number, by its logarithm; NaN where that errs by more than `MOST_ERROR`."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        error = np.where(expected > 0, np.sqrt(variance) / expected, 0.0)
        return np.where(error <= MOST_ERROR, expected * np.exp(DEVIATIONS * error), np.nan)


def markov(moves: Moves, longest_h: float | None) -> tuple[Floats, Floats]:
    """Return the Markov estimate of arrivals (P, G), for unseen stalls too, with its variance; NaN: there is no end.

    The estimate errs by the chances of a change, which the seen stalls show (delta method), and arrivals that no survey
    saw are a Poisson number.
    """
    found = np.full((2, *moves.seen.shape), np.nan)
    if longest_h is not None and (is_near := moves.hours <= longest_h).any():
        found[:, is_near] = _markov(Moves(*(getattr(moves, each.name)[is_near] for each in fields(Moves))))
    return found[0], found[1]


def _markov(moves: Moves) -> tuple[Floats, Floats]:
    """Return `markov` of pairs that are near each other."""
    table, hours, seen = moves.table, moves.hours[:, None], np.maximum(moves.seen, 1e-9)
    free, taken = table[..., FREE, :].sum(axis=-1), table[..., TAKEN, :].sum(axis=-1)
    shown = table[..., FREE, TAKEN]
    come, leave = (shown + 0.5) / (free + 1), (table[..., TAKEN, FREE] + 0.5) / (taken + 1)
    expected, more_come, more_leave = (
        moves.capacity * arrivals(*rates(come + a, leave + b, hours), taken / seen, hours)
        for a, b in ((0.0, 0.0), (_STEP, 0.0), (0.0, _STEP))
    )
    variance = ((more_come - expected) / _STEP) ** 2 * _spread(come, free, moves.error[..., 0])
    variance += ((more_leave - expected) / _STEP) ** 2 * _spread(leave, taken, moves.error[..., 1])
    variance += np.maximum(expected - shown, 0.0)
    has_end = (moves.seen >= 1) & np.isfinite(variance)
    return np.where(has_end, expected, np.nan), np.where(has_end, variance, np.nan)


def _spread(chance: Floats, of: Floats, error: Floats) -> Floats:
    """Return the variance of a chance that ``of`` stalls show, some of them by wrong states."""
    return (chance * (1 - chance) * (of + 1) + error**2) / (of + 1) ** 2


def longest_gap(whole: Moves) -> float | None:
    """Return the longest gap between surveys, hours, that has an upper end: `LONGEST` of the lot's mean stay.

    The mean stay is the Markov estimate of the closest pairs, at most `CLOSE_H` apart, with all stalls as the first
    group: those that show `LEAST_DEPARTURES`. None without one.
    """
    order = np.argsort(whole.hours, kind="stable")
    order = order[whole.hours[order] <= CLOSE_H]
    shown = np.cumsum(whole.table[order, 0, TAKEN, FREE])
    near = order[: int(np.searchsorted(shown, LEAST_DEPARTURES)) + 1]
    table, hours = whole.table[near, 0], whole.hours[near]
    free, taken = np.maximum(table.sum(axis=2), 1e-9).T
    comes, leaves = rates(table[:, FREE, TAKEN] / free, table[:, TAKEN, FREE] / taken, hours)
    weight = np.where(np.isfinite(comes) & (whole.seen[near, 0] >= 1), taken * hours, 0.0)
    left = float(weight @ np.nan_to_num(leaves))
    return LONGEST * float(weight.sum()) / left if left > 0 else None
