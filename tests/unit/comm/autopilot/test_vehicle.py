"""The autopilot's memory for a fence: what fits, and what is said of what does not."""

from __future__ import annotations

import math

import pytest

from hawk.comm.autopilot.vehicle import STORAGE_BYTES, AutopilotError, rings_of
from hawk.model.plans import Fence
from hawk.model.poses import GlobalPose

ORIGIN = GlobalPose(43.26, -79.92, 100.0)


def fence_of(corners: int, *zones: int) -> Fence:
    def ring(count: int, radius: float) -> tuple[tuple[float, float], ...]:
        turns = (2 * math.pi * k / count for k in range(count))
        return tuple((radius * math.cos(turn), radius * math.sin(turn)) for turn in turns)

    return Fence(
        polygon=ring(corners, 90.0),
        ceiling=97.0,
        autopilot_polygon=ring(corners, 95.0),
        autopilot_ceiling=100.0,
        zones=tuple(ring(count, 6.0) for count in zones),
        autopilot_zones=tuple(ring(count, 5.0) for count in zones),
    )


@pytest.mark.parametrize(("corners", "zones", "needed"), [(69, (), 559), (34, (34,), 553), (3, (3, 3, 60), 565)])
def test_a_fence_needs_five_bytes_two_a_ring_and_eight_a_corner(
    corners: int, zones: tuple[int, ...], needed: int
) -> None:
    fence = fence_of(corners, *zones)
    if needed <= STORAGE_BYTES:
        assert len(rings_of(fence, ORIGIN).inclusion) == corners
    else:
        with pytest.raises(AutopilotError, match=f"needs {needed} bytes, the autopilot has 560"):
            rings_of(fence, ORIGIN)
