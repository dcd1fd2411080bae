"""Stalls that changed between two surveys, and stalls that were the same in all surveys of a period."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from hawk.lots.answers import Count, Shown
from hawk.lots.plan.values import Id
from hawk.stats.counts import WIDER
from hawk.stats.values import (
    DEVIATIONS,
    FREE,
    NOTHING,
    TAKEN,
    UNSEEN,
    Bools,
    Estimate,
    Figure,
    Floats,
    Group,
    Panel,
    summed,
)

LEAST_LOOKS = 2
"""Surveys with a state of a stall, from which it counts as never or always taken."""


@dataclass(frozen=True, slots=True)
class StateChange:
    """A stall whose state changed; `taken`: now. `chance`: probability that both states are right."""

    id: Id
    label: str
    taken: bool
    chance: Annotated[Figure, Field(ge=0, le=1)]


class Changed(Shown):
    """Changes between two surveys. `compared`: stalls that both saw; `unknown`: those that one of them did not. `came`
    and `left`: stalls that are taken, free now.
    """

    compared: Count
    unknown: Count
    came: Estimate
    left: Estimate
    stalls: tuple[StateChange, ...]


def changes_between(panel: Panel, before: int, after: int) -> Changed:
    """Return what changed between two surveys of a panel."""
    there = panel.is_there[before] & panel.is_there[after]
    first, then = panel.state[before], panel.state[after]
    both = there & (first != UNSEEN) & (then != UNSEEN)
    one, other = np.nan_to_num(panel.taken[before]), np.nan_to_num(panel.taken[after])
    found = []
    for k in np.flatnonzero(both & (first != then)).tolist():
        is_taken = bool(then[k] == TAKEN)
        chance = (1 - one[k]) * other[k] if is_taken else one[k] * (1 - other[k])
        found.append(StateChange(panel.stalls[k].id, panel.stalls[k].label, is_taken, float(chance)))
    unknown = int(there.sum()) - int(both.sum())
    return Changed(
        stalls=tuple(found), compared=int(both.sum()), unknown=unknown,
        came=_counted(both & (first == FREE) & (then == TAKEN), (1 - one) * other, both, unknown, 2),
        left=_counted(both & (first == TAKEN) & (then == FREE), one * (1 - other), both, unknown, 2),
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Steady(Estimate):
    """Number of stalls that every survey saw in one state, and their labels."""

    stalls: tuple[str, ...]


def steady(panel: Panel, groups: Sequence[Group]) -> list[tuple[Steady, Steady]]:
    """Return the stalls of each group that no survey of a period saw taken, and those that every one saw taken, of
    `LEAST_LOOKS` or more. The numbers are those of the surveys' moments: a stall may be taken between them.
    """
    is_seen = panel.is_there & (panel.state != UNSEEN)
    looks = is_seen.sum(axis=0)
    probability = np.clip(np.nan_to_num(panel.taken), 1e-6, 1 - 1e-6)
    surveys = np.count_nonzero(summed(is_seen, groups), axis=0).tolist()
    ever = panel.is_there.any(axis=0)
    enough = looks >= LEAST_LOOKS
    lists, chances = [], []
    for state, right in ((FREE, 1 - probability), (TAKEN, probability)):
        lists.append(enough & np.all(~is_seen | (panel.state == state), axis=0))
        chances.append(np.exp(np.where(is_seen, np.log(right), np.float32(0)).sum(axis=0, dtype=np.float64)))
    found = []
    for group, count in zip(groups, surveys, strict=True):
        known, unknown = enough & group.members, int((ever & ~enough & group.members).sum())
        never, always = (
            _steady(panel, one & group.members, _counted(one & group.members, chance, known, unknown, count))
            for one, chance in zip(lists, chances, strict=True)
        )
        found.append((never, always))
    return found


def _steady(panel: Panel, chosen: Bools, number: Estimate) -> Steady:
    labels = tuple(panel.stalls[k].label for k in np.flatnonzero(chosen).tolist())
    return Steady(number.value, number.low, number.high, number.surveys, labels)


def _counted(found: Bools, chance: Floats, known: Bools, unknown: int, surveys: int) -> Estimate:
    """Return how many stalls were found, with the interval by the ``chance`` that each ``known`` one is truly one.

    Any of the ``unknown`` ones may be one as well. The number found is always within the interval.
    """
    if not known.any():
        return NOTHING
    count = float(found.sum())
    wrong = np.where(known, np.where(found, 1 - chance, 0.0), 0.0)
    missed = np.where(known & ~found, chance, 0.0)
    off = [
        float(each.sum()) + DEVIATIONS * float(np.sqrt(WIDER * (each * (1 - each)).sum())) for each in (wrong, missed)
    ]
    return Estimate(count, max(count - off[0], 0.0), min(count + off[1], float(known.sum())) + unknown, surveys)
