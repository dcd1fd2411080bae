"""What goes to the vision worker for one frame, and what comes back: the worker reads and returns nothing else."""

from __future__ import annotations

from dataclasses import dataclass, field

from hawk.model import (
    CameraModel,
    DesiredPose,
    Fence,
    Health,
    HeightParameters,
    MapPoint,
    MapPose,
    OccupancyMap,
    PathPlan,
    StateName,
)


@dataclass(frozen=True, slots=True)
class FrameInput:
    """Everything that the algorithms may know about one frame.

    ``captured`` is when the light was caught (daemon's clock, seconds); ``pose`` is interpolated to that moment, None
    before the first arm or when no pose is near enough (then nothing is mapped). ``speed`` is horizontal m/s.
    ``asked`` is a place that the way to is to be told, without flying there.
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


@dataclass(frozen=True, slots=True)
class FrameOutput:
    """What the algorithms made of one frame. ``timings`` are milliseconds by step."""

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
