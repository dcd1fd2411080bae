from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from zoneinfo import ZoneInfo

import numpy as np
import pytest
from sqlalchemy import delete, event, select, update

from hawk.exports.records import read_survey
from hawk.exports.text_files import survey_csv, survey_geojson
from hawk.lots.ingest import save
from hawk.lots.plan import edits
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LOOKS, STALL, SURVEY
from hawk.lots.values import FinishedSurvey, KnownGround, LotInputError, MappedGround, NotFoundError, Registration
from hawk.model.lot_map import StallState
from hawk.stats.aggregates import cds_aggregates
from hawk.stats.panel import NO_LOOKS, UNREGISTERED, Period, read_panel
from hawk.stats.period import period_of
from hawk.stats.queries import changes, stalls_use, statistics, surveys_use
from hawk.stats.values import FREE, NO_TIME, TAKEN, UNSEEN
from tests.unit.lots import surveys
from tests.unit.lots.surveys import BEGAN, survey

EVER = Period(None, None, UTC, "UTC")


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db")
    yield opened
    opened.close()


def register(known: KnownGround, found: MappedGround) -> Registration:
    """Take each stall for the one with its number."""
    there = [stall.id for stall in known.stalls]
    return Registration(0.0, 0.0, 0.0, {stall.id: there[stall.id - 1] for stall in found.stalls})


def seen(states: Mapping[int, StallState], stalls: int = 20, **values: object) -> FinishedSurvey:
    """Return a survey whose stalls are free, but those of some numbers."""
    whole = survey(stalls=stalls)
    chance = {StallState.FREE: 0.01, StallState.TAKEN: 0.99, StallState.UNKNOWN: 0.5}
    made = tuple(
        replace(each, state=state, taken_probability=chance[state])
        for each in whole.stalls
        for state in [states.get(each.id, StallState.FREE)]
    )
    return replace(whole, stalls=made, **values)  # type: ignore[arg-type]


def later(given: FinishedSurvey, number: int) -> FinishedSurvey:
    """Return the survey as one of the next day, its looks too."""
    stalls = tuple(replace(stall, looked_at=stall.looked_at + 86_400) for stall in given.stalls)
    return surveys.later(replace(given, stalls=stalls), number)


def lot_of(store: Database, *flown: FinishedSurvey) -> str:
    with store.writing() as connection:
        saved = [save(connection, each, register) for each in flown]
    return saved[0].lot or ""


@pytest.mark.slow
def test_states_and_probabilities_are_those_of_the_observations_by_time(store: Database) -> None:
    first = seen({1: StallState.TAKEN, 2: StallState.UNKNOWN})
    lot = lot_of(store, first, later(seen({3: StallState.TAKEN}), 2))
    with store.reading() as connection:
        found = read_panel(connection, lot, EVER)
    assert found.state[:, :4].tolist() == [[TAKEN, UNSEEN, FREE, FREE], [FREE, FREE, TAKEN, FREE]]
    assert found.taken_probability[0, :3].tolist() == pytest.approx([0.99, 0.5, 0.01])
    assert found.at[1] - found.at[0] == pytest.approx(86_400)
    assert {stall.row for stall in found.stalls} == {"A"}
    assert found.left_out == ()


@pytest.mark.nightly
def test_surveys_whose_place_or_time_is_not_sure_are_left_out_and_named_with_the_reason(store: Database) -> None:
    lot = lot_of(store, seen({}), later(seen({}), 2), later(seen({}), 3), later(seen({}), 4))
    with store.writing() as connection:
        ids = connection.execute(select(SURVEY.c.id).order_by(SURVEY.c.seq)).scalars().all()
        for seq, values in ((2, {"placed": "unregistered"}), (3, {"time_is_sure": False})):
            connection.execute(update(SURVEY).where(SURVEY.c.seq == seq).values(**values))
        connection.exec_driver_sql("DELETE FROM observation WHERE survey = 4")
        found = statistics(connection, lot, EVER)
    assert found.surveys == 1
    assert [(each.survey, each.why) for each in found.left_out] == [
        (ids[1], UNREGISTERED), (ids[2], NO_TIME), (ids[3], NO_LOOKS),
    ]  # fmt: skip


