from __future__ import annotations

import shutil
import time
import tracemalloc
from datetime import UTC, datetime
from pathlib import Path

import pytest

from hawk.picture.photographs.folder import read_folder
from hawk.picture.values import PictureError
from tests.unit.jpegs import jpeg
from tests.unit.picture.photographs.photos import DJI, exif, flight, photo, xmp


def _names(folder: Path, **options: object) -> list[str]:
    return [shot.name for shot in read_folder(folder, **options).shots]  # type: ignore[arg-type]


def test_shots_are_in_the_order_of_their_time(tmp_path: Path) -> None:
    flight(tmp_path, 3)
    (tmp_path / "DJI_0000.JPG").rename(tmp_path / "z.jpg")
    assert _names(tmp_path) == ["z.jpg", "DJI_0001.JPG", "DJI_0002.JPG"]


def test_without_a_clock_they_are_in_the_order_of_their_names(tmp_path: Path) -> None:
    for name, north in (("b.jpg", 46.84), ("a.jpg", 46.8401)):
        photo(tmp_path / name, exif((north, -91.99), photo={0x9003: None}), xmp(DJI))
    assert _names(tmp_path) == ["a.jpg", "b.jpg"]


def test_gnss_time_goes_before_the_clock_where_all_have_it(tmp_path: Path) -> None:
    for k, name in enumerate(("b.jpg", "a.jpg")):
        gps = {7: (9.0, 0.0, float(k)), 29: "2024:05:01"}
        photo(tmp_path / name, exif((46.84 + 1e-4 * k, -91.99), gps=gps), xmp(DJI))
    found = read_folder(tmp_path)
    assert [shot.name for shot in found.shots] == ["b.jpg", "a.jpg"]
    assert found.shots[1].time == pytest.approx((found.shots[0].time or 0.0) + 1.0)
    assert found.time_is_sure


def test_a_group_has_gnss_time_though_another_camera_of_the_folder_has_none(tmp_path: Path) -> None:
    for k, name in enumerate(("b.jpg", "a.jpg")):
        gps = {7: (9.0, 0.0, float(k)), 29: "2024:05:01"}
        photo(tmp_path / name, exif((46.84 + 1e-4 * k, -91.99), gps=gps), xmp(DJI))
    photo(tmp_path / "c.jpg", exif(model="FC6540", photo={0xA405: 24}), xmp(DJI))
    found = read_folder(tmp_path, group=1)
    assert [shot.name for shot in found.shots] == ["b.jpg", "a.jpg"]
    nine = datetime(2024, 5, 1, 9, tzinfo=UTC).timestamp()
    assert [shot.time for shot in found.shots] == [nine, nine + 1.0]
    assert found.time_is_sure
    assert not read_folder(tmp_path, group=2).time_is_sure


@pytest.mark.parametrize(
    ("zones", "is_sure"), [(("+02:00", "+02:00"), True), (("+00:00", None), False), ((None, None), False)]
)
def test_times_are_sure_where_every_clock_says_its_zone(
    tmp_path: Path, zones: tuple[str | None, ...], is_sure: bool
) -> None:
    for k, zone in enumerate(zones):
        tags = {} if zone is None else {0x9011: zone}
        photo(tmp_path / f"{k}.jpg", exif((46.84 + 1e-4 * k, -91.99), photo=tags), xmp(DJI))
    assert read_folder(tmp_path).time_is_sure is is_sure


def test_bad_ones_among_good_ones_are_named_and_the_rest_stays(tmp_path: Path) -> None:
    flight(tmp_path, 4)
    photo(tmp_path / "a_nowhere.jpg", exif(None), xmp(DJI))
    photo(tmp_path / "b_ahead.jpg", exif(), xmp({**DJI, "drone-dji:GimbalPitchDegree": "-20.0"}))
    (tmp_path / "c_torn.jpg").write_bytes((tmp_path / "DJI_0001.JPG").read_bytes()[:-100])
    shutil.copy(tmp_path / "DJI_0002.JPG", tmp_path / "e_double.JPG")
    photo(tmp_path / "d_ground.jpg", exif((46.8399, -91.99)), xmp({**DJI, "drone-dji:RelativeAltitude": "+0.20"}))
    (tmp_path / "notes.txt").write_text("wind from the west")
    (tmp_path / ".hidden.jpg").write_text("no picture")
    found = read_folder(tmp_path)
    assert len(found.shots) == 4
    reasons = {each.name: each.reason for each in found.left_out}
    words = {
        "a_nowhere.jpg": "no GPS",
        "b_ahead.jpg": "70 degrees off",
        "c_torn.jpg": "torn",
        "d_ground.jpg": "on the ground",
        "e_double.JPG": "the place and the time of DJI_0002.JPG",
    }
    assert list(reasons) == list(words)
    assert all(words[name] in reason for name, reason in reasons.items())
    assert found.notes == ("No JPEG, passed over: notes.txt",)


