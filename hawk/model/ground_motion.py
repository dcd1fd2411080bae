"""The camera as a witness: the drone's motion over ground between two pictures, and the size of the stalls."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StallSize:
    """``time``: exposure, seconds of the daemon's clock. ``height``: reported, over ground, metres.

    ``width``: the usual one of the stalls that the picture shows whole, metres by that height.
    """

    time: float
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class GroundStep:
    """From the exposure at ``since`` to that at ``until`` (daemon's clock, seconds).

    ``seen`` is the drone's movement by the pictures, at the reported height over ground, and ``reported`` that by the
    poses: metres north and east. ``stretch`` is the logarithm of the factor by which the same ground has become larger
    at the reported heights: positive while the drone sinks and its height does not show it. ``turn`` is how far the
    drone turned, clockwise, beyond what its heading shows, radians. ``height`` is the reported one over ground at
    ``until``, metres. Steps one after the other are measured against the same earlier picture where they can be: their
    errors do not add up then.
    """

    since: float
    until: float
    seen: tuple[float, float]
    reported: tuple[float, float]
    stretch: float
    turn: float
    height: float

    @property
    def beyond(self) -> tuple[float, float]:
        """Movement that the poses do not report, metres north and east."""
        return self.seen[0] - self.reported[0], self.seen[1] - self.reported[1]
