"""The API keeps its own definition: schemathesis finds nothing in some seconds."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from proving.api.__main__ import RULES, known_ids, main
from proving.api.served import RECORDING, Served, filled


@pytest.mark.slow
@pytest.mark.nightly
def test_nothing_is_found_in_some_seconds() -> None:
    assert main(["--seconds", "10", "--examples", "2", "--seed", "1"]) == 0


def test_the_rules_name_what_the_store_has() -> None:
    rules = tomllib.loads(RULES + known_ids(Served("http://drone", "LOT", "SURVEY", "STALL")))
    given = {each["include-path-regex"]: each["parameters"] for each in rules["operations"]}
    assert given["^/lots/\\{id\\}"] == {"path.id": "LOT"}
    assert given["^/recordings/"] == {"path.name": RECORDING}
    assert 422 in rules["checks"]["positive_data_acceptance"]["expected-statuses"]


@pytest.mark.slow
async def test_the_store_has_surveys_of_one_lot_and_one_whose_time_is_not_sure(tmp_path: Path) -> None:
    from hawk.lots import lists

    store = await filled(tmp_path)
    found = await store.read(lambda connection: lists.lots(connection, lists.Asked()))
    await store.close()
    (lot,) = found.items
    assert lot.last_survey is not None
    assert (lot.stalls, lot.survey_count, lot.last_survey.time_is_sure) == (40, 4, False)
