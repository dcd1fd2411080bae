"""What the autopilot said of its position and attitude during the last seconds, at any moment in between."""

from __future__ import annotations

import bisect
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

S = TypeVar("S", "EkfPosition", "Attitude")

REACH_S = 0.3
"""A moment farther than this from every sample has no pose."""


@dataclass(frozen=True, slots=True)
class EkfPosition:
    """Position and velocity in EKF-local (NED, metres, m/s) at a moment of our clock."""

    time: float
    x: float
    y: float
    z: float
    vx: float
    vy: float
    vz: float


@dataclass(frozen=True, slots=True)
class Attitude:
    """Roll, pitch, yaw (radians, NED to FRD) at a moment of our clock."""

    time: float
    roll: float
    pitch: float
    yaw: float


def wrap_angle(angle: float) -> float:
    """Return the same direction in [-pi, pi)."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


class PoseBuffer:
    """Samples of the last ``keep_s`` seconds, interpolated; no sample means no answer, never an old one."""

    def __init__(self, keep_s: float = 5.0) -> None:
        self._keep = keep_s
        self._positions: list[EkfPosition] = []
        self._attitudes: list[Attitude] = []

    def add_position(self, sample: EkfPosition) -> None:
        """Take a position; one that is not newer than the last is dropped (a repeated or overtaken datagram)."""
        if not self._positions or sample.time > self._positions[-1].time:
            self._positions.append(sample)
            _forget(self._positions, sample.time - self._keep)

    def add_attitude(self, sample: Attitude) -> None:
        """Take an attitude; one that is not newer than the last is dropped."""
        if not self._attitudes or sample.time > self._attitudes[-1].time:
            self._attitudes.append(sample)
            _forget(self._attitudes, sample.time - self._keep)

    def clear(self) -> None:
        """Forget everything: the frame or the clock behind the samples is another one."""
        self._positions.clear()
        self._attitudes.clear()

    @property
    def latest_position(self) -> EkfPosition | None:
        """The newest position."""
        return self._positions[-1] if self._positions else None

    def position_at(self, time: float) -> EkfPosition | None:
        """Return the position at that moment: between samples linearly, `REACH_S` beyond one by its velocity."""
        before, after = _neighbours(self._positions, time)
        if before is not None and after is not None and after.time - before.time <= 2 * REACH_S:
            share = (time - before.time) / (after.time - before.time)
            return EkfPosition(
                time,
                *(
                    a + (b - a) * share
                    for a, b in (
                        (before.x, after.x),
                        (before.y, after.y),
                        (before.z, after.z),
                        (before.vx, after.vx),
                        (before.vy, after.vy),
                        (before.vz, after.vz),
                    )
                ),
            )
        near = _nearest(before, after, time)
        if near is None:
            return None
        dt = time - near.time
        return EkfPosition(
            time, near.x + near.vx * dt, near.y + near.vy * dt, near.z + near.vz * dt, near.vx, near.vy, near.vz
        )

    def attitude_at(self, time: float) -> Attitude | None:
        """Return the attitude at that moment, every angle the short way; `REACH_S` beyond a sample it is held."""
        before, after = _neighbours(self._attitudes, time)
        if before is not None and after is not None and after.time - before.time <= 2 * REACH_S:
            share = (time - before.time) / (after.time - before.time)
            return Attitude(
                time,
                _between(before.roll, after.roll, share),
                _between(before.pitch, after.pitch, share),
                _between(before.yaw, after.yaw, share),
            )
        near = _nearest(before, after, time)
        return None if near is None else Attitude(time, near.roll, near.pitch, near.yaw)


def _between(first: float, second: float, share: float) -> float:
    return wrap_angle(first + wrap_angle(second - first) * share)


def _neighbours(samples: Sequence[S], time: float) -> tuple[S | None, S | None]:
    index = bisect.bisect_right(samples, time, key=lambda sample: sample.time)
    return (samples[index - 1] if index else None, samples[index] if index < len(samples) else None)


def _nearest(before: S | None, after: S | None, time: float) -> S | None:
    near = [sample for sample in (before, after) if sample is not None and abs(sample.time - time) <= REACH_S]
    return min(near, key=lambda sample: abs(sample.time - time)) if near else None


def _forget(samples: list[S], before: float) -> None:
    index = bisect.bisect_left(samples, before, key=lambda sample: sample.time)
    del samples[:index]
