"""Grids, windows, merged tiles and outlines of drawn pictures, to the last decimal that matters."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from hawk.picture.orthophoto import windows as parts
from hawk.picture.orthophoto.grid import PixelGrid, measure_grid, system
from hawk.picture.orthophoto.outline import LotOutline, read_outline
from hawk.picture.orthophoto.tile_merger import merge_tiles
from hawk.picture.orthophoto.windows import Window, WindowStalls
from hawk.picture.values import PictureError
from tests.golden import check_values
from tests.unit.picture.orthophoto.drawn import HERE as MIDDLE
from tests.unit.picture.orthophoto.drawn import UTM, opened_blank, placed

HERE = Path(__file__).parent / "windows_drawn"
Json = dict[str, Any]


def plain(value: Any, digits: int = 6) -> Any:
    if isinstance(value, np.ndarray):
        return plain(value.tolist(), digits)
    if hasattr(value, "__dataclass_fields__"):
        return plain(asdict(value), digits)
    if isinstance(value, dict):
        return {key: plain(each, digits) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each, digits) for each in value]
    return round(value, digits) + 0.0 if isinstance(value, float) else value


def made(
    crs: str = UTM, turn: float = 0.0, *, flip: bool = False, metres: float = 0.1, shear: float = 0.0
) -> PixelGrid:
    a, b, c, d, e, f = tuple(placed(crs, 300, 200, metres=metres, turn=turn))[:6]
    if flip:
        b, c, e, f = -b, c + 200 * b, -e, f + 200 * e
    return measure_grid(PixelGrid(300, 200, system(crs, "t.tif")[0], (a, b + shear * a, c, d, e, f)), "t.tif")


@pytest.mark.slow
def test_grids_on_earth() -> None:
    places = np.array([(0.0, 0.0), (300.0, 200.0), (150.0, 100.0), (40.5, 160.25)])
    found: Json = {}
    for name, grid in {
        "utm": made(),
        "turned": made(turn=40.0),
        "mirrored": made(flip=True),
        "mirrored, turned": made(turn=-75.0, flip=True),
        "degrees": made("EPSG:4326"),
        "feet": made("EPSG:3857", metres=0.3),
    }.items():
        there = grid.on_earth(places)
        assert grid.in_picture(there) == pytest.approx(places, abs=1e-3)
        # metres north and east of the middle: a metre is 1e-5 degrees
        found[name] = [plain(there, 7), bool(grid.is_mirrored), grid.metres, grid.metres_at(0.0, 0.0)]
    for shear in (0.03, 0.04):
        try:
            found[f"sheared by {shear}"] = made(shear=shear).metres
        except PictureError as refused:
            found[f"sheared by {shear}"] = str(refused)
    for text in ("EPSG:25832", "EPSG:4326", "OGC:CRS84", "EPSG:4978", "EPSG:5773", "EPSG:7415"):
        try:
            found[text] = system(text, "t.tif")[1]
        except PictureError as refused:
            found[text] = str(refused)
    check_values(HERE / "grids.json", found, digits=8)


@pytest.mark.slow
def test_windows_and_their_names(tmp_path: Path) -> None:
    found: Json = {}
    for name, rows, columns, metres in (
        ("one", 40, 60, 0.1),
        ("wide", 90, 3100, 0.1),
        ("coarse", 700, 300, 0.19),
        ("fine", 200, 9000, 0.02),
    ):
        picture = opened_blank(tmp_path, rows, columns, transform=placed(UTM, columns, rows, metres=metres))
        cut = parts.windows_of(picture)
        found[name] = [[each.core, each.box, each.step] for each in cut] + [cut[-1].name(picture.grid)]
    picture = opened_blank(tmp_path, 900, 4200)
    for name, (left, top, right, bottom) in {
        "left": (10, 10, 90, 90),
        "seam": (1330, 300, 1340, 310),
        "near": (1365, 300, 1370, 310),
    }.items():
        corners = picture.grid.on_earth(np.array([(left, top), (right, top), (right, bottom), (left, bottom)], float))
        found[f"outline {name}"] = [
            each.core for each in parts.windows_of(picture, LotOutline.of(shapely.Polygon(corners[:, ::-1])))
        ]
    mirrored = replace(picture.grid, is_mirrored=True)
    found["mirrored"] = Window((100, 200, 300, 500), (0, 0, 9, 9)).name(mirrored).split(", about")[0]
    check_values(HERE / "windows.json", plain(found), digits=6)


def test_masks_as_runs_and_cells() -> None:
    mask = np.array([[0, 0, 1, 1, 1], [1, 0, 0, 0, 1]], np.bool_)
    assert parts.encode_runs(mask) == [2, 5, 2, 4, 3, 1]
    assert parts.encode_runs(~mask) == [2, 5, 0, 2, 4, 3, 1]
    assert parts.decode_runs([2, 5, 2, 4, 3, 1]).tolist() == mask.tolist()
    for wrong in ([2, 5, 2, 4, 3], [0, 5], [2, 5, 11, -1], [1, 0]):
        with pytest.raises(ValueError, match="do not fill its mask"):
            parts.decode_runs(wrong)
    steps = np.add.outer(np.arange(12), np.arange(20)) % 3 == 0
    cells = [
        parts.encode_runs(parts.lot_cells(steps, side, np.array(core), shape))
        for side, core, shape in (
            ((0.1, 0.1), (0.0, 0.0, 2.0, 1.2), None),
            ((0.1, 0.2), (0.3, 0.2, 1.7, 2.2), None),
            ((0.4, 0.4), (1.0, 1.0, 9.0, 5.0), (5, 7)),
            ((0.1, 0.1), (0.5, 0.5, 0.6, 0.6), None),
        )
    ]
    check_values(HERE / "cells.json", cells)


def test_tiles_merged_at_a_seam() -> None:
    def stalls(core: Any, box: Any, *found: tuple[float, float, float], suggested: Any = ()) -> WindowStalls:
        def quad(x: float, y: float) -> list[tuple[float, float]]:
            return [(x - 12, y - 25), (x + 12, y - 25), (x + 12, y + 25), (x - 12, y + 25)]

        mask = np.zeros((1, 1), np.bool_)
        corners = np.array([quad(x, y) for x, y, _ in found], float).reshape(-1, 4, 2)
        score = np.array([each for *_, each in found])
        more = np.array([quad(x, y) for x, y in suggested], float).reshape(-1, 4, 2)
        return WindowStalls(Window(core, box), corners, score / 2, score, more, mask, mask)

    left = stalls(
        (0, 0, 400, 400),
        (0, 0, 560, 400),
        (100, 100, 0.9),
        (399, 200, 0.7),
        (410, 300, 0.8),
        (401, 50, 0.6),
        suggested=[(100, 110), (300, 300), (390, 390)],
    )
    right = stalls(
        (400, 0, 800, 400),
        (240, 0, 800, 400),
        (401, 200, 0.95),
        (411, 302, 0.5),
        (400, 50, 0.3),
        (700, 99.5, 0.9),
        suggested=[(392, 390), (500, 100)],
    )
    found = {
        name: plain(merge_tiles(each, metres))
        for name, each, metres in (
            ("both", [right, left], (0.1, 0.1)),
            ("other order", [left, right], (0.1, 0.1)),
            ("narrow pixels", [left, right], (0.05, 0.2)),
            ("one", [left], (0.1, 0.1)),
            ("none", [], (0.1, 0.1)),
        )
    }
    assert found["both"] == found["other order"]
    check_values(HERE / "tiles.json", found, digits=6)


def test_lots_of_outlines(tmp_path: Path) -> None:
    latitude, longitude = MIDDLE

    def area(east: float, north: float, size: float = 20.0, **properties: Any) -> Json:
        x, y = longitude + east * 1e-5, latitude + north * 1e-5
        ring = [[x, y], [x + size * 1e-5, y], [x + size * 1e-5, y + size * 1e-5], [x, y + size * 1e-5]]
        own = properties.pop("own", None)
        return {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}} | (
            {} if own is None else {"id": own}
        )

    crossed, named = area(90, 0), dict[str, Any]({"@id": "node/5"})
    crossed["geometry"]["coordinates"][0][1:3] = crossed["geometry"]["coordinates"][0][2:0:-1]
    files: dict[str, list[Json]] = {
        "names": [
            area(0, 0, name="P 10"),
            area(30, 0, name=" P  9 "),
            area(60, 0, ref="7"),
            area(0, 40, name="x" * 90),
            area(0, 80),
        ],
        "ids": [
            area(0, 0, own=7),
            area(30, 0, id="a"),
            area(60, 0, osm_id=3.0),
            area(0, 40, **named),
            area(30, 40, lot_id=True),
        ],
        "tags": [
            area(0, 0, Name="N", fee=True, capacity=12.0, surface="as  phalt", access=None, levels=[1], long="y" * 201)
        ],
        "parking alone": [
            area(0, 0, amenity="parking"),
            area(30, 0, amenity="bench"),
            area(60, 0, amenity="parking", parking="underground"),
        ],
        "one id twice": [area(0, 0, own="a"), area(30, 0, own="a"), area(60, 0, own="b")],
        "one lot twice": [area(0, 0, name="A"), area(0.001, 0, name="A"), area(30, 0)],
        "same middle": [area(0, 0), area(5, 5, 10.0)],
        "no ground": [area(0, 0, name="A"), {"type": "Feature", "properties": {"name": "B"}, "geometry": None}],
        "crossed": [area(0, 0), crossed],
        "nothing": [{"type": "Feature", "properties": {}, "geometry": {"type": "Point", "coordinates": [5, 52]}}],
    }
    found: Json = {}
    path = tmp_path / "lots.geojson"
    for name, features in files.items():
        path.write_text(json.dumps({"type": "FeatureCollection", "features": features}), "utf-8")
        try:
            outline = read_outline(path)
        except PictureError as refused:
            found[name] = str(refused).replace(str(path), "FILE")
            continue
        lots = [
            [lot.facts.id, lot.facts.name, lot.facts.is_named, lot.facts.tags, lot.shape.bounds] for lot in outline.lots
        ]
        found[name] = [lots, [number for number, _ in outline.crossed], outline.notes]
    check_values(HERE / "outlines.json", plain(found, 7), digits=7)
