"""Stalls that changed between two surveys, and stalls that were the same in all surveys of a period."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Final, Literal

import numpy as np
from pydantic import Field

from hawk.lots.answers import Count, Shown
from hawk.lots.plan import geometry
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
    Floats32,
    Group,
    Ints,
    Panel,
    States,
    summed,
)

LEAST_LOOKS: Final = 2
"""Surveys with a state of a stall, from which it counts as never or always taken."""


SAME_GROUND: Final = 0.5
"""Of the smaller one of two stalls of different layouts that overlap by more than this both are one, drawn again."""

State = Literal["free", "taken", "unknown"]
_STATE: Final[Mapping[int, State]] = {FREE: "free", TAKEN: "taken", UNSEEN: "unknown"}


@dataclass(frozen=True, slots=True)
class StateChange:
    """A stall whose state changed. `chance`: probability that both states are right; null where one is unclear.
    `former`: the stall of the survey before, another one where the plan's was drawn again.
    """

    id: Id
    label: str
    former: Id
    before: State
    after: State
    chance: Annotated[Figure, Field(ge=0, le=1)] | None


@dataclass(frozen=True, slots=True)
class StallLabel:
    """A stall that the layout of one of two surveys alone has."""

    id: Id
    label: str


@dataclass(frozen=True, slots=True)
class SectionCounts:
    """Vehicles that a survey counted in a section: `parked`, `least` to `most`."""

    parked: Count
    least: Count
    most: Count


@dataclass(frozen=True, slots=True)
class SectionChange:
    """A section at two surveys. `is_changed`: the intervals do not meet, so that the numbers of vehicles differ. What a
    survey did not look at is null.
    """

    id: Id
    name: str
    capacity: Count | None
    before: SectionCounts | None
    after: SectionCounts | None
    is_changed: bool | None


class Changed(Shown):
    """Changes between two surveys. `compared`: stalls that both saw; `unknown`: those that one of them did not. `free`:
    by how many more of those compared are free. `came` and `left`: stalls that are taken, free now. `matched`: stalls
    that were drawn again, compared by their ground; `begin` and `gone` are not compared.
    """

    compared: Count
    unknown: Count
    free: Estimate
    came: Estimate
    left: Estimate
    stalls: tuple[StateChange, ...]
    matched: Count
    begin: tuple[StallLabel, ...]
    gone: tuple[StallLabel, ...]
    sections: Annotated[
        tuple[SectionChange, ...], Field(description="vehicles in the sections of the present plan; no stalls")
    ] = ()


def changes_between(panel: Panel, before: int, after: int) -> Changed:
    """Return what changed between two surveys of a panel, in the order of its stalls."""
    in_both = np.flatnonzero(panel.is_there[before] & panel.is_there[after])
    gone = np.flatnonzero(panel.is_there[before] & ~panel.is_there[after])
    new = np.flatnonzero(panel.is_there[after] & ~panel.is_there[before])
    again = _drawn_again(panel, gone, new)
    earlier = np.concatenate([in_both, np.fromiter(again, np.int64)])
    later = np.concatenate([in_both, np.fromiter(again.values(), np.int64)])
    order = np.argsort(later)
    earlier, later = earlier[order], later[order]
    first, then = panel.state[before][earlier], panel.state[after][later]
    both = (first != UNSEEN) & (then != UNSEEN)
    one, other = (
        np.nan_to_num(panel.taken_probability[before][earlier]),
        np.nan_to_num(panel.taken_probability[after][later]),
    )
    came, left = (1 - one) * other, one * (1 - other)
    found = []
    for k in np.flatnonzero(first != then).tolist():
        chance = float((came if then[k] == TAKEN else left)[k]) if both[k] else None
        stall, was = panel.stalls[later[k]], panel.stalls[earlier[k]]
        states = _STATE[int(first[k])], _STATE[int(then[k])]
        found.append(StateChange(stall.id, stall.label, was.id, *states, chance))
    unknown = len(both) - int(both.sum())
    return Changed(
        stalls=tuple(found), compared=int(both.sum()), unknown=unknown, free=_more_free(first, then, one, other, both),
        came=_counted(both & (first == FREE) & (then == TAKEN), came, both, unknown, 2),
        left=_counted(both & (first == TAKEN) & (then == FREE), left, both, unknown, 2),
        matched=len(again), begin=_lone(panel, new, again.values()), gone=_lone(panel, gone, again),
    )  # fmt: skip


def _drawn_again(panel: Panel, gone: Ints, new: Ints) -> dict[int, int]:
    """Return which of the stalls that are gone lie where a new one does, each once: the largest share first."""
    shapes = np.array([stall.shape for stall in panel.stalls], np.float64).reshape(-1, 5)
    pairs = geometry.overlaps_between(shapes[gone], shapes[new], SAME_GROUND)
    found: dict[int, int] = {}
    used: set[int] = set()
    for one, other, _ in sorted(pairs, key=lambda pair: -pair[2]):
        was, stall = int(gone[one]), int(new[other])
        if was not in found and stall not in used:
            found[was] = stall
            used.add(stall)
    return found


def _lone(panel: Panel, stalls: Ints, compared: Collection[int]) -> tuple[StallLabel, ...]:
    return tuple(StallLabel(panel.stalls[k].id, panel.stalls[k].label) for k in stalls.tolist() if k not in compared)


def _more_free(first: States, then: States, one: Floats32, other: Floats32, both: Bools) -> Estimate:
    """Return how many more of the compared stalls are free.

    States of two surveys err each for itself, those of one together (`hawk.stats.counts`): the variances of both
    numbers of free stalls are added.
    """
    if not both.any():
        return NOTHING
    more = float((both & (then == FREE)).sum()) - float((both & (first == FREE)).sum())
    off = DEVIATIONS * float(
        np.sqrt(WIDER * sum((each * (1 - each))[both].sum(dtype=np.float64) for each in (one, other)))
    )
    most = float(both.sum())
    return Estimate(more, max(more - off, -most), min(more + off, most), 2)


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
    probability = np.clip(np.nan_to_num(panel.taken_probability), 1e-6, 1 - 1e-6)
    surveys = np.count_nonzero(summed(is_seen, groups), axis=0).tolist()
    ever = panel.is_there.any(axis=0)
    enough = looks >= LEAST_LOOKS
    lists, chances = [], []
    for state, right in ((FREE, 1 - probability), (TAKEN, probability)):
        lists.append(enough & np.all(~is_seen | (panel.state == state), axis=0))
        chances.append(np.exp((np.log(right) * is_seen).sum(axis=0, dtype=np.float64)))
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
