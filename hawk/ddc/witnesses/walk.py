"""Walk: what the camera has seen the position go wrong by since any earlier moment, however slowly.

Two records of the disagreement are kept: the sum of the camera's steps, and the comparisons with pictures of earlier in
the flight, in which nothing adds up (`hawk.model.pictures.GroundAgain`). Each is compared between now and every earlier
moment of it. What an honest receiver may have wandered in that time is no walk, nor is what a camera that sees a wrong
scale or a wrong heading makes of the path between.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from itertools import pairwise

from hawk.model.pictures import GroundAgain, GroundStep

SIGMA_M = 2.1
"""Standard deviation of an honest receiver's error along each axis, metres: 2.5 m CEP (u-blox NEO-M8's data sheet,
UBX-15031086, static over 24 hours) by 1.177. The GPS SPS Performance Standard (5th edition, 2020) has 8 m for 95 % of
the average place and of all satellites' worst: such a receiver says so by its own accuracy."""
TIME_S = 600.0
"""Correlation time of that error, seconds: half of the 1,100 s of Beard and McLain, Small Unmanned Aircraft (2012),
after Rankin (ION GPS 1994), so that it may wander more within minutes: 2.3 m in ten of them, 1 m in 75 s, each axis."""
SIGMAS = 3.8
"""A wander of more standard deviations is a walk."""
FLOOR_M = 1.5
"""Difference of two comparisons while nothing walks, metres: sways, and pictures 0.1 s late."""
FLOOR_HEIGHT_M = 25.0
"""Height up to which it holds, metres. Above it grows with the height, as what a tilt that is off makes of it does."""
BY_SIGMA = 1.41
"""Horizontal accuracy that a receiver reports (about 68 % of a circle), by the standard deviation of each axis."""
WORST_SIGMA_M = 4.0
"""No receiver is allowed for more, metres: one that walks says anything."""
SAMPLE_S = 2.0
"""Time between the moments of a record, seconds."""
SPARSE = 0.15
"""Of moments that are nearer to each other than this share of their age one is dropped: 50 stand for ten minutes."""
RECORDS = 100
"""Most earlier pictures whose comparisons are kept."""
NET_SHARE, PATH_SHARE = 0.06, 0.03
"""The sum of the steps may be off by these shares of the distance between two moments and of the path between them."""
AGAIN_SHARE = 0.12
"""A comparison may be off by this share of the distance to the earlier picture's place: roofs, wrong heights."""
AGAIN_FLOOR = 1.5
"""Share of `floor` by which a comparison may be off: the drone leaned otherwise in the earlier picture."""
UNPROVEN_SHARE = 0.12
"""Share of the distance before the camera was seen to agree: its scale and its heading are known less well."""
MOUNT_SHARE = 0.4
"""A camera that was not seen to agree and is off by a larger share is mounted otherwise: it sees the whole path
wrongly, and is no witness of it."""
MOUNTED_WRONG_SHARE = 2.0
"""Share of the distance that is no disagreement then: a camera that is turned by half a circle sees twice of it."""
SUCCESSIVE, SUCCESSIVE_S, ALIKE_M = 3, 2.0, 1.0
"""This number of comparisons with earlier pictures, none later than this after the one before, seconds, must show the
same walk within this distance, metres: one alone may be a wrong match."""
MOUNTED_FREE_M = 1.0
"""Of the movement so much counts once only, metres: `FLOOR_M` holds the rest, and a drone that holds hardly moves."""
TILT = 0.05
"""Share of the height by which a picture is off in its mount: it is off otherwise once the drone has turned."""
STILL_SHARE, STILL_M = 0.1, 3.0
"""A picture that stands still while the report says that the drone moves by more than the second is the camera's
fault."""
MOVING_M, MOVING_WITHIN_M = 1.5, 10.0
"""The sum of the steps may be off by the first besides once the drone has flown on by the second, metres: it leans, and
the picture's time is off by 0.1 s."""
SWAY_M = 2.0
"""A drone that leaves its place by less sways, and has flown nowhere, metres."""


def wander(seconds: float, accuracy: float | None = None) -> float:
    """Return the distance that an honest receiver may wander within a time, metres.

    Gauss-Markov: the difference of two errors has a variance of 2 s^2 (1 - exp(-t / T)) along each axis.
    ``accuracy`` is the receiver's own, metres; None where it gives none.
    """
    sigma = min(max(SIGMA_M, (accuracy or 0.0) / BY_SIGMA), WORST_SIGMA_M)
    return SIGMAS * sigma * math.sqrt(2.0 * (1.0 - math.exp(-max(0.0, seconds) / TIME_S)))


