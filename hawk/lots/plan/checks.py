"""Checks of a draft against the plan: overlaps, areas without stalls, labels that were another stall's.

Each refusal names the field and the remedy; nothing is written then.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from hawk.lots.labels import lasting_labels
from hawk.lots.plan import geometry
from hawk.lots.plan.operations import FARTHEST_M
from hawk.lots.plan.values import NEW, Draft, LayoutStall, PlanZone, shapes_of
from hawk.lots.values import LotInputError
from hawk.model.lot_map import Stall, StallState
from hawk.results.row_labels import letters

MOST_OVERLAP: Final = 0.10
"""Share of the smaller of two stalls that may be the other one's: lines have a width, and vision errs by some of it."""
_WORSE: Final = 1e-4
"""Rounding of a share: two stalls that vision found with a larger overlap may go on together, and come no nearer."""


def check_places(draft: Draft, around: Sequence[LayoutStall], zones: Sequence[PlanZone]) -> None:
    """Refuse stalls that overlap others, stand where none may be, or are far off. Raises LotInputError.

    ``around``: the stalls of the plan near the draft's, without those that it changes or ends.
    """
    placed = draft.placed
    shapes = shapes_of(placed)
    far = np.flatnonzero(np.abs(shapes[:, :2]).max(axis=1, initial=0.0) > FARTHEST_M)
    if len(far):
        raise LotInputError(draft.field, f"{_name(placed[far[0]])} would be 20 km off: write metres in the lot's frame")
    _check_overlaps(draft, placed, around)
    for zone in (*zones, *draft.forbidden):
        inside = geometry.within(zone.outline, shapes[:, :2])
        if any(inside):
            area = f'"{zone.name}"' if zone.name else "an area"
            name = _name(placed[inside.index(True)])
            raise LotInputError(draft.field, f"{name} would stand in {area} without stalls: allow stalls there first")


def _check_overlaps(draft: Draft, placed: Sequence[LayoutStall], around: Sequence[LayoutStall]) -> None:
    former = {new.id: old for old, new in draft.changed}
    everything = (*placed, *around)
    for first, second, share in geometry.overlaps(shapes_of(placed), shapes_of(around), MOST_OVERLAP):
        one, other = everything[first], everything[second]
        before = _share(former.get(one.id, one), former.get(other.id, other))
        if before <= MOST_OVERLAP or share > before + _WORSE:
            words = f"{_name(one)} would overlap {_name(other)} by {share:.0%}: 10% is the most. Move or remove one"
            raise LotInputError(draft.field, words)


def _share(one: LayoutStall, other: LayoutStall) -> float:
    """Return by how much two stalls of the plan overlap; 0 where one is new."""
    if NEW in (one.key, other.key):
        return 0.0
    found = geometry.overlaps(shapes_of([one]), shapes_of([other]), 0.0)
    return found[0][2] if found else 0.0


def _name(stall: LayoutStall) -> str:
    return stall.label or "the new stall"


def check_labels(
    given: Sequence[LayoutStall], owners: Mapping[str, str], letters_used: Collection[str], field: str
) -> None:
    """Refuse labels that were another stall's. Raises LotInputError.

    Args:
        given: Stalls with the labels that they are to have.
        owners: Label -> id of the stall whose it was, of these labels.
        letters_used: Letters of all rows that the lot ever had.
        field: The field that gives the labels.
    """
    for stall in given:
        if owners.get(stall.label, stall.id) != stall.id:
            letter = next(each for each in letters() if each not in letters_used)
            words = f"{stall.label} was another stall's, no label is used again: take a new letter, as {letter}"
            raise LotInputError(field, words)


def labelled(
    added: Sequence[LayoutStall], around: Sequence[LayoutStall], highest: Mapping[str, int]
) -> list[LayoutStall]:
    """Return new stalls with labels: the next ones of the row that they join, else those of a new row.

    ``around``: the stalls near them, with their labels; a row that has none there is not joined.
    """
    if all(stall.label for stall in added):
        return list(added)
    near = {number: _on_map(number, stall) for number, stall in enumerate((*added, *around))}
    kept = {number: stall.label for number, stall in enumerate((*added, *around)) if stall.label}
    labels = lasting_labels(near, kept, {f"{letter} {number}" for letter, number in highest.items()})
    return [replace(stall, label=labels[number]) for number, stall in enumerate(added)]


def _on_map(number: int, stall: LayoutStall) -> Stall:
    seen = {"taken": 0.0, "state": StallState.UNKNOWN, "score": 1.0, "seen": 1, "last_seen": 0.0, "version": 0}
    return Stall(number, *stall.shape, **seen)  # type: ignore[arg-type]
