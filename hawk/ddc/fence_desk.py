"""What an operator is told about a fence that is being drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hawk.comm.fence_messages import CheckFence, FenceCheck, SetFence
from hawk.ddc.fence_keeper import corners
from hawk.ddc.fence_plan import FencePlan, check_plan
from hawk.ddc.geofence import FenceError, contains, outside_by, sees_all, to_map
from hawk.ddc.words import metres
from hawk.model import Fence

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

BLIND_HOME = "From parts of it the straight way home leaves the fence: the autopilot returns straight."


def plan_of(command: SetFence | CheckFence) -> FencePlan:
    """Return the fence that a command means."""
    return FencePlan("drawn", tuple((each.latitude, each.longitude) for each in command.corners), command.ceiling)


def fence_refusal(context: OperationsManager, command: SetFence) -> str:
    """Return why the fence cannot be kept; empty when it can."""
    try:
        check_plan(plan_of(command), context.settings, context.heights)
    except FenceError as error:
        return str(error)
    return ""


def answer_check(context: OperationsManager, command: CheckFence) -> FenceCheck:
    """Return what speaks against the fence and what the drone would make of it."""
    plan = plan_of(command)
    try:
        found = check_plan(plan, context.settings, context.heights)
    except FenceError as error:
        return FenceCheck(
            id=command.id, problem=str(error), notes=[], inner=[], north_south=None, east_west=None, area=None
        )
    return FenceCheck(
        id=command.id,
        problem="",
        notes=_notes(context, plan),
        inner=corners(found.inner),
        north_south=found.north_south,
        east_west=found.east_west,
        area=found.area,
    )


def _notes(context: OperationsManager, plan: FencePlan) -> list[str]:
    """Return what would keep the drone on the ground, or surprise, where it stands now."""
    place = context.topics.get_global_pose()
    if place is None:
        return ["Where the drone is, is not known yet."]
    datum = context.datum_for_arm() or place
    fence = plan.on_map(datum, context.settings.fence)
    home = to_map(datum, place.latitude, place.longitude)
    if not contains(fence, home):
        away = metres(max(1.0, outside_by(fence, home)))
        return [f"The drone stands {away} outside the dotted line: it could not be armed there."]
    return [*_height_notes(context, fence), *([] if sees_all(fence, home) else [BLIND_HOME])]


def _height_notes(context: OperationsManager, fence: Fence) -> list[str]:
    altitude = context.preflight.return_height
    if altitude is None or altitude <= fence.ceiling:
        return []
    return [f"It returns home at {metres(altitude)}, above {metres(fence.ceiling)}: change the heights first."]
