"""Several outlines of one picture: each is a lot of its own, in files and in the store."""

from __future__ import annotations

import csv
import json
import os
import shutil
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
import shapely
from rasterio.transform import from_origin
from sqlalchemy import select

from hawk.cli import main
from hawk.lots.plan_files.crs import to_wgs_84
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LOT, OBSERVATION, SECTION, SECTION_LOOK, STALL, SURVEY
from hawk.lots.store import lots_file
from tests.drawn_worlds import drawn_world

pytestmark = pytest.mark.slow

SIDE = 700
CORNER = (155_000.0, 463_000.0)
"""Upper left corner of the picture in EPSG:28992; a pixel is 10 cm."""


@pytest.fixture(scope="module")
def picture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Half of a drawn lot as a GeoTIFF."""
    return written(tmp_path_factory.mktemp("picture") / "town.tif")


def written(path: Path, brighter: int = 0) -> Path:
    ground = drawn_world(3).ground[::2, ::2][:SIDE, :SIDE, ::-1]
    pixels = np.clip(ground.astype(np.int16) + brighter, 0, 255).astype(np.uint8)
    with rasterio.open(
        path, "w", driver="GTiff", width=SIDE, height=SIDE, count=3, dtype="uint8", crs="EPSG:28992",
        transform=from_origin(*CORNER, 0.1, 0.1),
    ) as file:  # fmt: skip
        file.write(np.moveaxis(pixels, -1, 0))
    return path


def ground(left: float, top: float, right: float, bottom: float) -> shapely.Polygon:
    """Return a part of the picture on Earth, given in metres from its upper left corner."""
    box = shapely.box(CORNER[0] + left, CORNER[1] - bottom, CORNER[0] + right, CORNER[1] - top)
    return shapely.transform(box, lambda at: to_wgs_84(at, "EPSG:28992")[0])


def feature(shape: shapely.Geometry | None, known: str | None = None, **facts: Any) -> dict[str, Any]:
    made = None if shape is None else json.loads(shapely.to_geojson(shape))
    found = {"type": "Feature", "geometry": made, "properties": {"amenity": "parking", **facts}}
    return found if known is None else {**found, "id": known}


WEST = feature(ground(0, 0, 30, 45), "relation/7", name="Wést", capacity=20, access="customers")
EAST = feature(ground(30, 0, 70, 45), "P-2", name="East")
TWO = feature(shapely.MultiPolygon([ground(0, 45, 20, 70), ground(45, 45, 70, 70)]), ref="=South, both")
MIDDLE = feature(ground(20, 45, 45, 70))
EVERY = (WEST, EAST, TWO, MIDDLE)


def outlines(folder: Path, *features: dict[str, Any]) -> Path:
    path = folder / "lots.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def mapped(picture: Path, out: Path, features: tuple[dict[str, Any], ...], *more: str) -> dict[str, Any]:
    """Map a picture; return the report. The windows of a run by the same folder are not looked at again."""
    out.parent.mkdir(exist_ok=True)
    arguments = ["map", str(picture), "--out", str(out), "--outline", str(outlines(out.parent, *features)), *more]
    assert main([*arguments, *(["--resume"] if out.exists() else [])]) == 0
    report: dict[str, Any] = json.loads((out / "report.json").read_text())
    return report


@pytest.fixture(scope="module")
def counted(picture: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("counted") / "out"
    mapped(picture, out, EVERY)
    return out


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_each_outline_is_a_lot_with_its_name_id_and_tags(counted: Path) -> None:
    lots = {row["lot_name"]: row for row in rows(counted / "lots.csv")}
    assert [*lots] == ["'=South, both", "East", "Lot 4", "Wést"]
    assert (lots["Wést"]["lot_id"], lots["East"]["lot_id"]) == ("relation/7", "P-2")
    assert lots["Wést"]["tags"] == "access=customers; amenity=parking; capacity=20"
    report = json.loads((counted / "report.json").read_text())
    assert [each["lot_id"] for each in report["lots"]] == [row["lot_id"] for row in rows(counted / "lots.csv")]
    assert sum(int(row["stalls"]) for row in lots.values()) == report["stalls"] > 20
    assert sum(int(row["free"]) for row in lots.values()) == report["free"]
    alone, together = report["free_range"], report["free_range_together"]
    assert together[0] <= alone[0] <= report["free"] <= alone[1] <= together[1]
    for row in lots.values():
        if int(row["stalls"]):
            assert int(row["free_least"]) <= int(row["free"]) <= int(row["free_most"])
    assert {*report["least_sure"]} == {row["lot_id"] for row in lots.values() if int(row["stalls"])}
    unsure = [next(float(row["unsure"]) for row in lots.values() if row["lot_id"] == k) for k in report["least_sure"]]
    assert unsure == sorted(unsure, reverse=True)


def test_vehicles_of_each_lot_are_counted_against_the_places_that_its_file_gives(counted: Path) -> None:
    lots = {row["lot_name"]: row for row in rows(counted / "lots.csv")}
    parked = {name: int(row["vehicles"]) for name, row in lots.items()}
    assert sum(parked.values()) > 10
    for name, row in lots.items():
        assert int(row["vehicles_least"]) <= parked[name] <= int(row["vehicles_most"])
        assert abs(parked[name] - int(row["taken"])) <= 0.3 * int(row["stalls"])
    assert (lots["Wést"]["capacity"], lots["East"]["capacity"], lots["East"]["occupancy"]) == ("20", "", "")
    assert float(lots["Wést"]["occupancy"]) == pytest.approx(parked["Wést"] / 20)


def test_a_lot_without_stalls_is_a_count_of_vehicles(
    picture: Path, counted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Half of it lies beside the picture: what was not seen is in the interval."""
    out = tmp_path / "out"
    shutil.copytree(counted, out)
    lane = feature(ground(-10, 0, 10, 20), "lane", name="Lane", places=40)
    report = mapped(picture, out, (lane, EAST))
    by_id = {each["lot_id"]: each for each in report["lots"]}
    found = by_id["lane"]
    assert (found["stalls"], found["vehicles"], found["capacity"]) == (0, 0, 40)
    assert found["vehicles_most"] >= 15
    assert "Lane: 0 stalls, free 0, taken 0, unclear 0, 0 vehicles (" in (said := capsys.readouterr().out)
    assert " for 40 places." in said
    store = tmp_path / "store"
    report = mapped(picture, out, (lane, EAST), "--store", str(store))
    assert next(each for each in report["lots"] if each["lot_id"] == "lane")["stored"] == "the first survey of Lane"
    database = Database(lots_file(store))
    with database.reading() as connection:
        asked = select(SECTION.c.name, SECTION.c.capacity, SECTION_LOOK.c.parked)
        kept = connection.execute(asked.join(SECTION_LOOK, SECTION_LOOK.c.section == SECTION.c.id)).all()
    database.close()
    assert kept == [("Lane", 40, 0)]


