"""The benchmark of two drones finds one set of ids, and says where there are two or an id stands on another stall."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from benchmarks.lots.looks import Look
from benchmarks.lots.visits import BIAS_M, Visit
from benchmarks.two_drones import NAMES, OneLot, both_visits, figures, line, survey_lot
from hawk.lots.values import FinishedSurvey
from hawk.model.poses import GlobalPose
from tests.examples import nightly
from tests.unit.lots.surveys import DATUM, later, survey

STALLS = 60
APART_DEG = 0.1


def look(visit: Visit, north_deg: float = 0.0, shifted: int = 0) -> Look:
    """Return a survey of the drawn lot by one of the visits, with its truth; ``shifted``: numbers of stalls."""
    given = later(survey(stalls=STALLS, seed=round(10 * visit.hours)), visit.number, visit.hours)
    found = moved(given, north_deg)
    return Look(
        found,
        true={each.id: each.id + shifted for each in found.stalls},
        at={each.id: (each.north, each.east + 2.5 * shifted) for each in found.stalls},
    )


def moved(given: FinishedSurvey, degrees: float) -> FinishedSurvey:
    """Return a survey that lies farther to the north."""
    outline, ground = (
        replace(each, polygons=tuple(tuple((north + degrees, east) for north, east in ring) for ring in each.polygons))
        for each in (given.outline, given.seen_ground)
    )
    datum = GlobalPose(DATUM.latitude + degrees, DATUM.longitude, 0.0)
    return replace(given, datum=datum, outline=outline, seen_ground=ground)


def few_visits() -> dict[str, list[Visit]]:
    """Three surveys of each drone before the lots are merged, and one after it."""
    return {name: each[:4] for name, each in both_visits(1).items()}


def found(one: OneLot) -> dict[str, float | None]:
    return {each.key: each.value for each in figures([one])}


def test_each_drone_has_six_surveys_of_its_own_with_errors_of_the_receiver() -> None:
    visits = both_visits(3)
    every = [each for name in NAMES for each in visits[name]]
    assert [len(visits[name]) for name in NAMES] == [6, 6]
    assert len({each.bias for each in every}) == len({each.hours for each in every}) == 12
    assert all(math.hypot(*each.bias) <= BIAS_M and not each.repaint and not each.is_next_door for each in every)


@pytest.mark.slow
@pytest.mark.parametrize("is_into_second", [True, *nightly(False)])
def test_the_lots_of_both_become_one_with_one_id_of_each_stall(is_into_second: bool) -> None:
    one = survey_lot("one", few_visits(), look, is_into_second=is_into_second)
    assert one == OneLot("one", 8, both=STALLS, same=STALLS, wrong=0, left=0, is_one=True, doubts=())
    assert (found(one)["same_id"], found(one)["wrong_id"], found(one)["proposed"]) == (1.0, 0.0, 1.0)


@pytest.mark.nightly
def test_an_id_on_the_stall_beside_is_wrong_and_not_the_same() -> None:
    def one_off(visit: Visit) -> Look:
        return look(visit, shifted=visit.number == 3)

    one = survey_lot("one", few_visits(), one_off, is_into_second=False)
    assert one.is_one
    assert (one.both, one.same, one.wrong) == (STALLS + 1, 2, STALLS), "the first and the last have one id"


@pytest.mark.nightly
def test_two_lots_that_nobody_proposes_as_one_have_two_sets_of_ids() -> None:
    visits = few_visits()

    def apart(visit: Visit) -> Look:
        return look(visit, APART_DEG if visit in visits[NAMES[1]] else 0.0)

    one = survey_lot("one", visits, apart, is_into_second=False)
    assert (one.is_one, one.both, one.same, one.wrong) == (False, STALLS, 0, 0)
    assert line(one).endswith("0 left; not proposed as one")
