"""The study judges figures by the history of the simulator."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest

from benchmarks.lots.looks import StillEye
from benchmarks.study.__main__ import figures, line, studied
from benchmarks.study.judged import History, Judged, judged
from benchmarks.study.visits import CLOCK, DAY, HOURS, StudyLot, moments
from hawk.algo.vision.network import StallNetwork
from hawk.stats.values import Panel, PanelColumn, PanelRow
from hawk.worlds.stays import Demand, LotStays

STALLS = 40
STAYS = LotStays(3, {k: Demand(0.5) for k in range(STALLS)}, CLOCK)
TRUE = {f"id {k}": k for k in range(STALLS)}


@pytest.fixture(scope="module")
def perfect() -> Panel:
    """Return the surveys of the study by an eye that errs in nothing."""
    at = [moment.timestamp() for moment in moments()]
    taken = np.array([[k in there for k in range(STALLS)] for there in map(STAYS.at, moments())])
    stalls = tuple(PanelColumn(f"id {k}", f"A {k}", "AB"[k % 2], "") for k in range(STALLS))
    surveys = tuple(PanelRow(str(k), each) for k, each in enumerate(at))
    chance = np.where(taken, 0.999, 0.001).astype(np.float32)
    everywhere = np.ones(taken.shape, np.bool_)
    return Panel("lot", "Lot", CLOCK, "UTC-5", stalls, surveys, (), chance, taken.astype(np.int8), everywhere)


def test_the_moments_are_twelve_of_one_day_and_six_of_another_week() -> None:
    found = [moment.astimezone(CLOCK) for moment in moments()]
    assert [moment.date() for moment in found[:12]] == [DAY.date()] * 12
    assert sorted(HOURS) == list(HOURS)
    assert all(moment.date() >= DAY.date() + timedelta(days=7) for moment in found[12:])
    assert len(found) == 18
    assert StudyLot(2).visits(3) == StudyLot(2).visits(3)
    assert len(StudyLot(2).visits(3)) == 4  # with the flight that finds the lot


@pytest.mark.nightly
def test_the_history_is_that_of_the_stays(perfect: Panel) -> None:
    history = History(STAYS, TRUE, perfect)
    noon = DAY + timedelta(hours=12)
    taken = history.taken(noon.timestamp())
    assert taken.sum() == len(STAYS.at(noon)) > 10
    hour = history.mean(noon.timestamp(), noon.timestamp() + 3600)
    assert 0 < np.abs(hour - taken).max() <= 1
    came = history.arrivals(noon.timestamp(), noon.timestamp() + 3600)
    began = [s for s in STAYS.between(noon, noon + timedelta(hours=1)) if s.begin > noon]
    assert came.sum() == len(began)


@pytest.mark.slow
def test_an_eye_that_errs_in_nothing_is_right_in_everything(perfect: Panel) -> None:
    found = judged("one", perfect, STAYS, TRUE)
    assert max(found.errors) == 0
    assert (found.wrong, found.changed[1:], found.peak_is_right, found.unseen) == (0, (0, 0), True, 0.0)
    assert found.moments[0] == found.moments[1]
    assert found.brackets[1] >= 0.95 * found.brackets[0]
    assert found.brackets[2] > 0
    assert 0.85 <= found.hours[1] / found.hours[0] <= 1.0


@pytest.mark.slow
def test_wrong_states_are_counted_in_every_figure(perfect: Panel) -> None:
    state = perfect.state.copy()
    state[2, :6] = 1 - state[2, :6]
    found = judged("one", replace(perfect, state=state), STAYS, TRUE)
    assert (found.wrong, found.changed[1] + found.changed[2] > 0) == (6, True)
    assert found.moments[1] < found.moments[0]


def test_a_figure_outside_its_limits_is_missed() -> None:
    good = Judged("one", 18, (0.0, 0.01), (100, 99), (100, 90), (100, 96, 10), (98, 1, 1), True, 0.0, 2, ())
    assert all(figure.passed is not False for figure in figures([good]))
    bad = Judged("two", 18, (0.0, 0.02), (9, 9), (100, 99), (100, 80, 10), (90, 9, 9), False, 0.0, 2, ("3: why",))
    assert [figure.key for figure in figures([bad]) if figure.passed is False] == [
        "occupancy_error_max", "interval_holds", "bracket_holds", "changed_precision", "changed_recall", "peak_right",
    ]  # fmt: skip
    assert line(bad).endswith("0.0% unseen; not registered: 3: why")


@pytest.mark.slow
@pytest.mark.nightly
def test_three_surveys_of_a_drawn_lot_go_through_the_store_and_are_near_the_truth() -> None:
    said: list[str] = []
    found = studied(StudyLot(3), StillEye(StallNetwork.load(None)), 3, said.append)
    assert (found.surveys, found.doubts, len(said)) == (3, (), 3)
    assert max(found.errors) <= 0.03
    right, false, missed = found.changed
    assert right > 50
    assert right / (right + false) > 0.9
    assert right / (right + missed) > 0.9
    assert found.brackets[1] >= 0.9 * found.brackets[0] > 0
