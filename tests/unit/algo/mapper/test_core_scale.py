"""A frame pays for what lies about the drone; what rests comes back as it was."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.algo.mapper import grid as grid_module
from hawk.algo.mapper.core import MapCore, MapperSettings
from hawk.algo.mapper.delta import Recent
from hawk.algo.mapper.stalls import StallTracker
from hawk.algo.mapper.table import SQUARE_M, STALL_DTYPE, FarStalls, Rows, squares_about
from tests.unit.algo.synthetic import SyntheticVision, pose_at, rows_lot

OUT_AND_BACK = [*np.arange(-210, 211, 8.0), *np.arange(210, -211, -8.0)]


def fly(core: MapCore, easts: list[float]) -> MapCore:
    vision = SyntheticVision(rows_lot(rows=1, columns=160), rng=np.random.default_rng(3), noise_m=0.1, miss=0.1)
    for number, east in enumerate(easts):
        pose = pose_at(0.0, float(east), math.pi / 2)
        core.fuse(vision.look(pose, number * 0.5))
        core.encode(pose)
    return core


@pytest.fixture(scope="module")
def flown() -> MapCore:
    """A map of the whole flight; no test changes it."""
    return fly(MapCore(MapperSettings(), "a"), OUT_AND_BACK)


@pytest.mark.nightly
def test_resting_stalls_change_nothing(flown: MapCore, monkeypatch: pytest.MonkeyPatch) -> None:
    resting = flown
    assert len(resting.tracker.rows) < 0.7 * len(resting.index.stalls)
    monkeypatch.setattr(StallTracker, "attend", lambda *_: None)
    awake = fly(MapCore(MapperSettings(), "a"), OUT_AND_BACK)
    assert len(awake.index.stalls) > 250
    assert resting.index.stalls == awake.index.stalls
    assert resting.index.counts == awake.index.counts
    assert {k: t.data for k, t in resting.index.tiles.items()} == {k: t.data for k, t in awake.index.tiles.items()}
    assert resting.changes_since(0).parts.keys() == awake.changes_since(0).parts.keys()


@pytest.mark.slow
def test_resting_tiles_change_next_to_nothing(flown: MapCore, monkeypatch: pytest.MonkeyPatch) -> None:
    awake = flown
    monkeypatch.setattr(grid_module, "LOADED", 16)
    resting = fly(MapCore(MapperSettings(), "a"), OUT_AND_BACK)
    at_rest = sum(tile._layers is None for tile in resting.grid.tiles.values())
    assert at_rest > 5
    assert resting.grid.lot_area_m2 == pytest.approx(awake.grid.lot_area_m2, rel=0.01)
    assert len(resting.index.stalls) == pytest.approx(len(awake.index.stalls), rel=0.01)
    for key, tile in awake.grid.tiles.items():
        assert np.abs(resting.grid.tiles[key].layers.lot - tile.layers.lot).max() < 0.5


@pytest.mark.nightly
def test_a_frame_touches_the_rows_about_it_only() -> None:
    core = fly(MapCore(MapperSettings(), "a"), OUT_AND_BACK[:52])
    far = {key: rows.tobytes() for key, rows in core.tracker._far._rows.items()}
    assert len(far) >= 2
    fly(core, [200.0])
    assert all(core.tracker._far._rows[key].tobytes() == rows for key, rows in far.items())


def rows_at(*places: tuple[float, float]) -> Rows:
    rows = np.zeros(len(places), STALL_DTYPE)
    for number, (north, east) in enumerate(places):
        rows[number]["id"], rows[number]["north"], rows[number]["east"] = number + 1, north, east
        rows[number]["touched"], rows[number]["confirmed"] = number + 1, True
    return rows


PLACE = st.tuples(st.floats(-400, 400), st.floats(-400, 400))


@pytest.mark.slow
@given(st.lists(PLACE, max_size=20), PLACE, st.floats(0, 300))
def test_all_rows_within_reach_are_taken_and_none_is_lost(
    places: list[tuple[float, float]], at: tuple[float, float], reach: float
) -> None:
    resting = FarStalls()
    for row in rows_at(*places):
        resting.put(np.array([row]))
    about = set(resting.about(*at, reach)["id"].tolist())
    taken = set(resting.take(*at, reach)["id"].tolist())
    left = set(resting.all()["id"].tolist())
    assert taken == about
    assert taken | left == set(range(1, len(places) + 1))
    assert not taken & left
    assert all(math.dist(places[i - 1], at) > reach - 1e-9 for i in left)
    assert all(math.dist(places[i - 1], at) < reach + SQUARE_M * math.sqrt(2) + 1e-6 for i in taken)


def test_a_place_at_a_corner_belongs_to_four_squares() -> None:
    assert set(squares_about(0.0, 0.0, 1.0)) == {(0, 0), (-1, 0), (0, -1), (-1, -1)}
    assert squares_about(32.0, 32.0, 1.0) == [(0, 0)]


@pytest.mark.slow
@given(st.lists(PLACE, min_size=1, max_size=20), st.lists(PLACE, min_size=1, max_size=6))
def test_wherever_the_drone_goes_what_is_near_is_at_hand(
    places: list[tuple[float, float]], path: list[tuple[float, float]]
) -> None:
    tracker = StallTracker()
    tracker.restore(rows_at(*places), 1)
    for at in path:
        tracker.attend(*at, 100.0)
        near = {i for i, place in enumerate(places, 1) if math.dist(place, at) < 100.0}
        assert near <= set(tracker.rows["id"].tolist())
        assert set(tracker.rows["id"][tracker.near(*at, 100.0)].tolist()) == near
        assert near <= set(tracker.about(*at, 100.0)["id"].tolist())
        assert sorted(tracker.confirmed["id"].tolist()) == list(range(1, len(places) + 1))
    since = np.concatenate(list(tracker.touched_since(len(places) // 2)))
    assert sorted(since["id"].tolist()) == list(range(len(places) // 2 + 1, len(places) + 1))


@given(st.lists(st.tuples(st.integers(0, 9), st.booleans()), max_size=30), st.integers(0, 30))
def test_what_changed_since_a_version(changes: list[tuple[int, bool]], since: int) -> None:
    recent: Recent[int] = Recent()
    model: dict[int, int] = {}
    for version, (key, forgets) in enumerate(changes, 1):
        if forgets:
            recent.forget(key)
            model.pop(key, None)
        else:
            recent.note(key, version)
            model[key] = version
    expected = sorted((v, k) for k, v in model.items() if v > since)
    assert list(recent.since(since)) == [key for _, key in reversed(expected)]
    assert len(recent) == len(model)