def mounted_wrong(moved: float) -> float:
    """Return what a camera that is mounted otherwise may make of a movement, metres."""
    return MOUNTED_WRONG_SHARE * moved - min(moved, MOUNTED_FREE_M)


def floor(height: float) -> float:
    """Return the camera's own error at a height over ground, metres."""
    return FLOOR_M * max(1.0, height / FLOOR_HEIGHT_M)


class Odometer:
    """Adds up the path flown, without sways, metres."""

    def __init__(self) -> None:
        self.place = 0j
        self.flown = 0.0
        self._mark = 0j

    def move(self, moved: complex) -> None:
        """Go on by ``moved``, metres."""
        self.place += moved
        if (left := abs(self.place - self._mark)) >= SWAY_M:
            self.flown += left
            self._mark = self.place


@dataclass(frozen=True, slots=True)
class Scale:
    """``learned``: share of the path by which the camera is known to be off; ``is_proven``: it was seen to agree.

    ``accuracy``: the receiver's own, metres; None where it gives none.
    """

    learned: complex
    is_proven: bool
    accuracy: float | None = None

    def allowed(self, off: float, moved: float, share: float) -> float:
        """Return what an error in proportion may make of a movement (metres) that the camera saw ``off`` by so much."""
        if self.is_proven:
            return share * moved
        if off <= MOUNT_SHARE * moved:
            return UNPROVEN_SHARE * moved
        return mounted_wrong(moved)


@dataclass(frozen=True, slots=True)
class Sample:
    """One moment. ``off`` is the disagreement, ``place`` the reported movement, complex metres.

    ``eased`` is the movement that was seen, after what stretch and turn until then explain (``warp``). ``tilt`` is what
    a picture that is off in its mount is off by on the ground. ``flown`` is the path that the sum of all steps stands
    for, metres, and ``noise`` what missing ones have left in it, square metres. ``height``: over ground, metres.
    """

    time: float
    off: complex
    place: complex
    eased: complex | None = None
    warp: complex = 1 + 0j
    tilt: complex = 0j
    flown: float = 0.0
    noise: float = 0.0
    height: float = 0.0

    def off_since(self, before: Sample) -> complex:
        """Return the disagreement since an earlier moment: the least that stretch and turn leave of it."""
        raw = self.off - before.off
        if self.eased is None or before.eased is None:
            return raw
        eased = (self.eased - before.eased) / before.warp - (self.place - before.place)
        return min(raw, eased, key=abs)


@dataclass(frozen=True, slots=True)
class Found:
    """The largest disagreement ``beyond`` what may be, metres; ``off``: how far the drone went unreported ``since``."""

    beyond: float = -math.inf
    off: complex = 0j
    since: float = math.inf


NOTHING = Found()


class Record:
    """Moments of one kind of comparison, the oldest first."""

    def __init__(self, share: float, *first: Sample, own: float = 1.0) -> None:
        """``share`` of the distance between two moments, and ``own`` of `floor`, may be off where the camera agrees."""
        self._share, self._own = share, own
        self._samples = list(first)

    def look(self, now: Sample, scale: Scale) -> Found:
        """Return what is found between a moment and all earlier ones."""
        return max((self._between(each, now, scale) for each in self._samples), key=_beyond, default=NOTHING)

    def keep(self, now: Sample) -> None:
        """Keep a moment where the last one is old enough."""
        if not self._samples:
            self._samples = [now]
        elif now.time - self._samples[-1].time >= SAMPLE_S:
            self._samples = [*self._thinned(now), now]

    def last(self, before: float) -> tuple[complex, complex]:
        """Return disagreement and place of the last moment that was kept until a time; zeros without one."""
        return next(((each.off, each.place) for each in reversed(self._samples) if each.time <= before), (0j, 0j))

    def _thinned(self, now: Sample) -> list[Sample]:
        """Return the moments before ``now`` without those that lie close together; the first one stays."""
        first, *rest = self._samples
        kept = [first]
        for each, after in pairwise([*rest, now]):
            if after.time - kept[-1].time >= SPARSE * (now.time - after.time):
                kept.append(each)
        return kept

    def _between(self, before: Sample, now: Sample, scale: Scale) -> Found:
        moved, seen = now.place - before.place, now.off_since(before)
        if abs(moved) > STILL_M and abs(moved + seen) < STILL_SHARE * abs(moved):
            return NOTHING
        off = seen - scale.learned * moved
        own = self._own * floor(max(before.height, now.height))
        may_be = scale.allowed(abs(off), abs(moved), self._share) + abs(now.tilt - before.tilt)
        flown, noise = now.flown - before.flown, now.noise - before.noise
        may_be += PATH_SHARE * flown + own * (MOVING_M / FLOOR_M) * min(1.0, flown / MOVING_WITHIN_M) + math.sqrt(noise)
        return Found(abs(off) - may_be - own - wander(now.time - before.time, scale.accuracy), off, before.time)


