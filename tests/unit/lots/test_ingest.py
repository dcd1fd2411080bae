from __future__ import annotations

import json
import math
import random
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Table, select, update

from hawk.exports import features
from hawk.lots import known_lot, lists
from hawk.lots.ingest import save
from hawk.lots.labels import parts_of
from hawk.lots.plan.queries import all_stalls
from hawk.lots.plan.values import LayoutStall
from hawk.lots.storage.database import Database
from hawk.lots.storage.outlines import outline_of
from hawk.lots.storage.schema import LAYOUT, LOT, OBSERVATION, OUTBOX, STALL, SURVEY
from hawk.lots.storage.tables import pack_stalls, unpack_stalls
from hawk.lots.survey.source import PictureSource, SourceKind
from hawk.lots.values import (
    Detection,
    Doubtful,
    FinishedSurvey,
    KnownGround,
    LotInputError,
    MappedGround,
    Placed,
    Register,
    Registration,
    Saved,
    utc,
)
from hawk.model.lot_map import StallState
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import to_global
from tests.unit.lots.repaints import by_place
from tests.unit.lots.surveys import BEGAN, DATUM, box, later, stall, survey

MOST_BYTES = 40_000


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db")
    yield opened
    opened.close()


def saved(store: Database, given: FinishedSurvey, register: Register | None = None) -> Saved:
    with store.writing() as connection:
        return save(connection, given, register)


def rows(store: Database, table: Table) -> list[dict[str, Any]]:
    with store.reading() as connection:
        return [dict(row) for row in connection.execute(select(table)).mappings()]


def layout(store: Database, lot: str | None) -> dict[str, LayoutStall]:
    assert lot is not None
    with store.reading() as connection:
        return {each.label: each for each in all_stalls(connection, lot)}


@pytest.mark.nightly
@pytest.mark.parametrize("text", ['{"polygons": [[[5', "{}", "[]", '{"polygons": 1, "holes": []}'])
def test_a_damaged_outline_of_another_lot_holds_up_no_survey_and_no_list(store: Database, text: str) -> None:
    first = saved(store, survey())
    datum = GlobalPose(DATUM.latitude + 0.1, DATUM.longitude, 0.0)
    far = replace(survey("000009-20260504T103000Z"), datum=datum, outline=box(-4, -10, 12, 140, datum))
    damaged = saved(store, far)
    assert damaged.lot not in (None, first.lot)
    with store.writing() as connection:
        connection.execute(update(LOT).where(LOT.c.id == damaged.lot).values(outline=text))
    again = saved(store, later(survey(), 1))
    assert (again.lot, again.placed) == (first.lot, Placed.UNREGISTERED)
    here = (DATUM.latitude, DATUM.longitude)
    with store.reading() as connection:
        (near,) = known_lot.lots_flown(connection, here)
        assert near[0][0] == first.lot
        assert [each.id for each in known_lot.lots_ahead(connection, here)] == [first.lot]
        assert lists.lot(connection, str(damaged.lot)).outline == []
        found = features.lots(connection, features.Choice())
        assert {each.id: each.geometry is None for each in found.features} == {
            first.lot: False,
            damaged.lot: True,
        }
        assert features.extent(connection).box is not None


@pytest.mark.slow
def test_a_first_survey_makes_the_lot_its_layout_and_its_labels(store: Database) -> None:
    first = saved(store, survey(stalls=40))
    assert (first.seq, first.placed, first.lot_name) == (1, Placed.FIRST, "Lot 1")
    labels = [f"{row} {number}" for row in "AB" for number in range(1, 21)]
    assert sorted(layout(store, first.lot)) == sorted(labels)
    (lot,) = rows(store, LOT)
    assert (lot["id"], lot["latitude"], lot["longitude"], lot["merged_into"]) == (first.lot, 52.0, 5.0, None)
    (version,) = rows(store, LAYOUT)
    assert (version["lot"], version["version"], version["valid_from"]) == (first.lot, 1, BEGAN)
    seen = {row["stall"]: row for row in rows(store, OBSERVATION)}
    for row in rows(store, STALL):
        found = stall(row["first_id"])
        look = seen[row["key"]]
        assert (look["looked_at"], look["taken_probability"], look["picture_count"]) == (
            found.looked_at,
            found.taken_probability,
            found.picture_count,
        )
        assert look["state"] == found.state
    assert len(seen) == 40
    begun, message, *_ = rows(store, OUTBOX)
    assert json.loads(begun["body"]) == {"lot": first.lot, "version": 1}
    assert json.loads(message["body"]) == {
        "survey": first.survey, "lot": first.lot, "placed": "first", "stalls": 40, "simulated": False,
            "kind": "flown", "ended": utc(BEGAN + 900), "time_is_sure": True,
    }  # fmt: skip


