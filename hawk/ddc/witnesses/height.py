"""Height: whether the reported height changes as GNSS, the camera and the rangefinder see the drone rise and sink.

The autopilot's height follows its barometer. One that drifts takes height and climb with it, all flags good. Three
witnesses show it: the altitude of GNSS since the ground, the camera, and the ground's height by the rangefinder. The
camera has two readings: the growth of the ground from picture to picture, exact for a minute, and the size of the
stalls, rough but for the whole flight. A slope of the ground changes both, so they are one witness. None is believed
alone: GNSS wanders by metres, ground slopes.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import median

from hawk.ddc.stopwatch import Doubt
from hawk.ddc.words import metres
from hawk.model.pictures import GroundStep, StallSize
from hawk.model.sentences import say

WINDOW_S = 60.0
"""Time over which camera and rangefinder count, seconds: ground slopes, and their errors add up. While the height is
doubted and GNSS says nothing, they count from before the doubt on: an error that stays is not over after this time."""
LIMIT_M = 4.0
"""One witness must be so far off the reported height, metres ..."""
SECOND_M = 2.5
"""... and another one so far, to the same side."""
CONFIRM_S = 1.0
"""Time for which they must be, seconds."""
AGREES_M = 2.0
"""A doubt ends when no witness is farther off than this, metres, ..."""
AGREES_S = 10.0
"""... for this time, seconds."""
SMOOTHING_S = 3.0
"""Time constant of the altitude by GNSS, seconds."""
WORST_ACCURACY_M = 5.0
"""A receiver that gives a worse accuracy of its altitude is no witness, metres."""
SILENT_S = 5.0
"""A witness that is silent for longer is none, seconds."""
SIZE_S = 5.0
"""The size of the stalls is the median of this time, seconds."""
LEAST_SIZES = 3
"""Readings of a size in that time."""
SETTLED_S = 30.0
"""A size counts as usual for this flight after this time, seconds, unless the height is doubted before."""
LEAST_SETTLED = 10
"""Readings of a usual size."""
SIZE_SHARE = 0.15
"""Share of the height that other rows, with narrower or wider stalls, explain: within it the size says nothing."""
NEAR_SHARE = 0.25
"""Share by which the heights of two sizes that are compared may differ: over ground that lies lower than the arm place
stalls seem smaller, and the less so the higher it flies."""
SIZES_KEPT = 2000
"""Settled sizes that are kept: a quarter of an hour."""


@dataclass(frozen=True, slots=True)
class HeightFacts:
    """Metres by which the reported height is above the one by each witness; None where it says nothing."""

    by_gnss: float | None = None
    by_camera: float | None = None
    by_range: float | None = None
    reported: float | None = None
    """Metres above the arm place."""
    doubted_s: float | None = None
    """Seconds since the height has been doubted; None while it is not."""
    last_off: float = 0.0
    """`off` as a witness last said it: it counts while all of them are silent, metres."""
    by_size: float | None = None
    """By the size of the stalls; None where other rows explain it, too."""

    @property
    def said(self) -> tuple[float, ...]:
        """Every reading of a witness that is not silent."""
        readings = (self.by_gnss, self.by_camera, self.by_range, self.by_size)
        return tuple(each for each in readings if each is not None)

    @property
    def votes(self) -> tuple[float, ...]:
        """One reading of each witness: of the camera's two the larger one; the growth where they contradict."""
        growth, size = self.by_camera, self.by_size
        camera = size if growth is None else growth
        if growth is not None and size is not None and growth * size >= 0.0:
            camera = max(growth, size, key=abs)
        return tuple(each for each in (self.by_gnss, camera, self.by_range) if each is not None)

    @property
    def is_doubted(self) -> bool:
        """True while the height is doubted."""
        return self.doubted_s is not None

    @property
    def off(self) -> float:
        """Metres by which the reported height is above the true one while it is doubted: the mean of the witnesses."""
        said = self.said
        if not self.is_doubted:
            return 0.0
        if not said:
            return self.last_off
        side = math.copysign(1.0, math.fsum(said))
        agreeing = [each for each in said if each * side >= SECOND_M] or said
        return math.fsum(agreeing) / len(agreeing)

    @property
    def words(self) -> str:
        """One sentence for the operator; empty without a doubt."""
        if not self.is_doubted:
            return ""
        if self.reported is None:
            return say("The height is not what the autopilot reports: {off} off.", off=metres(abs(self.off)))
        return say(
            "The height is not what the autopilot reports: {reported}, truly about {true}.",
            reported=metres(self.reported),
            true=metres(max(0.0, self.reported - self.off)),
        )


