"""Settings of the path planner; metres unless said otherwise. An area of lot is worth its square metres to a tour."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class PathPlanSettings:
    """Settings of the Path Plan App."""

    good_share: float = 0.85
    """Middle share of the picture's width and depth in which a place is seen well: the mapper's own."""
    known_share: float = 1.0
    """The same for stalls whose places are known: their states are read wherever a picture shows them whole."""
    turned_share: float = 0.92
    """Share of half a picture's width about a place that is shown by turning there: no drone turns at a point."""
    spun_share: float = 0.96
    """Share of the distance from a picture's middle to its corner that half a turn shows: the drone drifts a little."""
    lean_deg: float = 16.0
    """Lean of the drone as it speeds up and in corners: measured in hawk-sim, with ArduCopter's own limits."""
    stop_lean_deg: float = 9.0
    """Least lean before it stops: it slows down more gently than it speeds up."""
    lean_share: float = 0.81
    """Share of half a picture's width that is shown about its middle while it leans into a corner."""
    least_turn_m2: float = 30.0
    """Least expected new lot about the drone for a turn on the spot."""
    near_lot_m: float = 10.0
    """Largest distance of the drone from the lot while it explores."""
    cm_per_pixel: float | None = None
    """Size of a pixel on the ground while exploring, centimetres; None: from the operator's desired height."""
    exposure_s: float = 0.01
    """Longest time that the camera's shutter is open, seconds."""
    arrival_m: float = 2.5
    """Distance at which a target is reached."""
    short_by: float = 15.0
    """Cost of ground that a tour does not show, as a multiple of the path that sweeps it."""
    last_short_by: float = 100.0
    """The same at the end, when little and far ground is left: one stall is worth some 40 m."""
    turn_m: float = 3.0
    """Cost of a right angle, metres of path: braking, yaw, speeding up."""
    leg_m: float = 2.0
    """Cost of a waypoint, metres of path: many small corrections are worth less than they seem."""
    keep_m: float = 3.0
    """Least gain by another first waypoint: no dithering between equals."""
    border: float = 0.4
    """Weight (0..1) of ground beside the lot against lot: the border is never known to the metre."""
    first_spare: float = 0.01
    """Share (0..1) of the known lot that the first pass may leave out."""
    last_spare: float = 0.004
    """The same for the second pass."""
    most_spare_m2: float = 300.0
    """Largest area that either leaves out, on any lot."""
    switch_m: float = 4.0
    """Least gain by which another tour takes over from the one that is flown."""
    idle_plans: int = 24
    """Plans at one place without anything new after which the waypoint is given up: it cannot be seen."""
    idle_path_m: float = 400.0
    """The same for metres flown."""
    least_gain_m2: float = 15.0
    """Least expected new lot (a stall) in one patch that is worth flying to."""
    last_least_gain_m2: float = 15.0
    """The same after the first pass."""
    open_end_m2: float = 30.0
    """Worth, beyond the spare area, of a stretch of unseen ground along known lot in the second pass: maybe a lane.

    0: open ends are no lanes.
    """
    beyond_m: float = 24.0
    """Distance to which a lot may go on across other ground: a drive of 8 m, footpaths, planted strips, a row."""
    beyond_alike_m: float = 10.0
    """Distance to which it may go on from ground that looks like lot."""
    beyond_width_m: float = 14.0
    """Least width of ground that holds rows on both sides of an aisle, nearly."""
    beyond_worth: float = 0.3
    """Worth (0..1) against lot, in the second pass, of ground within it that was not looked at, where nearly all ground
    inside the fence is lot (`hawk.algo.path_plan.overview.Overview.found_share`); 0: none.
    """
    beyond_path_m: float = 40.0
    """Longest path for looking at such ground since lot was found, beside the share below."""
    beyond_path_share: float = 0.4
    """The same as a share of all that was flown until then."""
    found_m2: float = 60.0
    """Least area of lot that such looks have found: four stalls. The map's border moves a little."""
    beyond_least_m2: float = 40.0
    """Least area of such ground in one patch that is worth flying to: three stalls."""
    small_lot_pictures: float = 1.5
    """Number of pictures that a lot must fill to be the whole; the drone looks around a smaller one."""
    scout_near_lot_m: float = 25.0
    """Largest distance of the drone from the lot while it looks around."""
    scout_path_m: float = 120.0
    """Longest path for looking around."""
    quiet_plans: int = 12
    """Plans in a row without anything to learn after which the exploration is done."""
    stall_look_m: float = 8.0
    """Distance at which the drone has looked at an unclear stall again."""
    second_looks: int = 12
    """Most unclear stalls that are flown to once more."""

    def for_outlined_ground(self) -> PathPlanSettings:
        """Return the settings for the outline of an operator: nothing is looked for beside it, and no cell is spared.

        Corners and waypoints cost nothing but their path, and the drone may leave the ground for a while: measured by
        ``python -m benchmarks.exploration``.
        """
        return replace(
            self,
            border=0.0,
            turn_m=0.0,
            leg_m=0.0,
            near_lot_m=25.0,
            first_spare=0.01,
            last_spare=0.0,
            last_short_by=10_000.0,
            last_least_gain_m2=0.0,
            open_end_m2=0.0,
            beyond_worth=0.0,
        )
