from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import event, insert, select, update

from hawk.daemon.lots.keeper import find_stalls
from hawk.exports.features import Choice, extent, lots, stalls
from hawk.exports.feeds import valid_at
from hawk.exports.formats import FEEDS, VALID_S, Span
from hawk.exports.records import read_survey, survey_of, surveys_of
from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LOT, OBSERVATION, OUTBOX, STALL, SURVEY
from hawk.lots.survey.order import is_last_look, last_landing, last_of, newest_first, taken_at
from hawk.lots.survey.source import PictureSource, SourceKind, SurveyKind
from hawk.lots.values import FinishedSurvey, Placed, Saved, utc
from hawk.stats.panel import read_panel
from hawk.stats.period import period_of
from hawk.stats.values import NO_TIME, NOT_YET
from tests.unit.lots import whole
from tests.unit.lots.surveys import BEGAN, DATUM, box, later, survey

NOW = BEGAN + 10 * 86_400
IN_2062 = 2_916_000_000.0


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db", wall=lambda: NOW)
    yield opened
    opened.close()


def saved(store: Database, given: FinishedSurvey) -> Saved:
    with store.writing() as connection:
        return save(connection, given, find_stalls)


def pictures(number: int, hours: float) -> FinishedSurvey:
    """Return a survey by photographs of the same lot, some hours after the first landing."""
    source = PictureSource(SourceKind.PHOTOGRAPHS, "flight", ())
    found = later(survey(seed=2), number, hours)
    return replace(found, pictures=source, stalls=tuple(replace(each, looked_at=found.ended) for each in found.stalls))


@pytest.mark.nightly
def test_pictures_of_an_earlier_day_that_are_stored_later_are_not_the_last_survey(store: Database) -> None:
    saved(store, survey())
    last = saved(store, later(survey(seed=2), 2, 48.0))
    earlier = saved(store, pictures(3, 24.0))
    assert last.placed == earlier.placed == Placed.REGISTERED
    assert last.lot is not None
    ended = utc(later(survey(), 2, 48.0).ended)
    with store.reading() as connection:
        lot = whole.lot(connection, last.lot)
        assert lot["last_survey"]["id"] == last.survey
        assert lot["newest_registered"]["survey"] == last.survey
        assert survey_of(connection, last.lot) == last.survey
        assert surveys_of(connection, last.lot)[1] == earlier.survey
        assert [each.properties["surveyed"] for each in lots(connection, Choice()).features] == [ended]
        shown = {stall["id"]: stall["observed"] for stall in lot["stalls"]}
        of_last = OBSERVATION.c.survey.in_(select(SURVEY.c.seq).where(SURVEY.c.id == last.survey))
        looks = STALL.join(OBSERVATION, OBSERVATION.c.stall == STALL.c.key)
        seen = connection.execute(select(STALL.c.id, OBSERVATION.c.looked_at).select_from(looks).where(of_last)).all()
        assert len(seen) > 30
        assert all(shown[stall] == utc(looked) for stall, looked in seen)
        exported = {each.id: each.properties["observed"] for each in stalls(connection, Choice()).features}
        assert all(exported[stall] == utc(looked) for stall, looked in seen)


@pytest.mark.nightly
def test_pictures_of_a_later_day_are_the_last_survey(store: Database) -> None:
    saved(store, survey())
    last = saved(store, pictures(2, 24.0))
    assert last.lot is not None
    with store.reading() as connection:
        assert whole.lot(connection, last.lot)["last_survey"]["id"] == last.survey


@pytest.mark.nightly
def test_a_landing_follows_those_before_it_whatever_its_clock_says(store: Database) -> None:
    saved(store, survey())
    stepped = saved(store, later(survey(seed=2), 2, -1000.0))
    with store.reading() as connection:
        assert stepped.lot is not None
        assert whole.lot(connection, stepped.lot)["last_survey"]["id"] == stepped.survey
    earlier = saved(store, pictures(3, -10.0))
    with store.reading() as connection:
        order = connection.execute(select(SURVEY.c.id).order_by(*newest_first())).scalars().all()
    assert order.index(stepped.survey) == 0
    assert order.index(earlier.survey) == 2


def test_without_pictures_a_look_is_found_by_the_index(store: Database) -> None:
    with store.reading() as connection:
        fast = str(is_last_look(connection))
    saved(store, pictures(1, 0.0))
    with store.reading() as connection:
        exact = str(is_last_look(connection))
    assert "max(" in fast
    assert "ORDER BY" in exact


