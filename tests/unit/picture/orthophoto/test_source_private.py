"""Areas of a file that nobody may look at: no part that is read of a picture shows them."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from rasterio.transform import Affine

from hawk.cli import main
from hawk.lots import lists
from hawk.lots.lists import Asked
from hawk.lots.plan.queries import all_stalls
from hawk.lots.plan.values import shapes_of
from hawk.lots.storage.database import Database
from hawk.lots.store import lots_file
from hawk.picture.city.run import map_orthophoto
from hawk.picture.orthophoto.outline import read_private
from hawk.picture.orthophoto.source import open_orthophoto
from hawk.picture.orthophoto.steps import start
from hawk.picture.orthophoto.windows import Window, task_name
from hawk.picture.values import PictureError
from tests.unit.lots.plan.plans import Person
from tests.unit.picture.orthophoto.drawn import detector, lot_file, lot_picture, placed, rgb, write


@pytest.fixture(scope="module")
def picture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return lot_file(tmp_path_factory.mktemp("private"))


def file_of(folder: Path, picture: Path, *boxes: tuple[float, float, float, float], **facts: str) -> Path:
    """Return a GeoJSON file with boxes (left, top, right, bottom) of a picture's pixels."""
    grid = open_orthophoto(picture).grid
    features: list[dict[str, Any]] = []
    for left, top, right, bottom in boxes:
        ring = grid.on_earth(np.array([(left, top), (right, top), (right, bottom), (left, bottom)], np.float64))
        shape = json.loads(shapely.to_geojson(shapely.Polygon(ring[:, ::-1])))
        features.append({"type": "Feature", "geometry": shape, "properties": facts})
    path = folder / "gardens.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def plan(picture: Path, private: Path | None) -> Any:
    areas = () if private is None else read_private(private)
    return start(picture, outline=None, crs=None, load=detector, private=areas)


@pytest.mark.slow
def test_a_part_that_is_read_lacks_the_areas_at_any_scale(picture: Path, tmp_path: Path) -> None:
    source = plan(picture, file_of(tmp_path, picture, (100, 50, 300, 250), (400, 400, 420, 420))).source
    for step in (1, 4):
        part, whole = source.read((60, 10, 460, 450), step), replace(source, private=()).read((60, 10, 460, 450), step)
        rows, columns = np.mgrid[: part.valid.shape[0], : part.valid.shape[1]]
        x, y = 60 + (columns + 0.5) * step, 10 + (rows + 0.5) * step
        inside = (x > 105) & (x < 295) & (y > 55) & (y < 245) | (x > 405) & (x < 415) & (y > 405) & (y < 415)
        beside = (x < 95) | (x > 305) & (x < 395) | (y > 255) & (y < 395)
        assert not part.valid[inside].any()
        assert not part.image[inside].any()
        assert (part.image[beside] == whole.image[beside]).all()
        assert (part.valid[beside] == whole.valid[beside]).all()


@pytest.mark.slow
def test_only_the_windows_at_an_area_are_looked_at_again(picture: Path, tmp_path: Path) -> None:
    private = plan(picture, file_of(tmp_path, picture, (100, 50, 300, 250))).source
    plain = replace(private, private=())
    for box, is_same in (((0, 0, 200, 200), False), ((400, 300, 600, 500), True)):
        window = Window(box, box)
        assert (task_name(private, window, "m") == task_name(plain, window, "m")) is is_same


@pytest.mark.slow
def test_stalls_there_are_not_counted_and_the_ground_is_not_seen(picture: Path, tmp_path: Path) -> None:
    whole = map_orthophoto(picture)
    half = open_orthophoto(picture).grid.columns / 2
    out, private = tmp_path / "out", file_of(tmp_path, picture, (-50, -50, half, 5000))
    assert main(["map", str(picture), "--private", str(private), "--out", str(out)]) == 0
    report = json.loads((out / "report.json").read_text())
    assert 0 < report["stalls"] < len(whole.survey.stalls)
    assert report["area_seen_m2"] < 0.6 * whole.area_m2
    assert "No picture shows the areas of gardens.geojson, and nothing is counted there." in report["notes"]


@pytest.mark.slow
def test_private_ground_of_the_store_is_left_out_without_a_file(
    picture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store = tmp_path / "store"

    def mapped(name: str) -> dict[str, Any]:
        out = tmp_path / name
        assert main(["map", str(picture), "--store", str(store), "--out", str(out)]) == 0
        report: dict[str, Any] = json.loads((out / "report.json").read_text())
        return report

    whole, database = mapped("whole"), Database(lots_file(store))
    with database.reading() as connection:
        (lot,) = lists.lots(connection, Asked()).items
        places = shapes_of(all_stalls(connection, lot.id))[:, :2]
    (south, west), (north, _) = places.min(axis=0) - 3, places.max(axis=0) + 3
    middle = float(np.median(places[:, 1]))
    person = Person(database, lot.id, now=time.time())
    person.open()
    ring = [[south, west], [south, middle], [north, middle], [north, west]]
    person.do("forbid", outline=ring, name="Garden", private=True)
    database.close()
    left = mapped("left")
    assert 0 < left["stalls"] < 0.6 * whole["stalls"]
    assert left["area_seen_m2"] < whole["area_seen_m2"] - 100
    note = "No picture shows the private ground of the store's lots, and nothing is counted there."
    assert note in left["notes"]
    assert note not in whole["notes"]
    resumed = ["map", str(picture), "--out", str(tmp_path / "left"), "--resume"]
    assert main(resumed) != 0, "without the store its ground would be shown"
    assert "--store: " in capsys.readouterr().err
    assert main([*resumed, "--store", str(store)]) == 0
    assert main(["map", str(picture), "--out", str(tmp_path / "whole"), "--resume", "--store", str(store)]) != 0
    far = write(tmp_path / "far.tif", rgb(lot_picture()), placed("EPSG:32631", 700, 600) * Affine.translation(9000, 0))
    elsewhere = ["map", str(far), "--out", str(tmp_path / "far"), "--resume"]
    assert [main(elsewhere), main([*elsewhere, "--store", str(store)]), main([*elsewhere, "--check", "3"])] == [0, 0, 0]


@pytest.mark.parametrize(("facts", "words"), [({"amenity": "parking"}, "holds parking lots"), ({}, "holds no area")])
def test_a_file_of_lots_or_without_an_area_is_refused(
    picture: Path, tmp_path: Path, facts: dict[str, str], words: str
) -> None:
    path = file_of(tmp_path, picture, *([(0, 0, 9, 9)] if facts else []), **facts)
    with pytest.raises(PictureError, match=words):
        read_private(path)
    with pytest.raises(PictureError, match="--private: "):
        plan(picture, path)


def test_areas_that_lie_elsewhere_are_said(picture: Path, tmp_path: Path) -> None:
    """Latitude and longitude were exchanged, say."""
    out, private = tmp_path / "out", file_of(tmp_path, picture, (900_000, 0, 900_500, 500))
    assert main(["map", str(picture), "--private", str(private), "--out", str(out)]) == 0
    notes = json.loads((out / "report.json").read_text())["notes"]
    assert any(note.startswith("No area of gardens.geojson lies where the pictures are") for note in notes)
