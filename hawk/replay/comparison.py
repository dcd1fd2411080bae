"""Two maps of one flight, as GeoJSON of `hawk.results.survey_map.recorded_geojson`: which stalls differ, and how."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from typing import Any, Final, Literal

import numpy as np
import pymap3d
from numpy.typing import NDArray

from hawk.replay.flight import ReplayError

Kind = Literal["lost", "found", "moved", "state", "values"]
"""``lost``: recorded, not there now; ``found``: the reverse; ``moved``: farther than `MOVED_M`; ``state``: of
another state; ``values``: in the same place and state, with another size, probability or number."""
KINDS: Final[tuple[Kind, ...]] = ("lost", "found", "moved", "state", "values")
SAME_M: Final = 1.2
"""Stalls whose middles are no farther apart are the same one: half of a narrow stall's width."""
MOVED_M: Final = 0.3


@dataclass(frozen=True, slots=True)
class Change:
    """A stall that differs. What is recorded and what is made now are features of GeoJSON, None where there is none.

    ``metres``: distance between both, 0 where one of them is missing.
    """

    kind: Kind
    metres: float
    recorded: Mapping[str, Any] | None = field(repr=False)
    now: Mapping[str, Any] | None = field(repr=False)

    @property
    def stall(self) -> Mapping[str, Any]:
        """The recorded stall, or the new one."""
        found = self.recorded if self.recorded is not None else self.now
        assert found is not None  # noqa: S101
        return found


@dataclass(frozen=True, slots=True)
class Comparison:
    """Stalls of both maps, and those that differ; ``earlier`` ones of before the recording were not found again."""

    recorded: int
    now: int
    changes: tuple[Change, ...]
    earlier: int = 0

    def number(self, kind: Kind) -> int:
        """Return how many stalls differ in this respect."""
        return sum(change.kind == kind for change in self.changes)


def compare_maps(recorded: str, now: str, earlier: AbstractSet[int] = frozenset()) -> Comparison:
    """Compare two maps by the places of their stalls: ids may differ.

    ``earlier``: ids of recorded stalls that pictures before the recording showed; they are not lost. A stall has one
    change, the first that holds of lost, found, moved, state, values. Raises ReplayError for text that is no map.
    """
    before, after = _features(recorded), _features(now)
    pairs = _pairs(_middles(before), _middles(after))
    changes: list[Change] = []
    for old, new, metres in pairs:
        kind = _kind(before[old], after[new], metres)
        if kind is not None:
            changes.append(Change(kind, metres, before[old], after[new]))
    lost = [before[k] for k in sorted(set(range(len(before))) - {old for old, _, _ in pairs})]
    found = [after[k] for k in sorted(set(range(len(after))) - {new for _, new, _ in pairs})]
    changes += [Change("lost", 0.0, each, None) for each in lost if each["id"] not in earlier]
    changes += [Change("found", 0.0, None, each) for each in found]
    changes.sort(key=lambda change: (KINDS.index(change.kind), int(change.stall["id"])))
    not_found = sum(each["id"] in earlier for each in lost)
    return Comparison(len(before), len(after), tuple(changes), not_found)


def _kind(old: Mapping[str, Any], new: Mapping[str, Any], metres: float) -> Kind | None:
    if metres > MOVED_M:
        return "moved"
    if old["properties"]["state"] != new["properties"]["state"]:
        return "state"
    return None if old == new else "values"


def _features(text: str) -> list[Mapping[str, Any]]:
    try:
        features = json.loads(text)["features"]
        for each in features:
            int(each["id"]), str(each["properties"]["state"])
            np.asarray(each["geometry"]["coordinates"][0], float).reshape(5, 2)
    except (ValueError, LookupError, TypeError) as error:
        raise ReplayError(f"a recorded map cannot be read: {error!r}") from error
    return list(features)


def middle(feature: Mapping[str, Any]) -> tuple[float, float]:
    """Return latitude and longitude of a stall's middle, degrees."""
    corners = np.asarray(feature["geometry"]["coordinates"][0], float)[:4]
    longitude, latitude = corners.mean(axis=0).tolist()
    return latitude, longitude


def _middles(features: Sequence[Mapping[str, Any]]) -> NDArray[np.float64]:
    """Return the middles (N, 2) in degrees, latitude first."""
    return np.array([middle(each) for each in features], float).reshape(-1, 2)


def _pairs(before: NDArray[np.float64], after: NDArray[np.float64]) -> list[tuple[int, int, float]]:
    """Return pairs of places that are nearest to each other, with their distance, metres."""
    if not len(before) or not len(after):
        return []
    origin = before[0]
    one, two = _metres(before, origin), _metres(after, origin)
    apart = np.hypot(one[:, None, 0] - two[None, :, 0], one[:, None, 1] - two[None, :, 1])
    nearest, nearest_back = apart.argmin(axis=1), apart.argmin(axis=0)
    return [
        (old, int(new), float(apart[old, new]))
        for old, new in enumerate(nearest.tolist())
        if nearest_back[new] == old and apart[old, new] <= SAME_M
    ]


def _metres(places: NDArray[np.float64], origin: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (N, 2) metres north and east of an origin, both in degrees."""
    north, east, _ = pymap3d.geodetic2ned(places[:, 0], places[:, 1], 0.0, origin[0], origin[1], 0.0)
    return np.column_stack((north, east))
