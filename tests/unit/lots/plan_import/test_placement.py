"""Place of a plan: by coordinates, by two points, and by the stalls of the lot or of its newest survey."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import update

from hawk.lots.ingest import save
from hawk.lots.plan_import import placement
from hawk.lots.storage.schema import LOT, STALL
from hawk.lots.values import LotInputError
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import to_global
from tests.unit.lots.plan_files.files import DATUM, closed, dxf, row
from tests.unit.lots.plan_import.imports import Importer, drawn, geojson, importer
from tests.unit.lots.surveys import survey


@pytest.fixture
def person(tmp_path: Path) -> Importer:
    return importer(tmp_path)


@pytest.mark.slow
def test_a_plan_within_reach_is_moved_onto_the_stalls_of_the_lot(person: Importer) -> None:
    placed = person.shown(geojson(drawn(30, north=1.6, east=-1.1)))["placed"]
    assert (placed["by"], placed["on"], placed["is_certain"]) == ("coordinates", "stalls", True)
    assert (placed["north"], placed["east"]) == pytest.approx((-1.6, 1.1), abs=0.05)
    person.take(geojson(drawn(30, north=1.6, east=-1.1)))
    assert person.stalls()["1"]["east"] == pytest.approx(0.0, abs=0.05)


def test_a_plan_in_doubt_keeps_its_coordinates(person: Importer) -> None:
    shown = person.shown(geojson(drawn(10, north=60.0)))
    assert shown["placed"]["is_certain"] is False
    assert shown["placed"]["doubt"] == "too few stalls are on ground that both saw"
    assert shown["begin"][0]["north"] == pytest.approx(60.0, abs=0.01)


@pytest.mark.slow
def test_a_plan_is_placed_on_the_newest_survey_of_a_lot_without_stalls(tmp_path: Path) -> None:
    person = importer(tmp_path, 0)
    with person.store.writing() as connection:
        saved = save(connection, survey(stalls=40))
        assert saved.lot is not None
        connection.execute(update(STALL).where(STALL.c.lot == saved.lot).values(ends=1))
    person.lot = saved.lot
    placed = person.shown(geojson(drawn(40, a_row=20, north=1.5)))["placed"]
    assert (placed["on"], placed["is_certain"]) == ("survey", True)
    assert placed["north"] == pytest.approx(-1.5, abs=0.1)


def test_a_plan_of_another_place_is_refused(person: Importer) -> None:
    with person.store.writing() as connection:
        connection.execute(update(LOT).values(latitude=48.0))
    with pytest.raises(LotInputError, match=r"file: lies at 5[12]\.\d+, 5\.\d+, more than 20 km from this lot"):
        person.preview(geojson(drawn(3)))


def drawing(turn: float = 0.0, scale: float = 1.0) -> bytes:
    """Return the three rows of the lot as a drawing in metres that is turned, its origin far off."""
    cosine, sine = math.cos(turn), math.sin(turn)

    def draw(_: Any, space: Any) -> None:
        for number in range(30):
            across, along = divmod(number, 10)
            (ring,) = row(1, 2.5, -9.0 * across, 2.5 * along)
            corners = np.array(closed(ring, scale)) @ np.array([[cosine, sine], [-sine, cosine]]) + [1000.0, 2000.0]
            space.add_lwpolyline(corners.tolist(), close=True)

    return dxf(draw)


def pins(turn: float = 0.0, stretch: float = 1.0, places: Any = ((0.0, 0.0), (-18.0, 22.5))) -> tuple[str, ...]:
    """Return points (north, east) of the lot, as the drawing has them and where they are on Earth."""
    cosine, sine = math.cos(turn), math.sin(turn)
    found = []
    for north, east in places:
        x, y = (np.array([east, north]) @ np.array([[cosine, sine], [-sine, cosine]]) + [1000.0, 2000.0]).tolist()
        ((latitude, longitude),) = to_global(DATUM, np.array([[north * stretch, east * stretch]])).tolist()
        found.append(f"{x!r},{y!r},{latitude!r},{longitude!r}")
    return tuple(found)


@pytest.mark.slow
@pytest.mark.parametrize("turn", [0.0, 0.7, 3.0])
def test_two_points_place_a_drawing(person: Importer, turn: float) -> None:
    person.register = None
    shown = person.shown(drawing(turn), *pins(turn))
    assert shown["placed"]["by"] == "points"
    assert abs(shown["placed"]["residual"]) < 0.01
    assert (len(shown["stay"]) + shown["same"], shown["begin"]) == (30, [])


@pytest.mark.slow
def test_points_that_err_are_mended_by_the_stalls_of_the_lot(person: Importer) -> None:
    shown = person.shown(drawing(0.3), *pins(0.3, stretch=1.015))
    assert shown["placed"]["residual"] == pytest.approx(0.43, abs=0.02)
    assert shown["placed"]["is_certain"]
    person.take(drawing(0.3), *pins(0.3, stretch=1.015))
    assert person.stalls()["A 1"]["north"] == pytest.approx(0.0, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((), r"pin: must be given twice: .* which has x 1000 to 1022\.5 and y 1982 to 2000; or name the system"),
        (pins()[:1], "pin: must be given twice"),
        (pins(stretch=1.05), r"are 28\.81 m apart in the drawing and 30\.25 m on Earth \(\+5\.0%\), 2% is the most"),
        (pins(places=((0.0, 0.0), (0.0, 5.0))), r"pin: names points 5\.0 m apart: take two that are 10 m apart"),
        (("0,0,0,0", "1,1,1,1"), "pin: is more than 20 km from this lot"),
        (("0,0,52", "1,1,52,5"), "pin: must be x,y,latitude,longitude"),
        (("0,0,nan,5", "1,1,52,5"), "pin: must be finite numbers"),
        (("0,0,91,5", "1,1,52,5"), "pin: must be finite numbers: latitude -90 to 90"),
    ],
)
def test_points_that_cannot_be_used_are_refused(person: Importer, given: tuple[str, ...], words: str) -> None:
    with pytest.raises(LotInputError, match=words):
        person.preview(drawing(), *given)


def test_points_are_for_drawings_alone(person: Importer) -> None:
    with pytest.raises(LotInputError, match="pin: is for drawings without coordinates on Earth"):
        person.preview(geojson(drawn(3)), *pins())


@pytest.mark.slow
def test_a_large_plan_is_placed_by_some_of_its_stalls_and_then_by_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    person = importer(tmp_path, 120)
    monkeypatch.setattr(placement, "MOST_REGISTERED", 60)
    placed = person.shown(geojson(drawn(120, north=0.9)))["placed"]
    assert placed["north"] == pytest.approx(-0.9, abs=0.02)


def test_the_place_of_a_new_lot_is_that_of_its_first_point(person: Importer) -> None:
    found = person.preview(drawing(0.7), *pins(0.7), is_new=True)
    assert found.placement.datum == (DATUM.latitude, DATUM.longitude)
    first = found.matched.draft.added[0]
    assert (first.north, first.east) == pytest.approx((0.0, 0.0), abs=0.01)
    assert GlobalPose(*found.placement.datum, 0.0) == DATUM
