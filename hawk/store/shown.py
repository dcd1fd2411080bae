"""Values that a recording shows to viewers, as the daemon hands them over; `hawk.store.views` encodes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hawk.model.lot_map import Stall
from hawk.model.operation import Level
from hawk.model.poses import GlobalPose, VehiclePose


@dataclass(frozen=True, slots=True)
class Words:
    """A message for the operator."""

    level: Level
    text: str
    details: str = ""


@dataclass(frozen=True, slots=True)
class StallsSeen:
    """The stalls of a map, and the WGS-84 place of its origin."""

    datum: GlobalPose
    stalls: Mapping[int, Stall] = field(repr=False)


View = VehiclePose | Words | StallsSeen