@pytest.mark.slow
def test_a_survey_of_a_known_lot_without_registration_is_kept_with_its_stalls(store: Database) -> None:
    first = saved(store, survey())
    second = saved(store, later(survey(seed=1), 2))
    assert (second.lot, second.placed, second.seq) == (first.lot, Placed.UNREGISTERED, 2)
    assert len(rows(store, OBSERVATION)) == 40
    kept = unpack_stalls(rows(store, SURVEY)[1]["stalls"])
    assert [each.id for each in kept] == list(range(1, 41))
    for each, given in zip(kept, survey(seed=1).stalls, strict=True):
        assert (each.state, each.picture_count) == (given.state, given.picture_count)
        assert math.hypot(each.north - given.north, each.east - given.east) < 0.0071
        assert (each.angle, each.taken_probability) == pytest.approx((given.angle, given.taken_probability), abs=0.0005)
        assert each.looked_at == pytest.approx(given.looked_at, abs=0.051)


@pytest.mark.slow
def test_a_registered_survey_observes_the_lot_s_stalls(store: Database) -> None:
    first = saved(store, survey())
    known = layout(store, first.lot)

    def register(stored: KnownGround, found: MappedGround) -> Registration:
        assert sorted(each.label for each in stored.stalls) == sorted(known)
        assert len(found.stalls) == 40
        return Registration(0.4, -0.2, 0.01, {1: known["A 2"].id, 7: known["B 5"].id})

    second = saved(store, later(survey(seed=1), 2), register)
    assert second.placed is Placed.REGISTERED
    row = rows(store, SURVEY)[1]
    assert (row["placed"], row["layout"]) == ("registered", 1)
    assert [row[name] for name in ("north", "east", "turn")] == pytest.approx([0.4, -0.2, 0.01], abs=1e-6)
    assert (second.known, second.stalls, second.doubt) == (2, 40, "")
    keys = {each["key"]: each["label"] for each in rows(store, STALL)}
    looks = {keys[each["stall"]]: each for each in rows(store, OBSERVATION) if each["survey"] == 2}
    assert {label: look["picture_count"] for label, look in looks.items()} == {
        "A 2": stall(1, 1).picture_count,
        "B 5": stall(7, 1).picture_count,
    }


@pytest.mark.slow
def test_a_registration_that_is_not_certain_leaves_the_survey_unregistered(store: Database) -> None:
    saved(store, survey())
    second = saved(store, later(survey(seed=1), 2), lambda stored, found: Doubtful("two places fit alike"))
    assert (second.placed, second.known, second.doubt) == (Placed.UNREGISTERED, 0, "two places fit alike")
    assert {each["survey"] for each in rows(store, OBSERVATION)} == {1}


def given(number: int, known: LayoutStall, score: float) -> Detection:
    """A stall that the flight took from the plan, found by vision itself from a score of .5."""
    return replace(stall(number, 1), known=known.id, score=score)