def of(ended: float, *, is_sure: bool) -> FinishedSurvey:
    """Return pictures of the lot whose files say that moment."""
    found = replace(pictures(9, 0.0), name="of pictures", began=ended - 60.0, ended=ended, time_is_sure=is_sure)
    return replace(found, stalls=tuple(replace(each, looked_at=ended) for each in found.stalls))


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("ended", "is_sure", "why"),
    [
        (NOW - 60.0, False, NO_TIME),  # the file's time: somebody copied an old picture today
        (IN_2062, False, NOT_YET),
        (IN_2062, True, NOT_YET),
    ],
)
@pytest.mark.parametrize("is_stored_before", [False, True])
def test_a_moment_that_is_not_sure_decides_nothing(
    store: Database, ended: float, why: str, *, is_sure: bool, is_stored_before: bool
) -> None:
    flown = saved(store, survey())
    wrong = saved(store, of(ended, is_sure=is_sure))
    assert flown.lot is not None
    with store.writing() as connection:
        if is_stored_before:  # by a program that believed it
            row = SURVEY.c.id == wrong.survey
            connection.execute(update(SURVEY).where(row).values(time_is_sure=is_sure))
        lot = whole.lot(connection, flown.lot)
        assert lot["last_survey"]["id"] == survey_of(connection, flown.lot) == flown.survey
        assert {each["id"]: each["time_is_sure"] for each in lot["surveys"]} == {
            flown.survey: True,
            wrong.survey: False,
        }
        assert {stall["observed"] for stall in lot["stalls"]} <= {utc(each.looked_at) for each in survey().stalls}
        panel = read_panel(connection, flown.lot, period_of(None, None, "UTC"))
        assert [each.id for each in panel.surveys] == [flown.survey]
        assert [(each.survey, each.why) for each in panel.left_out] == [(wrong.survey, why)]
        assert extent(connection).end == max(each for each in (survey().ended, ended) if each <= NOW)
        feed = valid_at(read_survey(connection, wrong.survey), ended + 1.0, VALID_S)
        assert not feed.time_is_sure


@pytest.mark.nightly
@pytest.mark.parametrize("name", [name for name, feed in FEEDS.items() if feed.span is Span.SURVEY])
def test_an_only_survey_whose_moment_is_not_sure_is_no_live_occupancy(store: Database, name: str) -> None:
    lot = saved(store, of(NOW - 60.0, is_sure=False)).lot
    assert lot is not None
    with store.reading() as connection:
        found = valid_at(read_survey(connection, survey_of(connection, lot)), NOW, VALID_S)
    text = json.dumps(FEEDS[name].make(found))
    assert lot in text or name == "cds-zones"  # which names sections alone
    for word in ("realtime_free_capacity", "AVAILABLE", "TAKEN", "availability_time", '"available"', "availableSpot"):
        assert word not in text
    assert not re.search(r'"status": "(free|occupied)"|"has_realtime_data": true|observationDateTime', text)


@pytest.mark.slow
def test_pictures_whose_moment_is_sure_are_last_before_later_ones_that_are_not(store: Database) -> None:
    last = saved(store, pictures(2, 24.0))
    saved(store, of(NOW - 60.0, is_sure=False))
    assert last.lot is not None
    with store.reading() as connection:
        assert survey_of(connection, last.lot) == last.survey


def test_receivers_hear_whether_the_time_is_sure(store: Database) -> None:
    saved(store, of(IN_2062, is_sure=True))
    with store.reading() as connection:
        bodies = [
            json.loads(text)
            for text in connection.execute(select(OUTBOX.c.body).where(OUTBOX.c.kind == "survey")).scalars()
        ]
    assert [each["time_is_sure"] for each in bodies] == [False]


@pytest.mark.slow
def test_a_landing_without_a_sure_time_has_that_of_the_one_before_it_over_its_own_lot(store: Database) -> None:
    first = saved(store, survey())
    away = replace(DATUM, longitude=5.01)
    other = replace(later(survey(), 2, 30.0), datum=away, outline=box(-14, -3, 20, 54, away))
    assert saved(store, other).placed is Placed.FIRST
    unsure = saved(store, replace(later(survey(), 3, 72.0), time_is_sure=False))
    with store.reading() as connection:
        asked = select(taken_at()).order_by(SURVEY.c.seq)
        assert connection.execute(asked).scalars().all() == [survey().ended, other.ended, survey().ended]
    assert first.lot == unsure.lot


_TIMES = st.tuples(st.sampled_from(list(SurveyKind)), st.booleans(), st.sampled_from([-3.0, -2.0, -1.0, 0.0, 1.0, 2.0]))


@pytest.fixture(scope="module")
def rows_of_a_lot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Database]:
    """A store of one lot with one survey, of which others are made."""
    opened = Database(tmp_path_factory.mktemp("order") / "lots.db", wall=lambda: NOW)
    saved(opened, survey())
    yield opened
    opened.close()


