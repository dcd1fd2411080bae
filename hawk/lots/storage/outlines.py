"""Outlines of lots and surveys and rings of zones, as columns of the store hold them.

One that is damaged is passed over: readers get ground without corners, and the log names it. A change that would write
over it is refused.
"""

from __future__ import annotations

import json
import logging
import zlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, TypeVar

from hawk.lots.values import LotStoreError
from hawk.model.plans import Outline
from hawk.model.poses import Ring

Rings = Mapping[str, Sequence[Sequence[Sequence[float]]]]
"""An outline as `outline_json` writes it: ``polygons`` and ``holes``, rings of [latitude, longitude], degrees."""
T = TypeVar("T")
NO_RINGS: Final[Rings] = {"polygons": [], "holes": []}
_MOST_DEGREES: Final = 360.0
_MOST_M: Final = 1e6
_LOG = logging.getLogger(__name__)


def outline_json(outline: Outline) -> str:
    """Return an outline as JSON: rings of [latitude, longitude], degrees."""
    rounded = {
        name: [[[round(a, 8), round(b, 8)] for a, b in ring] for ring in rings]
        for name, rings in (("polygons", outline.polygons), ("holes", outline.holes))
    }
    return json.dumps(rounded, allow_nan=False, separators=(",", ":"))


def pack_outline(outline: Outline) -> bytes:
    """Return an outline as compressed JSON."""
    return zlib.compress(outline_json(outline).encode(), 9)


def unpack_outline(data: bytes | None) -> Outline:
    """Return the outline of `pack_outline`; one without polygons for None, and for damaged data."""
    if data is None:
        return Outline()
    return outline_of_rings(_sound(data, lambda: _rings(zlib.decompress(data).decode()), NO_RINGS))


def rings_of(text: str) -> Rings:
    """Return the rings of `outline_json`; none for a damaged text."""
    return _sound(text, lambda: _rings(text), NO_RINGS)


def outline_of(text: str) -> Outline:
    """Return the outline of `outline_json`; one without polygons for a damaged text."""
    return outline_of_rings(rings_of(text))


def outline_to_change(text: str) -> Outline:
    """Return the outline of `outline_json`. Raises LotStoreError for a damaged text: nothing writes over it."""
    found = _sound(text, lambda: _rings(text), None)
    if found is None:
        raise LotStoreError("lot: its outline is damaged on the disk. Restore a backup: hawk-drone restore FILE")
    return outline_of_rings(found)


def outline_of_rings(found: Rings) -> Outline:
    """Return the outline of rings that were read."""
    polygons, holes = (tuple(_ring(ring, _MOST_DEGREES) for ring in found[name]) for name in ("polygons", "holes"))
    return Outline(polygons, holes)


def ring_of(text: str) -> Ring:
    """Return the ring of a zone's column, (north, east) in metres; one without corners for a damaged text."""
    return _sound(text, lambda: _ring(json.loads(text), _MOST_M), ())


def _sound(given: str | bytes, read: Callable[[], T], without: T) -> T:
    """Return what reads as rings, else what stands for none, and say so."""
    try:
        return read()
    except (zlib.error, ValueError, KeyError, TypeError, RecursionError) as error:
        _LOG.warning("an outline in the store of lots is damaged: %.40r: %s", given, error)
        return without


def _rings(text: str) -> Rings:
    """Return the rings of a text, each corner two numbers of degrees. Raises ValueError, KeyError, TypeError."""
    found = json.loads(text)
    for name in NO_RINGS:
        for ring in found[name]:
            _check(ring, _MOST_DEGREES)
    return {name: found[name] for name in NO_RINGS}


def _check(ring: Sequence[Sequence[float]], most: float) -> None:
    if len(ring) < 3:
        raise ValueError("a ring has fewer than three corners")
    for a, b in ring:
        if not (-most <= a <= most and -most <= b <= most):
            raise ValueError("a corner is no place")


def _ring(ring: Any, most: float) -> Ring:
    _check(ring, most)
    return tuple((float(a), float(b)) for a, b in ring)
