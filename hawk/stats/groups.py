"""Groups of stalls: the whole lot, its rows, zones and kinds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from hawk.lots.plan.kinds import KINDS
from hawk.stats.partition import Partition
from hawk.stats.values import Group, Panel, PanelColumn

WHOLE: Final = "lot"
NO_ROW: Final = "other"
"""Row of stalls whose label names none."""
NO_ZONE: Final = "no zone"


def whole(panel: Panel) -> list[Group]:
    """Return all stalls of the lot as one group."""
    return [Group(panel.name or WHOLE, np.ones(len(panel.stalls), np.bool_))]


def groups_of(panel: Panel, by: Partition | None) -> list[Group]:
    """Return the groups of a lot by a `Partition` of its stalls, else none. A stall in two zones is in two groups."""
    if by not in _NAMES:
        return []
    names = [_NAMES[by](stall) for stall in panel.stalls]
    found = sorted({name for each in names for name in each}, key=lambda name: (len(name), name))
    return [Group(name, np.array([name in each for each in names], np.bool_)) for name in found]


_NAMES: Final[Mapping[Partition | None, Callable[[PanelColumn], tuple[str, ...]]]] = {
    "row": lambda stall: (stall.row or NO_ROW,),
    "zone": lambda stall: stall.zones or (NO_ZONE,),
    "kind": lambda stall: (stall.kind or KINDS[""],),
}