@pytest.mark.slow
def test_given_stalls_are_observed_and_only_those_that_vision_found_say_where_the_survey_lies(store: Database) -> None:
    first = saved(store, survey())
    known = layout(store, first.lot)
    stalls = (given(1, known["A 1"], 0.9), given(2, known["A 2"], 0.1), replace(stall(3, 1), id=3))
    asked: list[list[int]] = []

    def register(_: KnownGround, found: MappedGround) -> Registration:
        asked.append([each.id for each in found.stalls])
        return Registration(0.0, 0.0, 0.0, {1: known["A 1"].id, 3: known["A 3"].id})

    second = saved(store, later(replace(survey(), stalls=stalls), 2), register)
    assert asked == [[1, 3]]
    assert second.placed is Placed.REGISTERED
    keys = {each["key"]: each["label"] for each in rows(store, STALL)}
    assert {keys[each["stall"]] for each in rows(store, OBSERVATION) if each["survey"] == 2} == {"A 1", "A 2", "A 3"}


@pytest.mark.slow
def test_a_flight_that_saw_the_plan_in_another_place_is_a_doubt(store: Database) -> None:
    first = saved(store, survey())
    known = layout(store, first.lot)
    stalls = tuple(given(k, known[f"A {k}"], 0.9) for k in range(1, 11))
    shifted = {k: known[f"A {k + 1}"].id for k in range(1, 11)}
    second = saved(store, later(replace(survey(), stalls=stalls), 2), lambda *_: Registration(0.0, 2.5, 0.0, shifted))
    assert (second.placed, second.doubt) == (Placed.UNREGISTERED, "the flight saw the plan in another place")
    assert {each["survey"] for each in rows(store, OBSERVATION)} == {1}


def test_a_stall_keeps_the_id_by_which_the_flight_knew_it() -> None:
    kept = unpack_stalls(pack_stalls((replace(stall(1), known="0" * 36), stall(2))))
    assert [each.known for each in kept] == ["0" * 36, ""]


@pytest.mark.parametrize(("blurred", "count"), [((True, False, True), 2), ((False,) * 3, 0), ((None,) * 3, None)])
def test_a_survey_knows_how_many_stalls_only_blurred_pictures_showed(
    store: Database, blurred: tuple[bool | None, ...], count: int | None
) -> None:
    stalls = tuple(replace(stall(k), is_blurred=each) for k, each in enumerate(blurred, 1))
    saved(store, replace(survey(), stalls=stalls))
    (row,) = rows(store, SURVEY)
    assert row["blurred"] == count
    assert tuple(each.is_blurred for each in unpack_stalls(row["stalls"])) == blurred


def test_stalls_of_a_version_that_measured_no_blur_are_read() -> None:
    table = json.loads(zlib.decompress(pack_stalls((replace(stall(1), is_blurred=True),))))
    del table["is_blurred"]
    (kept,) = unpack_stalls(zlib.compress(json.dumps(table).encode()))
    assert kept.is_blurred is None


def test_stalls_of_a_version_that_knew_no_plan_in_flight_are_read() -> None:
    table = json.loads(zlib.decompress(pack_stalls((stall(1),))))
    del table["known"]
    (kept,) = unpack_stalls(zlib.compress(json.dumps(table).encode()))
    assert kept.known == ""
    assert kept.is_witness


@pytest.mark.slow
def test_a_survey_that_goes_on_keeps_ids_and_labels_and_adds_to_its_rows(store: Database) -> None:
    half = replace(survey(), stalls=survey().stalls[:30])  # the second row to its middle
    first = saved(store, half)
    before = layout(store, first.lot)
    again = saved(store, replace(survey(stalls=60), began=BEGAN + 700))  # it goes on after a battery swap
    after = layout(store, first.lot)
    assert (again.seq, again.survey, again.lot, again.placed) == (1, first.survey, first.lot, Placed.FIRST)
    assert {label: each.id for label, each in after.items() if label in before} == {
        label: each.id for label, each in before.items()
    }
    assert sorted(set(after) - set(before), key=lambda label: parts_of(label) or ("", 0)) == [
        *(f"B {number}" for number in range(11, 21)),
        *(f"C {number}" for number in range(1, 21)),
    ]
    (row,) = rows(store, SURVEY)
    assert (row["began"], row["ended"]) == (BEGAN, BEGAN + 900)
    assert len(rows(store, OBSERVATION)) == 60
    assert outline_of(rows(store, LOT)[0]["outline"]) == outline_of(rows(store, SURVEY)[0]["outline"])