def test_a_period_holds_its_begin_and_not_its_end(store: Database) -> None:
    lot = lot_of(store, seen({}), later(seen({}), 2))
    with store.reading() as connection:
        first, second = read_panel(connection, lot, EVER).at.tolist()
        counts = [
            len(read_panel(connection, lot, Period(begin, end, UTC, "UTC")).surveys)
            for begin, end in ((None, None), (first, second), (first + 1, None), (None, first))
        ]
    assert counts == [2, 1, 1, 0]


def over_midnight(store: Database) -> tuple[str, list[str]]:
    """Store a survey that ended early on 5 May 2026 and looked on 4 May, and one of the noon after it."""
    midnight = datetime(2026, 5, 5, tzinfo=UTC).timestamp()
    flown = []
    for name, ended, looked in (("000001-a", midnight + 120, midnight - 300), ("000002-b", midnight + 43_200, None)):
        stalls = tuple(replace(stall, looked_at=looked or ended) for stall in seen({}).stalls)
        flown.append(replace(seen({}), name=name, began=ended - 900, ended=ended, stalls=stalls))
    lot = lot_of(store, *flown)
    with store.reading() as connection:
        return lot, list(connection.execute(select(SURVEY.c.id).order_by(SURVEY.c.seq)).scalars())


@pytest.mark.nightly
@pytest.mark.parametrize("in_one_piece", [True, False])
def test_a_survey_over_midnight_counts_on_the_day_of_its_looks_alone(store: Database, *, in_one_piece: bool) -> None:
    lot, ids = over_midnight(store)
    with store.writing() as connection:
        if not in_one_piece:
            connection.execute(delete(LOOKS))
        for day, survey_id in (("2026-05-04", ids[0]), ("2026-05-05", ids[1])):
            period = period_of(day, day, "UTC")
            assert [each.id for each in read_panel(connection, lot, period).surveys] == [survey_id]
            listed = surveys_use(connection, lot, period).model_dump(mode="json")["surveys"]
            assert [(each["id"], each["occupancy"]["value"]) for each in listed] == [(survey_id, 0.0)]
            lines = cds_aggregates(read_panel(connection, lot, period)).splitlines()[1:]
            assert [f",{day},{hour}," in line for hour, line in enumerate(lines)] == [True] * 24
            assert sum(not line.endswith(",-1") for line in lines) == 1


def test_looks_may_be_days_before_the_end_of_a_survey(store: Database) -> None:
    lot, ids = over_midnight(store)
    with store.writing() as connection:
        connection.execute(update(SURVEY).where(SURVEY.c.seq == 1).values(ended=SURVEY.c.ended + 5 * 86_400))
        found = read_panel(connection, lot, period_of("2026-05-04", "2026-05-04", "UTC"))
        late = read_panel(connection, lot, period_of("2026-05-06", None, "UTC"))
    assert [each.id for each in found.surveys] == [ids[0]]
    assert (late.surveys, late.left_out) == ((), ())


def test_a_survey_that_is_left_out_belongs_to_the_period_of_its_end(store: Database) -> None:
    lot, ids = over_midnight(store)
    with store.writing() as connection:
        connection.execute(update(SURVEY).where(SURVEY.c.seq == 1).values(time_is_sure=False))
        for day, left_out in (("2026-05-04", []), ("2026-05-05", [ids[0]])):
            period = period_of(day, day, "UTC")
            assert [each.survey for each in read_panel(connection, lot, period).left_out] == left_out
            codes = {
                each["id"]: each["left_out_code"]
                for each in surveys_use(connection, lot, period).model_dump(mode="json")["surveys"]
            }
            assert [each for each, code in codes.items() if code == "no_time"] == left_out


def test_a_stall_counts_in_the_surveys_whose_layout_has_it(store: Database) -> None:
    lot = lot_of(store, seen({}))
    with store.writing() as connection:
        gone = connection.execute(select(STALL.c.id).order_by(STALL.c.key)).scalars().first()
        edit = edits.open_edit(connection, lot, {"who": "Ann"}, 1.0).edit
        edits.do(connection, lot, {"edit": edit, "operation": {"do": "remove", "stalls": [gone]}}, 2.0)
        edits.close(connection, lot, {"edit": edit}, 3.0)
        connection.execute(update(SURVEY).values(layout=1))
        save(connection, later(replace(seen({}), stalls=seen({}).stalls[:19]), 2), register)
        found = read_panel(connection, lot, EVER)
    assert found.is_there.sum(axis=1).tolist() == [20, 19]
    assert found.state[1][~found.is_there[1]].tolist() == [UNSEEN]


