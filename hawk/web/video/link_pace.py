"""The size of the pictures that one viewer's link takes, decided by how long each one takes to arrive.

A picture that takes ten seconds to cross a link is ten seconds old when it arrives, whatever waits behind it. Pictures
have steps: 0 is the whole one, each further step is smaller (`hawk.web.video.small_frames`). A picture that took more
than `SLOW_S` leads to a smaller step, one within `FRESH_S` to a larger one. The two are as far apart as the bytes of
two neighbouring steps, so that a steady link stays where it is. A step that proves too large is tried again after twice
the time.
"""

from __future__ import annotations

import math
from typing import Final

STEPS: Final = 4
"""Steps below the whole picture; the number of the smallest one."""
LEAST_RATIO: Final = 1.5
"""Least ratio of a picture's bytes to those of the next smaller step."""
MOST_RATIO: Final = 3.0
"""Greatest ratio of a picture's bytes to those of the next smaller step, up to 1920 pixels wide."""
SLOW_S: Final = 1.0
"""Real seconds from sending a picture to its arrival, above which smaller ones follow."""
FRESH_S: Final = SLOW_S / MOST_RATIO
"""Real seconds within which pictures arrive before a larger step is tried: the larger one then takes `SLOW_S`."""
HOLD_S: Final = 5.0
"""Real seconds until the step of a slow picture is tried again, unless an acknowledged one shows room for it."""
LONGEST_HOLD_S: Final = 60.0
"""Real seconds until a step that was too large several times is tried again, at most."""
TRIAL_S: Final = 20.0
"""A slow picture within this time after a larger step shows that the step is too large, real seconds."""
_NONE: Final = -1


class LinkPace:
    """The step of one viewer's pictures."""

    def __init__(self, *, is_acknowledged: bool = True) -> None:
        """Begin with the smallest picture, which shows how fast the link is.

        Without acknowledgements by the viewer the first picture is whole: programs that read a stream scale every
        picture to the size of the first. There buffers may swallow a small picture, so that its arrival says little
        about a larger one: steps become larger by one at a time.
        """
        self.step = STEPS if is_acknowledged else 0
        self._is_acknowledged = is_acknowledged
        self._grown_at: float | None = None
        """Time of the last larger step while it is on trial."""
        self._grown_from = STEPS
        self._too_large = _NONE
        self._failed_at = float("-inf")
        self._hold_s = 0.0

    def arrived(self, now: float, seconds: float) -> None:
        """Note that a picture of the present step has arrived.

        Args:
            now: Real seconds.
            seconds: From sending it to its arrival; delay counts as if it were lack of speed.
        """
        if seconds > SLOW_S:
            self._shrink(now, seconds)
            return
        if self._grown_at is not None and now - self._grown_at > TRIAL_S:
            self._grown_at = None
            if self.step <= self._too_large:
                self._too_large, self._hold_s = _NONE, HOLD_S
        if self.step > 0 and seconds <= FRESH_S:
            self._grow(now, seconds)

    def _shrink(self, now: float, seconds: float) -> None:
        on_trial = self._grown_at is not None
        failed_again = on_trial and self.step <= self._too_large
        self._hold_s = min(2 * self._hold_s, LONGEST_HOLD_S) if failed_again else HOLD_S
        self._too_large, self._failed_at, self._grown_at = self.step, now, None
        smaller = math.ceil(math.log(seconds / SLOW_S) / math.log(LEAST_RATIO))
        was_enough = on_trial and seconds <= SLOW_S * MOST_RATIO  # else the link itself became slower
        self.step = min(self.step + max(1, smaller), self._grown_from if was_enough else STEPS)

    def _grow(self, now: float, seconds: float) -> None:
        room = math.floor(math.log(FRESH_S / max(seconds, 1e-6)) / math.log(MOST_RATIO)) if self._is_acknowledged else 0
        step = max(0, self.step - max(1, room))
        if room == 0 and now - self._failed_at < self._hold_s:  # room that an acknowledgement shows is not waited for
            step = max(step, self._too_large + 1)
        if step < self.step:
            self._grown_from, self.step = self.step, step
            self._grown_at = now