class HeightReading:
    """Takes the witnesses' readings of a flight, and judges. `stand` on the ground."""

    def __init__(self) -> None:
        self._apart: float | None = None  # reported altitude less that of GNSS, smoothed
        self._apart_at = -math.inf
        self._on_ground: float | None = None
        self.reset()

    def reset(self) -> None:
        """Forget the flight."""
        self._sunk: deque[tuple[float, float]] = deque()
        self._ground: deque[tuple[float, float]] = deque()
        self._sizes: deque[StallSize] = deque()
        self._settled: deque[StallSize] = deque(maxlen=SIZES_KEPT)
        self._usual: float | None = None
        self._doubt = Doubt(CONFIRM_S, AGREES_S)
        self._last_off = 0.0

    def stand(self) -> None:
        """Stand on the ground: this is where GNSS and the reported height agree."""
        self._on_ground = self._apart
        self.reset()

    def note(self, step: GroundStep) -> None:
        """Take the camera's next step."""
        self._keep(self._sunk, step.until, step.height * (1.0 - math.exp(-step.stretch)))

    def note_range(self, time: float, ground: float) -> None:
        """Take the ground's height by the rangefinder, metres above the arm place."""
        self._keep(self._ground, time, ground)

    def note_size(self, size: StallSize) -> None:
        """Take the size of the stalls in a picture."""
        self._sizes.append(size)
        while size.time - self._sizes[0].time > SETTLED_S:
            settled = self._sizes.popleft()
            if not self._doubt.holds:
                self._settled.append(settled)
        near = [each.width for each in self._settled if abs(each.height / size.height - 1.0) <= NEAR_SHARE]
        self._usual = median(near) if len(near) >= LEAST_SETTLED else None

    def note_gnss(self, time: float, altitude: float, accuracy: float | None, reported: float) -> None:
        """Take the altitude by GNSS and the reported one of that moment, metres above sea level.

        ``accuracy`` in metres; None: not known.
        """
        if accuracy is not None and accuracy > WORST_ACCURACY_M:
            return
        apart, seconds = reported - altitude, time - self._apart_at
        gain = 1.0 if self._apart is None or seconds > SILENT_S else 1.0 - math.exp(-seconds / SMOOTHING_S)
        self._apart = apart if self._apart is None else self._apart + gain * (apart - self._apart)
        self._apart_at = time
        if self._on_ground is None and not self._doubt.holds:  # a height that is doubted is no beginning
            self._on_ground = self._apart

    def look(self, now: float, reported: float | None) -> HeightFacts:
        """Judge at ``now``, seconds, and return what is known."""
        gnss = self._by_gnss(now)
        begin = WINDOW_S if gnss is not None or not self._doubt.holds else math.inf
        camera, ground, size = self._by_camera(now, begin), self._by_range(now, begin), self._by_size(now)
        seen = HeightFacts(gnss, camera, ground, reported, by_size=size)
        if not self._doubt.holds:
            if self._doubt.begins(now, is_beyond=_contradict(seen.votes)):
                self._leave_out_silent(now)
        elif self._doubt.ends(now, agrees=max(map(abs, seen.said), default=math.inf) < AGREES_M):
            self._sunk.clear()  # what remains would be the return alone, a doubt of its own
            self._ground.clear()
        facts = replace(seen, doubted_s=self._doubt.seconds(now), last_off=self._last_off)
        self._last_off = facts.off
        return facts

    def _leave_out_silent(self, now: float) -> None:
        """Forget the readings of the witnesses that are silent as the doubt begins."""
        for readings in (self._sunk, self._ground):
            if readings and now - readings[-1][0] > SILENT_S:
                readings.clear()

    def _by_gnss(self, now: float) -> float | None:
        if self._apart is None or self._on_ground is None or now - self._apart_at > SILENT_S:
            return None
        return self._apart - self._on_ground

    def _by_camera(self, now: float, begin_s: float) -> float | None:
        sunk = self._counted(self._sunk, now, begin_s)
        return math.fsum(sunk) if sunk else None

    def _by_range(self, now: float, begin_s: float) -> float | None:
        ground = self._counted(self._ground, now, begin_s)
        return ground[-1] - ground[0] if ground else None

    def _by_size(self, now: float) -> float | None:
        """Return how far the height is off by the stalls, which are as many times too large as it is too great."""
        if self._usual is None or not self._sizes or now - self._sizes[-1].time > SILENT_S:
            return None
        newest = self._sizes[-1]
        widths = [each.width for each in self._sizes if newest.time - each.time <= SIZE_S]
        if len(widths) < LEAST_SIZES:
            return None
        off = newest.height * (1.0 - self._usual / median(widths))
        return off if abs(off) > SIZE_SHARE * newest.height else None

    @staticmethod
    def _counted(readings: deque[tuple[float, float]], now: float, begin_s: float) -> list[float]:
        """Return the readings of the last ``begin_s`` seconds before the newest one; none of a silent witness."""
        if not readings or now - readings[-1][0] > SILENT_S:
            return []
        newest = readings[-1][0]
        return [value for time, value in readings if newest - time <= begin_s]

    def _keep(self, readings: deque[tuple[float, float]], time: float, value: float) -> None:
        """Keep a reading. A witness that was silent when the doubt began does not know by how much it is off."""
        if not self._doubt.holds:
            readings.append((time, value))
            while time - readings[0][0] > WINDOW_S:
                readings.popleft()
        elif readings:
            readings.append((time, value))


def _contradict(votes: Sequence[float]) -> bool:
    """Return True when two witnesses contradict the reported height to the same side."""
    for side in (1.0, -1.0):
        beyond = sorted((each * side for each in votes), reverse=True)
        if len(beyond) >= 2 and beyond[0] >= LIMIT_M and beyond[1] >= SECOND_M:
            return True
    return False
