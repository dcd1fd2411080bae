"""A lot in the daemon's store, made and changed over HTTP by somebody without control."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any, Final, Literal, Self

from aiohttp import ClientSession

from hawk.survey.client import LinkLostError

_ROWS_M: Final = (-35.0, -20.0)
_STALLS: Final = 40
_WIDTH_M, _LENGTH_M = 2.5, 5.0
_NEW_ROW_M: Final = 28.0
"""North of the start, the lot lies south of it: no picture of the lot shows it."""
_DEGREE_M: Final = 111_320.0
_WHO: Final = "Operator 2"
_API: Final = "/api/v1/lots"


@dataclass(frozen=True, slots=True)
class StoredLot:
    """Two rows of stalls, 100 m long, about a place."""

    url: str
    id: str
    latitude: float
    longitude: float

    @classmethod
    async def make(cls, url: str, latitude: float, longitude: float) -> Self:
        """Import the plan of a lot. Raises LinkLostError where the daemon refuses it."""
        made = cls(url, "", latitude, longitude)
        shown = await made._post(f"{_API}/import?name=plan.geojson", data=made._plan())
        begun = await made._post(f"{_API}/import/{shown['token']}/take", json={"name": "Known lot"})
        return cls(url, str(begun["lot"]), latitude, longitude)

    async def change(self, what: Literal["plan", "pin", "outline"]) -> None:
        """Add a row 48 m beside the lot, pin the lot 25 m farther north, or split half of its ground off."""
        lot = f"{_API}/{self.id}"
        match what:
            case "plan":
                edit = (await self._post(f"{lot}/edit", json={"who": _WHO}))["edit"]
                front = [[_NEW_ROW_M, -25.0], [_NEW_ROW_M, 25.0]]
                operation = {"do": "add_row", "front": front, "far": [_NEW_ROW_M + _LENGTH_M, 0.0], "count": 20}
                await self._post(f"{lot}/plan", json={"edit": edit, "operation": operation})
            case "pin":
                points = [{"from": self._earth(0.0, 0.0), "to": self._earth(25.0, 0.0)}]
                await self._post(f"{lot}/pin", json={"points": points})
            case "outline":
                half = [self._earth(*corner) for corner in ((-60.0, 0.0), (60.0, 0.0), (60.0, 90.0), (-60.0, 90.0))]
                await self._post(f"{lot}/split", json={"outline": half, "name": "East half"})

    def _plan(self) -> bytes:
        features = []
        for north in _ROWS_M:
            for number in range(_STALLS):
                east = (number - _STALLS / 2) * _WIDTH_M
                ring = [self._earth(north + n, east + e)[::-1] for n, e in _corners()]
                polygon = {"type": "Polygon", "coordinates": [[*ring, ring[0]]]}
                features.append({"type": "Feature", "properties": {}, "geometry": polygon})
        return json.dumps({"type": "FeatureCollection", "features": features}).encode()

    def _earth(self, north: float, east: float) -> list[float]:
        """Return latitude and longitude of a place, metres about the lot's middle."""
        wide = _DEGREE_M * math.cos(math.radians(self.latitude))
        return [self.latitude + north / _DEGREE_M, self.longitude + east / wide]

    async def _post(self, path: str, **content: Any) -> dict[str, Any]:
        async with ClientSession() as session, session.post(f"{self.url.rstrip('/')}{path}", **content) as answer:
            text = await answer.text()
            if answer.status != 200:
                raise LinkLostError(f"{path}: {answer.status} {text[:200]}")
            return dict(json.loads(text))


def _corners() -> tuple[tuple[float, float], ...]:
    return (0.0, 0.0), (0.0, _WIDTH_M), (_LENGTH_M, _WIDTH_M), (_LENGTH_M, 0.0)
