"""Size of the stalls in one picture: a measure of the height that needs no barometer."""

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
