"""A survey as it is read for an export: ids and labels of the lot, the survey's own looks, and the place on Earth."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from sqlalchemy import select

from hawk.exports.records import NEWEST, read_survey, read_surveys, survey_of
from hawk.lots import commands
from hawk.lots.plan.queries import all_stalls
from hawk.lots.registration.georeference import about
from hawk.lots.registration.survey_place import MAP_M, USUAL_M, datum_accuracy, datum_of
from hawk.lots.storage.schema import LOT
from hawk.lots.values import Doubtful, KnownGround, MappedGround, NotFoundError
from tests.unit.exports.stored import Stored
from tests.unit.lots.repaints import NOW, flown, without


def nowhere(known: KnownGround, found: MappedGround) -> Doubtful:
    return Doubtful("the stalls differ too much")


@pytest.mark.slow
def test_a_survey_has_the_stalls_of_its_lot_with_its_own_looks(stored: Stored) -> None:
    second = stored.add(without(flown(2), 5))
    first, again = stored.read(), stored.read(second.survey)
    assert [stall.id for stall in first.stalls] == [stall.id for stall in again.stalls], "ids last"
    assert [stall.label for stall in again.stalls[:3]] == ["A 1", "A 2", "A 3"]
    assert [stall.state for stall in again.stalls[:4]] == [stall.state.value for stall in flown(2).stalls[:4]]
    assert [stall.picture_count for stall in first.stalls] == [stall.picture_count for stall in flown(1).stalls]
    missed = again.stalls[4]
    assert (missed.state, missed.taken_probability, missed.looked_at, missed.picture_count) == (
        "unknown",
        None,
        None,
        0,
    )
    assert {stall.kind for stall in first.stalls[20:40]} == {"disabled"}
    assert (first.lot, first.lot_id, first.survey) == ("Lot 1", stored.lot, stored.first.survey)
    assert (first.doubt, first.software, first.count("free") + first.count("taken")) == ("", "hawk-drone 0.3.0", 60)


@pytest.mark.slow
def test_surveys_that_are_read_together_are_as_each_alone_and_share_their_layout(stored: Stored) -> None:
    later = stored.add(without(flown(2), 5)), stored.add(flown(3)), stored.add(flown(4), nowhere)
    ids = [stored.first.survey, *(each.survey for each in later)]
    with stored.store.reading() as connection:
        together = read_surveys(connection, ids)
        assert together == [read_survey(connection, each) for each in ids]
        with pytest.raises(NotFoundError, match="there is no survey 0"):
            read_surveys(connection, [ids[0], "0"])
    assert all(a.corners is b.corners for a, b in zip(together[1].stalls, together[2].stalls, strict=True))
    assert together[3].doubt != ""


@pytest.mark.slow
def test_a_survey_has_its_stalls_again_when_a_part_that_was_split_off_is_merged(stored: Stored) -> None:
    before = stored.read()
    corners = [corner for stall in before.stalls if stall.label.startswith("C ") for corner in stall.corners]
    south, west = np.min(corners, axis=0).tolist()
    north, east = np.max(corners, axis=0).tolist()
    part = [[south, west], [south, east], [north, east], [north, west]]
    with stored.store.writing() as connection:
        commands.split(connection, stored.lot, {"name": "South", "outline": part}, "Ann", NOW)
        south_lot = connection.execute(select(LOT.c.id).where(LOT.c.name == "South")).scalar_one()
    assert len(stored.read().stalls) == 40
    with stored.store.writing() as connection:
        commands.merge(connection, stored.lot, south_lot, "Ann", NOW + 1)
    assert [(stall.id, stall.state) for stall in stored.read().stalls] == [
        (each.id, each.state) for each in before.stalls
    ]


@pytest.mark.slow
def test_stalls_lie_where_the_lot_has_them(stored: Stored) -> None:
    survey = stored.read()
    with stored.store.reading() as connection:
        plan, datum = all_stalls(connection, stored.lot), datum_of(connection, stored.lot)
    assert survey.origin == datum
    for stall, planned in zip(survey.stalls, plan, strict=True):
        assert about(datum, np.array([stall.place]))[0, :2] == pytest.approx((planned.north, planned.east), abs=1e-4)
        corners = about(datum, np.array(stall.corners))[:, :2]
        assert corners.mean(axis=0) == pytest.approx((planned.north, planned.east), abs=1e-4)
        front = corners[:2].mean(axis=0) - corners[2:].mean(axis=0)
        assert math.hypot(*front) == pytest.approx(planned.length, abs=1e-4)
        assert math.degrees(math.atan2(front[1], front[0])) % 180 == pytest.approx(stall.direction, abs=1e-3)
        assert shapely.LinearRing(corners[:, ::-1]).is_ccw, "as seen from above"


@pytest.mark.slow
def test_the_place_is_the_surer_the_more_surveys_there_are(stored: Stored) -> None:
    alone = math.hypot(USUAL_M, MAP_M)
    assert stored.read().accuracy == pytest.approx(alone)
    for number in (2, 3, 4):
        stored.add(flown(number))
    assert stored.read().accuracy == pytest.approx(alone / 2)
    with stored.store.reading() as connection:
        assert datum_accuracy(connection, stored.lot) == pytest.approx(alone / 2)


@pytest.mark.slow
def test_a_survey_that_is_not_certain_is_as_it_found_its_stalls_and_says_so(stored: Stored) -> None:
    saved = stored.add(flown(2), nowhere)
    survey = stored.read(saved.survey)
    assert survey.doubt.startswith("unregistered")
    assert [stall.id for stall in survey.stalls[:2]] == ["1", "2"]
    assert {stall.label for stall in survey.stalls} == {""}
    assert (survey.layout, survey.accuracy) == (None, None)


@pytest.mark.slow
def test_a_survey_is_named_by_its_id_or_its_beginning_and_the_newest_is_a_registered_one(stored: Stored) -> None:
    second, doubtful = stored.add(flown(2)), stored.add(flown(3), nowhere)
    with stored.store.reading() as connection:
        assert survey_of(connection, stored.lot) == second.survey
        assert survey_of(connection, stored.lot, doubtful.survey[:13]) == doubtful.survey
        with pytest.raises(NotFoundError, match=r"--survey: there is no survey 'zz' of this lot; there are .* of 20"):
            survey_of(connection, stored.lot, "zz")
        with pytest.raises(NotFoundError, match="there is no survey 5 of a lot"):
            read_survey(connection, "5")
        with pytest.raises(NotFoundError, match="none of the lot's surveys is registered"):
            survey_of(connection, "another", NEWEST)
