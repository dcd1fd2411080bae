"""Surveys of one lot with other cars, registered in the store: the same stalls keep their ids, or a doubt is kept."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from sqlalchemy import select, update

from hawk.algo.registration.likelihood import Placement, StallMap
from hawk.daemon.lots.registration import registration
from hawk.lots import change_log, commands
from hawk.lots.ingest import save
from hawk.lots.plan.queries import all_stalls
from hawk.lots.registration.frames import Move, frame_of
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LOT as LOT_TABLE
from hawk.lots.storage.schema import OBSERVATION, STALL, SURVEY
from hawk.lots.values import (
    Detection,
    Doubtful,
    FinishedSurvey,
    LotInputError,
    LotStoreError,
    Placed,
    PossiblePlace,
    Saved,
)
from hawk.model.lot_map import StallState
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import to_global
from tests.unit.algo.registration.lots import PITCH_M, flown_again, map_of, rows
from tests.unit.lots import whole
from tests.unit.lots.surveys import BEGAN, DATUM

LOT = map_of(rows([14, 9, 12, 6], [0.0, 5.0, 1.5, 14.0]))
ENDLESS = map_of(rows([40]))
STILL = Placement(0.0, (0.0, 0.0), (0.0, 0.0))


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db")
    yield opened
    opened.close()


def rings(datum: GlobalPose, ground: shapely.Geometry) -> Outline:
    parts = [part for part in shapely.get_parts(ground).tolist() if isinstance(part, shapely.Polygon)]
    corners = [to_global(datum, np.array(part.exterior.coords[:-1])) for part in parts]
    return Outline(tuple(tuple((float(a), float(b)) for a, b in ring) for ring in corners))


def survey_of(number: int, found: StallMap, datum: GlobalPose = DATUM) -> FinishedSurvey:
    """Return a survey with a map's stalls about a datum, each free or taken by chance; ids from 1."""
    drawn = np.random.default_rng(number)
    stalls = tuple(
        Detection(
            id=k + 1,
            north=float(found.stalls.centres[k, 0]),
            east=float(found.stalls.centres[k, 1]),
            angle=float(found.stalls.angle[k] % math.pi),
            width=float(found.stalls.width[k]),
            length=float(found.stalls.length[k]),
            taken_probability=round(float(drawn.random()), 3),
            state=StallState.TAKEN if drawn.random() < 0.5 else StallState.FREE,
            score=0.9,
            picture_count=9,
            looked_at=BEGAN + number * 86_400.0,
        )
        for k in range(len(found.stalls))
    )
    began = BEGAN + number * 86_400.0
    return FinishedSurvey(
        name=f"{number:06d}-x", datum=datum, began=began, ended=began + 900, time_is_sure=True,
        outline=rings(datum, found.seen.buffer(-8.0)), stalls=stalls, program="0.3.0",
        seen_ground=rings(datum, found.seen),
    )  # fmt: skip


def saved(store: Database, given: FinishedSurvey) -> Saved:
    with store.writing() as connection:
        return save(connection, given, registration)


def looks(store: Database, seq: int) -> dict[int, float]:
    """Return what a survey saw: the number of the stall in the lot's first survey -> probability of taken."""
    asked = select(STALL.c.first_id, OBSERVATION.c.taken_probability).join(
        OBSERVATION, OBSERVATION.c.stall == STALL.c.key
    )
    with store.reading() as connection:
        return {
            row.first_id: row.taken_probability for row in connection.execute(asked.where(OBSERVATION.c.survey == seq))
        }


def row_of(store: Database, seq: int) -> dict[str, Any]:
    with store.reading() as connection:
        return dict(connection.execute(select(SURVEY).where(SURVEY.c.seq == seq)).mappings().one())


def shown(store: Database, lot: str | None) -> dict[str, Any]:
    with store.reading() as connection:
        return whole.lot(connection, str(lot))


def about_middle(turn_deg: float, shift: tuple[float, float], known: StallMap = LOT) -> Placement:
    north, east = known.stalls.centres.mean(axis=0).tolist()
    return Placement(math.radians(turn_deg), shift, (north, east))


