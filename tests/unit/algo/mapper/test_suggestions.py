"""Suggested stalls: a car stands in several passes where no stall is known; it counts as none."""

from __future__ import annotations

import json
import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.mapper.core import MapCore, MapperSettings
from hawk.algo.mapper.suggestions import (
    LENGTH_M,
    PASS_M,
    PASS_S,
    SCORE,
    WIDTH_M,
    CarBoxes,
    Geometry,
    Sight,
    Suggestion,
    Suggestions,
)
from hawk.model.lot_map import Counts, StallState
from tests.unit.algo.synthetic import SyntheticVision, Truth, pose_at, rows_lot

CAR = (10.0, 5.0, 0.4, 1.8, 4.4)
Floats = NDArray[np.float64]


def everywhere(places: Floats) -> NDArray[np.bool_]:
    return np.ones(len(places), np.bool_)


def nowhere(places: Floats) -> NDArray[np.bool_]:
    return np.zeros(len(places), np.bool_)


def cars(*those: tuple[float, ...]) -> CarBoxes:
    return CarBoxes(*np.array(those, np.float64).reshape(-1, 5).T)


def stalls(*those: tuple[float, ...]) -> Geometry:
    """North, east, angle; 2.5 x 5 m."""
    north, east, angle = np.array(those, np.float64).reshape(-1, 3).T
    return north, east, angle, np.full(len(those), 2.5), np.full(len(those), 5.0)


class Passes:
    """Looks at cars, each at its own metre and second of the flight."""

    def __init__(self) -> None:
        self.suggestions = Suggestions()
        self.version = 0
        self.next_id = 1

    def look(
        self,
        *those: tuple[float, ...],
        flown_m: float,
        time: float = 0.0,
        about: Geometry | None = None,
        in_picture: Callable[[Floats], NDArray[np.bool_]] = everywhere,
        cover: float = 0.0,
    ) -> None:
        self.version += 1
        sight = Sight(
            cars(*those),
            lambda places: np.full(len(places), cover),
            in_picture,
            stalls() if about is None else about,
            flown_m,
            time,
            self.version,
        )
        self.next_id = self.suggestions.look(sight, (10.0, 5.0), 40.0, self.next_id)

    @property
    def shown(self) -> list[Suggestion]:
        return [one for one in self.suggestions.known.values() if one.is_shown]


def test_a_car_of_one_pass_is_not_suggested() -> None:
    flight = Passes()
    for metre in range(0, 200, 4):
        flight.look(CAR, flown_m=metre, time=metre / 4)
    assert flight.shown == []
    assert len(flight.suggestions.known) == 1


@pytest.mark.parametrize(("metres", "seconds"), [(PASS_M, 0.0), (0.0, PASS_S)])
def test_a_car_that_stands_there_in_the_next_pass_is_suggested(metres: float, seconds: float) -> None:
    flight = Passes()
    flight.look(CAR, flown_m=0)
    flight.look(CAR, flown_m=metres, time=seconds)
    (one,) = flight.shown
    assert (one.north, one.east, one.angle) == pytest.approx(CAR[:3])
    stall = one.to_stall()
    assert (stall.state, stall.seen, stall.score) == (StallState.SUGGESTED, 2, SCORE)
    assert (stall.width, stall.length) == (WIDTH_M, LENGTH_M)


def test_just_less_than_a_pass_suggests_nothing() -> None:
    flight = Passes()
    flight.look(CAR, flown_m=0)
    flight.look(CAR, flown_m=PASS_M - 0.1, time=PASS_S - 0.1)
    assert flight.shown == []


def test_another_car_beside_it_is_another_place() -> None:
    flight = Passes()
    flight.look(CAR, flown_m=0)
    flight.look((CAR[0], CAR[1] + 2.4, *CAR[2:]), flown_m=50)
    flight.look((CAR[0], CAR[1], CAR[2] + 1.0, *CAR[3:]), flown_m=100)
    assert flight.shown == []
    assert len(flight.suggestions.known) == 1, "the others were seen to have left"


def test_the_place_is_the_mean_of_its_looks_and_long_cars_need_long_places() -> None:
    flight = Passes()
    flight.look(CAR, flown_m=0)
    flight.look((CAR[0] + 0.6, CAR[1], CAR[2] + 0.1, 2.0, 5.6), flown_m=50)
    (one,) = flight.shown
    assert (one.north, one.angle) == pytest.approx((CAR[0] + 0.3, CAR[2] + 0.05))
    assert LENGTH_M < one.length < 6.1


def test_a_place_whose_car_left_is_forgotten() -> None:
    flight = Passes()
    flight.look(CAR, flown_m=0)
    flight.look(CAR, flown_m=50)
    flight.look(flown_m=100, in_picture=nowhere)
    assert len(flight.shown) == 1, "it was not looked at"
    flight.look(flown_m=104, cover=0.8)
    assert len(flight.shown) == 1, "something covers the ground: the box was missed"
    flight.look(flown_m=108, cover=0.1)
    assert flight.shown == []


def test_a_car_that_the_picture_cuts_is_not_judged() -> None:
    flight = Passes()
    flight.look(CAR, flown_m=0, in_picture=nowhere)
    assert flight.suggestions.known == {}


