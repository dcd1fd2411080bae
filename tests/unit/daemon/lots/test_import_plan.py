"""The command ``hawk-drone import-plan``."""

from __future__ import annotations

from pathlib import Path

import pytest

from hawk.cli import main
from hawk.lots.storage.database import Database
from tests.unit.lots import whole
from tests.unit.lots.plan_files.files import degrees, feature
from tests.unit.lots.plan_import.imports import drawn, geojson

pytestmark = pytest.mark.slow  # each file is read by a process of its own


def command(folder: Path, data: bytes, *options: str) -> int:
    file = folder / "plan.geojson"
    file.write_bytes(data)
    return main(["import-plan", str(file), "--store", str(folder / "store"), *options])


def lots(folder: Path) -> dict[str, int]:
    store = Database(folder / "store" / "lots.db")
    try:
        with store.reading() as connection:
            return {each["name"]: each["stalls"] for each in whole.lots(connection)}
    finally:
        store.close()


def test_a_lot_is_made_of_a_plan_and_follows_the_next_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(tmp_path, geojson(drawn(30)), "--new", "North") == 0
    assert "North is made, with 30 stalls: lot " in capsys.readouterr().out
    assert command(tmp_path, geojson(drawn(30)), "--lot", "North") == 0
    assert "nothing is changed: the lot has this plan already" in capsys.readouterr().out
    more = geojson([*drawn(40)[:-1], {"type": "Feature", "geometry": None}])
    assert command(tmp_path, more, "--lot", "North", "--dry-run") == 0
    said = capsys.readouterr().out
    assert "9 begin, 0 stay and change, 30 are so already, 0 end" in said
    assert "left out: features[39]: geometry: is missing" in said
    assert lots(tmp_path) == {"North": 30}
    assert command(tmp_path, more, "--lot", "North") == 0
    assert "the plan is version 2 of the layout, change " in capsys.readouterr().out
    assert lots(tmp_path) == {"North": 39}


def test_a_lot_is_made_of_sections_and_has_them_already(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kerb = feature(degrees([(0.0, 0.0), (0.0, 44.0)]), "LineString", name="Elm", side="right", capacity=8)
    assert command(tmp_path, geojson([kerb]), "--new", "Elm Street") == 0
    said = capsys.readouterr().out
    assert "plan.geojson: 0 stalls and 1 sections (GeoJSON), placed by coordinates" in said
    assert "sections: 1 begin, 0 stay and change, 0 are so already, 0 end" in said
    assert "Elm Street is made, with 0 stalls and 1 sections: lot " in said
    assert command(tmp_path, geojson([kerb]), "--lot", "Elm Street") == 0
    said = capsys.readouterr().out
    assert "sections: 0 begin, 0 stay and change, 1 are so already, 0 end" in said
    assert "stalls:" not in said
    assert "nothing is changed: the lot has this plan already" in said


@pytest.mark.parametrize(
    ("data", "options", "status", "words"),
    [
        (b"%PDF", ("--new", "North"), 2, "plan.geojson: file: is a PDF: export the drawing as DXF"),
        (geojson(drawn(3)), ("--lot", "South"), 2, "LOT: no lot is called 'South'; there are none"),
        (geojson(drawn(3)), ("--new", "North", "--crs", "x"), 2, "--crs: x is no system that is known"),
        (geojson(drawn(3)), ("--new", "North", "--pin", "1,2"), 2, "--pin: must be x,y,latitude,longitude"),
        (geojson(drawn(3)), (), 2, "one of the arguments --lot --new is required"),
        (geojson(drawn(2)) * 1, ("--new", " "), 2, "--new: is empty"),
    ],
)
def test_what_cannot_be_imported_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], data: bytes, options: tuple[str, ...], status: int, words: str
) -> None:
    assert command(tmp_path, data, *options) == status
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
