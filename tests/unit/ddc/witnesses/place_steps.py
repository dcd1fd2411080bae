"""Steps of a camera over ground, and the place's witness that notes them."""

from __future__ import annotations

from hawk.ddc.witnesses.place import PlaceFacts, PlaceReading
from hawk.model.pictures import GroundAgain, GroundStep

STEP_S = 0.4


class Flight:
    """Steps of a camera, one every 0.4 s. ``now`` is the time of the last one, seconds."""

    def __init__(self) -> None:
        self.reading = PlaceReading()
        self.now = 0.0
        self.height = 25.0

    def fly(
        self,
        seconds: float,
        reported: complex = 0j,
        *,
        walk: complex = 0j,
        camera: complex = 1 + 0j,
        stretch: float = 0.0,
        turn: float = 0.0,
    ) -> PlaceFacts:
        """Fly at ``reported`` m/s, of which ``walk`` is the error's own; ``stretch`` and ``turn`` are by the second.

        The camera sees the true motion times ``camera``.
        """
        for _ in range(round(seconds / STEP_S)):
            seen = camera * (reported - walk) * STEP_S
            path = reported * STEP_S
            self.reading.note(
                GroundStep(
                    self.now,
                    self.now + STEP_S,
                    (seen.real, seen.imag),
                    (path.real, path.imag),
                    stretch * STEP_S,
                    turn * STEP_S,
                    self.height,
                )
            )
            self.now += STEP_S
        return self.facts()

    def facts(self) -> PlaceFacts:
        return self.reading.facts(self.now)

    def doubted_after(self, limit: float, reported: complex = 0j, *, walk: complex = 0j) -> float:
        begun = self.now
        while self.now - begun < limit:
            if self.fly(STEP_S, reported, walk=walk).is_doubted:
                return self.now - begun
        raise AssertionError("no doubt")


def again(now: float, since: float, beyond: complex, reported: complex = 0j, yawed: float = 0.0) -> GroundStep:
    """Return a step that sees nothing itself, and the comparison with the picture at ``since``."""
    seen = GroundAgain(since, (beyond.real, beyond.imag), (reported.real, reported.imag), yawed)
    return GroundStep(now - STEP_S, now, (0.0, 0.0), (0.0, 0.0), 0.0, 0.0, 25.0, seen)


def held(reading: PlaceReading, begin: float, end: float, beyond: complex) -> PlaceFacts:
    """Take steps from one second to another that compare with the picture at 1 s."""
    for k in range(round((end - begin) / STEP_S)):
        reading.note(again(begin + (k + 1) * STEP_S, 1.0, beyond))
    return reading.facts(end)


def step(since: float, until: float, reported: float, beyond: float) -> GroundStep:
    """Return a step of ``reported`` metres north of which the camera saw ``beyond`` more."""
    return GroundStep(since, until, (reported + beyond, 0.0), (reported, 0.0), 0.0, 0.0, 25.0)