def is_right(looked: dict[int, float], flown: FinishedSurvey, which: np.ndarray) -> bool:
    """True when each look is that of the stall that it was drawn from."""
    truth = {int(which[k]) + 1: flown.stalls[k].taken_probability for k in range(len(which))}
    return all(truth.get(number) == taken for number, taken in looked.items())


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("away", [(0.0, 0.0), (3.0, -2.0), (-12.0, 16.0), (20.0, 22.0)])
def test_other_cars_a_bias_of_gnss_and_a_turn_change_no_id(
    store: Database, away: tuple[float, float], seed: int
) -> None:
    first = saved(store, survey_of(1, LOT))
    bias = about_middle(1.5, (1.2, -1.6))  # brings the survey onto the lot
    found, which = flown_again(LOT, bias, np.random.default_rng(seed))
    ((latitude, longitude),) = to_global(DATUM, np.array([away])).tolist()
    frame = frame_of((latitude, longitude), (DATUM.latitude, DATUM.longitude))
    stalls = replace(found.stalls, centres=frame.of(found.stalls.centres))
    flown = survey_of(
        2, StallMap(stalls, shapely.transform(found.seen, frame.of)), GlobalPose(latitude, longitude, 0.0)
    )
    second = saved(store, flown)
    assert (second.lot, second.placed) == (first.lot, Placed.REGISTERED)
    assert second.known > 0.95 * len(which)
    assert is_right(looks(store, 2), flown, which)
    assert len(looks(store, 2)) == second.known
    row = row_of(store, 2)
    placed = Move(row["north"], row["east"], row["turn"]).of(stalls.centres)
    assert np.abs(placed - LOT.stalls.centres[which]).max() < 0.9
    assert np.abs((placed - LOT.stalls.centres[which]).mean(axis=0)).max() < 0.1


def shifted(shifts: dict[int, float], gone: set[int]) -> tuple[FinishedSurvey, list[int]]:
    """Return a survey whose finds lie on the lot's stalls but for some, off along the row by shares of a pitch.

    Stalls by their numbers in the lot, from 0; those that are ``gone`` have no find. Also the stall of each find.
    """
    left = [k for k in range(len(LOT.stalls)) if k not in gone]
    centres = LOT.stalls.centres.copy()
    for k, share in shifts.items():
        centres[k, 1] += share * PITCH_M
    return survey_of(2, StallMap(replace(LOT.stalls[left], centres=centres[left]), LOT.seen)), left


ROW = range(14, 23)
"""The second row: nine stalls."""


@pytest.mark.nightly
@pytest.mark.parametrize("is_chosen", [False, True])
@pytest.mark.parametrize(
    ("shifts", "gone", "without"),
    [
        ({18: 0.5}, {19}, {18}),  # between two stalls, of which one has another find
        ({18: 0.5}, {17, 19}, {18}),
        ({18: 0.3}, {19}, {18}),  # it overlaps its stall by half, and lies between
        ({18: -0.3}, {17}, {18}),
        ({18: 0.7}, {19}, {18}),  # it overlaps its neighbour by half, whose own find vanished
        ({14: 0.3}, {15}, {14}),  # at the end of a row
        (dict.fromkeys(ROW, 0.5), set(), set(ROW)),  # the row was painted again, half a pitch farther
        (dict.fromkeys(ROW, -0.5), set(), set(ROW)),
        (dict.fromkeys(ROW, 0.3), set(), set()),  # the map errs: all of the row, in its order
        (dict.fromkeys(ROW, 1.0), {22}, set()),  # a pitch farther: each is the stall at its place
        ({}, {18}, set()),  # a neighbour vanished
    ],
)
def test_an_id_never_goes_to_a_neighbour_or_to_what_lies_between_two(
    store: Database, shifts: dict[int, float], gone: set[int], without: set[int], *, is_chosen: bool
) -> None:
    saved(store, survey_of(1, LOT))
    flown, left = shifted(shifts, gone)
    if is_chosen:  # a person says where the survey lies
        with store.writing() as connection:
            doubt = Doubtful("two places fit alike", (PossiblePlace(0.0, 0.0, 0.0, 1.0),))
            second = save(connection, flown, lambda *_: doubt)
            commands.choose(connection, second.survey, {"place": 0}, "somebody", BEGAN)
    elif saved(store, flown).placed is not Placed.REGISTERED:  # no id at all: a whole row is off the others
        assert len(shifts) == len(ROW)
        assert looks(store, 2) == {}
        return
    of = {stall.taken_probability: left[k] for k, stall in enumerate(flown.stalls)}
    whole = 1 if set(shifts.values()) == {1.0} else 0
    for number, taken in looks(store, 2).items():
        assert number - 1 == of[taken] + (whole if of[taken] in shifts else 0)
    expected = len(left) - len(without)
    assert len(looks(store, 2)) == expected


