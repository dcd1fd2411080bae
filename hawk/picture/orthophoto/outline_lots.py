"""Lots of a file of outlines: a lot a feature, with its name, its id, and what else the file says of it."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any, Final, NamedTuple

import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from hawk.formats.area_file import SAME_DEG
from hawk.lots.plan_files.section_facts import capacity_said
from hawk.lots.values import fitting_name
from hawk.picture.values import LotFacts, PictureError, id_of, list_names

_NAMES: Final = ("name", "ref")
"""Properties that name a lot, the best first; OpenStreetMap's ``ref`` is what its sign says."""
_IDS: Final = ("@id", "id", "osm_id", "lot_id")
"""Properties that are a lot's id where the feature has none of its own, the best first."""
_PLACE_DIGITS: Final = 5
"""Of degrees, a metre: a lot without an id is known again by its middle."""
_LONGEST_TAG: Final = 200
_SAME_SHARE: Final = 0.01
"""Share of a lot's area by which a copy of it may differ."""


class OutlineFeature(NamedTuple):
    """Properties and shape of a feature, (longitude, latitude), with its number in the file, from 1.

    ``id``: its own, "" without one. A feature without ground has an empty shape.
    """

    facts: Mapping[str, Any]
    shape: BaseGeometry
    number: int = 0
    id: str = ""


@dataclass(frozen=True, slots=True)
class OutlineLot:
    """A lot of an outline. ``shape``: its ground, one polygon or several, (longitude, latitude), degrees in WGS-84."""

    shape: BaseGeometry = field(repr=False)
    facts: LotFacts


def lots_of(features: Sequence[OutlineFeature]) -> tuple[OutlineLot, ...]:
    """Return features with ground as lots, in the order of their names, whatever theirs in the file.

    Raises PictureError for two with one id, and for a lot that is there twice.
    """
    same: dict[str, list[OutlineFeature]] = defaultdict(list)
    for each in features:
        same[_own_id(each) or _place(each)].append(each)
    for several in same.values():
        if len(several) > 1:
            _refuse_same(several)
    lots = [
        OutlineLot(_ground(each.shape), _facts(each, known if number == 0 else id_of(f"{known} {number}")))
        for known, several in same.items()
        for number, each in enumerate(sorted(several, key=lambda one: -one.shape.area))
    ]
    return tuple(sorted(lots, key=lambda lot: (_order(lot.facts.name), lot.facts.id)))


def _refuse_same(features: Sequence[OutlineFeature]) -> None:
    """Refuse features with one id, and copies of one lot. Others without an id may share name and middle."""
    numbers = list_names([str(each.number) for each in features])
    if named := _own_id(features[0]):
        raise PictureError(f"features {numbers} have one id, {named}: give each its own, or leave them out")
    for one, other in combinations(features, 2):
        apart = _ground(one.shape).symmetric_difference(_ground(other.shape)).area
        if apart < _SAME_SHARE * max(one.shape.area, other.shape.area):
            raise PictureError(f"features {one.number} and {other.number} are the same lot: leave one of them")


def ground_words(feature: OutlineFeature) -> str:
    """Return the note on a feature without ground."""
    name = _name(feature.facts)
    return (
        f"Feature {feature.number}{f' ({name})' if name else ''} has no ground, and is no lot: draw it, or delete it."
    )


def parts_of_shape(shape: BaseGeometry) -> list[BaseGeometry]:
    """Return the shapes of which one consists, those of collections within it too."""
    if not hasattr(shape, "geoms"):
        return [shape]
    return [part for each in shape.geoms for part in parts_of_shape(each)]


def polygons_of(shape: BaseGeometry) -> list[Polygon]:
    """Return the areas of a shape, made valid; none where it has no ground."""
    valid = shape if shape.is_valid else shapely.make_valid(shape)
    return [part for part in parts_of_shape(valid) if isinstance(part, Polygon) and part.area > 0]


def closed(geometry: dict[str, Any]) -> dict[str, Any]:
    """Return a Polygon or MultiPolygon whose rings end at their first corner, as the fence's reader takes them."""

    def close(part: Any, depth: int) -> Any:
        if not isinstance(part, list) or not part or depth > 2:
            return part
        if isinstance(part[0], list) and part[0] and not isinstance(part[0][0], list):
            return [*part[:-1], part[0]] if _is_near(part[0], part[-1]) else [*part, part[0]]
        return [close(each, depth + 1) for each in part]

    return {**geometry, "coordinates": close(geometry.get("coordinates"), 0)}


def _is_near(one: Any, other: Any) -> bool:
    pairs = zip(one[:2], other[:2], strict=True) if isinstance(other, list) and len(other) >= 2 <= len(one) else ()
    apart = [abs(a - b) for a, b in pairs if isinstance(a, int | float) and isinstance(b, int | float)]
    return len(apart) == 2 and max(apart) <= SAME_DEG


def _ground(shape: BaseGeometry) -> BaseGeometry:
    parts = polygons_of(shape)
    return parts[0] if len(parts) == 1 else MultiPolygon(parts)


def _place(feature: OutlineFeature) -> str:
    """Return the id of a lot by its name and place."""
    middle = feature.shape.centroid
    return id_of(f"lot {_name(feature.facts)} {middle.y:.{_PLACE_DIGITS}f} {middle.x:.{_PLACE_DIGITS}f}")


def _facts(feature: OutlineFeature, known: str) -> LotFacts:
    name = _name(feature.facts)
    used = {key for key in feature.facts if key.lower() in (*_IDS, "name")}
    tags = {
        fitting_name(str(key)): text
        for key, value in feature.facts.items()
        if key not in used and (text := _text(value)[:_LONGEST_TAG])
    }
    return LotFacts(
        id=known,
        name=name or f"Lot {feature.number}",
        is_named=bool(name),
        tags=tuple(sorted(tags.items())),
        capacity=capacity_said(feature.facts),
    )


def _name(facts: Mapping[str, Any]) -> str:
    return _first(facts, _NAMES)


def _own_id(feature: OutlineFeature) -> str:
    return fitting_name(feature.id) or _first(feature.facts, _IDS)


def _first(facts: Mapping[str, Any], keys: Sequence[str]) -> str:
    """Return the first of some properties that says something; the case of its name does not matter."""
    by_key = {str(key).lower(): value for key, value in facts.items()}
    return next((text for key in keys if (text := fitting_name(_text(by_key.get(key))))), "")


def _text(value: object) -> str:
    """Return a property as text; "" for lists and what else is no word or number."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return " ".join(str(value).split()) if isinstance(value, str | int | float) else ""


def _order(name: str) -> list[Any]:
    """Return by what names are in order: numbers in them count as numbers."""
    return [int(part) if k % 2 else part.casefold() for k, part in enumerate(re.split(r"([0-9]{1,9})", name))]
