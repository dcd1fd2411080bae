"""Every kind of file and feed of two drawn surveys, to the last word and decimal."""

from __future__ import annotations

import io
import json
import sqlite3
import zipfile
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hawk.exports import ground as ground_room
from hawk.exports.feeds import ngsi_entities, parkapi, valid_at
from hawk.exports.formats import FEEDS, Span
from hawk.exports.geopackage import surveys_gpkg
from hawk.exports.ground import Ground, _cropped, lot_picture, occupancy, time_words
from hawk.exports.kmz import survey_kmz
from hawk.exports.rasters import plane_of, stac_item, write_rasters
from hawk.exports.records import found_stalls
from hawk.exports.text_files import survey_csv, survey_geojson
from hawk.exports.values import ExportRecord, Observation
from hawk.lots.survey.moments import AHEAD_S
from hawk.lots.survey.source import Limit, PictureSource, SourceKind
from hawk.model.plans import Outline
from hawk.results.map_picture import Caption
from tests.golden import check_text, check_values
from tests.unit.lots import surveys

HERE = Path(__file__).parent / "drawn_survey"
ENDED = 1_770_000_900.25
WIDE, HIGH = 0.00004, 0.00005
"""Degrees of a stall."""
LOOKS: dict[str, tuple[str, float | None, float | None, int]] = {
    "A 1": ("free", 0.0204, ENDED - 60, 12),
    "A 2": ("taken", 0.98765, ENDED - 600.5, 3),
    "A 10": ("unknown", 0.5, ENDED - 60, 1),
    "B 1": ("unknown", None, None, 0),
    "": ("taken", 0.9, ENDED - 3601, 7),
}
KINDS = {"A 2": "disabled", "A 10": "charging", "B 1": "motorcycle"}


def stall(number: int, label: str) -> Observation:
    state, chance, looked_at, pictures = LOOKS[label]
    west, south = 5.0 + number * WIDE, 52.0
    corners = ((south, west), (south, west + WIDE), (south + HIGH, west + WIDE), (south + HIGH, west))
    return Observation(
        f"{number:032d}", label, KINDS.get(label, ""), state, chance, looked_at, pictures,
        (south + HIGH / 2, west + WIDE / 2), corners, 2.754, 5.561, 12.5, is_confirmed=number == 1,
        score=0.9 if number == 2 else None, is_named=number == 1,
    )  # fmt: skip


FLOWN = ExportRecord(
    "=Étoile <b>", "lot-1", "1" * 32, ENDED - 900.25, ENDED, True, 3, "hawk-drone 0.4.0, network 1234", False, 1.2345,
    False, (52.00005, 5.0001), Outline(
        (((51.9999, 4.9999), (52.0002, 4.9999), (52.0002, 5.0004), (51.9999, 5.0004)),),
        (((52.0001, 5.0002), (52.00015, 5.0002), (52.00015, 5.0003), (52.0001, 5.0003)),),
    ), tuple(stall(number, label) for number, label in enumerate(LOOKS)), blurred=2, time_zone="Europe/Amsterdam",
)  # fmt: skip
MAPPED = replace(
    FLOWN, lot="Yard", lot_id="lot-2", survey="2" * 32, ended=ENDED + 86_400, time_is_sure=False, layout=None,
    is_simulated=True, accuracy=None, is_pinned=True, outline=Outline(), stalls=FLOWN.stalls[:2], blurred=None,
    doubt="it may lie beside", pictures=PictureSource(SourceKind.ORTHOPHOTO, "yard.tif", (Limit.COARSE, Limit.PARTLY)),
)  # fmt: skip
BOTH = pytest.mark.parametrize("survey", [FLOWN, MAPPED], ids=["flown", "mapped"])


def named(survey: ExportRecord, end: str) -> Path:
    return HERE / f"{'flown' if survey is FLOWN else 'mapped'}{end}"


@BOTH
def test_tables_and_maps_of_a_drawn_survey(survey: ExportRecord) -> None:
    check_text(named(survey, ".csv"), survey_csv(survey).decode())
    check_values(named(survey, ".geojson"), json.loads(survey_geojson(survey)), digits=None)
    with zipfile.ZipFile(io.BytesIO(survey_kmz(survey))) as archive:
        (info,) = archive.infolist()
        assert (info.filename, info.date_time) == ("doc.kml", (1980, 1, 1, 0, 0, 0))
        check_text(named(survey, ".kml"), archive.read(info).decode())
    assert survey_kmz(survey) == survey_kmz(survey)


