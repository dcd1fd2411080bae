"""Files by their first bytes: archives, bombs, and what people send in place of a plan."""

from __future__ import annotations

import pytest

from hawk.lots.plan_files import formats
from hawk.lots.values import LotInputError
from tests.unit.lots.plan_files.files import archive, geojson, labels, numbered, plan


def test_the_one_plan_of_an_archive_is_read() -> None:
    assert labels(plan(archive(plan__geojson=geojson(numbered(2)), readme__txt=b"x"))) == ["P1", "P2"]
    for files, words in (({"readme__txt": b"x"}, "no plan"), ({"a__json": b"{}", "b__dxf": b""}, "2 plans")):
        with pytest.raises(LotInputError, match=f"is an archive with {words} in it: send the one file"):
            plan(archive(**files))


@pytest.mark.fault("a small file with a plan grows without end: an archive, entities of XML, blocks within blocks")
def test_an_archive_that_grows_beyond_the_bound_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(formats, "LARGEST_UNPACKED_BYTES", 1_000_000)
    bomb = archive(plan__geojson=bytes(5_000_000))
    assert len(bomb) < 10_000
    with pytest.raises(LotInputError, match="is too large unpacked"):
        plan(bomb)
    lying = bomb.replace((5_000_000).to_bytes(4, "little"), (1000).to_bytes(4, "little"))
    with pytest.raises(LotInputError, match=r"is too large unpacked|cannot be unpacked"):
        plan(lying)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "is empty: GeoJSON, GeoPackage, KML, DXF"),
        (b"  \n", "is empty"),
        (b"label;lat;lon\n1;52;5\n", "is of no kind that is known"),
        (b"%PDF-1.7", "is a PDF: export the drawing as DXF"),
        (b"\x00\x00\x27\x0a", "is a shapefile: save the layer as GeoPackage"),
        (b"\x1f\x8b\x08", "is packed by gzip"),
        (b"\x89PNG\r\n", "is a PNG picture: export the drawing"),
        (archive(plan__geojson=geojson(numbered(2)))[:60], "cannot be unpacked"),
        (bytes(32_000_001), "is too large: 32 MB are read at most"),
    ],
)
def test_what_is_no_plan_is_refused_with_the_remedy(data: bytes, words: str) -> None:
    with pytest.raises(LotInputError, match=words):
        plan(data)


def test_text_in_utf_16_or_with_a_mark_is_read() -> None:
    text = geojson(numbered(1)).decode()
    assert labels(plan(text.encode("utf-16"))) == ["P1"]
    assert labels(plan(text.encode("utf-8-sig"))) == ["P1"]