@pytest.mark.parametrize(
    ("stall", "is_suggested"),
    [
        ((10.0, 5.0, 0.4), False),
        ((10.9, 5.4, 0.4), False),
        ((10.0 - 5.3 * math.cos(1.97), 5.0 - 5.3 * math.sin(1.97), 1.97), False),
        ((10.0 - 9.5 * math.cos(1.97), 5.0 - 9.5 * math.sin(1.97), 1.97), True),
        ((10.0 + 2.6 * math.sin(0.4), 5.0 - 2.6 * math.cos(0.4), 0.4), True),
        ((10.0 - 5.2 * math.cos(0.4), 5.0 - 5.2 * math.sin(0.4), 0.4), True),
    ],
    ids=["on it", "half on it", "across its front", "beyond its aisle", "beside it", "behind it"],
)
def test_a_suggestion_keeps_its_distance_from_known_stalls(
    stall: tuple[float, float, float], is_suggested: bool
) -> None:
    flight = Passes()
    for metre in (0, 50):
        flight.look(CAR, flown_m=metre, about=stalls(stall))
    assert bool(flight.shown) is is_suggested


def test_a_stall_that_is_found_there_takes_the_place() -> None:
    flight = Passes()
    flight.look(CAR, flown_m=0)
    flight.look(CAR, flown_m=50)
    flight.look(CAR, flown_m=54, about=stalls(CAR[:3]))
    assert flight.suggestions.known == {}
    assert list(flight.suggestions.changed_since(2)) == [(1, None)]


def test_changes_are_found_by_version() -> None:
    flight = Passes()
    flight.look(CAR, flown_m=0)
    flight.look((30.0, 5.0, *CAR[2:]), flown_m=10, in_picture=lambda places: places[:, 0] > 20)
    assert [number for number, _ in flight.suggestions.changed_since(0)] == [2, 1]
    assert [number for number, _ in flight.suggestions.changed_since(1)] == [2]


def test_a_suggestion_comes_back_from_its_bytes() -> None:
    flight = Passes()
    flight.look(CAR, flown_m=0)
    one = flight.suggestions.known[1]
    assert Suggestion.from_bytes(one.to_bytes()) == one


@pytest.mark.parametrize(
    "data",
    [b"", b"{}", b"[]", b"7", b"\xff", json.dumps({"id": 1}).encode()],
)
def test_bytes_that_are_no_suggestion_are_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match=r".+"):
        Suggestion.from_bytes(data)


def test_a_number_that_is_not_finite_is_refused() -> None:
    flight = Passes()
    flight.look(CAR, flown_m=0)
    data = flight.suggestions.known[1].to_bytes().replace(b'"north": 10.0', b'"north": NaN')
    with pytest.raises(ValueError, match="not finite"):
        Suggestion.from_bytes(data)


def lot_and_cars() -> Truth:
    """A lot of four rows, and 30 m north of it three cars on ground without marks."""
    lot = rows_lot(columns=10)
    aside = np.array([[48.0, east, 0.2, 1.9, 4.5] for east in (-6.0, 0.0, 6.0)])
    return Truth(lot.lot, np.vstack([lot.stalls, aside]), np.append(lot.taken, [True] * 3))


class CarsAside(SyntheticVision):
    """Sees the last three as cars and never as stalls."""

    def _stalls(self, real, lot):  # type: ignore[no-untyped-def]
        return [stall for stall in super()._stalls(real, lot) if stall.north < 40]


@pytest.fixture(scope="module")
def core() -> MapCore:
    core, vision = MapCore(MapperSettings(), "a"), CarsAside(lot_and_cars())
    easts = [*np.arange(-70, 71, 2.0), *np.arange(70, -71, -2.0)]
    for number, east in enumerate(easts):
        pose = pose_at(34.0, float(east), math.pi / 2, height=45.0)
        core.fuse(vision.look(pose, number * 0.5))
        core.encode(pose)
    return core


def suggested(core: MapCore) -> list[tuple[float, float]]:
    those = [stall for stall in core.index.stalls.values() if stall.state is StallState.SUGGESTED]
    return sorted((round(stall.east, 0), round(stall.north, 0)) for stall in those)


@pytest.mark.nightly
def test_cars_beside_a_lot_are_suggested_and_counted_apart(core: MapCore) -> None:
    assert suggested(core) == [(-6.0, 48.0), (0.0, 48.0), (6.0, 48.0)]
    counts: Counts = core.index.counts
    assert counts.suggested == 3
    assert counts.total == len(core.index.stalls) - 3
    assert counts.taken == sum(stall.state is StallState.TAKEN for stall in core.index.stalls.values())


@pytest.mark.slow
def test_suggestions_are_no_stalls_for_others(core: MapCore) -> None:
    assert core.stalls_near(48.0, 0.0, 8.0) == []
    assert all(stall.state is not StallState.SUGGESTED for stall in core.published.unclear.values())


@pytest.mark.slow
def test_suggestions_come_back_with_the_map(core: MapCore) -> None:
    again = MapCore(MapperSettings(), "")
    assert again.restore([core.changes_since(0).parts]) == []
    assert suggested(again) == suggested(core)
    assert again.index.counts.suggested == 3
    assert again.tracker.next_id == core.tracker.next_id


def test_a_suggestion_that_cannot_be_read_is_reported_and_the_others_are_kept(core: MapCore) -> None:
    parts = dict(core.changes_since(0).parts)
    name = next(name for name in sorted(parts) if name.startswith("suggestion/") and parts[name])
    again = MapCore(MapperSettings(), "")
    (problem,) = again.restore([{**parts, name: b"{}"}])
    assert problem.startswith(name)
    assert again.index.counts.suggested == 2


def test_what_went_is_gone_from_the_journal(core: MapCore) -> None:
    parts = dict(core.changes_since(0).parts)
    name = next(name for name in sorted(parts) if name.startswith("suggestion/") and parts[name])
    again = MapCore(MapperSettings(), "")
    again.restore([parts, {name: b""}])
    assert again.index.counts.suggested == 2
