"""Changes that a placed plan makes to a lot: stalls that stay with another label, that begin, and that end.

A stall of the lot that one of the plan overlaps by half keeps its id. Labels of the owner are kept as they are: ours
yield to them. One that a person confirmed on a stall which stays as it is yields to none.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
import shapely
from shapely import Polygon, union_all

from hawk.lots.plan import geometry
from hawk.lots.plan.checks import MOST_OVERLAP
from hawk.lots.plan.operations import LONGEST_LABEL
from hawk.lots.plan.values import Draft, Floats, LayoutStall, PlanZone, shapes_of
from hawk.lots.plan_files.values import FileFeature, LeftOut
from hawk.lots.plan_import.section_match import MatchedSections
from hawk.lots.registration.survey_place import ABOUT_M
from hawk.results.label_parts import in_order

SAME_SHARE: Final = 0.5
"""Overlap from which a stall of the plan is that of the lot, of the smaller area."""
_EDGE_M: Final = 6.0
"""By this the ground about the plan's stalls is made smaller again: aisles are filled, a margin of 2 m is left."""
_ALIKE: Final = 1e-3
"""Metres and radians by which a stall of the plan is where that of the lot is already."""
_NOWHERE: Final = (0.0,) * 5
_MOST_NAMESAKES: Final = 99
"""Numbers that are tried behind a label that another stall keeps."""


@dataclass(frozen=True, slots=True)
class Choices:
    """The choices of a person: ``replace`` ends stalls that the plan has not; ``rename`` gives other labels."""

    replace: bool = False
    rename: bool = False


@dataclass(frozen=True, slots=True)
class Matched:
    """The change that a plan makes, with the stalls of the file that are no part of it and the labels in question.

    ``clashes``: stalls whose label another one keeps; the change cannot be made while there are some. ``renamed``:
    pairs of the file's label and the one that the stall gets; names of sections are among both. ``same_sections``:
    number of sections that the plan has as the file does.
    """

    draft: Draft = field(repr=False)
    left_out: tuple[LeftOut, ...]
    clashes: tuple[LeftOut, ...]
    renamed: tuple[tuple[str, str], ...]
    same_sections: int = 0

    def beside(self, found: MatchedSections) -> Matched:
        """Return the change with that of the sections."""
        return replace(
            self,
            draft=replace(self.draft, begun_sections=found.begun, ended_sections=found.ended),
            clashes=(*self.clashes, *found.clashes),
            renamed=(*self.renamed, *found.renamed),
            same_sections=found.same,
        )


def matched(
    stalls: Sequence[FileFeature],
    shapes: Floats,
    present: Sequence[LayoutStall],
    zones: Sequence[PlanZone],
    choices: Choices,
    new_id: Callable[[], str],
) -> Matched:
    """Return the change. ``shapes`` (N, 5): of the file's stalls, in the lot's frame."""
    left_out: list[LeftOut] = []
    kept = _allowed(stalls, shapes, zones, left_out)
    there = shapes_of(present)
    pairs = geometry.overlaps_between(shapes, there, MOST_OVERLAP)
    same = _same([(i, k, share) for i, k, share in pairs if i in kept], shapes, there)
    if choices.replace:
        ended = _ended(shapes[sorted(kept)], there, pairs, same)
    else:
        ended = set()
        _leave_conflicts(stalls, present, pairs, same, kept, left_out)
    clashes: list[LeftOut] = []
    order = sorted(kept)
    leaving = {*ended, *(k for i, k in same.items() if stalls[i].label)}
    keeping = [stall for k, stall in enumerate(present) if k not in leaving]
    labels, renamed = _labels([stalls[i] for i in order], keeping, choices, clashes)
    named = dict(zip(order, labels, strict=True))
    changed, added = [], []
    for i in order:
        shape = np.round(shapes[i], 6).tolist()
        if i in same:
            old = present[same[i]]
            kind = old.kind if stalls[i].kind is None else str(stalls[i].kind)
            place = old if _is_there(shapes[i], old) else old.at(shape)
            label, is_named = (named[i], True) if named[i] else (old.label, old.is_named)
            new = replace(place, label=label, kind=kind, is_confirmed=True, is_named=is_named)
            if new != old:
                changed.append((old, new))
        else:
            blank = LayoutStall(new_id(), named[i], *_NOWHERE, stalls[i].kind or "", True, bool(named[i]))
            added.append(blank.at(shape))
    gone = tuple(in_order(present[k] for k in ended))
    draft = Draft(changed=tuple(changed), ended=gone, added=tuple(added), field="file")
    return Matched(draft, tuple(left_out), tuple(clashes), tuple(renamed))


