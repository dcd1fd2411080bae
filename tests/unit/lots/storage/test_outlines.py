from __future__ import annotations

import json
import zlib

import pytest

from hawk.lots.storage.outlines import outline_json, outline_of, pack_outline, ring_of, rings_of, unpack_outline
from hawk.model.plans import Outline

RING = ((52.0, 5.0), (52.001, 5.0), (52.001, 5.001))
BAD: list[object] = [
    RING[:2], (*RING, (360.5, 5.0)), (*RING, (52.0, -360.5)), (*RING, (52.0,)), (*RING, (52.0, None)),
    (*RING, (52.0, float("nan"))), 7, None,
]  # fmt: skip
"""Rings that a disk may make of one."""


def test_an_outline_is_read_as_it_was_written_with_eight_decimals() -> None:
    outline = Outline((RING, ((1.123456789, 2.0), (3.0, 4.0), (5.0, -360.0))), (RING,))
    rounded = Outline((RING, ((1.12345679, 2.0), (3.0, 4.0), (5.0, -360.0))), (RING,))
    assert outline_of(outline_json(outline)) == unpack_outline(pack_outline(outline)) == rounded
    assert unpack_outline(None) == Outline()
    assert ring_of(json.dumps([[-1e6, 0.0], [0.0, 1e6], [0.0, 0.0]])) == ((-1e6, 0.0), (0.0, 1e6), (0.0, 0.0))


@pytest.mark.parametrize("ring", BAD)
@pytest.mark.parametrize("name", ["polygons", "holes"])
def test_a_damaged_ring_takes_the_outline_away_and_says_so(
    ring: object, name: str, caplog: pytest.LogCaptureFixture
) -> None:
    text = json.dumps({"polygons": [RING], "holes": [], name: [ring]})
    assert outline_of(text) == unpack_outline(zlib.compress(text.encode())) == Outline()
    assert rings_of(text) == {"polygons": [], "holes": []}
    assert len(caplog.records) == 3
    assert "an outline in the store of lots is damaged" in caplog.text


@pytest.mark.parametrize("text", ["", "{", "[]", "[[0, 0], [1, 1]]", "[[0, 0], [1, 1], [2, 1e7]]", "[" * 100_000])
def test_a_damaged_zone_has_no_ring(text: str) -> None:
    assert ring_of(text) == ()
    assert outline_of(text) == Outline()


def test_data_that_was_cut_has_no_outline() -> None:
    data = pack_outline(Outline((RING,)))
    assert unpack_outline(data[:-6]) == unpack_outline(b"") == Outline()