def test_a_lot_without_surveys_of_a_period_has_no_figures_and_no_hours(store: Database) -> None:
    lot = lot_of(store, seen({}))
    with store.reading() as connection:
        for by in (None, "hour", "row", "zone", "kind"):
            found = statistics(connection, lot, Period(BEGAN + 9e6, None, UTC, "UTC"), by)
            assert (found.whole, found.surveys, found.first) == (None, 0, None)
            assert all(each.occupancy.value is None for each in found.hours)


def test_zones_have_the_stalls_whose_middle_is_in_them(store: Database) -> None:
    lot = lot_of(store, seen({}), later(seen({1: StallState.TAKEN, 2: StallState.TAKEN}), 2))
    with store.writing() as connection:
        edit = edits.open_edit(connection, lot, {"who": "Ann"}, 1.0).edit
        ring = [[-9, -3], [9, -3], [9, 3.7], [-9, 3.7]]
        operation = {"do": "draw_zone", "name": "Short stay", "kind": "delivery", "outline": ring}
        edits.do(connection, lot, {"edit": edit, "operation": operation}, 2.0)
        edits.close(connection, lot, {"edit": edit}, 3.0)
        found = statistics(connection, lot, EVER, "zone")
    assert [(part.name, part.capacity) for part in found.parts] == [("no zone", 18), ("Short stay", 2)]
    assert found.parts[1].occupancy.value == pytest.approx(0.5, abs=0.01)


def test_changes_between_two_surveys_name_the_stalls(store: Database) -> None:
    lot = lot_of(store, seen({1: StallState.TAKEN, 4: StallState.UNKNOWN}), later(seen({2: StallState.TAKEN}), 2))
    with store.reading() as connection:
        before, after = connection.execute(select(SURVEY.c.id).order_by(SURVEY.c.seq)).scalars().all()
        found = changes(connection, lot, before, after)
        with pytest.raises(LotInputError, match="after: is no survey of this lot"):
            changes(connection, lot, before, "nobody")
    states = [("A 1", "taken", "free"), ("A 2", "free", "taken"), ("A 4", "unknown", "free")]
    assert [(each.label, each.before, each.after) for each in found.stalls] == states
    assert found.stalls[2].chance is None
    assert (found.compared, found.unknown, found.came.value, found.left.value) == (19, 1, 1.0, 1.0)
    assert (found.free.value, found.matched, found.begin, found.gone) == (0.0, 0, (), ())
    assert found.free.low is not None
    assert found.free.high is not None
    assert found.free.low < 0 < found.free.high
    assert found.stalls[0].chance == pytest.approx(0.99 * 0.99, abs=1e-3)


def test_every_list_and_file_stands_in_the_order_of_labels(store: Database) -> None:
    """A row that was numbered from its other end, and one behind Z."""
    lot = lot_of(store, seen(dict.fromkeys(range(1, 21), StallState.TAKEN)), later(seen({}), 2))
    with store.writing() as connection:
        for key in connection.execute(select(STALL.c.key).order_by(STALL.c.key)).scalars().all():
            label = f"E {17 - key}" if key <= 16 else f"AA {key}"
            connection.execute(update(STALL).values(label=label).where(STALL.c.key == key))
        ids = connection.execute(select(SURVEY.c.id).order_by(SURVEY.c.seq)).scalars().all()
        expected = [f"E {number}" for number in range(1, 17)] + [f"AA {number}" for number in range(17, 21)]
        assert [each.label for each in changes(connection, lot, *ids).stalls] == expected
        assert stalls_use(connection, lot, EVER).labels == expected
        survey = read_survey(connection, ids[0])
        assert [row["label"] for row in csv.DictReader(io.StringIO(survey_csv(survey).decode()))] == expected
        features = json.loads(survey_geojson(survey))["features"]
        assert [each["properties"]["ref"] for each in features if "ref" in each["properties"]] == expected


def test_an_unknown_lot_is_refused_by_name(store: Database) -> None:
    lot_of(store, seen({}))
    with store.reading() as connection, pytest.raises(NotFoundError, match="lot: there is no lot with this id"):
        read_panel(connection, "nobody", EVER)


