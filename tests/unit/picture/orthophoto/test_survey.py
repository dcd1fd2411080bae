"""The survey of an orthophoto from the findings of its windows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely

from hawk.algo.vision import quads
from hawk.exports.shapes import lot_shape, stall_shape
from hawk.exports.values import UNSEEN
from hawk.lots.registration.georeference import about, ground_about
from hawk.lots.survey.landing import finished
from hawk.lots.survey.source import Limit, SourceKind
from hawk.picture.orthophoto.outline import LotOutline
from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.orthophoto.survey import Findings, to_survey
from hawk.picture.orthophoto.tile_detector import TileVehicles
from hawk.picture.orthophoto.windows import Window, WindowStalls, windows_of
from hawk.picture.values import LeftOut, Provenance
from tests.unit.picture.orthophoto.drawn import HERE, UTM, opened_blank, placed

COLUMNS, ROWS = 600, 400
"""A picture of 60 by 40 m."""


def photo(folder: Path, turn: float = 0.0) -> Orthophoto:
    return opened_blank(folder, ROWS, COLUMNS, transform=placed(UTM, COLUMNS, ROWS, turn=turn))


def result(window: Window, middles: list[tuple[float, float]], taken: list[float]) -> WindowStalls:
    """Return findings: stalls of 2.5 by 5 m that stand upright, each on a lot of its own ground."""
    at = np.array(middles, np.float64).reshape(-1, 2)
    corners = quads.corners(at[:, 0], at[:, 1], *(np.full(len(at), v) for v in (np.pi / 2, 25.0, 50.0)))
    seen, lot = np.ones((100, 150), np.bool_), np.zeros((100, 150), np.bool_)
    lot[20:60, 20:120] = True  # 40 by 16 m
    cars = quads.corners(np.array([550.0]), np.array([350.0]), *(np.array([v]) for v in (0.0, 25.0, 50.0)))
    return WindowStalls(window, corners, np.array(taken), np.full(len(at), 0.8), cars, lot, seen)


@pytest.mark.parametrize("turn", [0.0, 30.0])
def test_stalls_are_on_earth_with_their_size_and_direction(tmp_path: Path, turn: float) -> None:
    source = photo(tmp_path, turn)
    (window,) = windows_of(source)
    mapped = to_survey(
        Findings.of(source, [result(window, [(300.0, 200.0), (400.0, 200.0)], [0.9, 0.1])], model="f" * 64)
    )
    survey = mapped.survey
    first, second = survey.stalls
    assert about(HERE, np.array([first.place]))[0, :2] == pytest.approx((0, 0), abs=0.01)
    assert np.hypot(*about(HERE, np.array([second.place]))[0, :2]) == pytest.approx(10.0, abs=0.01)
    assert (first.width, first.length) == pytest.approx((2.5, 5.0), abs=0.011)
    assert (first.direction + turn) % 180 == pytest.approx(0, abs=1.5) or first.direction == pytest.approx(
        180 - turn, abs=1.5
    )
    assert stall_shape(first).exterior.is_ccw
    assert [stall.state for stall in survey.stalls] == ["taken", "free"]
    assert [stall.id for stall in survey.stalls] == ["1", "2"]
    assert (survey.lot, survey.software.endswith("network ffffffff")) == ("blank", True)
    assert (mapped.crs, [stall.score for stall in survey.stalls]) == (UTM, [0.8, 0.8])
    assert (survey.began, survey.time_is_sure) == (1_700_000_000, False)
    assert mapped.notes == ("Cars stand where no stall is marked: 1 places are not counted.",)


def test_a_stall_of_uncertain_state_is_unknown(tmp_path: Path) -> None:
    source = photo(tmp_path)
    mapped = to_survey(Findings.of(source, [result(windows_of(source)[0], [(300.0, 200.0)], [0.5])]))
    assert mapped.survey.count(UNSEEN) == 1


def test_the_lot_that_was_found_is_the_outline(tmp_path: Path) -> None:
    source = photo(tmp_path)
    mapped = to_survey(Findings.of(source, [result(windows_of(source)[0], [(300.0, 200.0)], [0.5])]))
    ground = ground_about(HERE, mapped.survey.outline)
    assert ground.area == pytest.approx(40 * 16, rel=0.03)
    north, east = ground.centroid.coords[0]
    assert (north, east) == pytest.approx((4.0, -2.0), abs=0.2)
    assert mapped.area_m2 == pytest.approx(2400, rel=1e-3)
    assert mapped.ground is not None
    assert mapped.ground.image.shape[:2] == pytest.approx((ROWS, COLUMNS), abs=20)  # by the grid's turn in its zone


def test_an_outline_limits_stalls_and_area(tmp_path: Path) -> None:
    source = photo(tmp_path)
    ring = np.array([(100, 100), (350, 100), (350, 300), (100, 300)], float)
    lot = shapely.Polygon(source.grid.on_earth(ring)[:, ::-1], [source.grid.on_earth(ring / 10 + 150)[:, ::-1]])
    outline = LotOutline.of(lot)
    findings = [result(windows_of(source)[0], [(300.0, 200.0), (400.0, 200.0)], [0.9, 0.1])]
    mapped = to_survey(Findings.of(source, findings), outline)
    assert len(mapped.survey.stalls) == 1
    assert mapped.notes == ("1 stalls whose middle lies outside the outlines are not counted.",)
    assert mapped.area_m2 == pytest.approx(25 * 20 - 2.5 * 2, abs=0.5)
    part = np.zeros((100, 150), np.bool_)
    part[:50] = True  # down to 20 m
    half = to_survey(Findings.of(source, [replace(findings[0], seen=part)]), outline)
    assert half.area_m2 == pytest.approx(25 * 10 - 2.5 * 2, abs=3.0)  # by cells of .4 m
    whole, limited = (
        Provenance(source.path.name, SourceKind.ORTHOPHOTO).source(limits) for limits in ((), (Limit.PARTLY,))
    )
    assert (mapped.survey.pictures, half.survey.pictures) == (whole, limited)
    assert lot_shape(mapped.survey.outline).area == pytest.approx(lot.area, rel=1e-6)
    assert mapped.ground is not None
    assert mapped.ground.image.shape[:2] == pytest.approx((360, 410), abs=20)


def test_vehicles_on_the_lots_are_part_of_the_survey(tmp_path: Path) -> None:
    source = photo(tmp_path)
    found = result(windows_of(source)[0], [(300.0, 200.0)], [0.9])
    assert to_survey(Findings.of(source, [found])).landed.current.vehicles is None
    at = np.array([[320.0, 200.0], [250.0, 250.0], [500.0, 200.0], [300.0, 120.0]])
    corners = quads.corners(*at.T, *(np.full(4, v) for v in (0.0, 19.0, 46.0)))
    vehicles = TileVehicles(corners, np.array([0.9, 0.7, 0.9, 0.4]), np.array([0, 1, 0, 0]))
    ring = np.array([(100, 100), (350, 100), (350, 300), (100, 300)], float)
    outline = LotOutline.of(shapely.Polygon(source.grid.on_earth(ring)[:, ::-1]))
    landed = to_survey(Findings.of(source, [replace(found, vehicles=vehicles)]), outline).landed
    assert landed.current.vehicles is not None
    seen = list(landed.current.vehicles.values())
    assert [(each.kind, round(each.probability, 2)) for each in seen] == [("car", 0.9), ("van", 0.7)], (
        "one is outside the lot, of one the network is not sure"
    )
    apart = seen[1].north - seen[0].north, seen[1].east - seen[0].east
    assert apart == pytest.approx((-5.0, -7.0), abs=0.3)  # by the grid's turn in its zone
    assert (seen[0].width, seen[0].length) == pytest.approx((1.9, 4.6), abs=0.01)
    stored = finished(landed).vehicles
    assert stored is not None
    assert [each.kind for each in stored] == ["car", "van"]


def test_a_picture_without_a_stall_is_a_survey_of_none(tmp_path: Path) -> None:
    source = photo(tmp_path)
    (window,) = windows_of(source)
    none, mask = np.zeros((0, 4, 2)), np.zeros((10, 10), np.bool_)
    empty = WindowStalls(window, none, np.zeros(0), np.zeros(0), none, mask, mask)
    mapped = to_survey(Findings.of(source, [empty], left_out=[LeftOut("window 0, 0", "cut")]))
    assert (mapped.survey.stalls, mapped.survey.outline.polygons, mapped.area_m2) == ((), (), 0.0)
    assert mapped.left_out[0].reason == "cut"
    assert mapped.survey.pictures is not None
    assert mapped.survey.pictures.limits == (Limit.PARTLY,)


@pytest.mark.slow
def test_the_same_picture_is_the_same_survey(tmp_path: Path) -> None:
    source = photo(tmp_path)
    findings = [result(windows_of(source)[0], [(300.0, 200.0)], [0.9])]
    first, again = (to_survey(Findings.of(photo(tmp_path), findings, model="a")).survey for _ in range(2))
    assert first == again
    assert to_survey(Findings.of(source, findings, model="b")).survey.survey != first.survey


@pytest.mark.slow
def test_lots_of_one_picture_have_ids_of_their_own_in_whatever_order_and_digits(tmp_path: Path) -> None:
    source = photo(tmp_path)
    (window,) = windows_of(source)
    findings = [result(window, [(300.0, 200.0), (400.0, 200.0)], [0.9, 0.1])]
    north, east = HERE

    def around(d: float) -> shapely.Polygon:
        return shapely.box(east - d, north - d, east + d, north + d)

    far = shapely.box(east + 0.01, north, east + 0.011, north + 0.001)
    same = [LotOutline.of(around(1e-3), far), LotOutline.of(far, around(1e-3 + 1e-9))]
    outlines = [None, *same, LotOutline.of(around(1.1e-3), far)]
    surveys = [to_survey(Findings.of(source, findings), each).survey for each in outlines]
    assert [len(each.stalls) for each in surveys] == [2, 2, 2, 2]
    for ids in ([each.lot_id for each in surveys], [each.survey for each in surveys]):
        assert len(set(ids)) == 3
        assert ids[1] == ids[2]
