"""Stalls that changed between two surveys, and stalls that were the same in all surveys of a period."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hawk.stats.counts import WIDER
from hawk.stats.values import (
    DEVIATIONS,
    FREE,
    NOTHING,
    TAKEN,
    UNSEEN,
    Bools,
    Estimate,
    Floats,
    Group,
    Panel,
    PanelColumn,
    summed,
)

LEAST_LOOKS = 2
"""Surveys with a state of a stall, from which it counts as never or always taken."""


@dataclass(frozen=True, slots=True)
class Changed:
    """A stall whose state differs: ``is_taken`` now. ``chance``: that both states are right, by their looks."""

    stall: PanelColumn
    is_taken: bool
    chance: float


@dataclass(frozen=True, slots=True)
class Changes:
    """Changes between two surveys, by their numbers: ``came`` and ``left`` are stalls that are taken, free now.

    ``compared``: stalls with a state at both; ``unknown``: the others of both layouts.
    """

    stalls: tuple[Changed, ...]
    compared: int
    unknown: int
    came: Estimate
    left: Estimate


def changes_between(panel: Panel, before: int, after: int) -> Changes:
    """Return what changed between two surveys of a panel."""
    there = panel.is_there[before] & panel.is_there[after]
    first, then = panel.state[before], panel.state[after]
    both = there & (first != UNSEEN) & (then != UNSEEN)
    one, other = np.nan_to_num(panel.taken[before]), np.nan_to_num(panel.taken[after])
    found = []
    for k in np.flatnonzero(both & (first != then)).tolist():
        is_taken = bool(then[k] == TAKEN)
        chance = (1 - one[k]) * other[k] if is_taken else one[k] * (1 - other[k])
        found.append(Changed(panel.stalls[k], is_taken, float(chance)))
    unknown = int(there.sum()) - int(both.sum())
    return Changes(
        tuple(found), int(both.sum()), unknown,
        came=_counted(both & (first == FREE) & (then == TAKEN), (1 - one) * other, both, unknown, 2),
        left=_counted(both & (first == TAKEN) & (then == FREE), one * (1 - other), both, unknown, 2),
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Steady:
    """Stalls of a group that no survey of a period saw taken, and that every one saw taken, of ``LEAST_LOOKS`` or more.

    The numbers are those of the surveys' moments: a stall may be taken between them.
    """

    never: Estimate
    always: Estimate
    never_stalls: tuple[PanelColumn, ...]
    always_stalls: tuple[PanelColumn, ...]


def steady(panel: Panel, groups: Sequence[Group]) -> list[Steady]:
    """Return the stalls of each group that were the same in all surveys that saw them."""
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
            _counted(one & group.members, chance, known, unknown, count)
            for one, chance in zip(lists, chances, strict=True)
        )
        named = [_named(panel, one & group.members) for one in lists]
        found.append(Steady(never, always, named[0], named[1]))
    return found


def _named(panel: Panel, chosen: Bools) -> tuple[PanelColumn, ...]:
    return tuple(panel.stalls[k] for k in np.flatnonzero(chosen).tolist())


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
