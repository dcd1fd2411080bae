from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.picture.photographs.jpeg_head import read_head
from tests.unit.jpegs import jpeg, scan_start
from tests.unit.picture.photographs.photos import DJI, exif, photo, xmp


def test_size_exif_and_xmp_are_read(tmp_path: Path) -> None:
    head = read_head(photo(tmp_path / "a.jpg", exif(), xmp(DJI), (96, 64)))
    assert head.size == (96, 64)
    assert head.exif[:2] in (b"II", b"MM")
    assert b"GimbalYawDegree" in head.xmp


def test_a_thumbnail_s_end_is_not_the_picture_s(tmp_path: Path) -> None:
    """A torn picture keeps the end marker of the thumbnail in its EXIF."""
    whole = jpeg()
    segment = b"Exif\x00\x00II*\x00" + whole[:3000] + b"\xff\xd9"
    torn = whole[:2] + b"\xff\xe1" + (len(segment) + 2).to_bytes(2, "big") + segment + whole[2:-200]
    (tmp_path / "a.jpg").write_bytes(torn)
    with pytest.raises(ValueError, match="torn: its end is missing"):
        read_head(tmp_path / "a.jpg")


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 0.999])
def test_a_picture_that_ends_within_its_scan_is_torn(tmp_path: Path, share: float) -> None:
    whole = jpeg()
    start = scan_start(whole)
    (tmp_path / "a.jpg").write_bytes(whole[: start + int(share * (len(whole) - 2 - start))])
    with pytest.raises(ValueError, match="torn"):
        read_head(tmp_path / "a.jpg")


def test_what_follows_the_picture_is_no_part_of_it(tmp_path: Path) -> None:
    (tmp_path / "a.jpg").write_bytes(jpeg() + b"preview" * 100)
    assert read_head(tmp_path / "a.jpg").size == (320, 240)


@pytest.mark.parametrize("data", [b"", b"\xff", b"text, no picture", b"\x89PNG\r\n\x1a\n"])
def test_other_files_are_no_jpeg(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "a.jpg").write_bytes(data)
    with pytest.raises(ValueError, match="is no JPEG"):
        read_head(tmp_path / "a.jpg")


@settings(max_examples=60, deadline=None)
@given(data=st.binary(max_size=60))
def test_any_bytes_behind_the_start_end_in_a_sentence(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "any.jpg"
    path.write_bytes(b"\xff\xd8" + data)
    with pytest.raises(ValueError, match=r"^(is|has) "):
        read_head(path)
