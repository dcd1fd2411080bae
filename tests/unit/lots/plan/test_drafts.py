"""Each operation as the API takes it: the plan before and after, the refusals, and the labels."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hawk.lots.plan.kinds import KINDS
from hawk.lots.plan.operations import NAMES
from hawk.lots.values import LotInputError
from tests.unit.lots.plan.plans import Person

ROOT = Path(__file__).resolve().parents[4]
NOBODY = "0" * 36
ADD: dict[str, Any] = {"do": "add_stall", "north": 20.0, "east": 0.0, "angle": 0.0, "width": 2.5, "length": 5.0}
ROW: dict[str, Any] = {"do": "add_row", "front": [[20.0, 0.0], [20.0, 25.0]], "far": [25.0, 0.0]}
KERB: dict[str, Any] = {
    "do": "draw_section", "name": "Elm Street", "line": [[20.0, 0.0], [20.0, 56.0]], "side": "right", "width": 2.2,
    "kind": "parallel",
}  # fmt: skip
AREA = [[-3.0, 8.0], [-3.0, 14.0], [3.0, 14.0], [3.0, 8.0]]


@pytest.fixture
def ann(tmp_path: Path) -> Iterator[Person]:
    person = Person.at_work(tmp_path / "lots.db")
    yield person
    person.store.close()


@pytest.fixture(scope="module")
def bea(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Person]:
    """Somebody all of whose operations are refused: the plan is as drawn after each."""
    person = Person.at_work(tmp_path_factory.mktemp("refused") / "lots.db")
    yield person
    person.store.close()


def labels(answer: dict[str, Any]) -> list[str]:
    return sorted((each["label"] for each in answer["stalls"]), key=lambda label: (label[0], int(label[2:])))


@pytest.mark.slow
def test_a_stall_beside_a_row_joins_it_with_its_next_number(ann: Person) -> None:
    done = ann.do("add_stall", north=0.0, east=25.0, angle=0.0, width=2.5, length=5.0, kind="disabled")
    (stall,) = done["stalls"]
    assert (stall["label"], stall["kind"], stall["is_confirmed"], done["gone"]) == ("A 11", "disabled", True, [])
    assert ann.stalls()["A 11"] == stall
    assert ann.do(**ADD)["stalls"][0]["label"] == "D 1"


def test_a_stall_may_have_the_owners_label(ann: Person) -> None:
    assert ann.do(**ADD, label="  <b>P 7</b> ")["stalls"][0]["label"] == "<b>P 7</b>"


@pytest.mark.slow
def test_a_row_follows_the_pitch_of_the_lot_and_gets_a_new_letter(ann: Person) -> None:
    assert labels(ann.do(**ROW)) == [f"D {number}" for number in range(1, 11)]
    assert len(ann.do(**{**ROW, "front": [[30, 0], [30, 25]], "far": [35, 0]}, count=8)["stalls"]) == 8
    assert len(ann.do(**{**ROW, "front": [[40, 0], [40, 25]], "far": [45, 0]}, pitch=3.0)["stalls"]) == 8
    assert len(ann.do(**{**ROW, "front": [[50, 0], [50, 25]], "far": [52, 0]}, parallel=True)["stalls"]) == 5
    assert len(ann.do(**{**ROW, "front": [[60, 0], [60, 25]], "far": [65, 0]}, lean=math.pi / 4)["stalls"]) == 7
    double = ann.do(**{**ROW, "front": [[70, 0], [70, 25]], "far": [80, 0]}, double=True)
    assert len({each["label"].split()[0] for each in double["stalls"]}) == 2


def test_a_row_that_goes_on_a_row_continues_its_numbers(ann: Person) -> None:
    more = ann.do("add_row", front=[[-11.5, 26.25], [-11.5, 33.75]], far=[-6.5, 26.0])
    assert labels(more) == ["B 11", "B 12", "B 13"]


@pytest.mark.slow
def test_stalls_are_removed_moved_turned_and_widened_with_their_ids_and_labels(ann: Person) -> None:
    before = ann.stalls()
    assert ann.do("remove", stalls=ann.ids("A 1", "A 3"))["gone"] == [before["A 1"]["id"], before["A 3"]["id"]]
    moved = ann.do("move", row="C", north=-1.0, east=0.5)["stalls"]
    assert {each["label"]: (each["id"], each["north"]) for each in moved} == {
        f"C {n}": (before[f"C {n}"]["id"], -19.0) for n in range(1, 11)
    }
    (turned,) = ann.do("turn", stalls=ann.ids("A 2"), by=math.pi / 2, about="each")["stalls"]
    assert (turned["angle"], turned["east"]) == (pytest.approx(math.pi / 2), 2.5)
    (wide,) = ann.do("widen", stalls=ann.ids("B 1"), width=2.7, length=5.5)["stalls"]
    assert (wide["width"], wide["length"], wide["id"]) == (2.7, 5.5, before["B 1"]["id"])
    kept = {"A 1": None, "A 3": None}
    assert {label: each["id"] for label, each in ann.stalls().items()} == {
        label: each["id"] for label, each in before.items() if label not in kept
    }


def test_a_row_turns_about_its_middle(ann: Person) -> None:
    turned = {each["label"]: each for each in ann.do("turn", row="C", by=0.05)["stalls"]}
    assert turned["C 1"]["north"] > -18.0 > turned["C 10"]["north"]
    assert sum(each["north"] for each in turned.values()) == pytest.approx(-180.0)


@pytest.mark.slow
def test_a_stall_is_split_and_its_first_part_keeps_id_and_label(ann: Person) -> None:
    ann.do("remove", stalls=ann.ids("A 10"))
    ann.do("move", stalls=ann.ids("A 9"), north=0.0, east=1.2)
    (wide,) = ann.do("widen", stalls=ann.ids("A 9"), width=4.8)["stalls"]
    done = {each["label"]: each for each in ann.do("split", stall=wide["id"], parts=2)["stalls"]}
    assert done.keys() == {"A 9", "A 10"}
    assert done["A 9"]["id"] == wide["id"]
    assert [each["width"] for each in done.values()] == [2.4, 2.4]
    assert abs(done["A 9"]["east"] - done["A 10"]["east"]) == pytest.approx(2.4)


@pytest.mark.slow
def test_a_row_is_numbered_with_a_new_letter_or_the_owners_labels(ann: Person) -> None:
    ids = ann.ids(*(f"A {n}" for n in range(1, 11)))
    done = ann.do("renumber", row="A", letter="K", first=101)["stalls"]
    assert {each["id"]: each["label"] for each in done} == {each: f"K {101 + n}" for n, each in enumerate(ids)}
    done = ann.do("renumber", stalls=ids[:2], labels=["Boss", "Boss's guest"])["stalls"]
    assert {each["label"] for each in done} == {"Boss", "Boss's guest"}
    assert ann.do("renumber", stalls=ids[:1], labels=["A 1"])["stalls"][0]["label"] == "A 1"  # its own former one


@pytest.mark.slow
def test_kinds_are_openstreetmaps_values(ann: Person) -> None:
    for kind in KINDS:
        ann.do("set_kind", row="A", kind=kind)
        assert {each["kind"] for label, each in ann.stalls().items() if label[0] == "A"} == {kind}


@pytest.mark.slow
def test_stalls_are_confirmed_by_ids_by_row_and_all(ann: Person) -> None:
    def confirmed() -> int:
        return sum(each["is_confirmed"] for each in ann.stalls().values())

    counts = []
    for asked in ({"stalls": ann.ids("A 1", "B 2")}, {"row": "A"}, {"all": True}):
        ann.do("confirm", **asked)
        counts.append(confirmed())
    assert counts == [2, 11, 30]
    assert ann.do("confirm", all=True)["undo"] == 3  # nothing was left to confirm: no step


@pytest.mark.slow
def test_an_area_without_stalls_ends_those_in_it_until_it_is_taken_away(ann: Person) -> None:
    gone = ann.ids("A 5", "A 6")
    done = ann.do("forbid", outline=AREA, name="Trees & <i>lamps</i>")
    (zone,) = done["zones"]
    assert (sorted(done["gone"]), zone["name"], zone["kind"]) == (sorted(gone), "Trees & <i>lamps</i>", "no_stalls")
    with pytest.raises(LotInputError, match=r'north: the new stall would stand in "Trees & .* without stalls'):
        ann.do(**{**ADD, "north": 0.0, "east": 11.0})
    with pytest.raises(LotInputError, match="stalls: A 1 would stand in"):
        ann.do("move", stalls=ann.ids("A 1"), north=0.0, east=11.0)
    assert ann.do("allow", zone=zone["id"])["zones"] == []
    assert "A 5" not in ann.stalls()
    assert ann.do(**{**ADD, "north": 0.0, "east": 10.0})["stalls"][0]["label"] == "A 5"


def test_a_zone_with_a_name_is_drawn_and_erased_and_changes_no_stall(ann: Person) -> None:
    done = ann.do("draw_zone", outline=AREA, name="Short  stay", kind="delivery")
    (zone,) = done["named_zones"]
    assert (zone["name"], zone["kind"], done["zones"], done["gone"], done["stalls"]) == (
        "Short stay", "delivery", [], [], [],
    )  # fmt: skip
    with pytest.raises(LotInputError, match="name: Short stay is another zone's"):
        ann.do("draw_zone", outline=AREA, name="Short stay")
    assert len(ann.do("draw_zone", outline=AREA, name="Long stay")["named_zones"]) == 2  # zones may overlap
    assert ann.do(**{**ADD, "north": 0.0, "east": 40.0})["named_zones"] != []
    with pytest.raises(LotInputError, match="zone: must be of this plan"):
        ann.do("allow", zone=zone["id"])
    assert [each["name"] for each in ann.do("erase_zone", zone=zone["id"])["named_zones"]] == ["Long stay"]


@pytest.mark.slow
def test_stalls_that_vision_found_on_each_other_may_be_moved_together_and_come_no_nearer(ann: Person) -> None:
    ann.do("remove", stalls=ann.ids("A 2"))
    with ann.store.writing() as connection:
        connection.exec_driver_sql("UPDATE stall SET east = 0.6 WHERE label = 'A 3'")
    assert len(ann.do("move", stalls=ann.ids("A 1", "A 3"), north=30.0, east=0.0)["stalls"]) == 2
    ann.do("move", stalls=ann.ids("A 3"), north=0.0, east=0.3)
    with pytest.raises(LotInputError, match=r"stalls: A 3 would overlap A 1 by 72%: 10% is the most"):
        ann.do("move", stalls=ann.ids("A 3"), north=0.0, east=-0.2)


BAD: list[tuple[Any, str]] = [
    ({}, "do: is missing: write it"),
    ("add", "operation: must be an object with do: add_stall"),
    ({"do": "explode"}, "do: must be 'add_stall', 'add_row'"),
    ({**ADD, "north": math.nan}, "north: must be a finite number"),
    ({**ADD, "north": math.inf}, "north: must be a finite number"),
    ({**ADD, "north": "20"}, "north: must be a number"),
    ({**ADD, "north": True}, "north: must be a number"),
    ({**ADD, "east": 20_001}, "east: must be 20000 or less"),
    ({**ADD, "width": -1}, "width: must be 0.5 or more"),
    ({**ADD, "width": 6.0}, "width: is more than the length"),
    ({**ADD, "length": 25.1}, "length: must be 25 or less"),
    ({**ADD, "kind": "electric"}, "kind: is called charging in OpenStreetMap: write that"),
    ({**ADD, "kind": "<b>"}, "kind: is no kind: write one of disabled, charging"),
    ({**ADD, "label": " "}, "label: is empty or holds characters that cannot be shown"),
    ({**ADD, "label": "a\u202eb"}, "label: is empty or holds characters that cannot be shown"),
    ({**ADD, "label": "x" * 21}, "label: must have 20 or fewer characters"),
    ({**ADD, "colour": "red"}, "colour: is not known here: leave it out"),
    ({**ADD, "north": 0.0}, "north: the new stall would overlap A 1 by 100%: 10% is the most. Move or remove one"),
    ({"do": "add_stall", "north": 20.0}, "east: is missing: write it"),
    ({**ROW, "front": [[0, 0]]}, r"front\[1\]: is missing: write it"),
    ({**ROW, "front": [[0, 0], [0, math.nan]]}, r"front\[1\]\[1\]: must be a finite number"),
    ({**ROW, "front": [[20, 0], [20, 0.2]]}, "front: is 0.20 m long"),
    ({**ROW, "far": [20, 5]}, "far: leaves the stalls no length"),
    ({**ROW, "far": [50, 0]}, "far: makes stalls 30.00 m long"),
    ({**ROW, "count": 0}, "count: must be 1 or more"),
    ({**ROW, "count": 60}, "count: makes stalls 0.42 m wide: write one for 0.5 to 10 m"),
    ({**ROW, "count": 1.5}, "count: must be a whole number"),
    ({**ROW, "count": 501, "double": True}, "count: makes 1002 stalls: write one for 1000 or fewer"),
    ({**ROW, "count": 9, "pitch": 2.5}, "pitch: follows from the count"),
    ({**ROW, "lean": 1.3}, "lean: must be 1.134464014 or less"),
    ({**ROW, "lean": 0.5, "parallel": True}, "lean: must be left out: a parallel row"),
    ({**ROW, "front": [[0, 0], [0, 25]], "far": [5, 0]}, r"front: .* would overlap A \d+ by \d+%"),
    ({"do": "remove"}, "stalls: names no stalls, or twice"),
    ({"do": "remove", "stalls": []}, "stalls: must be a list of 1 or more, not 0"),
    ({"do": "remove", "stalls": [NOBODY]}, r"stalls\[0\]: is no stall of this plan: read the plan again"),
    ({"do": "remove", "stalls": [NOBODY, NOBODY]}, "stalls: names a stall twice"),
    ({"do": "remove", "stalls": [NOBODY], "all": True}, "stalls: names no stalls, or twice"),
    ({"do": "remove", "row": "Z"}, "row: Z has none: the plan has no such stall"),
    ({"do": "remove", "row": "a%"}, "row: a% has none"),
    ({"do": "remove", "row": "x" * 13}, "row: must have 12 or fewer characters"),
    ({"do": "move", "row": "A", "north": 1, "east": -math.inf}, "east: must be a finite number"),
    ({"do": "move", "row": "B", "north": 20_000, "east": 20_000}, "stalls: B 2 would be 20 km off"),
    ({"do": "move", "row": "A", "north": -9, "east": 0}, r"stalls: A 1 would overlap B 1 by 100%"),
    ({"do": "turn", "row": "A", "by": 7}, "by: must be 6.283185307 or less"),
    ({"do": "turn", "row": "A", "by": 1.57, "about": "me"}, "about: must be 'middle' or 'each'"),
    ({"do": "turn", "row": "A", "by": 1.57, "about": "each"}, r"stalls: A \d+ would overlap A \d+ by 5\d%"),
    ({"do": "widen", "row": "A"}, "width: is missing: write a width, a length, or both"),
    ({"do": "widen", "row": "A", "width": 2.9}, r"stalls: A \d+ would overlap A \d+ by 14%"),
    ({"do": "widen", "row": "A", "length": 1.0}, "length: makes a stall wider than long"),
    ({"do": "split", "stall": NOBODY, "parts": 2}, "stall: is no stall of this plan"),
    ({"do": "split", "stall": NOBODY, "parts": 1}, "parts: must be 2 or more"),
    ({"do": "renumber", "row": "A"}, "letter: and labels are both there or both missing"),
    ({"do": "rename", "row": "A"}, "to: is missing: write it"),
    ({"do": "rename", "row": "A", "to": " "}, "to: .*is empty or holds characters that cannot be shown"),
    ({"do": "rename", "row": "Z", "to": "Q"}, "row: Z has none: the plan has no such stall"),
    ({"do": "rename", "all": True, "to": "Q"}, "all: has no order: name the stalls, or a row"),
    ({"do": "reverse", "row": "Z"}, "row: Z has none"),
    ({"do": "reverse", "all": True}, "all: has no order: name the stalls, or a row"),
    ({"do": "shift", "row": "A", "by": -2}, "by: makes A 1 number -1: write -1 or more"),
    ({"do": "shift", "row": "A", "by": 1.5}, "by: must be a whole number"),
    ({"do": "swap", "rows": ["A"]}, r"rows\[1\]: is missing: write it"),
    ({"do": "swap", "rows": ["A", "A"]}, "rows: names a row twice: name two rows"),
    ({"do": "swap", "rows": ["A", "Z"]}, r"rows\[1\]: Z has none"),
    ({"do": "renumber", "row": "A", "labels": ["X", "Y"]}, "labels: are 2 for 10 stalls: write one for each"),
    ({"do": "renumber", "row": "A", "labels": ["X", "X"]}, "labels: holds a label twice"),
    ({"do": "renumber", "all": True, "letter": "Q"}, "all: has no order: name the stalls, or a row"),
    ({"do": "set_kind", "row": "A", "kind": 3}, "kind: must be text"),
    ({"do": "forbid", "outline": [[0, 0], [2, 2]]}, "outline: must be a list of 3 or more, not 2"),
    ({"do": "forbid", "outline": [[0, 0], [2, 2], [2, 0], [0, 2]]}, "outline: crosses or touches itself"),
    ({"do": "forbid", "outline": [[0, 0]] * 101}, "outline: must be a list of 100 or fewer, not 101"),
    ({"do": "forbid", "outline": [[0, 0], [2, 2], [2, math.nan]]}, r"outline\[2\]\[1\]: must be a finite number"),
    ({"do": "forbid", "outline": AREA, "name": "a\0b"}, "name: holds characters that cannot be shown"),
    ({"do": "allow", "zone": NOBODY}, "zone: must be of this plan: read the plan again"),
    ({"do": "draw_zone", "outline": AREA}, "name: is missing: write it"),
    ({"do": "draw_zone", "outline": AREA, "name": " "}, "name: .*is empty or holds characters that cannot be shown"),
    ({"do": "draw_zone", "outline": AREA, "name": "A", "kind": "no_stalls"}, "kind: .*is no kind"),
    ({"do": "draw_zone", "outline": [[0, 0], [2, 2], [2, 0], [0, 2]], "name": "A"}, "outline: crosses or touches"),
    ({"do": "erase_zone", "zone": NOBODY}, "zone: must be of this plan: read the plan again"),
    ({**KERB, "name": " "}, "name: .*is empty or holds characters that cannot be shown"),
    ({**KERB, "outline": AREA}, "line: and outline are both there or both missing"),
    ({"do": "draw_section", "name": "A"}, "line: and outline are both there or both missing"),
    ({**KERB, "side": "north"}, "side: must be 'left' or 'right'"),
    ({**KERB, "side": None}, "side: is missing: a line has a side, left or right"),
    ({**KERB, "width": None}, "width: is missing: a line has a side"),
    ({**KERB, "width": math.nan}, "width: must be a finite number"),
    ({**KERB, "line": [[20, 0], [20, 0.5]]}, "line: is 0.50 m long: place its ends 1 m apart or more"),
    ({**KERB, "line": [[20, 0], [20, 9], [25, 5], [15, 5]]}, "line: crosses itself"),
    ({**KERB, "line": [[20, 0], [20, math.inf]]}, r"line\[1\]\[1\]: must be a finite number"),
    ({**KERB, "capacity": 0}, "capacity: must be 1 or more"),
    ({**KERB, "capacity": 4, "place_m": 6.0}, "place_m: makes the capacity: leave one of both out"),
    ({**KERB, "note": "x" * 201}, "note: must have 200 or fewer characters"),
    ({**KERB, "kind": "diagonal"}, "kind: must be 'parallel', 'across' or"),
    ({"do": "draw_section", "name": "A", "outline": AREA, "side": "left"}, "side: belongs to a line: leave it out"),
    ({"do": "draw_section", "name": "A", "outline": [[0, 0], [2, 2], [2, 0], [0, 2]]}, "outline: crosses or touches"),
    ({"do": "change_section", "section": NOBODY}, "section: must be of this plan: read the plan again"),
    ({"do": "remove_section", "section": NOBODY}, "section: must be of this plan: read the plan again"),
]  # fmt: skip


@pytest.mark.fault(
    "an operation on a plan has NaN, crosses itself or puts stalls on each other",
    "refused with the field and the remedy; nothing is written",
)
@pytest.mark.parametrize(("operation", "refusal"), BAD)
def test_an_operation_that_cannot_be_done_names_field_and_remedy_and_writes_nothing(
    bea: Person, operation: object, refusal: str
) -> None:
    before = bea.plan()
    with pytest.raises(LotInputError) as refused:
        bea.operate(operation)
    assert re.match(refusal, str(refused.value)), str(refused.value)
    assert bea.plan() == before


def test_every_operation_has_a_bad_day_above() -> None:
    assert {each["do"] for each, _ in BAD if isinstance(each, dict) and "do" in each} - {"explode"} == {*NAMES} - {
        "confirm"
    }


def test_the_how_to_names_every_kind_and_the_api_every_operation() -> None:
    how_to, api = (
        (ROOT / "docs" / page).read_text(encoding="utf-8") for page in ("how-to/correct-the-plan.md", "api.md")
    )
    assert {*KINDS} - {""} <= set(re.findall(r"`([a-z_]+)`", how_to))
    headings = re.findall(r"^### (\w+)$", api, re.MULTILINE)
    assert {*NAMES} <= {re.sub(r"\B([A-Z])", r"_\1", heading).lower() for heading in headings}