def test_a_database_of_drawn_surveys(tmp_path: Path) -> None:
    path = tmp_path / "surveys.gpkg"
    path.write_bytes(surveys_gpkg([FLOWN, replace(FLOWN, survey="3" * 32), MAPPED]))
    with closing(sqlite3.connect(path)) as opened:
        pragmas = [opened.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version")]
        check_text(HERE / "surveys.sql", "\n".join(opened.iterdump()) + "\n")
    assert pragmas == [0x47504B47, 10300]
    path.write_bytes(surveys_gpkg([]))
    with closing(sqlite3.connect(path)) as opened:
        assert opened.execute("SELECT table_name, min_x FROM gpkg_contents ORDER BY 1").fetchall() == [
            ("lots", None), ("stalls", None),
        ]  # fmt: skip


@BOTH
@pytest.mark.parametrize("name", [name for name, feed in FEEDS.items() if feed.span is Span.SURVEY])
def test_feeds_of_a_drawn_survey(survey: ExportRecord, name: str) -> None:
    check_values(named(survey, f"_{name}.json"), FEEDS[name].make(survey), digits=None)


@pytest.mark.parametrize("name", ["free", "taken"])
def test_a_feed_counts_where_every_state_is_known(name: str) -> None:
    survey = replace(FLOWN, stalls=tuple(replace(each, state=name) for each in FLOWN.stalls))
    site, row, *_ = ngsi_entities(survey)
    assert (site["availableSpotNumber"], site["occupiedSpotNumber"]) == ((5, 0) if name == "free" else (0, 5))
    assert (row["availableSpotNumber"], "occupiedSpotNumber" in row) == (3 if name == "free" else 0, False)
    assert parkapi(survey)["parking_sites"][0]["realtime_free_capacity"] == (5 if name == "free" else 0)


def test_a_state_is_valid_from_its_look_for_as_long_as_is_asked() -> None:
    def states(now: float, valid_s: float) -> list[str]:
        return [each.state for each in valid_at(FLOWN, now, valid_s).stalls]

    first, second, _, _, last = (each.looked_at or 0.0 for each in FLOWN.stalls)
    assert states(last + 3600, 3600) == ["free", "taken", "unknown", "unknown", "taken"]
    assert states(last + 3600.5, 3600) == ["free", "taken", "unknown", "unknown", "unknown"]
    assert states(second - AHEAD_S, 3600)[1] == "taken"  # a clock may be ahead of another one by so much
    assert states(second - AHEAD_S - 1, 3600)[:2] == ["unknown", "unknown"]
    unsure = valid_at(MAPPED, first, 3600)
    assert (unsure.ended, [(each.state, each.looked_at) for each in unsure.stalls]) == (first, [("unknown", None)] * 2)
    assert all(each.taken_probability is None for each in unsure.stalls)


def ground() -> Ground:
    pixels = np.arange(40 * 60 * 3, dtype=np.uint8).reshape(40, 60, 3)
    seen = np.full((40, 60), 255, np.uint8)
    seen[:5] = 0
    return Ground(pixels, seen, 6.0, -10.0, 0.5)


def test_rasters_of_a_drawn_survey(tmp_path: Path) -> None:
    rasterio = pytest.importorskip("rasterio")
    mosaic, states, item = write_rasters(FLOWN, ground(), tmp_path / "survey.tif")
    check_values(HERE / "stac.json", json.loads(item.read_text("utf-8")), digits=None)
    assert (mosaic.name, states.name, item.name) == ("survey.tif", "survey-occupancy.tif", "survey.json")
    with rasterio.open(mosaic) as file:
        assert tuple(file.transform)[:6] == (0.5, 0.0, -10.0, 0.0, -0.5, 6.0)
        assert [each.name for each in file.colorinterp] == ["red", "green", "blue", "alpha"]
        shown = file.read()
        assert (shown[:3, :5] == 0).all()
        assert shown[:3, 5:].tolist() == ground().image[5:, :, ::-1].transpose(2, 0, 1).tolist()
        assert file.tags()["STALLS"] == "5"
    with rasterio.open(states) as file:
        colours = file.colormap(1)
        assert [colours[k] for k in range(4)] == [
            (0, 0, 0, 0), (47, 143, 255, 255), (255, 122, 26, 255), (22, 22, 28, 255),
        ]  # fmt: skip
        assert file.nodata == 0
        check_text(HERE / "occupancy.txt", "\n".join("".join(map(str, row)) for row in file.read(1).tolist()) + "\n")
        assert (file.read(1) == occupancy(FLOWN, ground())).all()


def test_an_item_without_an_outline_is_the_ground_of_its_stalls() -> None:
    check_values(HERE / "stac_mapped.json", stac_item(MAPPED, ground(), "a.tif", "b.tif"), digits=None)
    assert plane_of(MAPPED).startswith("+proj=aeqd +lat_0=52.000050000 +lon_0=5.000100000 +x_0=0")


@pytest.mark.parametrize(
    ("survey", "words"),
    [
        (FLOWN, "2026-02-02T02:55:00Z"),
        (replace(FLOWN, time_is_sure=False), "2026-02-02T02:55:00Z (the clock was not set)"),
        (MAPPED, "time not known, from orthophoto yard.tif"),
        (
            replace(MAPPED, pictures=PictureSource(SourceKind.PHOTOGRAPHS, "week")),
            "2026-02-03T02:55:00Z (time zone not known), from photographs week",
        ),
    ],
)
def test_the_words_of_a_time_that_is_not_sure(survey: ExportRecord, words: str) -> None:
    assert time_words(survey) == words


def test_stalls_as_a_survey_found_them_have_no_label_that_a_person_gave() -> None:
    (found,) = found_stalls([surveys.stall(1)], FLOWN.origin)
    assert (found.id, found.label, found.kind, found.is_confirmed, found.is_named) == ("1", "", "", False, False)
    bare = Observation("1", "", "", "free", 0.1, ENDED, 1, (52.0, 5.0), (), 2.5, 5.0, 0.0, is_confirmed=False)
    assert (bare.score, bare.is_named) == (None, False)


def test_a_sheet_is_named_by_its_lot_with_the_doubt(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[Caption] = []

    def sheet(picture: object, _metres: float, caption: Caption) -> object:
        said.append(caption)
        return picture

    monkeypatch.setattr(ground_room, "sheet", sheet)
    for survey in (FLOWN, MAPPED):
        lot_picture(survey, ground())
    assert [(each.title, each.lines[1]) for each in said] == [
        ("=Étoile <b>", "hawk-drone 0.4.0, network 1234, survey 11111111"),
        ("Yard (it may lie beside)", "hawk-drone 0.4.0, network 1234, survey 22222222, simulated"),
    ]
    assert [each.value for each in said[0].counts] == ["free", "taken", "unknown"]
    assert list(said[0].counts.values()) == [1, 2, 2]


@pytest.mark.parametrize(
    ("stall_at", "rows", "columns"),
    [
        ((-6.5, 18.0), (15, 45), (40, 70)),  # seen
        ((6.0, -10.0), (0, 45), (0, 70)),  # at the corner of the picture
        ((-6.5, 60.0), (15, 45), (40, 70)),  # beyond its right edge
        ((-6.5, 50.0), (15, 45), (40, 70)),  # at its right edge, where no pixel is
        ((20.0, 18.0), (15, 45), (40, 70)),  # above it
    ],
)
def test_a_picture_is_cut_to_what_was_seen_and_to_the_stalls_in_it(
    stall_at: tuple[float, float], rows: tuple[int, int], columns: tuple[int, int]
) -> None:
    seen = np.zeros((80, 120), np.uint8)
    seen[25:35, 50:60] = 255
    whole = Ground(np.arange(80 * 120 * 3, dtype=np.uint8).reshape(80, 120, 3), seen, 6.0, -10.0, 0.5)
    part = _cropped(whole, np.array([stall_at]))
    assert (part.north, part.east, part.metres) == (6.0 - rows[0] * 0.5, -10.0 + columns[0] * 0.5, 0.5)
    assert part.seen.tolist() == seen[slice(*rows), slice(*columns)].tolist()
    assert part.image.tolist() == whole.image[slice(*rows), slice(*columns)].tolist()
