"""Place: whether the reported position moves as the camera sees the drone move over ground.

GNSS that walks takes the estimate with it: position, velocity and variances agree with each other, and all are wrong.
The camera is the second witness. Its motion is compared with the reported one over `WINDOW_S`. A wrong height or a
wrong heading makes the two differ in proportion to the path flown: what such an error can explain is no disagreement.
"""

from __future__ import annotations

import cmath
import math
from collections import deque
from dataclasses import dataclass

from hawk.ddc.stopwatch import Doubt
from hawk.ddc.words import metres
from hawk.model.pictures import GroundStep
from hawk.model.sentences import say

WINDOW_S = 10.0
"""Time over which the two are compared, seconds."""
LIMIT_M = 3.0
"""Disagreement in the window that is a doubt, metres."""
PATH_SHARE = 0.06
"""Share of the path flown in the window that is no disagreement: cars and crowns stand above the ground that the camera
is taken to see, grounds slope, and the picture's time is off by some hundredths of a second."""
GAP_M = 1.5
"""Disagreement that a comparison that is missing may leave, metres: half of a sway of the picture, while the drone
leans over and the picture's time is off by 0.1 s."""
STILL_GAP_M = 0.3
"""The same for a drone that holds: it sways little."""
SWAYS_M = 10.0
"""Metres flown in the window from which on `GAP_M` counts whole."""
CONFIRM_S = 0.5
"""Time for which the disagreement must last, seconds."""
UNPROVEN_SHARE = 0.12
"""The same before the camera was seen to agree: its scale and its heading are known less well."""
MOUNT_SHARE = 0.4
"""A camera that was not seen to agree and is off by a larger share is mounted otherwise: it sees the whole path
wrongly, and is no witness while the drone flies."""
MOUNTED_WRONG_SHARE = 2.0
"""Share of the path that is no disagreement then: none is left."""
PROOF_M = 15.0
"""Metres of flight in which the camera agrees before it is believed while the drone flies."""
PROOF_SHARE = 0.25
"""Largest share of the path by which a camera that agrees is off."""
MEMORY_M = 150.0
"""The share of the path by which the camera is off is learned over about this distance, metres."""
PRIOR_M2 = 40.0
"""Squared metres of path that say that it is not off."""
BRIDGED_S = 5.0
"""A shorter gap between two comparisons is bridged, at the pace of disagreement that was seen, seconds."""
LOST_S = 5.0
"""A camera that has compared nothing for this time follows the drone no more, seconds."""
STILL_SHARE = 0.1
"""A picture that moves less than this share of the path flown stands still: that is the camera's fault."""
AGREES_M = 1.0
"""A disagreement in the window below this is none, metres."""
AGREES_S = 10.0
"""A doubt ends when the two have agreed for this time, seconds, ..."""
BACK_M = 2.0
"""... and the position is back to within this distance, metres, by a camera that followed all the time."""


@dataclass(frozen=True, slots=True)
class PlaceFacts:
    """Comparison of the reported position with the camera. Pairs are metres north and east."""

    camera_age: float = math.inf
    """Seconds since the camera last compared the two."""
    apart: float = 0.0
    """Disagreement in the last `WINDOW_S`, beyond what a wrong height or heading explains, metres."""
    doubted_s: float | None = None
    """Seconds since the position has been doubted; None while it is not."""
    off: tuple[float, float] = (0.0, 0.0)
    """Distance by which the reported position has gone from the true one since shortly before the doubt."""
    is_followed: bool = False
    """The camera has seen the whole path since then, and sees it now: ``off`` is known."""

    @property
    def is_doubted(self) -> bool:
        """True while the position is doubted."""
        return self.doubted_s is not None

    @property
    def off_m(self) -> float:
        """Length of ``off``, metres."""
        return math.hypot(*self.off)

    @property
    def words(self) -> str:
        """One sentence for the operator; empty without a doubt."""
        if not self.is_doubted:
            return ""
        return say(
            "The camera sees the drone move {off} that the position does not show.",
            off=metres(self.off_m),
        )


@dataclass(frozen=True, slots=True)
class _Sum:
    """A step of the window. ``beyond`` is as seen, ``eased`` as seen after what stretch and turn explain."""

    until: float
    seconds: float
    after_gap: bool
    reported: complex
    beyond: complex
    eased: complex


