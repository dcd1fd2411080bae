"""Heading: whether the reported heading turns as the camera sees the drone turn.

A compass that is off takes the estimate with it, all flags good. The camera sees the ground turn below the drone.
Only turns are compared: how the camera is mounted does not matter.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Final

from hawk.ddc.stopwatch import Doubt
from hawk.model.pictures import GroundStep
from hawk.model.sentences import say

WINDOW_S: Final = 30.0
"""Time over which the turns are compared, seconds: the camera's errors add up."""
LIMIT_DEG: Final = 25.0
"""Disagreement in the window that is a doubt. A picture's time that is off by 0.1 s leaves up to 19° in a survey at
12 m with turns of half a circle, and 16° in wind."""
GAP_DEG: Final = 12.0
"""Disagreement that a comparison that is missing may leave: half of a turn at 1 rad/s whose picture's time is off by
0.2 s."""
CONFIRM_S: Final = 0.5
"""Time for which it must last, seconds."""
AGREES_DEG: Final = 12.0
AGREES_S: Final = 10.0
"""A doubt ends when the heading has been back to within `AGREES_DEG` for this time, seconds."""


@dataclass(frozen=True, slots=True)
class HeadingFacts:
    """``off``: radians by which the reported heading has gone clockwise of the true one; within the window, or since
    shortly before the doubt. ``doubted_s``: seconds since the heading has been doubted; None while it is not.
    """

    off: float = 0.0
    doubted_s: float | None = None

    @property
    def is_doubted(self) -> bool:
        """True while the heading is doubted."""
        return self.doubted_s is not None

    @property
    def words(self) -> str:
        """One sentence for the operator; empty without a doubt."""
        if not self.is_doubted:
            return ""
        return say(
            "The heading is not what the autopilot reports: the camera sees it {off:.0f}° off.",
            off=abs(math.degrees(self.off)),
        )


class HeadingReading:
    """Takes the camera's steps of a flight, and judges. `reset` on the ground."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the flight."""
        self._turns: deque[tuple[float, float, bool]] = deque()  # time, turn, comes after a gap
        self._last: float | None = None
        self._doubt = Doubt(CONFIRM_S, AGREES_S)
        self._off = 0.0

    def note(self, step: GroundStep) -> None:
        """Take the camera's next step."""
        after_gap = self._last is not None and step.since > self._last
        self._last = step.until
        self._turns.append((step.until, step.turn, after_gap))
        while step.until - self._turns[0][0] > WINDOW_S:
            self._turns.popleft()
        if self._doubt.holds:
            self._off -= step.turn
            if self._doubt.ends(step.until, agrees=abs(self._off) < math.radians(AGREES_DEG)):
                self._turns.clear()
            return
        self._off = -math.fsum(turn for _, turn, _ in self._turns)
        gaps = sum(after_gap for _, _, after_gap in self._turns)
        self._doubt.begins(step.until, is_beyond=abs(self._off) > math.radians(LIMIT_DEG + GAP_DEG * gaps))

    def facts(self, now: float) -> HeadingFacts:
        """Return what is known at ``now``, seconds."""
        return HeadingFacts(self._off, self._doubt.seconds(now))
