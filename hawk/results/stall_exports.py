"""Stalls as table (CSV) and GeoJSON, for the server and the headless survey."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pymap3d
from numpy.typing import NDArray

from hawk.model.lot_map import Stall
from hawk.model.poses import GlobalPose

CSV_COLUMNS = (
    "id",
    "state",
    "taken_probability",
    "latitude",
    "longitude",
    "north_m",
    "east_m",
    "direction_deg",
    "width_m",
    "length_m",
    "seen",
    "score",
)


def to_global(datum: GlobalPose, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (N, 2) of (north, east) metres in the map as (latitude, longitude) degrees."""
    latitude, longitude, _ = pymap3d.ned2geodetic(points[:, 0], points[:, 1], 0.0, datum.latitude, datum.longitude, 0.0)
    return np.column_stack((latitude, longitude))


def stalls_csv(datum: GlobalPose, stalls: Mapping[int, Stall]) -> str:
    """Return the table of stalls, one line each, in the order of their ids."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(CSV_COLUMNS)
    for key in sorted(stalls):
        writer.writerow(_row(datum, stalls[key]).values())
    return out.getvalue()


def stalls_geojson(datum: GlobalPose, stalls: Mapping[int, Stall]) -> str:
    """Return the stalls as a GeoJSON FeatureCollection (RFC 7946: longitude first, rings closed, counter-clockwise)."""
    features = [_feature(datum, stalls[key]) for key in sorted(stalls)]
    return json.dumps({"type": "FeatureCollection", "features": features}, allow_nan=False)


def _row(datum: GlobalPose, stall: Stall) -> dict[str, object]:
    latitude, longitude = to_global(datum, np.array([[stall.north, stall.east]]))[0]
    return {
        "id": stall.id,
        "state": stall.state.value,
        "taken_probability": f"{stall.taken:.3f}",
        "latitude": f"{latitude:.8f}",
        "longitude": f"{longitude:.8f}",
        "north_m": f"{stall.north:.2f}",
        "east_m": f"{stall.east:.2f}",
        "direction_deg": f"{math.degrees(stall.angle):.1f}",
        "width_m": f"{stall.width:.2f}",
        "length_m": f"{stall.length:.2f}",
        "seen": stall.seen,
        "score": f"{stall.score:.3f}",
    }


def _feature(datum: GlobalPose, stall: Stall) -> dict[str, Any]:
    corners = stall.corners()
    ring = to_global(datum, np.vstack((corners, corners[:1])))
    return {
        "type": "Feature",
        "id": stall.id,
        "geometry": {
            "type": "Polygon",
            "coordinates": [[[round(float(lon), 8), round(float(lat), 8)] for lat, lon in ring]],
        },
        "properties": {
            "id": stall.id,
            "state": stall.state.value,
            "taken_probability": round(stall.taken, 3),
            "width_m": round(stall.width, 2),
            "length_m": round(stall.length, 2),
            "direction_deg": round(math.degrees(stall.angle), 1),
            "seen": stall.seen,
            "score": round(stall.score, 3),
        },
    }
