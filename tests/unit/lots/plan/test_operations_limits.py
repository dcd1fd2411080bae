"""Limits of every field of an operation, and the words of every refusal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from pydantic import TypeAdapter

from hawk.lots.plan.operations import Operation, operation_of
from hawk.lots.values import LotInputError
from tests.golden import check_values

Json = dict[str, Any]
HERE = Path(__file__).parent / "operations"
STALL: Json = {"do": "add_stall", "north": 1.0, "east": 2.0, "angle": 0.1, "width": 2.5, "length": 5.0}
ROW: Json = {"do": "add_row", "front": [[0.0, 0.0], [0.0, 25.0]], "far": [5.0, 0.0]}
STRIP: Json = {"do": "draw_section", "name": "Kerb", "line": [[0, 0], [0, 9]], "side": "left", "width": 2.0}
AREA: Json = {"do": "draw_section", "name": "Kerb", "outline": [[0, 0], [0, 9], [9, 9]]}
RENUMBER: Json = {"do": "renumber", "row": "A"}
LIMITS = ("minimum", "maximum", "minLength", "maxLength", "minItems", "maxItems", "default")
REFUSED: list[Json] = [
    STALL | {"width": 5.1}, STALL | {"label": " \t "}, STALL | {"label": "x" * 21}, STALL | {"label": "a\u0007"},
    ROW | {"count": 3, "pitch": 2.5}, ROW | {"parallel": True, "lean": 0.1}, ROW | {"lean": 1.14}, ROW | {"far": [5.0]},
    {"do": "remove"}, {"do": "remove", "row": "A", "all": True}, {"do": "remove", "stalls": ["a", "b", "a"]},
    {"do": "remove", "stalls": ["a"], "row": "A"}, {"do": "widen", "row": "A"}, {"do": "shift", "all": True, "by": 1},
    RENUMBER, RENUMBER | {"letter": "B", "labels": ["B 1"]}, RENUMBER | {"labels": ["1", "2", "1"]},
    RENUMBER | {"letter": "B", "first": -1}, {"do": "rename", "row": "A", "to": "N" * 13},
    {"do": "swap", "rows": ["A", "A"]}, {"do": "split", "stall": "a", "parts": 1},
    STRIP | {"side": None}, {key: each for key, each in STRIP.items() if key != "width"}, AREA | {"side": "left"},
    AREA | {"width": 2.0}, STRIP | AREA, {"do": "draw_section", "name": "Kerb"},
    STRIP | {"capacity": 3, "place_m": 5.0}, AREA | {"note": "a\u0000"}, {"do": "fly"}, {}, {"do": 7},
]  # fmt: skip
TAKEN: list[Json] = [
    STALL | {"width": 5.0, "label": f"  {'y' * 17} "}, ROW | {"parallel": True}, ROW | {"lean": 1.13, "pitch": 2.4},
    ROW | {"count": 1000, "double": True}, {"do": "remove", "all": True}, {"do": "remove", "stalls": ["a", "b"]},
    {"do": "widen", "row": "A", "length": 5.0}, {"do": "widen", "row": "A", "width": 2.0}, RENUMBER | {"letter": "B"},
    RENUMBER | {"labels": ["1", "2"]}, {"do": "swap", "rows": ["A", "B"]}, STRIP, AREA, STRIP | {"capacity": 3},
    AREA | {"place_m": 5.0, "note": "  "}, STRIP | {"note": "  by the  mill "},
]  # fmt: skip


def _read(asked: Json) -> Any:
    try:
        return operation_of(asked).model_dump(mode="json")
    except LotInputError as refused:
        return f"{refused.field}: {refused.reason}"


def _limits(part: Any, path: str = "") -> dict[str, Any]:
    """Return the limits and defaults within a JSON schema, by where they stand."""
    if isinstance(part, list):
        part = dict(enumerate(part))
    if not isinstance(part, dict):
        return {}
    found = {f"{path} {name}": part[name] for name in LIMITS if isinstance(part.get(name), int | float | str | bool)}
    return found | {name: value for key, each in part.items() for name, value in _limits(each, f"{path}/{key}").items()}


def test_every_field_has_the_limits_that_are_checked_in() -> None:
    check_values(HERE / "limits.json", _limits(TypeAdapter(Operation).json_schema()["$defs"]), None)


@pytest.mark.parametrize(("name", "asked"), [("refused", REFUSED), ("taken", TAKEN)])
def test_what_is_refused_and_what_is_taken(name: str, asked: list[Json]) -> None:
    found = [_read(each) for each in asked]
    assert all(isinstance(each, str) == (name == "refused") for each in found), found
    check_values(HERE / f"{name}.json", found)
