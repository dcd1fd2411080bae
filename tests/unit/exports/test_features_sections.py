"""Sections as features of map programs: their ground, their newest look, and how they are chosen."""

from __future__ import annotations

from datetime import datetime

import pytest
import shapely

from hawk.exports.features import Box, Choice, sections
from tests.unit.exports.stored import Stored
from tests.unit.lots.repaints import flown

KERB = {"do": "draw_section", "kind": "across", "outline": [[-3.0, -1.3], [-3.0, 23.7], [3.0, 23.7], [3.0, -1.3]]}
FAR = {"do": "draw_section", "name": "Far", "outline": [[900.0, 0.0], [900.0, 20.0], [920.0, 20.0]], "note": "permit"}


@pytest.mark.slow
def test_sections_are_features_with_their_newest_look(stored: Stored) -> None:
    stored.edit({**KERB, "name": "Row A"}, FAR)
    stored.add(flown(2))
    with stored.store.reading() as connection:
        found = sections(connection, Choice())
        near = sections(connection, Choice(box=Box(4.999, 51.999, 5.001, 52.001)))
        first = sections(connection, Choice(limit=1, offset=1))
        named = sections(connection, Choice(ids=[found.features[0].id]))
        late = sections(connection, Choice(begin=4e9))
    by_name = {each.properties["name"]: each for each in found.features}
    row_a, far = by_name["Row A"], by_name["Far"]
    assert (row_a.properties["capacity"], far.properties["capacity"], far.properties["note"]) == (10, None, "permit")
    assert (far.properties["parked"], far.properties["observed"]) == (None, None)  # no survey saw it
    newest = max(stored.read(each).sections[0].look.observed for each in _surveys(stored))
    assert datetime.fromisoformat(row_a.properties["observed"]) == newest
    assert row_a.geometry is not None
    ring = shapely.geometry.shape(dict(row_a.geometry)).exterior
    assert ring.is_ccw
    assert ring.length == pytest.approx(2 * (25 / 68_700 + 6 / 111_270), rel=0.01)  # degrees at 52 north
    assert (near.features, near.matched) == ([row_a], 1)
    assert (first.features, first.matched) == (found.features[1:], 2)
    assert named.features == found.features[:1]
    assert late.features == []


def _surveys(stored: Stored) -> list[str]:
    with stored.store.reading() as connection:
        return [str(each) for (each,) in connection.exec_driver_sql("SELECT id FROM survey").all()]


@pytest.mark.slow
@pytest.mark.fault("a section's ring is damaged on the disk", "map programs get the other sections")
def test_a_damaged_section_is_passed_over(stored: Stored) -> None:
    stored.edit({**KERB, "name": "Row A"}, FAR)
    with stored.store.writing() as connection:
        connection.exec_driver_sql("UPDATE section SET outline = '7' WHERE name = 'Far'")
    with stored.store.reading() as connection:
        assert [each.properties["name"] for each in sections(connection, Choice()).features] == ["Row A"]