def test_two_flights_are_refused_with_their_counts_and_one_can_be_named(tmp_path: Path) -> None:
    flight(tmp_path, 3)
    flight(tmp_path, 2, first=10, minute=50)
    with pytest.raises(
        PictureError, match=r"2 flights or cameras \(1: 3 of DJI FC330, 80 x 60.*; 2: 2 of .*--group NUMBER"
    ):
        read_folder(tmp_path)
    assert _names(tmp_path, group=1) == ["DJI_0000.JPG", "DJI_0001.JPG", "DJI_0002.JPG"]
    assert _names(tmp_path, group=2) == ["DJI_0010.JPG", "DJI_0011.JPG"]
    with pytest.raises(PictureError, match=r"--group 3: must be 1 to 2"):
        read_folder(tmp_path, group=3)


def test_a_pause_for_a_battery_is_one_flight(tmp_path: Path) -> None:
    flight(tmp_path, 3)
    flight(tmp_path, 2, first=10, minute=40)
    assert len(_names(tmp_path)) == 5


def test_a_place_a_kilometre_off_is_another_flight(tmp_path: Path) -> None:
    flight(tmp_path, 3)
    flight(tmp_path, 3, first=10, minute=2, north=0.0095)
    with pytest.raises(PictureError, match="mixes 2"):
        read_folder(tmp_path)


@pytest.mark.parametrize("change", [{"model": "FC6540"}, {"size": (60, 80)}, {"photo": {0x920A: 17.0}}])
def test_another_camera_size_or_lens_is_another_group(tmp_path: Path, change: dict[str, object]) -> None:
    flight(tmp_path, 3)
    changed = {"photo": {0x920A: 8.8, 0xA405: 24}, **change}
    flight(tmp_path, 2, first=10, minute=1, **changed)
    with pytest.raises(PictureError, match="mixes 2 flights or cameras"):
        read_folder(tmp_path)


def test_nothing_that_can_be_used_is_refused_with_the_reasons(tmp_path: Path) -> None:
    for k in range(3):
        photo(tmp_path / f"{k}.jpg", exif(None), xmp(DJI))
    (tmp_path / "3.jpg").write_bytes(jpeg()[:-9])
    with pytest.raises(
        PictureError, match=r"no photograph can be used: 0\.jpg \(and 2 more\) has no GPS.*; 3\.jpg is torn"
    ):
        read_folder(tmp_path)


def test_a_folder_without_photographs_says_where_to_look(tmp_path: Path) -> None:
    with pytest.raises(PictureError, match="no JPEG photograph is in it; name the folder that holds them"):
        read_folder(tmp_path)
    (tmp_path / "100MEDIA").mkdir()
    with pytest.raises(PictureError, match="name one of its folders: 100MEDIA"):
        read_folder(tmp_path)
    with pytest.raises(PictureError, match="cannot be read"):
        read_folder(tmp_path / "none")


def test_no_height_is_left_to_the_pictures_or_taken(tmp_path: Path) -> None:
    for k in range(3):
        packet = xmp({name: value for name, value in DJI.items() if "Altitude" not in name})
        photo(tmp_path / f"{k}.jpg", exif((46.84 + 1e-4 * k, -91.99), 300.0 + k), packet)
    assert [shot.height for shot in read_folder(tmp_path).shots] == [None] * 3
    assert [shot.height for shot in read_folder(tmp_path, height_m=60.0).shots] == [59.0, 60.0, 61.0]


def test_what_a_person_must_know_is_noted(tmp_path: Path) -> None:
    changed = {306: "2024:05:03 09:00:00", 305: "Windows Photo Viewer", 274: 6}
    for k in range(2):
        found = exif((46.84 + 1e-4 * k, -91.99), model="new", base=changed, photo={0x920A: None, 0xA405: 24})
        photo(tmp_path / f"{k}.jpg", found)
    found_folder = read_folder(tmp_path, height_m=60.0)
    notes = "\n".join(found_folder.notes)
    for words in (
        "guessed from its focal length on 35 mm",
        "straight down is assumed",
        "Windows Photo Viewer",
        "not applied",
    ):
        assert words in notes
    assert not any(shot.yaw_is_sure or shot.lens_is_known for shot in found_folder.shots)


@pytest.mark.slow
@pytest.mark.nightly
def test_3000_photographs_with_20_broken_ones_take_little_time_and_memory(tmp_path: Path) -> None:
    for path in flight(tmp_path, 3000, size=(16, 12))[::150]:
        path.write_bytes(path.read_bytes()[:-10])
    start = time.perf_counter()
    found = read_folder(tmp_path)
    assert time.perf_counter() - start < 60.0
    assert len(found.shots) == 2980
    assert [each.name for each in found.left_out] == [f"DJI_{k:04d}.JPG" for k in range(0, 3000, 150)]
    assert all("torn" in each.reason for each in found.left_out)


@pytest.mark.nightly
def test_a_folder_is_read_without_its_pictures_in_memory(tmp_path: Path) -> None:
    flight(tmp_path, 40, size=(1600, 1200))
    tracemalloc.start()
    read_folder(tmp_path)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 3e6 < sum(path.stat().st_size for path in tmp_path.iterdir())
