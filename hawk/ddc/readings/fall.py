"""Motors that went off in the air: a disarmed drone has landed only where its landing, or its standing, was seen.

ArduCopter reports "on the ground" for every drone without motors, whatever it does. So the end of a flight is judged by
what was seen before and after: its fall, the phases that the autopilot reported, and its height.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from hawk.ddc.readings.belief import AIR_HEIGHT_M, Belief, Motion
from hawk.ddc.readings.instant import Instant, Reading
from hawk.ddc.readings.topic_interface import POSE_TIMEOUT_S
from hawk.model.operation import Fall
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say
from hawk.model.vehicle import LANDED_TIMEOUT_S, LandedState

RECOVERED_S = 5.0
"""A drone that fell this long ago and was not disarmed since has caught itself, seconds. A drone that lies on its side
is disarmed by ArduCopter's crash check 2 s after it struck the ground."""
SINK_M_S = 2.5
"""A drone that sinks faster may be falling: its place of before is kept. LOITER without a radio sinks at 2.4 m/s."""
UNSEEN_M_S = 1.5
"""A drone that came down faster, on the mean of a time in which it was not seen, did not land: WPNAV_SPEED_DN is
1.5 m/s, and LAND_SPEED .5 m/s near the ground."""
FASTEST_FALL_M_S = 60.0
"""A height that changes faster did not fall: the estimate jumped."""
GRAVITY = 9.81
"""Metres per second squared."""
STOOD_S = 1.5
"""An armed drone that is said to be on the ground for this long has landed, seconds: "armed" is up to 1 s late."""
PHASE_S = 3.0
"""Seconds since LANDING was said for which "on the ground" belongs to a landing."""
SETTLING_S = 5.0
"""The place of a fall follows the drone for this time after "disarmed", seconds."""


@dataclass(frozen=True, slots=True)
class _Sample:
    """A moment of a flying drone: when (clock and UTC, seconds), its height (m above the arm place), its place."""

    time: float
    utc: float
    height: float | None
    place: GlobalPose | None


class FallReading(Reading):
    """Follows a flight to its end, moment by moment."""

    def __init__(self, kept: Fall | None = None) -> None:
        """``kept``: the fall that ended the last flight of an earlier run, as nobody cleared it."""
        self._armed = False
        self._steady: _Sample | None = None
        self._last: _Sample | None = None
        self._fell_at: float | None = None
        self._is_off_said = False
        self._off_at = -math.inf
        self._landing_said = -math.inf
        self._ground_said: float | None = None
        self._has_landed = False
        self._fall = kept

    def update(self, instant: Instant) -> None:
        """Take armed and landed as they are believed and as the autopilot gives them; height, climb and place."""
        belief, place, now, utc = instant.belief, instant.place, instant.now, instant.utc
        armed, motion = belief.vehicle.armed, belief.motion
        if armed and not self._armed:
            self._begin()
        if armed or self._armed:
            self._off_at = now
        if armed:
            self._listen(belief, now)
        if now - self._off_at <= SETTLING_S:
            self._look(belief, _Sample(now, utc, motion.height, place), motion)
            if not armed:
                self._fall = self._end(motion, place, now, utc)
        self._armed = armed

    def facts(self) -> Fall | None:
        """Return the fall that ended the last flight; None while armed, and after a landing."""
        return self._fall

    def _begin(self) -> None:
        self._steady = self._last = self._fell_at = self._ground_said = self._fall = None
        self._landing_said = -math.inf
        self._is_off_said = self._has_landed = False

    def _listen(self, belief: Belief, now: float) -> None:
        """Note the phases of the flight as the autopilot says them."""
        said = belief.ground
        self._is_off_said = not said.armed_said
        landed = said.landed_said if said.landed_age <= LANDED_TIMEOUT_S else LandedState.UNDEFINED
        if landed is LandedState.LANDING:
            self._landing_said = now
        if landed is not LandedState.ON_GROUND:
            self._ground_said, self._has_landed = None, False
            return
        if self._ground_said is None:
            self._ground_said = now
        stood = said.armed_said and now - self._ground_said >= STOOD_S
        if stood or self._ground_said - self._landing_said <= PHASE_S:
            self._has_landed = True

    def _look(self, belief: Belief, sample: _Sample, motion: Motion) -> None:
        """Note whether it falls, and where it was last while it did not."""
        now, last = sample.time, self._last
        if motion.climb is None:
            return
        unseen = 0.0 if last is None else now - last.time
        dropped = _drop(last, sample)
        is_unseen = unseen > POSE_TIMEOUT_S and dropped > AIR_HEIGHT_M
        fell_unseen = is_unseen and UNSEEN_M_S < dropped / unseen <= FASTEST_FALL_M_S
        if motion.is_fall or fell_unseen:
            self._fell_at = now
        elif self._fell_at is not None and now - self._fell_at > RECOVERED_S and not self._is_off_said:
            self._fell_at = None
        if belief.is_airborne and self._fell_at is None and motion.climb >= -SINK_M_S:
            self._steady = replace(sample, height=_apex(motion))
        self._last = sample

    def _end(self, motion: Motion, place: GlobalPose | None, now: float, utc: float) -> Fall | None:
        """Return the fall of a drone that was just disarmed; None after a landing, as far as it was seen by now."""
        if self._fall is None:
            return self._judge(motion, now, utc)
        if place is None:
            return self._fall
        return replace(self._fall, latitude=place.latitude, longitude=place.longitude)

    def _judge(self, motion: Motion, now: float, utc: float) -> Fall | None:
        last = self._last
        if last is None:
            return None  # nothing was seen of this flight
        if now > self._off_at:
            return None if self._fell_at is None else self._fallen(last, utc)
        height = last.height or 0.0
        unseen = now - last.time if motion.height is None else 0.0
        fell = height > AIR_HEIGHT_M and height > UNSEEN_M_S * unseen
        if self._fell_at is None and (self._has_landed or not fell):
            return None
        return self._fallen(last, utc)

    def _fallen(self, last: _Sample, utc: float) -> Fall:
        before, place = self._steady or last, last.place
        return Fall(
            at=utc if self._steady is None else before.utc,
            latitude=None if place is None else place.latitude,
            longitude=None if place is None else place.longitude,
            height=before.height,
        )


def fall_words(fall: Fall) -> str:
    """Return height, place and time of a fall in words, as far as they are known."""
    when = datetime.fromtimestamp(fall.at, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    height, latitude, longitude = fall.height, fall.latitude, fall.longitude
    if latitude is None or longitude is None:
        return when if height is None else say("at {height:.1f} m, {when}", height=height, when=when)
    if height is None:
        return say("near {latitude:.6f}, {longitude:.6f}, {when}", latitude=latitude, longitude=longitude, when=when)
    return say(
        "at {height:.1f} m, near {latitude:.6f}, {longitude:.6f}, {when}",
        height=height,
        latitude=latitude,
        longitude=longitude,
        when=when,
    )


def _apex(motion: Motion) -> float | None:
    """Return the height from which a drone that sinks may have begun to fall: it is seen to fall a moment later."""
    if motion.height is None or motion.climb is None:
        return None
    return motion.height + min(0.0, motion.climb) ** 2 / (2.0 * GRAVITY)


def _drop(before: _Sample | None, after: _Sample) -> float:
    if before is None or before.height is None or after.height is None:
        return 0.0
    return before.height - after.height
