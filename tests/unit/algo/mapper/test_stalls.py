from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.mapper.published import StallIndex
from hawk.algo.mapper.stalls import InPicture, Look, StallTracker, call_state
from hawk.algo.mapper.table import (
    FREE,
    TAKEN,
    UNKNOWN,
    Detections,
    corners_of,
    from_bytes,
    seen_blurred,
    to_bytes,
    to_stall,
)
from hawk.algo.vision.detection import Detection


def seen(north: float = 0.0, east: float = 0.0, **changes: float) -> Detection:
    values = {"angle": 0.0, "width": 2.6, "length": 5.2, "score": 0.9, "taken": 0.05, "visible": 1.0} | changes
    return Detection(north, east, **values)


def everywhere(points: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.ones(len(points), np.bool_)


def nowhere(points: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.zeros(len(points), np.bool_)


class Flight:
    """A tracker that is given frames."""

    def __init__(self) -> None:
        self.tracker = StallTracker()
        self.version = 0

    def frame(
        self,
        *stalls: Detection,
        weight: float = 0.5,
        change: float = 0.0,
        in_picture: InPicture = everywhere,
        is_blurred: bool = False,
    ) -> None:
        self.version += 1
        look = Look(
            Detections.of(stalls), weight, self.version * 0.1, in_picture, self.version, change=change,
            is_blurred=is_blurred,
        )  # fmt: skip
        self.tracker.fuse(look, np.arange(len(self.tracker.rows)))

    @property
    def ids(self) -> list[int]:
        return [int(i) for i in self.tracker.confirmed["id"]]


def test_a_find_of_one_frame_does_not_count_yet() -> None:
    flight = Flight()
    flight.frame(seen())
    assert flight.ids == []
    flight.frame(seen())
    assert flight.ids == [1]


def test_a_stall_is_seen_blurred_until_one_sharp_picture_shows_it() -> None:
    flight = Flight()
    for _ in range(3):
        flight.frame(seen(), is_blurred=True)
    assert seen_blurred(flight.tracker.rows).tolist() == [True]
    assert to_stall(flight.tracker.rows[0]).is_blurred is True
    assert to_stall(from_bytes(to_bytes(flight.tracker.rows[0]))[0]).is_blurred is True
    flight.frame(seen())
    assert to_stall(flight.tracker.rows[0]).is_blurred is False


def test_a_stall_that_is_seen_sharp_at_last_is_shown_so() -> None:
    flight, index = Flight(), StallIndex()

    def show() -> int:
        index.update(flight.tracker.rows, np.array([0]), [], flight.version)
        return index.stalls[1].version

    for _ in range(40):
        flight.frame(seen(), is_blurred=True)
    before = show()
    flight.frame(seen(), is_blurred=True)
    assert (show(), index.stalls[1].is_blurred) == (before, True)
    flight.frame(seen())
    assert (show(), index.stalls[1].is_blurred) == (flight.version, False)


def test_a_false_alarm_of_one_frame_never_counts_and_goes() -> None:
    flight = Flight()
    flight.frame(seen(score=0.5))
    for _ in range(10):
        flight.frame()
    assert flight.ids == []
    assert len(flight.tracker.rows) == 0


def test_many_frames_from_one_place_are_not_many_looks() -> None:
    flight = Flight()
    for _ in range(10):
        flight.frame(seen(score=0.5), weight=0.02)
    assert flight.ids == []
    assert float(flight.tracker.rows["looks"][0]) < 1.3


def test_an_id_stays_over_many_noisy_looks() -> None:
    flight, rng = Flight(), np.random.default_rng(0)
    for _ in range(60):
        flight.frame(*(seen(*(np.array([0, 2.6 * i]) + rng.normal(0, 0.3, 2))) for i in range(6)))
    assert sorted(flight.ids) == [1, 2, 3, 4, 5, 6]
    east = np.sort(flight.tracker.confirmed["east"])
    assert east == pytest.approx(np.arange(6) * 2.6, abs=0.25)


def test_a_stall_that_the_pictures_stop_showing_counts_no_longer_but_its_neighbours_do() -> None:
    flight = Flight()
    for _ in range(3):
        flight.frame(seen(), seen(east=2.6))
    for _ in range(30):
        flight.frame(seen(east=2.6))
    assert flight.ids == [2]
    assert 1 in flight.tracker.gone


def test_what_is_not_in_the_picture_is_not_missed() -> None:
    flight = Flight()
    for _ in range(4):
        flight.frame(seen())
    for _ in range(100):
        flight.frame(in_picture=nowhere)
    assert flight.ids == [1]


def test_a_stall_partly_in_the_picture_is_not_missed() -> None:
    flight = Flight()
    for _ in range(4):
        flight.frame(seen())
    for _ in range(100):
        flight.frame(in_picture=lambda points: points[:, 0] < 0)
    assert flight.ids == [1]


def test_a_stall_that_comes_back_has_its_id_again_and_is_not_gone() -> None:
    flight = Flight()
    for _ in range(6):
        flight.frame(seen())
    while flight.ids:
        flight.frame()
    assert flight.tracker.gone
    for _ in range(12):
        flight.frame(seen())
    assert flight.ids == [1]
    assert not flight.tracker.gone


def test_a_car_that_leaves_is_seen_within_a_few_looks() -> None:
    flight = Flight()
    for _ in range(50):
        flight.frame(seen(taken=0.97))
    assert flight.tracker.rows["state"][0] == TAKEN
    for _ in range(8):
        flight.frame(seen(taken=0.03))
    assert flight.tracker.rows["state"][0] == FREE


def test_a_stall_of_unclear_state_stays_unknown() -> None:
    flight = Flight()
    for _ in range(20):
        flight.frame(seen(taken=0.5))
    assert flight.tracker.rows["state"][0] == UNKNOWN


def test_states_have_hysteresis() -> None:
    before = np.array([TAKEN, FREE, UNKNOWN, TAKEN, FREE])
    evidence = np.array([0.2, -0.2, 0.2, -0.2, 0.2])
    assert call_state(evidence, before).tolist() == [TAKEN, FREE, UNKNOWN, UNKNOWN, UNKNOWN]
    assert call_state(np.array([-1.0, 1.0]), np.array([TAKEN, FREE])).tolist() == [FREE, TAKEN]


def test_a_stall_cut_by_the_edge_does_not_move_a_known_one() -> None:
    flight = Flight()
    for _ in range(5):
        flight.frame(seen())
    for _ in range(20):
        flight.frame(seen(north=1.2, length=3.0, visible=0.5))
    assert flight.tracker.rows["north"][0] == pytest.approx(0.0, abs=0.35)
    assert flight.tracker.rows["length"][0] > 4.5


def test_directions_either_side_of_north_do_not_cancel() -> None:
    flight = Flight()
    for i in range(20):
        flight.frame(seen(angle=0.05 if i % 2 else math.pi - 0.05))
    corners = corners_of(flight.tracker.rows)[0]
    assert np.ptp(corners[:, 0]) == pytest.approx(5.2, abs=0.2)


def test_where_two_overlap_the_older_id_stays() -> None:
    flight = Flight()
    for _ in range(4):
        flight.frame(seen())
    for _ in range(4):
        flight.frame(seen(), seen(north=0.4, east=1.2))
    assert flight.ids == [1]


def test_neighbours_at_the_narrowest_pitch_are_not_merged() -> None:
    flight = Flight()
    for _ in range(4):
        flight.frame(*(seen(east=2.2 * i, width=2.3) for i in range(5)))
    assert len(flight.ids) == 5


def test_numbers_that_are_not_finite_are_left_out() -> None:
    flight = Flight()
    flight.frame(seen(north=math.nan), seen(width=0.0), seen(taken=math.inf), seen())
    assert len(flight.tracker.rows) == 1


def test_an_id_is_never_given_twice() -> None:
    flight = Flight()
    flight.frame(seen(score=0.4))
    for _ in range(20):
        flight.frame()
    flight.frame(seen())
    assert flight.tracker.rows["id"].tolist() == [2]


@pytest.mark.slow
def test_a_frame_that_shows_nothing_new_changes_no_count() -> None:
    flight, rng = Flight(), np.random.default_rng(2)
    for _ in range(3):
        flight.frame(seen(taken=0.42), seen(east=2.6, taken=0.9), weight=0.5)
    before = flight.tracker.confirmed.copy()
    for _ in range(600):
        flight.frame(
            seen(taken=float(rng.uniform(0.3, 0.75))),
            seen(east=2.6, taken=0.85),
            seen(east=7.8, score=0.95),
            weight=0.0,
        )
    after = flight.tracker.confirmed
    assert after["id"].tolist() == before["id"].tolist()
    assert after["state"].tolist() == before["state"].tolist()
    for _ in range(50):
        flight.frame(weight=0.0)
    assert flight.tracker.confirmed["id"].tolist() == before["id"].tolist()


@pytest.mark.slow
def test_a_car_that_leaves_is_seen_by_a_drone_that_hovers() -> None:
    flight = Flight()
    for _ in range(10):
        flight.frame(seen(taken=0.97), weight=0.5)
    assert flight.tracker.confirmed["state"].tolist() == [TAKEN]
    for _ in range(150):  # fifteen seconds
        flight.frame(seen(taken=0.03), weight=0.0, change=0.02)
    assert flight.tracker.confirmed["state"].tolist() == [FREE]


def test_what_was_found_later_moves_whether_it_is_near_or_evicted() -> None:
    tracker = StallTracker()
    for flown, found in ((10.0, [seen(), seen(0.0, 500.0)]), (50.0, [seen(0.0, 100.0), seen(0.0, 700.0)])):
        tracker.fuse(Look(Detections.of(found), 1.0, 0.0, nowhere, 1, flown), np.arange(0))
    tracker.attend(0.0, 0.0, 10.0)
    assert len(tracker.rows) < 4
    index = tracker.move_younger(10.0, np.array([1.0, -2.0]), 7)
    assert sorted(tracker.rows["east"].tolist()) == [0.0, 98.0, 500.0, 698.0]
    assert tracker.rows["north"][index].tolist() == [1.0, 1.0]
    assert tracker.rows["touched"][index].tolist() == [7, 7]
