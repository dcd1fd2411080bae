"""Previews are kept for a while, the newest ones, each for its lot."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from hawk.lots.plan_import.previews import LONGEST_S, MOST, Previews, new_token, shown_preview
from hawk.lots.registration.frames import Move
from hawk.lots.values import LotStoreError
from tests.unit.lots.plan_import.imports import drawn, geojson, importer


def test_a_preview_is_there_until_it_is_taken_too_old_or_one_of_many(tmp_path: Path) -> None:
    person = importer(tmp_path)
    found = person.preview(geojson(drawn(3)))
    kept, tokens = Previews(), [new_token() for _ in range(MOST + 1)]
    kept.keep(tokens[0], found, 100.0)
    assert kept.of(tokens[0], person.lot, 100.0 + LONGEST_S) is found
    for lot, now in ((person.lot, 101.0 + LONGEST_S), (person.lot, 99.0), (None, 100.0), ("other", 100.0)):
        with pytest.raises(LotStoreError, match="import: the preview is gone: send the file again"):
            kept.of(tokens[0], lot, now)
    for token in tokens[1:]:
        kept.keep(token, replace(found), 100.0)
    with pytest.raises(LotStoreError, match="is gone"):
        kept.of(tokens[0], person.lot, 100.0)
    kept.drop(tokens[1])
    with pytest.raises(LotStoreError, match="is gone"):
        kept.of(tokens[1], person.lot, 100.0)


def test_a_preview_shows_its_shift_to_the_millimetre_and_its_turn_in_degrees(tmp_path: Path) -> None:
    found = importer(tmp_path).preview(geojson(drawn(3)))
    shift = Move(1.23456, -2.34567, 0.0123456)
    placed = shown_preview(replace(found, placement=replace(found.placement, shift=shift, residual=-0.45678)), "token")
    shown = placed.placed
    assert (shown.north, shown.east, shown.turn, shown.residual) == (1.235, -2.346, 0.7074, -0.457)
    assert (placed.lot, placed.token, placed.same, len(placed.stay)) == (found.lot, "token", 0, 3)
