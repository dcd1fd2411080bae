"""Sections of features from their properties: those that owners and hawk write, and OpenStreetMap's.

A polygon is a section where its properties say so, a line where they say the side; OpenStreetMap's roads have the tags
``parking:left|right|both`` (https://wiki.openstreetmap.org/wiki/Street_parking). Sections are given, never derived
from vehicles.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, Literal

from hawk.lots.plan.operations import LONGEST_NOTE, MOST_PLACES, STRIP_WIDTHS_M
from hawk.lots.plan.values import SectionKind
from hawk.lots.plan_files.facts import plain_text
from hawk.lots.plan_files.values import Facts, Notes, SectionFacts, Strip
from hawk.lots.values import LONGEST_NAME, free_name

TITLE_KEYS: Final = ("name", "section", "street", "ref", "label")
CAPACITY_KEYS: Final = ("capacity", "places", "spaces", "num_spaces", "bays")
LENGTH_KEYS: Final = ("length_m", "metres", "meters", "length")
WIDTH_KEYS: Final = ("width_m", "width")
KIND_KEYS: Final = ("kind", "orientation")
NOTE_KEYS: Final = ("note", "notes", "remark", "restriction")
_OURS: Final = ("section_id", "capacity_given", "is_capacity_given")
"""Properties that hawk's own files of sections have."""
LAYER: Final = "sections"
"""Name of a layer whose polygons are sections."""
AREA: Final = "parking"
"""OpenStreetMap's ``amenity`` of a car park."""

_KINDS: Final[Mapping[str, SectionKind]] = {
    "parallel": "parallel", "along": "parallel", "longitudinal": "parallel", "inline": "parallel",
    "across": "across", "perpendicular": "across", "orthogonal": "across",
    "diagonal": "across", "angle": "across", "angled": "across",
    "any": "",
}  # fmt: skip
_SLANTED: Final = ("diagonal", "angle", "angled")
SLANTED_M: Final = 3.5
"""Metres of kerb for one vehicle that stands at 45 degrees: 2.5 m, the width of a stall, over sin 45."""
_WIDTHS_M: Final[Mapping[SectionKind, float]] = {"parallel": 2.5, "across": 5.0, "": 2.5}
"""Width of a strip that says none: the width of a stall, or its length."""
_LONGEST_M: Final = 20_000.0
_FALSE: Final = ("false", "no", "0")
_HIDDEN: Final = ("underground", "multi-storey")
"""OpenStreetMap's values of ``parking`` whose places are not seen from above."""

_POSITIONS: Final = ("lane", "yes", "street_side", "on_kerb", "half_on_kerb", "shoulder")
_OUTSIDE: Final = ("street_side", "on_kerb", "shoulder")
"""Positions of parked vehicles beside the carriageway."""
_NONE: Final = ("", "no", "none", "separate")
"""Values of a side without places, or whose places the map draws by themselves."""
_FORBIDDEN: Final = ("no_parking", "no_stopping", "no_standing", "fire_lane")
_LANES: Final = {"on_street": "lane", "lay_by": "street_side", "painted_area_only": "lane"}
"""Values of the former ``parking:lane:SIDE:ORIENTATION`` -> those of ``parking:SIDE``."""
_RULES: Final = ("restriction", "restriction:conditional", "access", "access:conditional", "fee", "maxstay")
DRIVEN_M: Final = (4.75, 3.0)
"""Width between parked vehicles of a road that says none, and of such a one-directional road: an access road's, and the
least of a lane, in Germany's RASt 06 (FGSV, 2006). It is assumed, and the preview says so.
"""

_Side = Literal["left", "right"]
_SIDES: Final[tuple[_Side, _Side]] = ("left", "right")


@dataclass(slots=True)
class Roads:
    """Roads of a file: ``without_width`` counts the sides whose place was assumed, ``titles`` are names in use."""

    without_width: int = 0
    titles: set[str] = field(default_factory=set)


def is_area(facts: Facts, layer: str = "") -> bool:
    """Return whether a polygon with these properties is a section."""
    known = lowered(facts)
    if (amenity := known.get("amenity", "")) != "":
        return amenity == AREA
    if layer.lower() == LAYER or any(key in known for key in _OURS):
        return True
    places = _number(_first(known, CAPACITY_KEYS))
    return (places is not None and places > 1) or _KINDS.get(known.get("kind", "").lower(), "") != ""


def is_line(facts: Facts) -> bool:
    """Return whether the properties of a line are those of a section or of a road with parking."""
    return any(key == "side" or key.startswith(("parking:left", "parking:right", "parking:both", "parking:lane:"))
               for key in map(str.lower, map(str, facts)))  # fmt: skip


