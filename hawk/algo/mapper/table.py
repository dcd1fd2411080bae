"""The known stalls as one table: a row a stall, so that a frame is fused without a loop over stalls."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision import quads
from hawk.model import Stall, StallState

Floats = NDArray[np.float64]
Rows = NDArray[Any]

STATES = (StallState.UNKNOWN, StallState.FREE, StallState.TAKEN)
"""What the ``state`` column counts."""
UNKNOWN, FREE, TAKEN = range(3)

STALL_DTYPE = np.dtype(
    [
        ("id", "i8"),
        ("north", "f8"),
        ("east", "f8"),
        ("cos2", "f8"),  # of twice the direction: directions are equal modulo pi
        ("sin2", "f8"),
        ("width", "f8"),
        ("length", "f8"),
        ("solidity", "f8"),  # weight of all looks at the geometry
        ("exists", "f8"),  # log-odds of being a stall
        ("taken", "f8"),  # log-odds of being taken
        ("looks", "f8"),  # independent looks
        ("seen", "i8"),  # frames in which it was found
        ("last_seen", "f8"),
        ("born", "f8"),  # metres that the drone had flown when it was first found
        ("state", "i8"),
        ("inferred", "?"),  # from its row, never found by itself
        ("lone", "?"),  # stands in no row
        ("raised", "?"),  # stands off the ground (`hawk.algo.mapper.parallax`)
        ("lean", "f8"),
        ("lean_looks", "f8"),
        ("confirmed", "?"),
        ("version", "i8"),  # of the last change of what is shown
        ("touched", "i8"),  # of the last change of anything
    ]
)


_LATER = ("raised", "lean", "lean_looks")
"""Columns that older journals lack: nothing was known of them."""


def angle_of(rows: Rows) -> Floats:
    """Return directions in [0, pi)."""
    angle = np.arctan2(rows["sin2"], rows["cos2"]) / 2 % np.pi
    return np.where(angle >= np.pi, 0.0, angle)


def corners_of(rows: Rows) -> Floats:
    """Return corners (N, 4, 2) of (north, east)."""
    return quads.corners(rows["north"], rows["east"], angle_of(rows), rows["width"], rows["length"])


def probability(log_odds: Floats) -> Floats:
    """Return the probability of log-odds."""
    return np.asarray(1 / (1 + np.exp(-log_odds)))


def to_stall(row: Any) -> Stall:
    """Return one row as everybody else sees it, rounded to what is worth sending."""
    return Stall(
        id=int(row["id"]),
        north=round(float(row["north"]), 3),
        east=round(float(row["east"]), 3),
        angle=round(float(angle_of(row)), 4),
        width=round(float(row["width"]), 3),
        length=round(float(row["length"]), 3),
        taken=round(float(probability(row["taken"])), 3),
        state=STATES[int(row["state"])],
        score=round(float(probability(row["exists"])), 3),
        seen=int(row["seen"]),
        last_seen=round(float(row["last_seen"]), 3),
        version=int(row["version"]),
    )


def to_bytes(row: Any) -> bytes:
    """Return one row as JSON."""
    return json.dumps(dict(zip(STALL_DTYPE.names or (), row.item(), strict=True))).encode()


def from_bytes(data: bytes) -> Rows:
    """Return the row, shape (1,). Raises ValueError when it is not one."""
    try:
        values = json.loads(data)
        values = dict.fromkeys(_LATER, 0) | values
        row = np.array([tuple(values[name] for name in STALL_DTYPE.names or ())], STALL_DTYPE)
    except (KeyError, TypeError, UnicodeDecodeError) as error:
        raise ValueError(f"not a stall: {error!r}") from error
    if not all(np.isfinite(row[name]).all() for name in STALL_DTYPE.names or ()):
        raise ValueError("not a stall: a number is not finite")
    return row