@pytest.mark.slow
def test_half_a_lot_is_that_half_and_the_other_half_is_not_missed(store: Database) -> None:
    first = saved(store, survey_of(1, LOT))
    half = shapely.box(-20, -20, 22, 80)
    found, which = flown_again(LOT, about_middle(0.5, (0.8, 1.5)), np.random.default_rng(2), missed=0.0)
    seen = np.array(shapely.contains_xy(half, found.stalls.centres))
    flown = survey_of(2, StallMap(found.stalls[seen], found.seen.intersection(half)))
    second = saved(store, flown)
    assert (second.placed, second.known) == (Placed.REGISTERED, int(seen.sum()))
    assert is_right(looks(store, 2), flown, which[seen])
    newest = shown(store, first.lot)["newest_registered"]
    assert newest == {"survey": second.survey, "found": [], "missed": []}


def test_the_lot_next_door_is_not_taken_for_this_one(store: Database) -> None:
    saved(store, survey_of(1, LOT))
    other = rows([5, 17, 3, 11], [9.0, 1.0, 20.0, 3.3], pitch=3.1)
    next_door = replace(other, centres=other.centres[:, ::-1].copy(), angle=other.angle + math.pi / 2)
    second = saved(store, survey_of(2, map_of(next_door)))
    assert (second.placed, second.known) == (Placed.UNREGISTERED, 0)
    assert second.doubt
    assert looks(store, 2) == {}


@pytest.mark.nightly
def test_a_survey_saved_again_after_a_battery_swap_keeps_place_and_ids(store: Database) -> None:
    saved(store, survey_of(1, LOT))
    found, which = flown_again(LOT, about_middle(1.0, (0.5, 1.0)), np.random.default_rng(4), missed=0.0)
    half = StallMap(found.stalls[which < 23], found.seen)
    saved(store, survey_of(2, half))
    before = looks(store, 2)
    whole = survey_of(2, found)
    again = saved(store, whole)
    assert (again.seq, again.placed, again.known) == (2, Placed.REGISTERED, len(which))
    assert before.keys() <= looks(store, 2).keys()
    assert is_right(looks(store, 2), whole, which)
    with store.reading() as connection:
        assert len(connection.execute(select(STALL.c.id).distinct()).all()) == len(LOT.stalls)


def test_a_survey_without_its_ground_is_registered_nowhere(store: Database) -> None:
    saved(store, survey_of(1, LOT))
    second = saved(store, replace(survey_of(2, LOT), seen_ground=Outline()))
    assert (second.placed, second.doubt) == (Placed.UNREGISTERED, "the ground that the survey saw is not known")
    with store.writing() as connection:
        connection.execute(update(SURVEY).where(SURVEY.c.seq == 1).values(seen_ground=None))
    third = saved(store, survey_of(3, LOT))
    assert (third.placed, third.doubt) == (Placed.UNREGISTERED, "the ground of the lot's first survey is not known")


