from __future__ import annotations

from pathlib import Path

import pytest
from sqlalchemy import insert

from hawk.lots.names import SHOWN, chosen_survey, lot_named, schedule_names
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LOT
from hawk.lots.values import LotInputError, NotFoundError, checked_name, fitting_name

DAY_S = 86_400.0
SURVEYS = [(f"{number:02x}aa4c1f-0000-4000-8000-000000000000", number * DAY_S) for number in range(12)]


def test_an_id_or_its_beginning_names_a_survey() -> None:
    assert chosen_survey(SURVEYS, SURVEYS[3][0]) == SURVEYS[3][0]
    assert chosen_survey(SURVEYS, "0b") == SURVEYS[11][0]


def test_a_beginning_of_several_ids_names_them() -> None:
    two = [("af6f0001-1", 0.0), ("af6f0002-2", DAY_S)]
    with pytest.raises(NotFoundError) as raised:
        chosen_survey(two, "af6f", "of this lot")
    assert str(raised.value) == (
        "--survey: 2 surveys of this lot begin with 'af6f': write more of the id; they are "
        "af6f0002-2 of 1970-01-02T00:00:00Z, af6f0001-1 of 1970-01-01T00:00:00Z"
    )


def _row(lot: str, name: object) -> dict[str, object]:
    at = {"latitude": 0.0, "longitude": 0.0, "outline": "{}", "datum_is_pinned": False}
    return {"id": lot, "name": name, "made": 0.0, **at}


def test_an_id_goes_before_a_name_that_is_the_same(tmp_path: Path) -> None:
    store = Database(tmp_path / "lots.db")
    with store.writing() as connection:
        connection.execute(insert(LOT), [_row("a", "North"), _row("b", "a"), _row("c", "South"), _row("d", "South")])
    with store.reading() as connection:
        assert [lot_named(connection, given) for given in ("a", "b", "North")] == ["a", "b", "a"]
        found = schedule_names(connection, ["North", "a", "South", b"\xff"])
    store.close()
    assert found == {"North": "North", "a": "", "South": "", b"\xff": ""}


@pytest.mark.parametrize(
    ("count", "given", "words"),
    [
        (0, "North", "there are none"),
        (2, "North", "there are 'Lot 1', 'Lot 2'"),
        (600, "Lot 77 North", "there are 600, most like it 'Lot 77'"),
        (600, "Ztsch", "there are 600, none like it"),
    ],
)
def test_a_lot_that_is_not_there_is_refused_with_names_like_it(
    tmp_path: Path, count: int, given: str, words: str
) -> None:
    store = Database(tmp_path / "lots.db")
    with store.writing() as connection:
        lots = [_row(f"{k}", f"Lot {k}") for k in range(1, count + 1)]
        if lots:
            connection.execute(insert(LOT), lots)
    with store.reading() as connection, pytest.raises(NotFoundError) as raised:
        lot_named(connection, given)
    store.close()
    assert f"no lot is called {given!r}; {words}" in str(raised.value)
    assert len(str(raised.value)) < 200


def test_without_one_the_newest_surveys_are_listed() -> None:
    with pytest.raises(NotFoundError) as raised:
        chosen_survey(SURVEYS, "zz")
    assert str(raised.value).startswith(
        "--survey: there is no survey 'zz'; the last 10 of 12 are 0baa4c1f of 1970-01-12T00:00:00Z, 0aaa4c1f of "
    )
    assert str(raised.value).count(" of 1970") == SHOWN
    with pytest.raises(NotFoundError, match="--survey: there is no survey 'zz'; there are none"):
        chosen_survey([], "zz")


@pytest.mark.parametrize(
    "name",
    [
        "\u0645\u06cc\u200c\u0631\u0648\u0645",
        "\U0001f468\u200d\U0001f469\u200d\U0001f467",
        "=1+1 <b>",
        "\u05e9\u05dc\u05d5\u05dd",
    ],
)
def test_a_lot_may_have_a_name_of_any_script(name: str) -> None:
    assert checked_name(f" {name} ") == name
    assert fitting_name(name) == name


@pytest.mark.parametrize("name", ["\u202eevil", "a\0b", "\u200d", "\u200c \u200d"])
def test_a_name_that_cannot_be_seen_is_refused(name: str) -> None:
    with pytest.raises(LotInputError, match="cannot be shown"):
        checked_name(name)
