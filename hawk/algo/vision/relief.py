"""Takes relief out of found stalls: standing cars show farther from the point below the camera than their wheels.

A thing of height h at the distance r from that point shows r h / H too far out when it is projected onto the ground,
where H is the camera's height above ground (relief displacement: Wolf, Dewitt and Wilkinson, Elements of
Photogrammetry, 4th ed., 6-8). The network takes most of it out by what it sees of a car's sides, and leaves some.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from hawk.algo.vision.seen import StallSeen
from hawk.model import MapPose


@dataclass(frozen=True, slots=True)
class Relief:
    """Heights, metres, whose relief is left in the centre of a free and of a taken stall."""

    free_m: float = 0.0
    taken_m: float = 0.0

    def taken_out(self, stalls: Sequence[StallSeen], pose: MapPose) -> tuple[StallSeen, ...]:
        """Return the stalls with their centres where they are on the ground; ``pose``: the camera's, over ground."""
        return tuple(self._moved(stall, pose) for stall in stalls)

    def _moved(self, stall: StallSeen, pose: MapPose) -> StallSeen:
        share = (self.free_m + (self.taken_m - self.free_m) * stall.taken) / pose.height
        return replace(
            stall,
            north=stall.north - (stall.north - pose.north) * share,
            east=stall.east - (stall.east - pose.east) * share,
        )


NO_RELIEF = Relief()
NETWORK_RELIEF = Relief(0.06, 0.31)
"""What the network of the package leaves: ``python -m benchmarks.perception.relief``, docs/results/perception.md."""