class PlaceReading:
    """Takes the camera's steps of a flight, and judges. `reset` on the ground."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the flight."""
        self._window: deque[_Sum] = deque()
        self._last: float | None = None
        self._warp = 1 + 0j  # what stretch and turn have made of the ground since the window's first step
        self._share, self._weight, self._flown = 0j, 0.0, 0.0  # sums of what is learned about the share
        self._apart = 0.0
        self._doubt = Doubt(CONFIRM_S, AGREES_S)
        self._off = 0j
        self._is_followed = True

    def lose(self) -> None:
        """Follow no more what went before: the reported position leapt."""
        self._window.clear()
        self._apart = 0.0
        self._is_followed = self._is_followed and not self._doubt.holds

    def note(self, step: GroundStep) -> None:
        """Take the next step."""
        gap = 0.0 if self._last is None else step.since - self._last
        if gap < 0.0:
            return
        self._last = step.until
        self._bridge(gap)
        reported, beyond = complex(*step.reported), complex(*step.beyond)
        if not self._window:
            self._warp = 1 + 0j
        self._warp *= cmath.exp(complex(-step.stretch, step.turn))
        eased = complex(*step.seen) * self._warp - reported
        self._window.append(_Sum(step.until, step.until - step.since, gap > 0.0, reported, beyond, eased))
        while step.until - self._window[0].until > WINDOW_S:
            self._learn(self._window.popleft())
        self._judge(step.until, beyond, reported)

    def facts(self, now: float) -> PlaceFacts:
        """Return what is known at ``now``, seconds."""
        age = math.inf if self._last is None else max(0.0, now - self._last)
        return PlaceFacts(
            camera_age=age,
            apart=self._apart,
            doubted_s=self._doubt.seconds(now),
            off=(-self._off.real, -self._off.imag),
            is_followed=self._is_followed and age <= LOST_S,
        )

    def _bridge(self, gap: float) -> None:
        if gap > BRIDGED_S:
            self.lose()
        elif gap > 0.0 and self._doubt.holds and self._window:
            seconds = math.fsum(each.seconds for each in self._window)
            self._off += sum((each.beyond for each in self._window), 0j) / seconds * gap

    def _learn(self, old: _Sum) -> None:
        """Take a step that left the window, unless the position is doubted."""
        if self._doubt.holds:
            return
        path = abs(old.reported)
        keep = math.exp(-path / MEMORY_M)
        self._flown = self._flown * keep + path
        self._share = self._share * keep + old.beyond * old.reported.conjugate()
        self._weight = self._weight * keep + path * path

    def _disagreement(self) -> float:
        """Return the disagreement in the window, metres: the least that an error in proportion leaves."""
        path = sum((each.reported for each in self._window), 0j)
        learned = self._learned()
        known = 0j if learned is None else learned * path
        flown = math.fsum(abs(each.reported) for each in self._window)
        seen = math.fsum(abs(each.reported + each.beyond) for each in self._window)
        if flown > LIMIT_M and seen < STILL_SHARE * flown:
            return 0.0
        raw = abs(sum((each.beyond for each in self._window), 0j) - known)
        eased = abs(sum((each.eased for each in self._window), 0j) - known)
        gaps = sum(each.after_gap for each in self._window)
        return max(0.0, min(raw, eased) - self._allowed(raw, flown) - _hidden(flown) * gaps)

    def _allowed(self, raw: float, flown: float) -> float:
        """Return the disagreement that a path of ``flown`` metres explains, metres; ``raw`` is what was seen."""
        if self._learned() is not None:
            return PATH_SHARE * flown
        return (UNPROVEN_SHARE if raw <= MOUNT_SHARE * flown else MOUNTED_WRONG_SHARE) * flown

    def _learned(self) -> complex | None:
        """Return the share of the path by which the camera is off; None until it was seen to agree."""
        share = self._share / (self._weight + PRIOR_M2)
        return share if self._flown >= PROOF_M and abs(share) <= PROOF_SHARE else None

    def _judge(self, time: float, beyond: complex, reported: complex) -> None:
        self._apart, share = self._disagreement(), self._learned() or 0j
        if not self._doubt.holds:
            if self._doubt.begins(time, is_beyond=self._apart > LIMIT_M):
                self._is_followed = True
                self._off = sum((each.beyond - share * each.reported for each in self._window), 0j)
            return
        self._off += beyond - share * reported
        agrees = self._is_followed and self._apart < AGREES_M and abs(self._off) < BACK_M
        if self._doubt.ends(time, agrees=agrees):
            self._off = 0j


def _hidden(flown: float) -> float:
    """Return the disagreement that one missing comparison may leave, metres."""
    return STILL_GAP_M + (GAP_M - STILL_GAP_M) * min(1.0, flown / SWAYS_M)