class SlowWalk:
    """Both records of a flight."""

    @property
    def is_sure(self) -> bool:
        """True while both records show a walk: each confirms the other."""
        return min(self._by_steps.beyond, self._by_pictures.beyond) > 0.0

    def __init__(self) -> None:
        self._pictures: dict[float, Record] = {}
        self._suspected: tuple[float, complex] = (-math.inf, 0j)
        self._successive = 0
        self.forget_steps()

    def forget_steps(self) -> None:
        """Begin the sum of the steps again: what happened meanwhile was not seen. Earlier pictures still count."""
        self._steps, self._odometer = Record(NET_SHARE), Odometer()
        self._off, self._noise = 0j, 0.0
        self._eased, self._warp = 0j, 1 + 0j
        self._by_steps = self._by_pictures = NOTHING

    def bridge(self, off: complex, noise_m: float) -> None:
        """Add what a comparison that is missing would have seen by the pace before it; it may be off by ``noise_m``."""
        self._off += off
        self._eased += off * self._warp
        self._noise += noise_m * noise_m

    def look(self, step: GroundStep, scale: Scale, counts: bool) -> Found:
        """Take the next step; return what the records show. The earlier picture ``counts``, or does not."""
        self._off += complex(*step.beyond)
        self._odometer.move(complex(*step.reported))
        self._warp *= cmath.exp(complex(-step.stretch, step.turn))
        self._eased += complex(*step.seen) * self._warp
        now = Sample(
            step.until,
            self._off,
            self._odometer.place,
            self._eased,
            self._warp,
            flown=self._odometer.flown,
            noise=self._noise,
            height=step.height,
        )
        self._by_steps = self._steps.look(now, scale)
        self._steps.keep(now)
        if step.again is not None and counts:
            self._by_pictures = self._seen_again(step, step.again, scale)
        elif step.until - self._suspected[0] > SUCCESSIVE_S:
            self._by_pictures = NOTHING  # nothing is known by a comparison that is old
        return max(self._by_steps, self._by_pictures, key=_beyond)

    def _seen_again(self, step: GroundStep, again: GroundAgain, scale: Scale) -> Found:
        beyond, reported = complex(*again.beyond), complex(*again.reported)
        tilt = TILT * step.height
        if again.since not in self._pictures:
            self._pictures[again.since] = Record(
                AGAIN_SHARE, Sample(again.since, 0j, 0j, tilt=complex(tilt)), own=AGAIN_FLOOR
            )
            if len(self._pictures) > RECORDS:
                del self._pictures[next(iter(self._pictures))]
        now = Sample(step.until, beyond, reported, tilt=cmath.rect(tilt, again.yawed), height=step.height)
        record = self._pictures[again.since]
        found = record.look(now, scale)
        if found.beyond <= 0.0:
            self._successive = 0
            record.keep(now)
            return found
        return found if self._is_confirmed(found, step.until) else NOTHING

    def _is_confirmed(self, found: Found, now: float) -> bool:
        """Return True for a walk that comparisons in a row show alike."""
        (last, off), self._suspected = self._suspected, (now, found.off)
        is_alike = now - last <= SUCCESSIVE_S and abs(found.off - off) <= ALIKE_M
        self._successive = self._successive + 1 if self._successive and is_alike else 1
        return self._successive >= SUCCESSIVE

    def off_by(self, again: GroundAgain, share: complex, right_until: float) -> complex:
        """Return how far the drone is off by an earlier picture, from what that showed last while the report was right.

        Args:
            again: The comparison with it.
            share: Share of the path by which the camera is off.
            right_until: The last moment at which the report was right, seconds.
        """
        record = self._pictures.get(again.since)
        off, place = (0j, 0j) if record is None else record.last(right_until)
        return complex(*again.beyond) - off - share * (complex(*again.reported) - place)


def _beyond(found: Found) -> float:
    return found.beyond
