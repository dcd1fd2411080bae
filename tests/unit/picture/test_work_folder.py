from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest
import shapely

from hawk.picture.values import PictureError
from hawk.picture.work_folder import SOURCE, WORK, is_ours, keep_stored, kept_source, other_private, other_source


def photographs(folder: Path, *names: str, second: int = 0) -> Path:
    """Write files of one size into a folder, each with a time of its own."""
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).write_bytes(b"picture")
        os.utime(folder / name, (second, second))
    return folder


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """A folder of work on two photographs."""
    work = tmp_path / "out"
    with kept_source(work, photographs(tmp_path / "yard", "1.jpg", "2.JPG")):
        (work / "work").mkdir()
    return work


def test_a_source_that_grew_or_moved_is_the_same(out: Path, tmp_path: Path) -> None:
    yard = photographs(tmp_path / "yard", "3.jpg", second=9)
    assert other_source(out, yard) is None
    (yard / "1.jpg").unlink()
    assert other_source(out, yard.rename(tmp_path / "moved")) is None


def test_another_folder_with_the_same_names_is_another_source(out: Path, tmp_path: Path) -> None:
    other = photographs(tmp_path / "other", "1.jpg", "2.JPG", second=9)
    shutil.copy2(other / "1.jpg", other / "notes.txt")
    assert other_source(out, other) == "yard"


def test_a_card_that_was_flown_with_again_is_another_source(out: Path, tmp_path: Path) -> None:
    assert other_source(out, photographs(tmp_path / "yard", "1.jpg", "2.JPG", second=9)) == "yard"


def test_a_picture_that_was_exported_again_is_the_same_and_a_film_of_the_same_name_is_not(tmp_path: Path) -> None:
    for name, expected in (("yard.tif", None), ("DJI_0001.MP4", "DJI_0001.MP4")):
        folder = photographs(tmp_path, name)
        with kept_source(tmp_path / f"{name}-out", folder / name):
            (tmp_path / f"{name}-out" / "work").mkdir()
        photographs(tmp_path, name, second=9)
        assert other_source(tmp_path / f"{name}-out", folder / name) == expected


def test_without_work_nothing_stays(tmp_path: Path) -> None:
    source, empty = photographs(tmp_path / "yard", "1.jpg"), tmp_path / "empty"
    empty.mkdir()
    for out in (tmp_path / "new" / "out", empty):
        with kept_source(out, source):
            assert is_ours(out)
            assert (out / SOURCE).is_file()
    assert {path.name for path in tmp_path.iterdir()} == {"yard", "empty"}
    assert not any(empty.iterdir())


def test_a_file_that_is_torn_says_no_source(out: Path, tmp_path: Path) -> None:
    (out / SOURCE).write_text('{"source": "a"')
    assert other_source(out, tmp_path / "yard") is None


def test_work_goes_on_with_the_private_ground_that_it_began_with_alone(out: Path, tmp_path: Path) -> None:
    gardens, others = tmp_path / "gardens.geojson", tmp_path / "others.geojson"
    gardens.write_text("{}")
    others.write_text("[]")
    assert other_private(out, None) == ""
    assert other_private(out, gardens) == f"the pictures in {out} show that ground; name another folder by --out"
    with kept_source(out, tmp_path / "yard", gardens):
        pass
    assert other_private(out, gardens) == ""
    same = "name the same file again, or another folder by --out"
    assert other_private(out, None) == f"{out} leaves private ground out; {same}"
    assert (
        other_private(out, others) == f"{out} leaves other ground out; name that file again, or another folder by --out"
    )
    assert other_private(tmp_path / "new", gardens) == ""


def test_work_goes_on_with_the_stored_private_ground_that_it_began_with_alone(out: Path, tmp_path: Path) -> None:
    garden, other, fresh = shapely.box(5, 52, 6, 53), shapely.box(6, 52, 7, 53), tmp_path / "fresh"
    keep_stored(out, [])
    with pytest.raises(PictureError, match=f"^--store: the pictures in {out} were made with other private ground"):
        keep_stored(out, [garden])
    with kept_source(fresh, tmp_path / "yard"):
        keep_stored(fresh, [garden, other])
        (fresh / WORK).mkdir()
    with kept_source(fresh, tmp_path / "yard"):
        keep_stored(fresh, [other, garden])
        with pytest.raises(PictureError, match=r"^--store: .* name that store again, or another folder by --out"):
            keep_stored(fresh, [])
        with pytest.raises(PictureError, match="other private ground than the store's lots have there now"):
            keep_stored(fresh, [other])
    assert other_private(fresh, None) == "", "no file named it"