def capacity_said(facts: Mapping[str, Any]) -> int | None:
    """Return the number of places that properties say; None where they say none, or one that cannot be."""
    return _places(_first(lowered(facts), CAPACITY_KEYS), "", Notes())


def area_facts(facts: Facts, name: str, notes: Notes) -> SectionFacts | None:
    """Return a section that is an area; None, which is noted, for one that is not seen from above.

    ``name``: where the feature stands in the file.
    """
    known = lowered(facts)
    if known.get(AREA, "") in _HIDDEN:
        notes.add(name, f"{AREA}: is {known[AREA]}, which is not seen from above: leave it out")
        return None
    return replace(_facts(known, name, notes), is_lot=known.get("amenity") == AREA)


def line_facts(facts: Facts, name: str, notes: Notes, roads: Roads) -> list[SectionFacts]:
    """Return the sections beside a line, as one goes along it; none, which is noted, where it says no side."""
    known = lowered(facts)
    if any(key.startswith("parking:") for key in known):
        return _beside_road(known, name, notes, roads)
    side = known.get("side", "").lower()
    if side not in (*_SIDES, "both"):
        said = f"is {side[:20]}" if side else "is missing"
        notes.add(name, f"side: {said}: write left, right or both, as one goes along the line")
        return []
    found = _facts(known, name, notes)
    width = _metres(known, WIDTH_KEYS, name, notes, *STRIP_WIDTHS_M) or _WIDTHS_M[found.kind or ""]
    sides = [each for each in _SIDES if side in (each, "both")]
    if len(sides) > 1 and found.capacity is not None:
        notes.add(name, "capacity: is of both sides together: draw a line for each side, with its own")
        found = replace(found, capacity=None)
    return [
        replace(found, title=_titled(found.title, each) if len(sides) > 1 else found.title, strip=Strip(each, width))
        for each in sides
    ]


def lowered(facts: Mapping[str, Any]) -> dict[str, str]:
    """Return properties as text, by their names in small letters; those that say nothing are left out, but ``note``."""
    texts = {
        str(key).lower(): str(value) if isinstance(value, bool) else plain_text(value) for key, value in facts.items()
    }
    empty = {str(key).lower() for key, value in facts.items() if value == ""}
    return {key: text for key, text in texts.items() if text or (key == "note" and key in empty)}


def _facts(known: Mapping[str, str], name: str, notes: Notes) -> SectionFacts:
    said = _first(known, KIND_KEYS).lower()
    is_ours = any(key in known for key in _OURS)
    kind = _KINDS.get(said, "" if is_ours else None)
    given = next((known[key].lower() for key in _OURS[1:] if key in known), "true")
    return SectionFacts(
        title=_tidy(_first(known, TITLE_KEYS), LONGEST_NAME, "name", name, notes),
        id=known.get("section_id") or known.get("id", ""),
        kind=kind,
        capacity=_places(_first(known, CAPACITY_KEYS), name, notes),
        is_capacity_given=given not in _FALSE,
        metres=_metres(known, LENGTH_KEYS, name, notes, 0.0, _LONGEST_M),
        place_m=SLANTED_M if said in _SLANTED else None,
        note=_note(known, said if said not in _KINDS else "", name, notes),
    )


def _note(known: Mapping[str, str], kind: str, name: str, notes: Notes) -> str | None:
    """Return the words about a section, and the kind that no section has: permit, loading, disabled."""
    access = known.get("access", "")
    disabled = known.get("capacity:disabled", "")
    said = [
        _first(known, NOTE_KEYS),
        kind,
        f"access {access}" if access not in ("", "yes", "public", "permissive") else "",
        f"disabled {disabled}" if disabled not in ("", "no", "0", "none") else "",
    ]
    words = ", ".join(filter(None, said))
    if not words and "note" not in known:
        return None
    return _tidy(words, LONGEST_NOTE, "note", name, notes)