def test_the_same_panel_is_read_once_until_the_store_changes(store: Database) -> None:
    first = seen({1: StallState.TAKEN})
    lot = lot_of(store, first)
    with store.reading() as connection:
        panel = read_panel(connection, lot, EVER)
        assert read_panel(connection, lot, EVER) is panel
        assert read_panel(connection, lot, Period(BEGAN, None, UTC, "UTC")) is not panel
    with pytest.raises(ValueError, match="read-only"):
        panel.taken_probability[0, 0] = 0.5
    lot_of(store, later(seen({2: StallState.TAKEN}), 1))
    with store.reading() as connection:
        assert len(read_panel(connection, lot, EVER).surveys) == 2


@pytest.mark.nightly
@pytest.mark.parametrize("zone", ["UTC", "Asia/Kathmandu"])
@pytest.mark.parametrize(("begin", "end"), [(1, None), (None, 2), (1, 3), (3, 9), (9, 10)])
def test_a_part_of_what_is_kept_is_that_which_is_read_alone(
    store: Database, begin: int | None, end: int | None, zone: str
) -> None:
    unknown, day = {3: StallState.UNKNOWN}, 86_400.0
    flown = [seen({number: StallState.TAKEN, **unknown}) for number in (1, 2, 4, 5, 6)]
    lot = lot_of(store, flown[0], *(later(each, number) for number, each in enumerate(flown[1:], 2)))
    with store.writing() as connection:
        connection.execute(update(SURVEY).where(SURVEY.c.seq == 3).values(time_is_sure=False))
        connection.execute(update(STALL).where(STALL.c.label == "A 2").values(begins=2))
        connection.execute(update(SURVEY).where(SURVEY.c.seq >= 4).values(layout=2))
        ended = connection.execute(select(SURVEY.c.ended).order_by(SURVEY.c.seq)).scalars().first()
    moments = [None if number is None else float(ended or 0) + (number - 0.5) * day for number in (begin, end)]
    part = Period(moments[0], moments[1], ZoneInfo(zone), zone)
    with store.reading() as connection:
        alone = read_panel(connection, lot, part)
        whole = read_panel(connection, lot, EVER)
        found = read_panel(connection, lot, part)
    assert len(whole.surveys) == 4
    assert found is not alone
    for name in ("stalls", "surveys", "left_out", "local_times", "clock", "clock_name", "lot", "name"):
        assert getattr(found, name) == getattr(alone, name)
    for name in ("taken_probability", "state", "is_there"):
        np.testing.assert_array_equal(getattr(found, name), getattr(alone, name))


@pytest.mark.slow
def test_stalls_of_other_layouts_are_left_out_of_a_period(store: Database) -> None:
    lot = lot_of(store, seen({1: StallState.TAKEN, 3: StallState.UNKNOWN}), later(seen({2: StallState.TAKEN}), 2))
    with store.writing() as connection:
        connection.execute(update(STALL).where(STALL.c.label == "A 2").values(begins=2))
        connection.execute(update(SURVEY).where(SURVEY.c.seq == 2).values(layout=2))
        ended = connection.execute(select(SURVEY.c.ended).order_by(SURVEY.c.seq)).scalars().all()
    with store.reading() as connection:
        panel = read_panel(connection, lot, Period(None, ended[0] + 1, UTC, "UTC"))
    assert [stall.label for stall in panel.stalls[:3]] == ["A 1", "A 3", "A 4"]
    assert panel.state[0, :3].tolist() == [TAKEN, UNSEEN, FREE]
    assert panel.taken_probability[0, :3].tolist() == pytest.approx([0.99, 0.5, 0.01])
    assert panel.is_there.all()


def test_a_wider_period_is_read_again_and_then_kept(store: Database) -> None:
    lot = lot_of(store, seen({1: StallState.TAKEN}), later(seen({2: StallState.TAKEN}), 2))
    statements: list[str] = []
    with store.reading() as connection:
        event.listen(connection, "before_cursor_execute", lambda *given: statements.append(given[2]))
        ended = connection.execute(select(SURVEY.c.ended).order_by(SURVEY.c.seq)).scalars().all()
        day = Period(ended[1] - 900, None, UTC, "UTC")
        sizes = [len(read_panel(connection, lot, period).surveys) for period in (day, EVER, day, EVER)]
    assert sizes == [1, 2, 1, 2]
    assert sum("looks.stalls" in each for each in statements) == 2
