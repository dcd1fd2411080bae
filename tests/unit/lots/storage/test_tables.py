from __future__ import annotations

import json
import zlib
from dataclasses import fields, replace

import pytest

from hawk.lots.storage.tables import pack_stalls, unpack_stalls
from hawk.lots.values import WITNESS_SCORE, Detection, LotStoreError
from tests.unit.lots.surveys import BEGAN, stall

EXACT = replace(
    stall(1), north=-1.23, east=40.07, angle=1.2345, width=2.51, length=5.02, taken_probability=0.123, score=0.987,
    looked_at=BEGAN + 0.3, known="a", is_extra=True, is_blurred=True,
)  # fmt: skip


def test_a_packed_stall_is_whole_to_the_centimetre_the_tenth_of_a_milliradian_and_the_thousandth() -> None:
    fine = replace(
        EXACT, north=-1.2337, angle=1.23447, taken_probability=0.12349, score=0.98651, looked_at=BEGAN + 0.26
    )
    assert unpack_stalls(pack_stalls([EXACT, fine])) == (EXACT, replace(EXACT, angle=1.2345))


def test_a_snapshot_of_an_earlier_version_is_read_by_its_own_names() -> None:
    table = json.loads(zlib.decompress(pack_stalls([EXACT])))
    former = {"taken_probability": "taken", "picture_count": "seen", "looked_at": "looked"}
    least = {former.get(name, name): values for name, values in table.items() if name not in LATER}
    (found,) = unpack_stalls(zlib.compress(json.dumps(least).encode()))
    assert found == replace(EXACT, known="", is_extra=False, is_blurred=None)


LATER = ("known", "is_extra", "is_blurred")
"""Columns that the first snapshots had not."""


@pytest.mark.parametrize("data", [b"", zlib.compress(b"[]"), zlib.compress(b"{}"), zlib.compress(b'{"id": [1]}')])
def test_a_snapshot_that_is_none_is_refused(data: bytes) -> None:
    with pytest.raises(LotStoreError, match="the stalls of a survey cannot be read"):
        unpack_stalls(data)


@pytest.mark.parametrize(
    ("known", "score", "is_witness"), [("", 0.0, True), ("a", WITNESS_SCORE, True), ("a", WITNESS_SCORE - 0.01, False)]
)
def test_a_given_stall_is_a_witness_where_the_pictures_show_it(known: str, score: float, is_witness: bool) -> None:
    assert replace(EXACT, known=known, score=score).is_witness is is_witness


def test_a_stall_of_a_map_has_the_values_of_the_detection() -> None:
    on_map = EXACT.on_map()
    assert (on_map.taken, on_map.seen, on_map.last_seen) == (EXACT.taken_probability, EXACT.picture_count, 0.0)
    found = Detection.of(on_map, EXACT.looked_at)
    for each in fields(EXACT):
        if each.name != "is_extra":
            assert getattr(found, each.name) == getattr(EXACT, each.name)