def _is_there(shape: Floats, stall: LayoutStall) -> bool:
    """Return whether a stall of the plan is where that of the lot is already: an angle of pi is one of 0."""
    apart = np.abs(shape - stall.shape)
    apart[2] = min(apart[2], np.pi - apart[2])
    return bool(apart.max() < _ALIKE)


def _allowed(
    stalls: Sequence[FileFeature], shapes: Floats, zones: Sequence[PlanZone], left_out: list[LeftOut]
) -> set[int]:
    """Return the numbers of the stalls that stand where stalls may be."""
    kept = set(range(len(stalls)))
    for zone in zones:
        inside = geometry.within(zone.outline, shapes[:, :2])
        for i in [i for i in kept if inside[i]]:
            area = f'"{zone.name}"' if zone.name else "an area"
            left_out.append(LeftOut(stalls[i].name, f"stands in {area} without stalls: allow stalls there first"))
            kept.discard(i)
    return kept


def _same(pairs: Sequence[tuple[int, int, float]], shapes: Floats, there: Floats) -> dict[int, int]:
    """Return which stall of the lot each one of the plan is: by the largest overlap, each at most once."""
    away = [float(np.hypot(*(shapes[i, :2] - there[k, :2]))) for i, k, _ in pairs]
    order = sorted(range(len(pairs)), key=lambda n: (-round(pairs[n][2], 2), away[n]))
    same: dict[int, int] = {}
    taken: set[int] = set()
    for n in order:
        i, k, share = pairs[n]
        if share >= SAME_SHARE and i not in same and k not in taken:
            same[i] = k
            taken.add(k)
    return same


def _ended(shapes: Floats, there: Floats, pairs: Sequence[tuple[int, int, float]], same: Mapping[int, int]) -> set[int]:
    """Return the numbers of the lot's stalls that the plan has not: on its ground, or under its stalls."""
    if not len(shapes):
        return set()
    ground = union_all(shapely.buffer(geometry.polygons(shapes), ABOUT_M)).buffer(-_EDGE_M)
    parts = [Polygon(part.exterior) for part in shapely.get_parts(ground)]
    inside = np.zeros(len(there), np.bool_)
    for part in parts:
        inside |= shapely.contains_xy(part, there[:, :2])
    return {*np.flatnonzero(inside).tolist(), *(k for _, k, _ in pairs)} - {*same.values()}


def _leave_conflicts(
    stalls: Sequence[FileFeature],
    present: Sequence[LayoutStall],
    pairs: Sequence[tuple[int, int, float]],
    same: dict[int, int],
    kept: set[int],
    left_out: list[LeftOut],
) -> None:
    """Leave stalls of the plan out that overlap one which stays as it is: as long as that frees others to stay."""
    while True:
        changing = {*same.values()}
        found = [(i, k, share) for i, k, share in pairs if i in kept and k not in changing]
        if not found:
            return
        for i, k, share in found:
            if i not in kept:
                continue
            kept.discard(i)
            same.pop(i, None)
            label = present[k].label
            words = f"would overlap {label}, which stays, by {share:.0%}: import with replace, or remove that one"
            left_out.append(LeftOut(stalls[i].name, words))


def _labels(
    stalls: Sequence[FileFeature], keeping: Sequence[LayoutStall], choices: Choices, clashes: list[LeftOut]
) -> tuple[list[str], list[tuple[str, str]]]:
    """Return the labels of stalls, "" for those that keep theirs or get one of ours, and the pairs that were renamed.

    ``keeping``: the stalls of the lot that the plan gives no label and does not end.
    """
    of_lot = {stall.label for stall in keeping if stall.is_named}
    first_of: dict[str, str] = {}
    for stall in stalls:
        if stall.label and stall.label not in of_lot:
            first_of.setdefault(stall.label, stall.name)
    known = {*of_lot, *first_of}
    labels, renamed = [], []
    for stall in stalls:
        if first_of.get(stall.label, "") == stall.name or not stall.label:
            labels.append(stall.label)
        elif choices.rename:
            labels.append(next((each for each in _namesakes(stall.label) if each not in known), ""))
            known.add(labels[-1])
            renamed.append((stall.label, labels[-1]))
        else:
            another = first_of.get(stall.label, "")
            whose = f"{another} has it too" if another else "a person confirmed it on another stall of this lot"
            clashes.append(
                LeftOut(stall.name, f"label {stall.label}: {whose}; write another one, or import with rename")
            )
            labels.append("")
    return labels, renamed


def _namesakes(label: str) -> list[str]:
    """Return labels like one that is taken: with a number behind it."""
    ends = [f"-{number}" for number in range(2, _MOST_NAMESAKES + 1)]
    return [label[: LONGEST_LABEL - len(end)] + end for end in ends]
