"""Place: whether the reported position moves as the camera sees the drone move over ground.

GNSS that walks takes the estimate with it: position, velocity and variances agree with each other, and all are wrong.
The camera is the second witness. Its motion is compared with the reported one over `WINDOW_S`; what adds up over a
longer time, however slowly, is found by `hawk.ddc.witnesses.walk`. A wrong height or a wrong heading makes the two
differ in proportion to the path flown: what such an error can explain is no disagreement.
"""

from __future__ import annotations

import cmath
import math
from collections import deque
from dataclasses import dataclass

from hawk.ddc.stopwatch import Doubt
from hawk.ddc.witnesses.walk import (
    ALIKE_M,
    MOUNT_SHARE,
    NOTHING,
    STILL_SHARE,
    UNPROVEN_SHARE,
    Odometer,
    Scale,
    SlowWalk,
    mounted_wrong,
)
from hawk.ddc.words import metres
from hawk.model.pictures import GroundAgain, GroundStep
from hawk.model.sentences import say

WINDOW_S = 10.0
"""Time over which the two are compared, seconds."""
LIMIT_M, LIMIT_HEIGHT_M = 2.75, 38.0
"""Disagreement in the window that is a doubt, metres, up to a height over ground; above, it grows with the height, as
what a tilt that is off makes of it does."""
PATH_SHARE = 0.06
"""Share of the path flown in the window that is no disagreement: cars and crowns stand above the ground that the camera
is taken to see, grounds slope, and the picture's time is off by some hundredths of a second."""
GAP_M, LEANS_M_S = 1.2, 3.0
"""Disagreement that a missing comparison may leave while the drone flies, metres: half of a sway of the picture, since
it leans over and the picture's time is off by 0.1 s; no more than the second times its time, m/s."""
STILL_GAP_M = 0.3
"""The same of a drone that holds, and of one that flies besides: it sways little. Such sways do not add up."""
SWAYS_M = 10.0
"""Metres flown in the window from which on `GAP_M` counts whole, and time that was not seen not at all."""
CONFIRM_S = 0.2
"""Time for which the disagreement must last, seconds, ..."""
NEAR_SHARE = 0.75
"""... or this share of the limit the look before, up to `STALLS_HEIGHT_M`: what grows is no single wrong comparison."""
MOST_UNSEEN = 2.0
"""Time that no comparison saw counts at the pace of the rest: the disagreement grows by this factor at most."""
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
STALLS_HEIGHT_M = 40.0
"""Above this height over ground, metres, stalls are some pixels long: one is taken for its neighbour from picture to
picture."""
DENIED_SHARE, DENIED_S = 0.5, 2.0
"""There an earlier picture that shows less than this share of a walk denies it, for this time, seconds."""
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
    """A step of the window, ``gap`` seconds after the one before. ``beyond`` is as seen, ``eased`` as seen after what
    stretch and turn explain.
    """

    until: float
    seconds: float
    gap: float
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
        self._began: float | None = None
        self._last: float | None = None
        self._warp = 1 + 0j  # what stretch and turn have made of the ground since the window's first step
        self._share, self._weight, self._flown = 0j, 0.0, 0.0  # sums of what is learned about the share
        self._apart = 0.0
        self._slow, self._found = SlowWalk(), NOTHING
        self._untrue = (math.inf, -math.inf)  # pictures of that time are compared no more: the report was wrong
        self._doubt = Doubt(CONFIRM_S, AGREES_S)
        self._off = 0j
        self._fixed: tuple[float, complex] | None = None
        self._by_picture: complex | None = None
        self._denied_at = -math.inf
        self._is_followed = True

    def lose(self) -> None:
        """Follow no more what went before: the reported position leapt."""
        self._blind()
        self._slow, self._fixed = SlowWalk(), None
        self._untrue = -math.inf, -math.inf if self._last is None else self._last

    def note(self, step: GroundStep, accuracy: float | None = None) -> None:
        """Take the next step; ``accuracy`` is the receiver's own, metres, None where it gives none."""
        gap = 0.0 if self._last is None else step.since - self._last
        if gap < 0.0:
            return
        if self._began is None:
            self._began = step.since
        self._last = step.until
        self._bridge(gap)
        reported, beyond = complex(*step.reported), complex(*step.beyond)
        if not self._window:
            self._warp, gap = 1 + 0j, 0.0
        self._warp *= cmath.exp(complex(-step.stretch, step.turn))
        eased = complex(*step.seen) * self._warp - reported
        self._window.append(_Sum(step.until, step.until - step.since, gap, reported, beyond, eased))
        while step.until - self._window[0].until > WINDOW_S:
            self._learn(self._window.popleft())
        before, self._apart = self._apart, self._disagreement()
        self._found = self._slow.look(step, self._scale(accuracy), self._counts(step.again))
        self._judge(step, before)

    def _counts(self, again: GroundAgain | None) -> bool:
        """Return True for an earlier picture of this flight that was taken while the report was right."""
        if again is None or self._began is None or again.since < self._began:
            return False
        return not self._untrue[0] <= again.since <= self._untrue[1]

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

    def _blind(self) -> None:
        """Begin the sums again: what happened meanwhile was not seen. A picture of before may show it yet."""
        self._window.clear()
        self._apart = 0.0
        self._slow.forget_steps()
        self._is_followed = self._is_followed and not self._doubt.holds

    def _bridge(self, gap: float) -> None:
        """Let time pass without a comparison: what it would have seen goes on at the pace that was seen."""
        if gap > BRIDGED_S:
            self._blind()
        elif gap > 0.0 and self._window:
            seconds, share = math.fsum(each.seconds for each in self._window), self._learned() or 0j
            beyond = self._gone(share) / seconds * gap
            moving = _moving(self._path().flown)
            self._slow.bridge(beyond * (1.0 - moving), STILL_GAP_M + _leaning(gap) * moving)
            if self._doubt.holds:
                self._off += beyond

    def _learn(self, old: _Sum) -> None:
        """Take a step that left the window, unless the position is doubted."""
        if self._doubt.holds:
            return
        path = abs(old.reported)
        keep = math.exp(-path / MEMORY_M)
        self._flown = self._flown * keep + path
        self._share = self._share * keep + old.beyond * old.reported.conjugate()
        self._weight = self._weight * keep + path * path

    def _path(self) -> Odometer:
        """Return the path that was flown in the window, also while nothing was compared: at the pace beside the gap."""
        path, pace = Odometer(), 0.0
        for each in self._window:
            before, pace = pace, abs(each.reported) / each.seconds
            path.flown += each.gap * max(before, pace)
            path.move(each.reported)
        return path

    def _disagreement(self) -> float:
        """Return the disagreement in the window, metres: the least that an error in proportion leaves.

        While the drone holds, time that no comparison saw counts at the pace of the rest.
        """
        path = self._path()
        learned = self._learned()
        known = 0j if learned is None else learned * path.place
        flown = math.fsum(abs(each.reported) for each in self._window)
        seen = math.fsum(abs(each.reported + each.beyond) for each in self._window)
        if flown > LIMIT_M and seen < STILL_SHARE * flown:
            return 0.0
        unseen_s = math.fsum(each.gap for each in self._window)
        seconds = math.fsum(each.seconds for each in self._window)
        moving = _moving(path.flown)
        whole = min(1.0 + (1.0 - moving) * unseen_s / seconds, MOST_UNSEEN)
        raw = abs(sum((each.beyond for each in self._window), 0j) - known) * whole
        eased = abs(sum((each.eased for each in self._window), 0j) - known) * whole
        gaps = [each.gap for each in self._window if each.gap > 0.0]
        hidden = STILL_GAP_M * math.sqrt(len(gaps)) + moving * math.fsum(map(_leaning, gaps))
        return max(0.0, min(raw, eased) - self._allowed(raw, path) - hidden)

    def _allowed(self, raw: float, path: Odometer) -> float:
        """Return the disagreement that a path explains, metres; ``raw`` is what was seen."""
        if self._learned() is not None:
            return PATH_SHARE * path.flown
        least = UNPROVEN_SHARE * path.flown
        return least if raw <= MOUNT_SHARE * path.flown else least + mounted_wrong(abs(path.place))

    def _learned(self) -> complex | None:
        """Return the share of the path by which the camera is off; None until it was seen to agree."""
        share = self._share / (self._weight + PRIOR_M2)
        return share if self._flown >= PROOF_M and abs(share) <= PROOF_SHARE else None

    def _scale(self, accuracy: float | None) -> Scale:
        learned = self._learned()
        return Scale(learned or 0j, learned is not None, accuracy)

    def _judge(self, step: GroundStep, before: float) -> None:
        share = self._learned() or 0j
        if not self._doubt.holds:
            limit = LIMIT_M * max(1.0, step.height / LIMIT_HEIGHT_M)
            is_beyond = self._apart > limit or self._found.beyond > 0.0
            is_beyond = is_beyond and not self._is_denied(step, share)
            grows = self._apart > limit and before > NEAR_SHARE * limit and step.height <= STALLS_HEIGHT_M
            if self._doubt.begins(step.until, is_beyond=is_beyond, is_sure=grows or self._slow.is_sure):
                self._begin(step, share)
            return
        self._off += complex(*step.beyond) - share * complex(*step.reported)
        self._fix(step, share)
        agrees = self._is_followed and self._apart < AGREES_M and abs(self._off) < BACK_M
        if self._doubt.ends(step.until, agrees=agrees):
            self._end(step.until)

    def _is_denied(self, step: GroundStep, share: complex) -> bool:
        """Return True while earlier pictures show no walk, from high above."""
        if step.height <= STALLS_HEIGHT_M:
            return False
        if step.again is not None and self._counts(step.again):
            off, since = self._suspected(share)
            if abs(self._slow.off_by(step.again, share, since)) < DENIED_SHARE * abs(off):
                self._denied_at = step.until
        return step.until - self._denied_at <= DENIED_S

    def _suspected(self, share: complex) -> tuple[complex, float]:
        """Return how far the position has gone, and since when: of a slow walk, or since the window began."""
        if self._found.beyond > 0.0:
            return self._found.off, self._found.since
        return self._gone(share), self._window[0].until

    def _gone(self, share: complex) -> complex:
        """Return how far the position has gone in the window, beyond the learned share of the path."""
        return sum((each.beyond - share * each.reported for each in self._window), 0j)

    def _begin(self, step: GroundStep, share: complex) -> None:
        """Begin a doubt: the position has gone since the window began, or since the moment of a slow walk."""
        self._is_followed = True
        self._off, since = self._suspected(share)
        self._untrue = min(since, self._untrue[0]), math.inf
        self._fixed = self._by_picture = None
        self._fix(step, share)

    def _end(self, time: float) -> None:
        """End the doubt. Pictures that were kept while the position was wrong are no witnesses."""
        self._off, self._fixed = 0j, None
        self._slow, self._untrue = SlowWalk(), (self._untrue[0], time)

    def _fix(self, step: GroundStep, share: complex) -> None:
        """Take what an earlier picture says of the error: nothing adds up in it, and it bridges what was not seen."""
        again = step.again
        if again is None:
            return
        seen = complex(*again.beyond) - share * complex(*again.reported)
        if self._counts(again):
            self._take(self._slow.off_by(again, share, self._untrue[0]))
        elif self._fixed is not None and self._fixed[0] == again.since:
            self._take(self._fixed[1] + seen)
        elif self._is_followed:
            self._fixed = again.since, self._off - seen

    def _take(self, off: complex) -> None:
        """Take the error that a picture shows, where the steps or the comparison before it show it too."""
        before, self._by_picture = self._by_picture, off
        if abs(off - self._off) <= BACK_M or (before is not None and abs(off - before) <= ALIKE_M):
            self._off, self._is_followed = off, True


def _moving(flown: float) -> float:
    """Return 0 for a drone that holds in the window, 1 for one that flies."""
    return min(1.0, flown / SWAYS_M)


def _leaning(gap: float) -> float:
    """Return the disagreement that a missing comparison of ``gap`` seconds may leave while the drone flies, metres."""
    return min(GAP_M, LEANS_M_S * gap)