@pytest.mark.nightly
@given(st.lists(_TIMES, max_size=12))
def test_the_last_survey_of_a_lot_is_the_first_one_of_those_with_the_newest_first(
    rows_of_a_lot: Database, times: list[tuple[SurveyKind, bool, float]]
) -> None:
    with contextlib.suppress(_DoneError), rows_of_a_lot.writing() as connection:
        first = dict(connection.execute(select(SURVEY)).mappings().one())
        for seq, (kind, is_sure, days) in enumerate(times, 2):
            values = {"seq": seq, "id": str(seq), "origin": str(seq), "kind": kind.value, "time_is_sure": is_sure}
            connection.execute(insert(SURVEY).values(first | values | {"ended": NOW + 86_400 * days}))
        in_order = select(SURVEY.c.seq).where(SURVEY.c.lot == first["lot"]).order_by(*newest_first())
        found = select(last_of(LOT.c.id)).where(LOT.c.id == first["lot"])
        last, expected = (connection.execute(each).scalar() for each in (found, in_order.limit(1)))
        raise _DoneError
    assert last == expected


class _DoneError(Exception):
    """Takes back what was written."""


def test_a_landing_without_a_sure_time_has_that_of_the_sure_landing_before_it_in_its_lot(store: Database) -> None:
    saved(store, survey(stalls=6))
    day = 86_400.0
    others = [
        ("flown, unsure", "flown", False, 1.0),
        ("pictures", "picture", True, 2.0),
        ("flown, unsure again", "flown", False, 9.0),
        ("flown, of another lot", "flown", True, 3.0),
        ("flown, unsure after it", "flown", False, 0.5),
        ("flown, sure", "flown", True, 4.0),
        ("flown, unsure at last", "flown", False, 0.1),
        ("pictures, unsure", "picture", False, 5.0),
        ("pictures, later than now", "picture", False, 11.0),
        ("flown, later than now", "flown", True, 11.0),
    ]
    with store.writing() as connection:
        first = dict(connection.execute(select(SURVEY)).mappings().one())
        for number, (name, kind, is_sure, days) in enumerate(others, 2):
            lot = None if name == "flown, of another lot" else first["lot"]
            more = {"seq": number, "id": f"{number:036d}", "origin": name, "kind": kind, "time_is_sure": is_sure}
            connection.execute(insert(SURVEY).values(**first | more | {"lot": lot, "ended": BEGAN + days * day}))
        rows = connection.execute(select(SURVEY.c.origin, taken_at().label("at"))).all()
        found = {row.origin: row.at for row in rows}
        ordered = connection.execute(select(SURVEY.c.origin).order_by(*newest_first())).scalars().all()
    del found[first["origin"]]
    expected = [first["ended"], BEGAN + 2 * day, first["ended"], BEGAN + 3 * day, first["ended"]]
    expected += [BEGAN + 4 * day, BEGAN + 4 * day, BEGAN + 5 * day, 0.0, BEGAN + 11 * day]
    assert found == dict(zip((name for name, *_ in others), expected, strict=True))
    assert ordered[:3] == ["flown, later than now", "flown, unsure at last", "flown, sure"]
    assert ordered[-2:] == ["pictures, unsure", "pictures, later than now"]


def test_the_last_landing_is_that_of_all_lots_and_of_surveys_without_one(store: Database) -> None:
    with store.writing() as connection:
        assert last_landing(connection, "") is None
        first = save(connection, survey())
        last = save(connection, later(survey(), 2))
        alone = save(connection, later(survey(), 3))
        ends = {seq: float(end) for seq, end in connection.execute(select(SURVEY.c.seq, SURVEY.c.ended))}
        origins = {seq: str(origin) for seq, origin in connection.execute(select(SURVEY.c.seq, SURVEY.c.origin))}
        connection.execute(update(SURVEY).where(SURVEY.c.seq == alone.seq).values(lot=None))
        assert last_landing(connection, "") == ends[alone.seq]
        assert last_landing(connection, origins[alone.seq]) == ends[last.seq], "but for the survey itself"
        connection.execute(update(SURVEY).where(SURVEY.c.seq == last.seq).values(time_is_sure=False))
        picture = SurveyKind.PICTURE.value
        connection.execute(update(SURVEY).where(SURVEY.c.seq == alone.seq).values(kind=picture))
        assert last_landing(connection, "") == ends[first.seq], "neither unsure times nor pictures"


def test_no_question_about_the_newest_reads_all_surveys(store: Database) -> None:
    """A store has a million surveys of 10 kB: questions at each landing and page read the index of the order alone."""
    asked: list[tuple[str, object]] = []

    def note(_: object, __: object, statement: str, parameters: object, *___: object) -> None:
        asked.append((statement, parameters))

    with store.writing() as connection:
        event.listen(connection, "before_cursor_execute", note)
        last_landing(connection, "a flight")
        is_last_look(connection)
        event.remove(connection, "before_cursor_execute", note)
        assert len(asked) == 3
        for statement, parameters in asked:
            plan = connection.exec_driver_sql(f"EXPLAIN QUERY PLAN {statement}", parameters)  # type: ignore[arg-type]
            steps = [row.detail for row in plan if "survey" in row.detail]
            assert steps
            assert all(step.startswith("SEARCH survey USING") and "ix_survey_order" in step for step in steps), steps