@pytest.mark.slow
def test_a_stall_that_a_survey_gives_up_ends_and_keeps_its_label_for_when_it_is_found_again(store: Database) -> None:
    first = saved(store, survey())
    gone = layout(store, first.lot)["B 20"]
    saved(store, replace(survey(), stalls=survey().stalls[:39]))
    assert "B 20" not in layout(store, first.lot)
    other = replace(stall(40), id=77)
    saved(store, replace(survey(), stalls=(*survey().stalls[:39], other)))
    after = layout(store, first.lot)
    assert "B 20" not in after
    assert after["B 21"].id != gone.id
    saved(store, survey())
    assert layout(store, first.lot)["B 20"].id == gone.id  # it is found again


@pytest.mark.slow
def test_two_lots_that_overlap_the_flight_are_a_question_and_a_near_one_is_too(store: Database) -> None:
    west = saved(store, replace(survey(), outline=box(0, 0, 40, 100)))
    far = later(survey(), 2)
    east = saved(store, replace(far, outline=box(0, 500, 40, 100)))
    assert east.placed is Placed.FIRST
    both = saved(store, replace(later(survey(), 3), outline=box(0, 50, 40, 500)))
    assert (both.lot, both.placed) == (None, Placed.UNDECIDED)
    assert set(both.candidates) == {west.lot, east.lot}
    near = saved(store, replace(later(survey(), 4), outline=box(0, 150, 40, 40)))
    assert (near.placed, near.candidates) == (Placed.UNDECIDED, (west.lot,))
    assert json.loads(rows(store, SURVEY)[3]["candidates"]) == [west.lot]
    assert len(rows(store, LOT)) == 2


@pytest.mark.slow
@pytest.mark.fault(
    "a survey that found nothing is stored",
    "stored without a lot",
)
def test_a_survey_of_nothing_is_stored_and_makes_no_lot(store: Database) -> None:
    nothing = saved(store, survey(stalls=0))
    assert (nothing.lot, nothing.placed) == (None, Placed.NOTHING)
    field = saved(store, replace(later(survey(stalls=0), 2), outline=box(0, 0, 40, 100)))
    assert (field.lot, field.placed) == (None, Placed.NOTHING)
    assert rows(store, LOT) == []
    assert [row["free"] + row["taken"] + row["unknown"] for row in rows(store, SURVEY)] == [0, 0]


@pytest.mark.slow
@pytest.mark.fault(
    "the clock is in 1970, or jumps by a year",
    "surveys keep their order; the time is marked unsure",
)
def test_surveys_keep_their_order_and_a_time_that_goes_back_is_unsure(store: Database) -> None:
    year = 8766.0
    given = [
        replace(survey(), began=0.0, ended=900.0, time_is_sure=False),  # 1970, nothing keeps the clock
        later(survey(), 2),
        later(survey(), 3, hours=-year),  # kept, the clock says, yet a year before the last one
        later(survey(), 4, hours=48),
    ]
    seqs = [saved(store, each).seq for each in given]
    assert seqs == [1, 2, 3, 4]
    assert [row["time_is_sure"] for row in rows(store, SURVEY)] == [False, True, False, True]
    assert [row["origin"].split("-")[0] for row in rows(store, SURVEY)] == ["000001", "000002", "000003", "000004"]


def jagged(seed: int, corners: int = 400) -> Outline:
    """Return ground that pictures of many flight lines leave: a ring of many corners about the lot."""
    drawn = random.Random(seed)
    ring = [
        ((70 + drawn.uniform(-5, 5)) * math.cos(math.tau * n / corners), 70 * math.sin(math.tau * n / corners))
        for n in range(corners)
    ]
    return Outline((tuple((float(a), float(b)) for a, b in to_global(DATUM, np.array(ring))),))


