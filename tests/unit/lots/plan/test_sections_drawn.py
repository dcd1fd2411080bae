"""Sections of every form as the plan has them: rings, lengths and capacities."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hawk.lots.values import LotInputError
from tests.golden import NamedIds, check_values
from tests.unit.lots.plan.plans import Person

LINE: dict[str, Any] = {"line": [[20.0, 0.0], [20.0, 56.0]], "side": "right", "width": 2.2}
BENT: dict[str, Any] = {"line": [[40.0, 0.0], [40.0, 20.0], [52.0, 31.0]], "side": "left", "width": 2.5}
AREA: dict[str, Any] = {"outline": [[60.0, 3.0], [60.0, 30.0], [64.0, 30.0], [64.0, 3.0]]}
DRAWN: list[dict[str, Any]] = [
    LINE | {"kind": "parallel"}, LINE | {"side": "left", "kind": "across"}, BENT,
    BENT | {"side": "right", "place_m": 6.1},
    AREA, AREA | {"kind": "across"}, AREA | {"kind": "parallel", "capacity": 3, "note": "by  the mill"},
    AREA | {"place_m": 27.0}, AREA | {"place_m": 28.0}, LINE | {"line": [[80, 0], [80, 0.9]]},
    LINE | {"line": [[80, 0], [80, 1.0]]}, LINE | {"line": [[80, 0], [80, 9], [81, 4], [79, 4]]},
    BENT | {"width": 30.0}, {"outline": [[0, 0], [9, 9], [9, 0], [0, 9]]},
    {"outline": [[90.0, 0.0], [94.0, 3.0], [91.0, 30.0]], "kind": "across"},
]  # fmt: skip


@pytest.mark.slow
def test_sections_of_every_form_and_their_changes(tmp_path: Path) -> None:
    ann = Person.at_work(tmp_path / "lots.db", 3)
    plain = NamedIds().plain
    found: list[Any] = []
    for number, each in enumerate(DRAWN):
        try:
            ann.do("draw_section", name=f"S {number}", **each)
        except LotInputError as refused:
            found.append(f"S {number}: {refused.field}: {refused.reason}")
    found.append(plain(ann.plan()["sections"]))
    ids = {each["name"]: each["id"] for each in ann.plan()["sections"]}
    for name, change in (
        ("S 0", {"kind": "across"}), ("S 1", {"capacity": 7}), ("S 6", {"capacity": None}), ("S 6", {"kind": "across"}),
        ("S 4", {"note": "old", "name": "Mill"}), ("S 3", {"kind": ""}), ("S 2", {"name": "S 2"}),
        ("S 5", {"name": "S 1"}),
    ):  # fmt: skip
        try:
            sections = ann.do("change_section", section=ids[name], **change)["sections"]
            found.append(plain([each for each in sections if each["id"] == ids[name]]))
        except LotInputError as refused:
            found.append(f"{refused.field}: {refused.reason}")
    ann.do("remove_section", section=ids["S 0"])
    found.append([each["name"] for each in ann.plan()["sections"]])
    ann.store.close()
    check_values(Path(__file__).parent / "operations" / "sections.json", found, digits=8)
