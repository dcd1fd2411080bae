"""All that previews of drawn files say, and the plans that they leave, to the last decimal that is shown."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.golden import NamedIds, check_values
from tests.unit.lots import whole
from tests.unit.lots.plan_files.files import feature
from tests.unit.lots.plan_import.imports import Importer, drawn, geojson, importer
from tests.unit.lots.plan_import.test_placement import drawing, pins

HERE = Path(__file__).parent / "drawn"
Json = dict[str, Any]


def labelled(features: list[Json], **labels: str) -> list[Json]:
    """Give some of the features, by their numbers, another label."""
    for number, label in labels.items():
        features[int(number[1:])]["properties"] = {"ref": label} if label else {}
    return features


def square(stalls: list[Json]) -> list[Json]:
    """Return stalls in their order on the ground, with one angle for the two that a square stall may have."""
    found = [each | {"angle": round(each["angle"], 3) % round(math.pi, 3)} for each in stalls]
    return sorted(found, key=lambda each: (-each["north"], each["east"]))


def without(features: list[Json], *numbers: int) -> list[Json]:
    return [each for number, each in enumerate(features) if number not in numbers]


@pytest.fixture
def person(tmp_path: Path) -> Importer:
    found = importer(tmp_path)
    found.register = None
    return found


FILES: dict[str, Callable[[], tuple[list[Json], dict[str, str]]]] = {
    "over by 1.2 m": lambda: (drawn(30, east=1.2), {}),
    "over by 1.3 m": lambda: (drawn(30, east=1.3), {}),
    "another pitch": lambda: (drawn(8, a_row=8, pitch=2.9), {}),
    "another pitch, replaced": lambda: (drawn(8, a_row=8, pitch=2.9), {"replace": "1"}),
    "wide stalls": lambda: (drawn(10, pitch=3.8), {}),
    "some are gone": lambda: (without(drawn(30), 3, 17, 29), {"replace": "1"}),
    "a row is gone": lambda: (without(drawn(30), *range(10, 20)), {"replace": "true"}),
    "beside": lambda: (drawn(4, north=12.0, east=3.0), {"replace": "1"}),
    "labels twice": lambda: (labelled(drawn(12), n3="7", n4="7", n5="Gate"), {}),
    "labels twice, renamed": lambda: (labelled(drawn(12), n3="7", n4="7", n5="Gate"), {"rename": "1"}),
    "long labels": lambda: (labelled(drawn(3), n0="P" * 20, n1="P" * 20, n2="P" * 20), {"rename": "1"}),
    "no labels": lambda: (labelled(drawn(14), **{f"n{k}": "" for k in range(14)}), {}),
    "in the works": lambda: (drawn(4, north=25.0), {}),
    "not a stall": lambda: ([*drawn(2), feature([[[5.0, 52.0], [5.1, 52.0], [5.0, 52.0]]])], {}),
}


@pytest.mark.slow
def test_what_previews_say_of_drawn_files(person: Importer) -> None:
    person.do("add_stall", north=30.0, east=0.0, angle=0.0, width=2.5, length=5.0, label="Gate")
    person.do("forbid", outline=[[20, -5], [20, 4], [30, 4], [30, -5]], name="Works")
    person.do("set_kind", stalls=person.ids("A 2"), kind="disabled")
    plain = NamedIds().plain
    plain(person.plan())
    found = {}
    for name, make in FILES.items():
        features, choices = make()
        shown = person.shown(geojson(features), **choices)
        shown |= {key: square(shown[key]) for key in ("begin", "stay", "end")}
        found[name] = {key: each for key, each in plain(shown).items() if key != "datum"}
    check_values(HERE / "previews.json", found)


@pytest.mark.nightly
def test_the_plans_that_imports_leave(person: Importer) -> None:
    person.do("confirm", stalls=person.ids("A 1", "A 2"))
    plain = NamedIds().plain
    found = {"before": plain(person.plan())}
    for name, features, choices in (
        ("labels", labelled(drawn(12, east=0.4), n3="", n4="A 1", n5="A 2"), {"rename": "1"}),
        ("replaced", labelled(without(drawn(20, north=0.3), 2, 3), n0="North 7", n1="A 9"), {"replace": "1"}),
        ("more", drawn(5, a_row=5, north=40.0, pitch=3.1, first=90), {}),
    ):
        person.take(geojson(features), **choices)
        plan = person.plan()
        found[name] = plain({"stalls": square(plan["stalls"]), "layout": plan["layout"], "revision": plan["revision"]})
    check_values(HERE / "plans.json", found, digits=8)


@pytest.mark.nightly
def test_where_plans_are_placed(tmp_path: Path) -> None:
    person = importer(tmp_path)
    placed = {
        "coordinates": person.shown(geojson(drawn(30, north=1.6, east=-1.1))),
        "in doubt": person.shown(geojson(drawn(10, north=60.0))),
    }
    person.register = None
    placed["points"] = person.shown(drawing(0.3), *pins(0.3, stretch=1.015))
    placed["points, turned"] = person.shown(drawing(3.0), *pins(3.0, stretch=0.99))
    found: Json = {name: [shown["placed"], shown["datum"]] for name, shown in placed.items()}
    made = person.begin(geojson(drawn(7, a_row=4, north=5000.0)))
    with person.store.reading() as connection:
        lot = whole.lot(connection, made["lot"])
    found["new lot"] = {key: lot[key] for key in ("name", "datum", "outline", "layouts")} | {
        "stalls": [[each[key] for key in ("label", "north", "east", "width", "length")] for each in lot["stalls"]]
    }
    check_values(HERE / "places.json", NamedIds().plain(found), digits=8)
