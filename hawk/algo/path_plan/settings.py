"""What can be set of the path planner; metres unless said otherwise."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PathPlanSettings:
    """Settings of the Path Plan App."""

    good_share: float = 0.85
    """Middle share of the picture, each way, in which a place counts as seen well: the mapper's own."""
    turned_share: float = 0.92
    """Share of half a picture's width about a place that counts as shown when the picture turns there: the drone does
    not turn at a point."""
    spun_share: float = 0.96
    """Share of the way from a picture's middle to its corner that counts as shown about a place where it turns half
    round: the drone drifts a little meanwhile."""
    lean_deg: float = 16.0
    """How far the drone leans as it speeds up and in corners: measured in hawk-sim, with ArduCopter's own limits."""
    stop_lean_deg: float = 9.0
    """How far it leans, at least, before it stops: it slows down more gently than it speeds up."""
    lean_share: float = 0.81
    """Share of half a picture's width that counts as shown about its middle while it leans into a corner."""
    least_turn_m2: float = 30.0
    """Expected new lot about the drone below which it does not turn on the spot for it."""
    near_lot_m: float = 10.0
    """How far from the lot the drone may be while it explores."""
    cm_per_pixel: float | None = None
    """Wanted size of a pixel on the ground while exploring, centimetres; None: the operator's desired height."""
    exposure_s: float = 0.01
    """The longest time that the camera's shutter is open, seconds."""
    arrival_m: float = 2.5
    """Distance at which a target counts as reached."""
    short_by: float = 15.0
    """What a tour does not show costs it so many times the way that sweeps it."""
    last_short_by: float = 100.0
    """The same at the end, when what is left is little and far away: one stall is worth some 40 m."""
    turn_m: float = 3.0
    """A right angle costs a tour so much way: braking, yaw, speeding up."""
    leg_m: float = 2.0
    """So much way each way point costs a tour: many small corrections are worth less than they seem."""
    keep_m: float = 3.0
    """So much shorter a tour must become by flying elsewhere first: no dithering between equals."""
    border: float = 0.4
    """Weight (0..1) of ground beside the lot against lot: the border is never known to the metre."""
    first_spare: float = 0.01
    """Share (0..1) of the known lot that the tour may leave out at first."""
    last_spare: float = 0.004
    """The same once all the rest was seen."""
    most_spare_m2: float = 300.0
    """The most that either leaves out, however large the lot."""
    switch_m: float = 4.0
    """So much shorter another tour must be to take over from the one that is flown."""
    idle_plans: int = 24
    """Plans at one place without anything new after which the way point is given up: it cannot be seen."""
    idle_way_m: float = 400.0
    """The same for way flown."""
    least_gain_m2: float = 15.0
    """Expected new lot (a stall) in one patch below which it is not worth flying to."""
    open_end_m2: float = 30.0
    """What a stretch of unseen ground along known lot counts once all the rest was seen, more than may be left out: a
    lane may lead on there to another part of the lot."""
    small_lot_pictures: float = 1.5
    """A lot smaller than so many pictures may be part of a larger one: the drone looks around it before it is done."""
    scout_near_lot_m: float = 25.0
    """How far from the lot the drone may be while it looks around."""
    scout_way_m: float = 120.0
    """Way that looking around may cost."""
    quiet_plans: int = 12
    """Plans in a row without anything to learn after which the exploration is done."""
    stall_look_m: float = 8.0
    """So near to an unclear stall the drone has looked at it again."""
    second_looks: int = 12
    """Unclear stalls that are flown to once more, at most."""