def endless(store: Database, known: Callable[[int], int] | None = None) -> tuple[Saved, Saved]:
    """Save two surveys of the middle of a long row: which stall is which is not certain.

    ``known``: number of the plan's stall, along the row, for which the flight took each stall of the second survey.
    """
    within = StallMap(ENDLESS.stalls, shapely.box(-10, 5.5 * PITCH_M, 10, 33.5 * PITCH_M))
    inside = np.array(shapely.contains_xy(within.seen, ENDLESS.stalls.centres))
    middle = StallMap(ENDLESS.stalls[inside], within.seen)
    first = saved(store, survey_of(1, middle))
    moved = about_middle(0.0, (0.0, 0.4), middle)
    found, _ = flown_again(middle, moved, np.random.default_rng(1), missed=0.0)
    second = survey_of(2, found)
    if known is not None:
        with store.reading() as connection:
            plan = sorted(all_stalls(connection, first.lot or ""), key=lambda stall: stall.east)
        along = sorted(second.stalls, key=lambda stall: stall.east)
        given = {stall.id: plan[known(k)].id for k, stall in enumerate(along) if 0 <= known(k) < len(plan)}
        stalls = tuple(replace(stall, known=given.get(stall.id, "")) for stall in second.stalls)
        second = replace(second, stalls=stalls)
    return first, saved(store, second)


@pytest.mark.slow
@pytest.mark.parametrize("steps", [0, 1])
def test_of_two_places_that_fit_alike_the_one_counts_where_the_flight_saw_the_plan(store: Database, steps: int) -> None:
    _, second = endless(store, lambda k: k + steps)
    assert second.placed is Placed.REGISTERED
    assert set(looks(store, 2)) == set(range(1 + steps, 29))


@pytest.mark.nightly
@pytest.mark.parametrize("known", [lambda k: k + 6, lambda k: k + k % 2, lambda k: k if k < 3 else -1])
def test_a_flight_that_saw_the_plan_elsewhere_or_at_few_stalls_settles_no_doubt(
    store: Database, known: Callable[[int], int]
) -> None:
    _, second = endless(store, known)
    assert (second.placed, second.doubt) == (Placed.UNREGISTERED, "two places fit alike")


@pytest.mark.slow
def test_a_row_without_an_end_in_view_waits_for_a_person_who_chooses_a_place_and_undoes_it(store: Database) -> None:
    first, second = endless(store)
    assert (second.placed, second.doubt) == (Placed.UNREGISTERED, "two places fit alike")
    waiting = shown(store, first.lot)["surveys"][1]
    best, other = waiting["doubt"]["places"]
    assert (waiting["place"], waiting["doubt"]["chosen"]) == (None, None)
    apart = math.hypot(best["north"] - other["north"], best["east"] - other["east"])
    assert apart == pytest.approx(PITCH_M, abs=0.5)
    assert best["score"] >= other["score"]
    before = row_of(store, 2)
    with store.writing() as connection:
        done = commands.choose(connection, second.survey, {"place": 1}, "operator", BEGAN)
    placed = shown(store, first.lot)["surveys"][1]
    assert (placed["placed"], placed["doubt"]["chosen"]) == ("registered", 1)
    assert placed["place"] == {name: other[name] for name in ("north", "east", "turn")}
    assert len(looks(store, 2)) >= 26
    with store.writing() as connection, pytest.raises(LotStoreError, match="waits for no place"):
        commands.choose(connection, second.survey, {"place": 0}, "operator", BEGAN)
    with store.writing() as connection:
        assert change_log.undo(connection, done.seq, BEGAN) == "place"
    assert row_of(store, 2) == before
    assert looks(store, 2) == {}


@pytest.mark.slow
def test_a_place_that_a_person_chose_stays_when_the_survey_goes_on(store: Database) -> None:
    _, second = endless(store)
    with store.writing() as connection:
        commands.choose(connection, second.survey, {"place": 1}, "operator", BEGAN)
    before, looked = row_of(store, 2), looks(store, 2)
    _, again = endless(store)
    assert (again.seq, again.placed) == (2, Placed.REGISTERED)
    assert row_of(store, 2) == before
    assert looks(store, 2) == looked


