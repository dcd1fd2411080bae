"""Pictures of earlier in the flight that are kept, so that ground that is seen again is compared with them.

A comparison with an earlier picture says how far the drone has come from that picture's place, whatever it flew, and
however slowly, in between: no error of the steps adds up in it. The oldest picture that has enough in common with the
present one is taken: over a hover that is the one of where it began, over a lane of a survey that of the lane beside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from hawk.algo.vision.similarity import KEY_SHARE, KEY_STRETCH, REACH_M, GroundFeatures, Similarity, compare
from hawk.model.pictures import GroundAgain
from hawk.model.poses import MapPose

AGAIN_S = 0.45
"""Shortest time between two comparisons with earlier pictures, seconds."""
EARLIER_S = 4.0
"""Younger pictures are not compared: the step does it."""
SPACING_SHARE = 0.2
"""A picture is kept where no other one is nearer than this share of the height, ..."""
HIGHER_SHARE = 0.25
"""... or all of those are higher or lower by this share."""
FARTHEST_SHARE = 0.5
"""A match that is farther from the expected place than this share of the height is a wrong one."""
CAPACITY, FIRST = 96, 12
"""Most pictures that are kept, 17 kB each, and those of the flight's beginning that are never dropped: its home."""


@dataclass(frozen=True, slots=True)
class _Anchor:
    """A picture that is kept: what the drone had moved ``beyond`` the poses until then, by all comparisons, metres."""

    time: float
    pose: MapPose
    ground: GroundFeatures
    beyond: complex


class Anchors:
    """Keeps pictures, and compares each one of half a second with one of them. Worker thread only."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all pictures: the poses of before and after are not of one flight, or leapt."""
        self._kept: list[_Anchor] = []
        self._beyond = 0j
        self._unexpected = 0j
        self._looked = -math.inf
        self._passed_over = 0

    def look(self, time: float, pose: MapPose, ground: GroundFeatures, beyond: complex) -> GroundAgain | None:
        """Return the comparison with an earlier picture; None without one. The picture may be kept.

        Args:
            time: Its exposure, seconds.
            pose: The reported pose, its height above the ground.
            ground: Its features.
            beyond: What the drone was seen to move since the last look that the poses do not report, metres.
        """
        self._beyond += beyond
        again = None
        if time - self._looked >= AGAIN_S:
            self._looked = time
            again = self._compared(time, pose, ground)
        if not any(self._is_covered(anchor, pose, SPACING_SHARE) for anchor in self._kept):
            self._keep(_Anchor(time, pose, ground, self._beyond))
        return again

    def _compared(self, time: float, pose: MapPose, ground: GroundFeatures) -> GroundAgain | None:
        """Compare with the oldest picture that covers this place; after a failure with the next one."""
        known = [
            anchor
            for anchor in self._kept
            if time - anchor.time >= EARLIER_S and self._is_covered(anchor, pose, KEY_SHARE)
        ]
        if not known:
            return None
        anchor = known[self._passed_over % len(known)]
        moved = complex(pose.north - anchor.pose.north, pose.east - anchor.pose.east)
        expected = Similarity(offset=-(moved + self._beyond - anchor.beyond))
        found = compare(anchor.ground, ground, expected, FARTHEST_SHARE * pose.height)
        if found is None or abs(math.log(abs(found.factor))) > KEY_STRETCH:
            self._passed_over += 1
            return None
        self._passed_over = 0 if anchor is known[0] else self._passed_over
        beyond = -found.offset - moved
        self._correct(anchor.beyond + beyond - self._beyond)
        return GroundAgain(
            since=anchor.time,
            beyond=(beyond.real, beyond.imag),
            reported=(moved.real, moved.imag),
            yawed=math.remainder(pose.yaw - anchor.pose.yaw, math.tau),
        )

    def _correct(self, error: complex) -> None:
        """Go by a comparison that is about as expected, or that the next one repeats: rows of stalls look alike."""
        is_repeated = abs(error - self._unexpected) <= REACH_M
        if abs(error) <= REACH_M or is_repeated:
            self._beyond += error
            self._unexpected = 0j
        else:
            self._unexpected = error

    def _is_covered(self, anchor: _Anchor, pose: MapPose, share: float) -> bool:
        """Return True when the drone is truly about that picture's place, as the comparisons until now have it."""
        north, east = pose.north - anchor.pose.north, pose.east - anchor.pose.east
        apart = complex(north, east) + self._beyond - anchor.beyond
        is_alike = abs(math.log(pose.height / anchor.pose.height)) <= HIGHER_SHARE
        return is_alike and abs(apart) <= share * pose.height

    def _keep(self, anchor: _Anchor) -> None:
        if len(self._kept) >= CAPACITY:
            del self._kept[FIRST]
        self._kept.append(anchor)
