"""Values of one frame: the input that the worker reads, the output that it returns, and its error; work in steps.

Work in steps is a generator that yields after a few milliseconds of it and returns its outcome at the end. A frame does
one step of long work, so that no frame waits for the whole.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, field, replace
from typing import TypeVar, cast

from hawk.model.known_lot import KnownLot, LotTour
from hawk.model.lot_map import OccupancyMap
from hawk.model.operation import Health, StateName
from hawk.model.pictures import CameraModel, GroundStep, StallSize
from hawk.model.plans import AskedGround, DesiredPose, Fence, HeightParameters, PathPlan
from hawk.model.poses import MapPoint, MapPose, Ring
from hawk.model.sun import SunPosition


class AlgoError(Exception):
    """An algorithm could not work on this frame; the text gives the reason (specification sections 10 to 13)."""


@dataclass(frozen=True, slots=True)
class FrameInput:
    """Everything that the algorithms know about one frame.

    ``captured`` is the time of exposure (daemon's clock, seconds); ``pose`` is interpolated to that moment, None before
    the first arm or when no pose is near enough (then nothing is mapped). ``speed`` is horizontal m/s. ``asked`` is a
    place whose route is asked for; nothing is flown for it.
    """

    sequence: int
    captured: float
    jpeg: bytes = field(repr=False)
    camera: CameraModel
    pose: MapPose | None
    speed: float
    state: StateName
    desired: DesiredPose | None
    heights: HeightParameters
    fence: Fence | None
    home: MapPoint | None
    asked: DesiredPose | None = None
    map_problem: str = ""
    """Why nothing may be mapped by this pose; empty when it may be."""
    asked_ground: AskedGround | None = None
    """Ground inside the fence that an operator asked to survey; None: the lot is found by looking."""
    ground: float = 0.0
    """Height of the ground below at the exposure, metres above the arm place; 0 where no rangefinder measures it."""
    mount_problem: str = ""
    """Why nothing is known of where the camera looks; empty when it is."""
    sun: SunPosition | None = None
    """The sun's place in the sky at the exposure; None where moment or place are not known."""
    known: tuple[KnownLot, ...] = field(default=(), repr=False)
    """The lots that are flown over, where they are known; another object is another plan of one."""
    tours: tuple[LotTour, ...] = field(default=(), repr=False)
    """Tours over the lots that an operator asked to survey again, in their order; empty: ground or lot are explored."""
    private: tuple[Ring, ...] = field(default=(), repr=False)
    """Rings (north, east) of ground that nobody may look at, metres of the map."""

    @property
    def over_ground(self) -> MapPose | None:
        """``pose`` with its height above the ground below: the scale of the picture."""
        if self.pose is None or not self.ground:
            return self.pose
        return replace(self.pose, height=self.pose.height - self.ground)


@dataclass(frozen=True, slots=True)
class FrameOutput:
    """Results of one frame.

    ``camera_health`` is what the pictures show of the camera: frozen, turned, mirrored. ``timings`` are milliseconds by
    step. ``is_damaged``: a part of the picture was lost in transit, so that nothing of it is used.
    """

    sequence: int
    captured: float
    park_lot_detected: bool
    annotated_jpeg: bytes = field(repr=False)
    occupancy_map: OccupancyMap = field(repr=False)
    path_plan: PathPlan
    footprint: tuple[MapPoint, ...]
    vision_health: Health
    mapper_health: Health
    path_plan_health: Health
    timings: tuple[tuple[str, float], ...] = ()
    camera_health: Health = field(default_factory=Health)
    is_damaged: bool = False
    ground_step: GroundStep | None = None
    """Motion over ground since an earlier frame; None where the two were not compared, or the camera is not well."""
    stall_size: StallSize | None = None
    """Usual size of the stalls; None where too few are whole."""
    recorded_jpeg: bytes | None = field(default=None, repr=False)
    """The picture to record: without private ground, b"" for none; None: the frame's own."""


Outcome = TypeVar("Outcome")
Steps = Generator[None, None, Outcome]


def outcome(steps: Steps[Outcome]) -> Outcome:
    """Do all the steps of some work and return its outcome."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return cast("Outcome", end.value)
