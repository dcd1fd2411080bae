"""A recording that was processed again, in words for the terminal and as JSON."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from hawk.replay.comparison import KINDS, Change, Comparison, Kind, compare_maps, middle
from hawk.replay.flight import Maker, RecordedFlight

if TYPE_CHECKING:  # vision takes half a second to load
    from hawk.replay.process import Processed


SHOWN_CHANGES: Final = 20
"""Stalls that differ, of which the terminal shows this number; JSON has all."""
_WORDS: Final[dict[Kind, str]] = {
    "lost": "lost",
    "found": "found",
    "moved": "moved",
    "state": "of another state",
    "values": "of other size or probability",
}


@dataclass(frozen=True, slots=True)
class Report:
    """A processed recording, the program of now, and the comparison of the last maps (None: none is recorded)."""

    flight: RecordedFlight
    now: Maker
    processed: Processed = field(repr=False)
    comparison: Comparison | None = field(repr=False)

    @classmethod
    def of(cls, flight: RecordedFlight, now: Maker, processed: Processed) -> Report:
        """Compare the last recorded map with the one that was made again. Raises ReplayError."""
        last = processed.last
        found = None if last is None else compare_maps(last.recorded, last.again, processed.earlier)
        return cls(flight, now, processed, found)

    @property
    def is_equal(self) -> bool:
        """True when every recorded map is equal byte for byte, and every recorded plan."""
        done = self.processed
        return (done.equal, done.planned_equal) == (done.compared, done.planned)

    def text(self) -> str:
        """Return the report for the terminal."""
        done = self.processed
        began = f" of {self.flight.utc}" if self.flight.utc else ""
        times = done.seconds / done.took_s if done.took_s else 0.0
        lines = [
            f"{self.flight.path}: recording{began}",
            f"  recorded by {self.flight.maker}",
            f"  made now by {self.now}",
            f"  {done.frames} pictures of {done.seconds:.0f} s in {done.took_s:.1f} s: {times:.1f} times real time",
            *(f"  {each}" for each in self._doubts()),
            *(f"  {each}" for each in self._maps()),
            *([f"  plans: {done.planned_equal} of {done.planned} recorded plans are equal"] if done.planned else []),
        ]
        return "\n".join(lines)

    def json(self) -> dict[str, Any]:
        """Return the report as JSON; stalls are features of GeoJSON."""
        done, found = self.processed, self.comparison
        return {
            "recording": str(self.flight.path),
            "recorded_by": _maker(self.flight.maker),
            "made_by": _maker(self.now),
            "is_equal": self.is_equal,
            "damage": self.flight.damage,
            "pictures": done.frames,
            "pictures_missing": done.missing,
            "pictures_failed": done.failed,
            "failure": done.failure,
            "seconds": round(done.seconds, 3),
            "took_s": round(done.took_s, 3),
            "maps_compared": done.compared,
            "maps_equal": done.equal,
            "plans_compared": done.planned,
            "plans_equal": done.planned_equal,
            "compared_at_s": None if done.last is None else round(done.last.at, 3),
            "stalls_before_recording": len(done.earlier),
            "stalls_recorded": None if found is None else found.recorded,
            "stalls_now": len(done.final.stalls) if found is None else found.now,
            "numbers": {kind: 0 if found is None else found.number(kind) for kind in KINDS},
            "changes": [] if found is None else [_change(each) for each in found.changes],
        }

    def _doubts(self) -> list[str]:
        done = self.processed
        lines = []
        if self.flight.damage:
            lines.append(f"processed up to the damage at {done.seconds:.1f} s: {self.flight.damage}")
        if done.missing:
            lines.append(f"pictures missing in the recording: {done.missing}; the map cannot be quite the same")
        if done.failed:
            lines.append(f"pictures that could not be used: {done.failed}; the first: {done.failure}")
        if done.earlier:
            lines.append(f"it began with a map of {len(done.earlier)} stalls, which the recording does not hold")
        return lines

    def _maps(self) -> list[str]:
        done, found = self.processed, self.comparison
        if found is None:
            return [f"stalls: {len(done.final.stalls)} now; the recording holds no map to compare them with"]
        head = f"stalls: {found.recorded} recorded, {found.now} now"
        maps = f"{done.equal} of {done.compared} recorded maps are equal byte for byte"
        if done.equal == done.compared:
            return [f"{head}; {maps}"]
        numbers = [f"{found.number(kind)} {_WORDS[kind]}" for kind in KINDS if found.number(kind)]
        if found.earlier:
            numbers.append(f"{found.earlier} of before not seen again")
        listed = [each for each in found.changes if each.kind != "values"]
        more = len(listed) - SHOWN_CHANGES
        return [
            f"{head}; {maps}",
            *([f"the last map: {', '.join(numbers)}"] if numbers else []),
            *(_row(each) for each in listed[:SHOWN_CHANGES]),
            *([f"and {more} more: --json has all"] if more > 0 else []),
        ]


def _maker(maker: Maker) -> dict[str, str]:
    return {"version": maker.version, "network": maker.network}


def _row(change: Change) -> str:
    latitude, longitude = middle(change.stall)
    states = [each["properties"]["state"] for each in (change.recorded, change.now) if each is not None]
    became = " -> ".join(states if change.kind == "state" else states[:1])
    metres = f"  {change.metres:.2f} m" if change.kind == "moved" else ""
    return f"{change.kind:6} {change.stall['id']:>5}  {latitude:.7f} {longitude:.7f}  {became}{metres}"


def _change(change: Change) -> dict[str, Any]:
    return {
        "kind": change.kind,
        "metres": round(change.metres, 3),
        "recorded": change.recorded,
        "now": change.now,
    }