def test_a_stall_belongs_to_the_outline_that_holds_its_middle(counted: Path) -> None:
    stalls, lots = rows(counted / "stalls.csv"), json.loads((counted / "lots.geojson").read_text())["features"]
    shapes = {each["id"]: shapely.geometry.shape(each["geometry"]) for each in lots}
    assert len(stalls) == len({row["stall_id"] for row in stalls}) > 20
    for row in stalls:
        at = shapely.Point(float(row["longitude"]), float(row["latitude"]))
        assert shapes[row["lot_id"]].covers(at)
        assert row["stall_id"].startswith(f"{row['lot_id']}/")
    both = next(each for each in lots if each["properties"]["name"] == "=South, both")
    assert len(both["geometry"]["coordinates"]) == 2
    features = json.loads((counted / "stalls.geojson").read_text())["features"]
    assert [each["properties"]["lot_id"] for each in features] == [row["lot_id"] for row in stalls]
    database = sqlite3.connect(counted / "survey.gpkg")
    of_lots = dict(database.execute("SELECT lot_id, COUNT(*) FROM stalls GROUP BY lot_id"))
    assert dict(database.execute("SELECT lot_id, name FROM lots"))["relation/7"] == "Wést"
    database.close()
    assert of_lots == {row["lot_id"]: int(row["stalls"]) for row in rows(counted / "lots.csv") if int(row["stalls"])}


def test_each_lot_has_a_picture_and_all_have_one(counted: Path) -> None:
    pictures = {row["lot_name"]: row["picture"] for row in rows(counted / "lots.csv")}
    assert (pictures["Wést"], pictures["East"]) == ("lots/relation-7.png", "lots/P-2.png")
    assert {counted / each for each in pictures.values()} == {*(counted / "lots").iterdir()}
    assert (counted / "lots.png").exists()
    assert not (counted / "lot.png").exists()


def test_the_order_of_the_features_changes_nothing(picture: Path, counted: Path, tmp_path: Path) -> None:
    other = tmp_path / "out"
    shutil.copytree(counted / "windows", other / "windows")
    (other / "failures").mkdir()
    mapped(picture, other, (EAST, TWO, WEST, MIDDLE))  # the one without a name has its number
    names = {path.relative_to(counted) for path in counted.rglob("*") if path.is_file()} - {Path("source.json")}
    assert names == {path.relative_to(other) for path in other.rglob("*") if path.is_file()} - {Path("source.json")}
    assert [name for name in names if (counted / name).read_bytes() != (other / name).read_bytes()] == []


