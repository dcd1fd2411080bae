"""Stalls and vehicles of a survey packed as one compressed table by columns: about 25 bytes a stall."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any, Final

from hawk.lots.values import Detection, LotStoreError, VehicleDetection
from hawk.model.lot_map import StallState
from hawk.model.vehicles import VehicleKind

SCALES: Final[Mapping[str, float]] = {
    "north": 100, "east": 100, "angle": 1e4, "width": 100, "length": 100, "taken_probability": 1000, "score": 1000,
    "probability": 1000,
}  # fmt: skip
"""Whole steps of a unit of a column: centimetres, 0.1 mrad, thousandths. Other fractions are tenths."""
_FORMER: Final = {"taken": "taken_probability", "seen": "picture_count", "looked": "looked_at"}
"""Names of columns in the snapshots of stores before version 4 -> their names."""
_COLUMNS: Final = tuple(each.name for each in fields(Detection))
_ADDED: Final = {"known": "", "is_extra": False, "is_blurred": None}
"""Columns that earlier versions lack."""
_OF_VEHICLE: Final = tuple(each.name for each in fields(VehicleDetection))
_DAMAGED_DATA: Final = (zlib.error, ValueError, KeyError, TypeError, AttributeError)


def pack_stalls(stalls: Sequence[Detection]) -> bytes:
    """Return the stalls as a compressed table."""
    return _pack(stalls, _COLUMNS)


def unpack_stalls(data: bytes) -> tuple[Detection, ...]:
    """Return the stalls of `pack_stalls`, rounded to centimetres, 0.1 mrad and thousandths. Raises LotStoreError."""
    try:
        rows = _unpack(data, _COLUMNS, _ADDED)
        return tuple(Detection(**{**row, "state": StallState(row["state"])}) for row in rows)
    except _DAMAGED_DATA as error:
        raise LotStoreError(f"the stalls of a survey cannot be read: {error}") from error


def pack_vehicles(vehicles: Sequence[VehicleDetection] | None) -> bytes | None:
    """Return the vehicles as a compressed table; None for those of a network that knows none."""
    return None if vehicles is None else _pack(vehicles, _OF_VEHICLE)


def unpack_vehicles(data: bytes | None) -> tuple[VehicleDetection, ...] | None:
    """Return the vehicles of `pack_vehicles`, rounded as stalls are. Raises LotStoreError."""
    if data is None:
        return None
    try:
        rows = _unpack(data, _OF_VEHICLE, {})
        return tuple(VehicleDetection(**{**row, "kind": VehicleKind(row["kind"])}) for row in rows)
    except _DAMAGED_DATA as error:
        raise LotStoreError(f"the vehicles of a survey cannot be read: {error}") from error


def _pack(items: Sequence[object], columns: Sequence[str]) -> bytes:
    """Return attributes of items as a compressed table."""
    table: dict[str, list[Any]] = {}
    for name in columns:
        values, scale = [getattr(item, name) for item in items], SCALES.get(name)
        if scale is not None:
            values = [round(value * scale) for value in values]
        table[name] = [round(value, 1) if isinstance(value, float) else value for value in values]
    return zlib.compress(json.dumps(table, allow_nan=False, separators=(",", ":")).encode(), 9)


def _unpack(data: bytes, columns: Sequence[str], missing: Mapping[str, object]) -> list[dict[str, Any]]:
    """Return the rows of `_pack`, rounded. ``missing``: values of columns that earlier versions lack.

    Raises zlib.error, ValueError, KeyError, TypeError, AttributeError for data that are none.
    """
    table = {_FORMER.get(name, name): values for name, values in json.loads(zlib.decompress(data)).items()}
    for name, value in missing.items():
        table.setdefault(name, [value] * len(table["id"]))
    found = [[value / SCALES[n] for value in table[n]] if n in SCALES else table[n] for n in columns]
    return [dict(zip(columns, row, strict=True)) for row in zip(*found, strict=True)]
