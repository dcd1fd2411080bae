"""A lot of 20,000 stalls in every format."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import islice
from pathlib import Path

import pyogrio
import pytest

from hawk.exports.files import TABLES
from hawk.exports.formats import FEEDS, Span
from hawk.exports.values import ExportRecord
from hawk.results.row_labels import letters
from tests.examples import nightly
from tests.unit.exports.stored import Stored

STALLS = 20_000
A_ROW = 100
ROW_DEG = 0.0002
STALL_DEG = 0.00004


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> ExportRecord:
    stored = Stored(tmp_path_factory.mktemp("large"))
    survey = stored.read()
    stored.store.close()
    one = survey.stalls[0]
    made, names = [], list(islice(letters(), STALLS // A_ROW))
    for number in range(STALLS):
        row, place = divmod(number, A_ROW)
        north, east = row * ROW_DEG, place * STALL_DEG
        corners = tuple((a + north, b + east) for a, b in one.corners)
        middle = (one.place[0] + north, one.place[1] + east)
        made.append(replace(one, id=f"{number:036d}", label=f"{names[row]} {place + 1}", place=middle, corners=corners))
    return replace(survey, stalls=tuple(made))


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("suffix", "layer"), [(".geojson", None), (".gpkg", "stalls"), *nightly((".csv", None), (".kmz", None))]
)
def test_every_stall_is_in_the_file(large: ExportRecord, tmp_path: Path, suffix: str, layer: str | None) -> None:
    path = tmp_path / f"lot{suffix}"
    path.write_bytes(TABLES[suffix](large))
    assert path.stat().st_size < 30_000_000
    found = pyogrio.read_info(path, layer=layer, force_feature_count=True)
    assert found["features"] - STALLS in (0, 1), "GeoJSON has the lot, too"


@pytest.mark.nightly
@pytest.mark.parametrize(
    "name", ["cds", *nightly(*(name for name, feed in FEEDS.items() if feed.span is Span.SURVEY and "cds" not in name))]
)
def test_every_stall_is_in_the_feed(large: ExportRecord, name: str) -> None:
    text = json.dumps(FEEDS[name].make(large))
    assert len(text) < 40_000_000
    assert all(f"{number:036d}" in text for number in range(0, STALLS, 997))
