"""Checks of a draft against the plan: overlaps, areas without stalls, and parts that are far off.

Each refusal names the field and the remedy; nothing is written then.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from hawk.lots.plan import geometry
from hawk.lots.plan.operations import FARTHEST_M
from hawk.lots.plan.values import NEW, Draft, Floats, LayoutStall, PlanZone, shapes_of
from hawk.lots.values import LotInputError
from hawk.model.sentences import say

MOST_OVERLAP: Final = 0.10
"""Share of the smaller of two stalls that may be the other one's: lines have a width, and vision errs by some of it."""
MOST_APART_M: Final = 1000.0
"""Ground without any part of a lot between two parts of it: what lies farther off is another lot, flown by itself."""
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
        raise LotInputError(
            draft.field, say("{stall} would be 20 km off: write metres in the lot's frame", stall=_name(placed[far[0]]))
        )
    _check_overlaps(draft, placed, around)
    for zone in (*zones, *draft.forbidden):
        inside = geometry.within(zone.outline, shapes[:, :2])
        if any(inside):
            stall = _name(placed[inside.index(True)])
            if not zone.name:
                words = say("{stall} would stand in an area without stalls: allow stalls there first", stall=stall)
            else:
                words = say(
                    '{stall} would stand in "{area}" without stalls: allow stalls there first',
                    stall=stall,
                    area=zone.name,
                )
            raise LotInputError(draft.field, words)


def check_extent(draft: Draft, extent: Floats | None) -> None:
    """Refuse stalls and sections that lie more than `MOST_APART_M` off the rest of the lot. Raises LotInputError.

    ``extent`` (2, 2): the box around that rest, metres; None: an empty lot, which is where its first part is.
    What is near makes it larger for what goes on from there.
    """
    names = [*map(_name, draft.placed), *(each.name for each in draft.begun_sections)]
    stalls, rings = shapes_of(draft.placed)[:, :2], [np.array(each.outline) for each in draft.begun_sections]
    boxes = np.array([*((each, each) for each in stalls), *((ring.min(axis=0), ring.max(axis=0)) for ring in rings)])
    while len(boxes):
        extent = boxes[0] if extent is None else extent
        gaps = np.maximum(np.maximum(boxes[:, 0] - extent[1], extent[0] - boxes[:, 1]), 0.0)
        away = np.hypot(*gaps.T)
        is_near = away <= MOST_APART_M
        if not is_near.any():
            raise LotInputError(
                draft.field,
                say(
                    "{part} would be {away:.0f} m off the rest of the lot: {most:.0f} m is the most. Draw it where the "
                    "lot is, or in a lot of its own",
                    part=names[int(away.argmin())],
                    away=float(away.min()),
                    most=MOST_APART_M,
                ),
            )
        near = boxes[is_near]
        extent = np.stack(
            (np.minimum(extent[0], near[:, 0].min(axis=0)), np.maximum(extent[1], near[:, 1].max(axis=0)))
        )
        boxes, names = boxes[~is_near], [name for name, is_one in zip(names, is_near, strict=True) if not is_one]


def _check_overlaps(draft: Draft, placed: Sequence[LayoutStall], around: Sequence[LayoutStall]) -> None:
    former = {new.id: old for old, new in draft.changed}
    everything = (*placed, *around)
    for first, second, share in geometry.overlaps(shapes_of(placed), shapes_of(around), MOST_OVERLAP):
        one, other = everything[first], everything[second]
        before = _share(former.get(one.id, one), former.get(other.id, other))
        if before <= MOST_OVERLAP or share > before + _WORSE:
            words = say(
                "{stall} would overlap {other} by {share:.0f}%: 10% is the most. Move or remove one",
                stall=_name(one),
                other=_name(other),
                share=100 * share,
            )
            raise LotInputError(draft.field, words)


def _share(one: LayoutStall, other: LayoutStall) -> float:
    """Return by how much two stalls of the plan overlap; 0 where one is new."""
    if NEW in (one.key, other.key):
        return 0.0
    found = geometry.overlaps(shapes_of([one]), shapes_of([other]), 0.0)
    return found[0][2] if found else 0.0


def _name(stall: LayoutStall) -> str:
    return stall.label or say("the new stall")
