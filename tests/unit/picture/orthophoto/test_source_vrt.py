"""Files of which a VRT is made, also by another VRT."""

from __future__ import annotations

from pathlib import Path

from hawk.picture.orthophoto.source import missing_parts, parts_of


def mosaic(path: Path, *names: str, kind: str = "SourceFilename") -> Path:
    """Write what a VRT says of its parts, and nothing else."""
    parts = "".join(f'<{kind} relativeToVRT="1">{name}</{kind}>' for name in names)
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"<VRTDataset>{parts}</VRTDataset>")
    return path


def test_parts_of_parts_are_named_and_what_is_elsewhere_is_not(tmp_path: Path) -> None:
    inner = mosaic(tmp_path / "north" / "a.vrt", "b.tif")
    outer = mosaic(tmp_path / "city.vrt", "north/a.vrt", "/vsizip/a.zip/a.tif", "https://host/a.tif")
    assert parts_of(outer) == [inner, inner.parent / "b.tif"]
    assert missing_parts(parts_of(outer)) == [str(inner.parent / "b.tif")]


def test_the_picture_that_a_warped_one_is_made_of_is_named(tmp_path: Path) -> None:
    inner = mosaic(tmp_path / "city.vrt", "a.tif")
    warped = mosaic(tmp_path / "warped.vrt", "city.vrt", kind="SourceDataset")
    assert parts_of(warped) == [tmp_path / "a.tif", inner]
    assert parts_of(mosaic(tmp_path / "within.vrt", "&lt;VRTDataset/&gt;", kind="SourceDataset")) == []


def test_parts_lie_beside_the_file_and_not_beside_a_link_to_it(tmp_path: Path) -> None:
    path = mosaic(tmp_path / "pictures" / "city.vrt", "a.tif")
    link = tmp_path / "link.vrt"
    link.symlink_to(path)
    assert parts_of(link) == [tmp_path / "pictures" / "a.tif"]


def test_vrts_that_name_each_other_end(tmp_path: Path) -> None:
    one, other = mosaic(tmp_path / "one.vrt", "other.vrt"), mosaic(tmp_path / "other.vrt", "one.vrt", "a.tif")
    assert parts_of(one) == [tmp_path / "a.tif", one, other]


def test_a_file_that_is_no_vrt_has_no_parts(tmp_path: Path) -> None:
    (tmp_path / "a.vrt").write_text("<cut")
    assert missing_parts(parts_of(tmp_path / "a.vrt")) == missing_parts(parts_of(tmp_path / "gone.vrt")) == []
    (tmp_path / "b.tif").write_bytes(b"II*\x00")
    assert parts_of(tmp_path / "b.tif") == []


def test_a_vrt_is_one_by_its_bytes_whatever_its_name_says(tmp_path: Path) -> None:
    assert missing_parts(parts_of(mosaic(tmp_path / "a.tif", "b.tif"))) == [str(tmp_path / "b.tif")]