def _beside_road(known: Mapping[str, str], name: str, notes: Notes, roads: Roads) -> list[SectionFacts]:
    """Return the sections on both sides of a road, by its tags ``parking:left|right|both``."""
    found = []
    for side in _SIDES:
        tags = _side_tags(known, side)
        position = tags.get("", "").lower()
        if position in _NONE:
            continue
        if position not in _POSITIONS:
            notes.add(name, f"parking:{side}: {position[:40]} is not known: write one of {', '.join(_POSITIONS)}")
            continue
        if (rule := tags.get("restriction", "")) in _FORBIDDEN:
            notes.add(name, f"parking:{side}:restriction: is {rule}: draw the section, if vehicles are to be counted")
            continue
        where = f"{name} {side}"
        read = _facts({**tags, "name": known.get("name", known.get("ref", ""))}, where, notes)
        rules = [f"{rule} {tags[rule]}" for rule in _RULES if tags.get(rule)]
        words = ", ".join([*rules, *([read.note] if read.note and not rules else [])])
        strip = _strip(known, tags, side, position, read.kind or "", where, notes)
        title = free_name(_titled(read.title, side), roads.titles)  # a street is drawn as several lines
        roads.titles.add(title)
        roads.without_width += "width" not in known
        found.append(replace(read, title=title, note=words[:LONGEST_NOTE] or None, strip=strip))
    return found


def _side_tags(known: Mapping[str, str], side: str) -> dict[str, str]:
    """Return what a road says of a side: "" -> the position, and the other tags by their last parts."""
    tags: dict[str, str] = {}
    for prefix in ("parking:both", f"parking:{side}"):
        tags |= {key[len(prefix) + 1 :]: value for key, value in known.items() if f"{key}:".startswith(f"{prefix}:")}
    if "" in tags:
        return tags
    for of in ("both", side):  # the scheme before 2022
        if (lane := known.get(f"parking:lane:{of}", "").lower()) == "":
            continue
        placed = known.get(f"parking:lane:{of}:{lane}", "lane")
        is_lane = lane in _KINDS
        tags |= {"": _LANES.get(placed, placed), "orientation": lane} if is_lane else {"": lane}
        if lane in _FORBIDDEN:
            tags |= {"": "lane", "restriction": lane}
    return tags


def _strip(
    known: Mapping[str, str], tags: Mapping[str, str], side: _Side, position: str, kind: SectionKind, name: str,
    notes: Notes,
) -> Strip:  # fmt: skip
    """Return where the vehicles of a road's side stand, from its middle line: inside of the kerb, over it, or outside.

    A ``width`` is that from kerb to kerb (https://wiki.openstreetmap.org/wiki/Key:width); without one the vehicles
    stand beside `DRIVEN_M`.
    """
    wide = _metres(tags, ("width",), name, notes, *STRIP_WIDTHS_M) or _WIDTHS_M[kind]
    road = _metres(known, ("width",), name, notes, *STRIP_WIDTHS_M)
    if road is None:
        return Strip(side, wide, DRIVEN_M[known.get("oneway", "no") in ("yes", "-1", "true", "1")] / 2)
    inside = 0.0 if position in _OUTSIDE else wide / 2 if position == "half_on_kerb" else wide
    return Strip(side, wide, max(road / 2 - inside, 0.0))


def _titled(title: str, side: str) -> str:
    return f"{title[: LONGEST_NAME - len(side) - 3]} ({side})" if title else ""


def _tidy(text: str, longest: int, key: str, name: str, notes: Notes) -> str:
    """Return a text with single spaces, "" for one that cannot be shown and cut to its longest, which is noted."""
    found = " ".join(text.split())
    if not found.isprintable():
        notes.add(name, f"{key}: holds characters that cannot be shown: write letters and digits")
        return ""
    if len(found) > longest:
        notes.add(name, f"{key}: has {len(found)} characters, {longest} are the most: shorten it")
    return found[:longest].rstrip()


def _places(text: str, name: str, notes: Notes) -> int | None:
    """Return the number of places that a text says; None for none, and for one that is none, which is noted."""
    if text == "":
        return None
    value = _number(text)
    if value is not None and value.is_integer() and 1 <= value <= MOST_PLACES:
        return int(value)
    notes.add(name, f"capacity: {text[:20]} is no number of places: write a whole number, 1 to {MOST_PLACES}")
    return None


def _metres(
    known: Mapping[str, str], keys: Sequence[str], name: str, notes: Notes, least: float, most: float
) -> float | None:
    """Return the metres that a property says; None for none, and for some that cannot be, which are noted."""
    key = next((key for key in keys if known.get(key)), None)
    if key is None:
        return None
    value = _number(known[key].lower().removesuffix("m"))
    if value is not None and max(least, 1e-3) <= value <= most:
        return value
    notes.add(name, f"{key}: {known[key][:20]} cannot be: write metres, {least:g} to {most:g}")
    return None


def _first(known: Mapping[str, str], keys: Sequence[str]) -> str:
    return next((known[key] for key in keys if known.get(key)), "")


def _number(text: str) -> float | None:
    try:
        value = float(text.strip().replace(",", "."))
    except ValueError:
        return None
    return value if math.isfinite(value) else None