def test_one_outline_alone_has_the_files_of_one_lot_and_its_name(picture: Path, counted: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(counted, out)
    report = mapped(picture, out, (WEST,))
    (row,) = (row for row in rows(counted / "lots.csv") if row["lot_name"] == "Wést")
    assert (report["lot_name"], str(report["stalls"])) == ("Wést", row["stalls"])
    assert {path.name for path in out.iterdir() if path.is_file()} == {
        "stalls.csv", "stalls.geojson", "survey.gpkg", "survey.kmz", "lot.png", "report.json", "source.json",
        "stalls-source-crs.geojson",
    }  # fmt: skip
    assert not (out / "lots").exists()


def in_store(folder: Path) -> tuple[dict[str, int], int, int]:
    """Return the stalls of each lot by its name, and the numbers of surveys and of looks."""
    database = Database(lots_file(folder))
    with database.reading() as connection:
        names = {row.id: row.name for row in connection.execute(select(LOT.c.id, LOT.c.name))}
        lots = dict.fromkeys(names.values(), 0)
        for lot in connection.execute(select(STALL.c.lot).where(STALL.c.ends.is_(None))).scalars():
            lots[names[lot]] += 1
        surveys = len(connection.execute(select(SURVEY.c.seq)).all())
        looks = len(connection.execute(select(OBSERVATION.c.survey)).all())
    database.close()
    return lots, surveys, looks


def test_each_lot_is_one_of_the_store_and_a_second_picture_its_second_survey(
    picture: Path, counted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, store = tmp_path / "out", tmp_path / "store"
    shutil.copytree(counted, out)
    report = mapped(picture, out, EVERY, "--store", str(store), "--taken", "2026-05-04T10:30+02:00")
    first = in_store(store)
    stalls = {each["lot_name"]: each["stalls"] for each in report["lots"] if each["stalls"]}
    assert first[0] == stalls
    assert f"Stored in {store}: {len(stalls)} new lots" in (said := capsys.readouterr().out)
    assert "give it by --taken" not in said
    mapped(picture, out, EVERY, "--store", str(store), "--taken", "2026-05-04T10:30+02:00")
    assert in_store(store) == first
    second = written(tmp_path / "later.tif", brighter=6)
    os.utime(second, (1_780_000_000, 1_780_000_000))
    left = tuple(each for each in EVERY if each is not EAST)
    later = mapped(second, tmp_path / "second", left, "--store", str(store), "--taken", "2026-06-04T10:30+02:00")
    lots, surveys, looks = in_store(store)
    assert lots == stalls
    assert surveys == first[1] + len(later["lots"])
    assert looks > first[2]
    assert all("a survey of" in each["stored"] for each in later["lots"] if each["stalls"])


def test_of_outlines_that_overlap_the_smaller_one_has_the_stalls_and_it_is_said(
    picture: Path, counted: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    shutil.copytree(counted, out)
    whole = feature(ground(0, 0, 70, 70), "all", name="All")
    report = mapped(picture, out, (whole, WEST))
    by_id = {each["lot_id"]: each for each in report["lots"]}
    (west,) = (row for row in rows(counted / "lots.csv") if row["lot_name"] == "Wést")
    assert str(by_id["relation/7"]["stalls"]) == west["stalls"]
    assert "It overlaps Wést: the smaller outline has the stalls of both." in by_id["all"]["doubts"]
    assert "It overlaps All: the smaller outline has the stalls of both." in by_id["relation/7"]["doubts"]


def test_a_lot_that_the_picture_cuts_or_ends_at_is_in_doubt(picture: Path, counted: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(counted, out)
    cut, inner = feature(ground(40, 20, 90, 60), "cut"), feature(ground(15, 20, 35, 60), "inner")
    by_id = {each["lot_id"]: each for each in mapped(picture, out, (cut, inner))["lots"]}
    assert by_id["cut"]["unseen_share"] == pytest.approx(0.4, abs=0.01)
    assert by_id["cut"]["doubts"][0] == "40% of its outline was not seen."
    assert by_id["inner"]["doubts"] == []
    report = mapped(picture, out, (feature(ground(0, 0, 30, 30), "edge"), inner))
    assert report["lots"][0]["doubts"][0].startswith("The picture ends within 8 m of it")


@pytest.mark.parametrize(
    ("features", "words"),
    [
        ((WEST, {**EAST, "id": "relation/7"}), "features 1, 2 have one id, relation/7: give each its own"),
        ((TWO, EAST, TWO), "features 1 and 3 are the same lot: leave one of them"),
        ((feature(None, name="Gone"),), "holds no area that is a lot"),
    ],
)
def test_features_that_are_wrong_are_named_with_the_remedy(
    picture: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    features: tuple[dict[str, Any], ...],
    words: str,
) -> None:
    path = outlines(tmp_path, *features)
    assert main(["map", str(picture), "--out", str(tmp_path / "out"), "--outline", str(path)]) == 1
    assert words in (said := capsys.readouterr().err)
    assert "--outline: " in said
    assert not (tmp_path / "out").exists()


def test_a_feature_without_ground_is_named_and_the_others_are_counted(
    picture: Path, counted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    shutil.copytree(counted, out)
    report = mapped(picture, out, (WEST, feature(None, name="Gone"), EAST))
    assert "Feature 2 (Gone) has no ground, and is no lot: draw it, or delete it." in report["notes"]
    assert len(report["lots"]) == 2
    said = capsys.readouterr().out
    assert "town: 2 lots, " in said
    assert "give it by --taken" in said
