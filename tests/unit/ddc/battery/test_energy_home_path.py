"""The path home that the reserve counts, and the speed along it."""

from __future__ import annotations

import pytest

from hawk.ddc.battery import energy
from hawk.ddc.battery.energy import LANDING_PERCENT, LOOK_S, SLOWEST_M_S, HomePath, Reserve, mean_speed
from hawk.ddc.fence.path import length, path_inside
from hawk.ddc.readings.wind import Wind
from hawk.model.plans import Fence
from hawk.model.poses import MapPoint
from tests.unit.ddc.fence.test_path import EAST, FOOT, U_SHAPE, WEST


def test_the_path_inside_is_counted_and_the_straight_one_where_none_is_needed_or_known() -> None:
    path = HomePath()
    assert length(path.look(U_SHAPE, WEST, EAST, 0.0)) == pytest.approx(190.5, abs=0.1)
    assert path.look(U_SHAPE, MapPoint(0.0, 40.0), FOOT, 0.1) == (MapPoint(0.0, 40.0), FOOT)
    assert path.look(None, WEST, EAST, 0.2) == (WEST, EAST)
    outside = MapPoint(80.0, 0.0)
    assert HomePath().look(U_SHAPE, outside, EAST, 0.3) == (outside, EAST)


def test_a_path_is_looked_for_once_a_second_and_begins_at_the_drone(monkeypatch: pytest.MonkeyPatch) -> None:
    looked: list[MapPoint] = []

    def counted(fence: Fence, start: MapPoint, end: MapPoint) -> tuple[MapPoint, ...] | None:
        looked.append(start)
        return path_inside(fence, start, end)

    monkeypatch.setattr(energy, "path_inside", counted)
    path = HomePath()
    for tick in range(41):
        here = MapPoint(WEST.north - tick * 0.2, WEST.east)
        assert path.look(U_SHAPE, here, EAST, tick * 0.05)[0] == here
    assert len(looked) == round(2.0 / LOOK_S) + 1
    path.look(U_SHAPE, WEST, FOOT, 2.0)
    assert looked[-1] == WEST, "another home is looked for at once"


def test_each_leg_is_flown_against_its_wind() -> None:
    bent = (MapPoint(0.0, 0.0), MapPoint(60.0, 0.0), MapPoint(60.0, 60.0))
    assert mean_speed(bent, 4.0, None) == pytest.approx(4.0)
    assert mean_speed((FOOT, FOOT), 4.0, None) == 4.0
    north_wind = Wind(-10.0, 0.0)
    out, back = mean_speed(bent[:2], 4.0, north_wind), mean_speed(bent[1:], 4.0, north_wind)
    assert out < back
    assert mean_speed(bent, 4.0, north_wind) == pytest.approx(120.0 / (60.0 / out + 60.0 / back))
    assert mean_speed(bent[:2], 4.0, Wind(-60.0, 0.0)) == pytest.approx(SLOWEST_M_S)


def test_the_wind_counts_by_the_leg_and_not_by_where_it_lies() -> None:
    wind = Wind(-3.0, 5.0)
    bent = (MapPoint(0.0, 0.0), MapPoint(60.0, 20.0), MapPoint(40.0, 70.0))
    shifted = tuple(MapPoint(each.north + 300.0, each.east - 200.0) for each in bent)
    assert mean_speed(shifted, 8.0, wind) == pytest.approx(mean_speed(bent, 8.0, wind))
    assert mean_speed(bent[::-1], 8.0, wind) != pytest.approx(mean_speed(bent, 8.0, wind), rel=0.01)


def test_a_charge_lasts_when_something_is_left_at_the_landing() -> None:
    assert Reserve(30.0, 45.0, 0.0, 30.0 - LANDING_PERCENT).lasts
    assert not Reserve(30.0, 45.0, 0.0, 30.1 - LANDING_PERCENT).lasts