@pytest.mark.nightly
@pytest.mark.parametrize("place", [None, -1, 2, 0.0, True, "0", [0]])
def test_a_place_that_is_not_listed_is_refused_with_its_remedy(store: Database, place: object) -> None:
    _, second = endless(store)
    with store.writing() as connection, pytest.raises(LotInputError) as refused:
        commands.choose(connection, second.survey, {"place": place}, "operator", BEGAN)
    assert (refused.value.field, refused.value.reason) == ("place", "must be the number of one of the places: 0 to 1")


@pytest.mark.nightly
def test_the_datum_of_a_lot_is_the_mean_over_its_surveys_until_it_is_pinned(store: Database) -> None:
    first = saved(store, survey_of(1, LOT))
    assert shown(store, first.lot)["datum"] == pytest.approx([DATUM.latitude, DATUM.longitude], abs=1e-9)
    for number, shift in ((2, (3.0, 0.0)), (3, (0.0, -3.0))):
        flown = replace(LOT.stalls, centres=LOT.stalls.centres + shift)
        assert saved(store, survey_of(number, StallMap(flown, LOT.seen))).placed is Placed.REGISTERED
    middle = to_global(DATUM, np.array([[1.0, -1.0]]))[0].tolist()  # the mean of (0, 0), (3, 0) and (0, -3)
    assert shown(store, first.lot)["datum"] == pytest.approx(middle, abs=2e-6)
    with store.writing() as connection:
        connection.execute(update(LOT_TABLE).values(datum_is_pinned=True))
    assert shown(store, first.lot)["datum"] == [DATUM.latitude, DATUM.longitude]


@pytest.mark.slow
def test_what_the_newest_survey_found_and_missed_is_listed_and_changes_nothing(store: Database) -> None:
    first = saved(store, survey_of(1, LOT))
    before = shown(store, first.lot)["stalls"]
    gone, added = 17, np.array([[52.0, 5.0]])
    kept = np.arange(len(LOT.stalls)) != gone
    more = replace(
        LOT.stalls[kept],
        centres=np.vstack([LOT.stalls.centres[kept], added]),
        angle=np.append(LOT.stalls.angle[kept], 0.0),
        width=np.append(LOT.stalls.width[kept], PITCH_M),
        length=np.append(LOT.stalls.length[kept], 5.2),
    )
    bias = Move(0.9, -1.1, 0.0)
    second = saved(store, survey_of(2, StallMap(replace(more, centres=bias.of(more.centres)), LOT.seen)))
    assert second.placed is Placed.REGISTERED
    after = shown(store, first.lot)
    newest = after["newest_registered"]
    assert [stall["label"] for stall in newest["missed"]] == [
        each["label"] for each in before
        if np.hypot(*(np.array([each["north"], each["east"]]) - LOT.stalls.centres[gone])) < 0.01
    ]  # fmt: skip
    (new,) = newest["found"]
    assert (new["id"], new["north"], new["east"]) == (
        len(more),
        pytest.approx(52.0, abs=0.1),
        pytest.approx(5.0, abs=0.1),
    )
    assert [each["id"] for each in after["stalls"]] == [each["id"] for each in before]


@pytest.mark.slow
def test_a_survey_that_is_moved_to_its_lot_by_a_person_is_registered_there(store: Database) -> None:
    first = saved(store, survey_of(1, LOT))
    found, which = flown_again(LOT, about_middle(1.0, (0.5, 1.0)), np.random.default_rng(5))
    flown = survey_of(2, found)
    ((a, b),) = to_global(DATUM, np.array([[200.0, 0.0]])).tolist()
    beside = rings(GlobalPose(a, b, 0.0), LOT.seen)
    asked = saved(store, replace(flown, outline=beside))
    assert asked.placed is Placed.UNDECIDED
    with store.writing() as connection:
        done = commands.move(connection, asked.survey, {"lot": first.lot}, "operator", BEGAN, registration)
    assert row_of(store, 2)["placed"] == Placed.REGISTERED
    assert is_right(looks(store, 2), flown, which)
    with store.writing() as connection:
        change_log.undo(connection, done.seq, BEGAN)
    assert (row_of(store, 2)["placed"], looks(store, 2)) == (Placed.UNDECIDED, {})
