"""What can be set of the path planner; metres unless said otherwise."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PathPlanSettings:
    """Settings of the Path Plan App."""

    good_share: float = 0.85
    """Middle share of the picture, each way, in which a place counts as seen well: the mapper's own."""
    near_lot_m: float = 10.0
    """How far from the lot the drone may be while it explores."""
    arrival_m: float = 2.5
    """Distance at which a target counts as reached."""
    least_gain_m2: float = 20.0
    """Expected new lot (a stall and a half) below which a way is not worth flying."""
    small_lot_pictures: float = 1.5
    """A lot smaller than so many pictures may be part of a larger one: the drone looks around it before it is done."""
    scout_near_lot_m: float = 25.0
    """How far from the lot the drone may be while it looks around."""
    scout_way_m: float = 120.0
    """Way that looking around may cost."""
    quiet_plans: int = 12
    """Plans in a row without anything to learn after which the exploration is done."""
    second_looks: int = 12
    """Unclear stalls that are flown to once more, at most."""
    review_plans: int = 8
    """Plans between two looks for a better way while a line is approached."""
    switch_share: float = 0.75
    """Share of the present plan's way below which another plan takes over."""
