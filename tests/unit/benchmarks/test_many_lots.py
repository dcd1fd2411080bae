from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.many_lots import figures, measure
from benchmarks.many_lots_store import fill
from hawk.lots import lists
from hawk.lots.storage.database import Database


@pytest.mark.slow
def test_every_lot_of_a_drawn_store_is_whole_and_listed(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    fill(path, lots=5, surveys=2, size=40)
    store = Database(path)
    assert store.damage == ""
    with store.reading() as connection:
        found = lists.lots(connection, lists.Asked()).items
        assert {(lot.name, lot.survey_count) for lot in found} >= {(f"Lot {n}", 2) for n in range(1, 4)}
        assert {lot.survey_count for lot in found} == {2}
        assert {lot.stalls for lot in found} == {found[0].stalls}
        last = [lot.last_survey for lot in found]
        assert len({survey.id for survey in last if survey is not None}) == 5
    store.close()
    times = measure(path, 5)
    section = figures(times, times)
    keys = {"open_s", "first_s", "list_s", "list_part_s", "map_s", "features_s", "lot_s"}
    assert {each.key for each in section.figures} == keys
    assert {each.ratio for each in section.figures if each.key != "map_s"} == {1.0}
    (shown,) = [each.reference for each in section.figures if each.key == "map_s"]
    assert shown is not None
    assert shown.value == times.seconds["features_s"]