@pytest.mark.nightly
def test_a_stored_survey_of_300_stalls_takes_no_more_than_40_000_bytes(store: Database) -> None:
    first = saved(store, survey(stalls=300))
    known = layout(store, first.lot)
    ids = [known[label].id for label in sorted(known)]

    def register(_: KnownGround, found: MappedGround) -> Registration:
        return Registration(0.0, 0.0, 0.0, dict(enumerate(ids, 1)))

    sizes = []
    for number in range(2, 7):
        flown = later(survey(stalls=300, seed=number), number, hours=number)
        saved(store, replace(flown, seen_ground=jagged(number)), register)
        sizes.append(store.path.stat().st_size)
    assert (sizes[-1] - sizes[0]) / 4 <= MOST_BYTES
    assert len(rows(store, OBSERVATION)) == 6 * 300


@pytest.mark.slow
@pytest.mark.nightly
def test_a_lot_of_20_000_stalls_is_stored_and_read(store: Database) -> None:
    first = saved(store, survey(stalls=20_000))
    assert len(layout(store, first.lot)) == 20_000
    second = saved(store, later(survey(stalls=20_000, seed=1), 2))
    assert second.lot == first.lot
    assert unpack_stalls(rows(store, SURVEY)[1]["stalls"])[19_999].id == 20_000


@pytest.mark.fault("a survey holds numbers that are none")
@pytest.mark.parametrize(
    "name", ["north", "east", "angle", "width", "length", "taken_probability", "score", "looked_at"]
)
def test_a_stall_with_a_number_that_is_none_is_refused_by_name(name: str) -> None:
    changed: dict[str, Any] = {name: math.nan}
    with pytest.raises(LotInputError, match=f"stalls\\[3\\]\\.{name}: must be a finite number, not nan") as refused:
        replace(stall(3), **changed)
    assert refused.value.field == f"stalls[3].{name}"


@pytest.mark.parametrize(
    ("field", "changed"),
    [
        ("datum.latitude", {"datum": GlobalPose(math.nan, 5.0, 0.0)}),
        ("datum.longitude", {"datum": GlobalPose(52.0, math.inf, 0.0)}),
        ("began", {"began": math.inf}),
        ("ended", {"ended": math.nan}),
        ("outline[1]", {"outline": Outline((((52.0, 5.0), (52.0, math.nan), (52.1, 5.0)),))}),
    ],
)
def test_a_survey_with_a_number_that_is_none_is_refused_by_name(field: str, changed: dict[str, Any]) -> None:
    with pytest.raises(LotInputError) as refused:
        replace(survey(), **changed)
    assert refused.value.field == field


def test_a_snapshot_keeps_the_state_that_is_unknown() -> None:
    given = (replace(stall(1), state=StallState.UNKNOWN),)
    assert unpack_stalls(pack_stalls(given))[0].state is StallState.UNKNOWN
    assert unpack_stalls(pack_stalls(())) == ()


@pytest.mark.parametrize("register", [None, by_place])
def test_pictures_mapped_again_with_more_of_them_leave_each_stall_its_id(
    store: Database, register: Register | None
) -> None:
    source = PictureSource(SourceKind.PHOTOGRAPHS, "flight", ())
    whole = replace(survey(stalls=60), pictures=source)
    part = replace(survey(stalls=40), pictures=source)
    first = saved(store, part, register)
    before = layout(store, first.lot)
    numbers = [one.id for one in whole.stalls]
    random.Random(3).shuffle(numbers)
    moved = (replace(one, id=number) for one, number in zip(whole.stalls, numbers, strict=True))
    again = saved(store, replace(whole, stalls=tuple(moved)), register)
    assert (again.survey, again.lot, again.placed) == (first.survey, first.lot, Placed.FIRST)
    after = layout(store, first.lot)
    assert len(after) == 60
    kept = {each.id: (each.north, each.east) for each in after.values()}
    assert {each.id for each in before.values()} < kept.keys()
    for each in before.values():
        assert kept[each.id] == pytest.approx((each.north, each.east))
    places = {(one.north, one.east): one.state for one in whole.stalls}
    keys = {row["key"]: row for row in rows(store, STALL)}
    looks = rows(store, OBSERVATION)
    assert len(looks) == 60
    assert all(look["state"] == places[keys[look["stall"]]["north"], keys[look["stall"]]["east"]] for look in looks)
