"""Every tag that decides is compared with a second witness, as the table in docs/photographs.md has it."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hawk.picture.photographs.folder import read_folder
from hawk.picture.values import PictureError, ShotSet
from tests.unit.picture.photographs.photos import DJI, exif, flight, photo, xmp

CANADA, KAZAKHSTAN = (43.26, -79.92), (43.26, 79.92)
PAGE = Path(__file__).parents[4] / "docs" / "photographs.md"


def _one(
    folder: Path, k: int, by_exif: tuple[float, float], by_xmp: tuple[float, float] | None, **changes: Any
) -> None:
    place = (by_exif[0] + 1e-4 * k, by_exif[1])
    tags = dict(DJI)
    if by_xmp is not None:
        tags |= {"drone-dji:GpsLatitude": f"{by_xmp[0] + 1e-4 * k:.7f}", "drone-dji:GpsLongitude": f"{by_xmp[1]:.7f}"}
    photo(folder / f"{k}.jpg", exif(place, **changes), xmp(tags))


def _longitudes(read: ShotSet) -> list[float]:
    return [round(shot.longitude, 2) for shot in read.shots]


def _place_by_letters(path: Path) -> None:
    for k in range(4):
        _one(path, k, KAZAKHSTAN, CANADA, gps={3: None})
    read = read_folder(path)
    assert _longitudes(read) == [-79.92] * 4
    assert any(note.startswith("EXIF and XMP say different places: 0.jpg") for note in read.notes)


def _place_by_neighbours(path: Path) -> None:
    for k in range(4):
        _one(path, k, KAZAKHSTAN if k == 2 else CANADA, CANADA)
    assert _longitudes(read_folder(path)) == [-79.92] * 4
    _one(path, 1, CANADA, KAZAKHSTAN)
    assert _longitudes(read_folder(path)) == [-79.92] * 4


def _place_by_clock(path: Path) -> None:
    for k in range(4):
        _one(path, k, KAZAKHSTAN, CANADA, photo={0x9011: "-04:00"})
    assert _longitudes(read_folder(path)) == [-79.92] * 4
    for k in range(4):
        _one(path, k, KAZAKHSTAN, CANADA, photo={0x9011: "+05:00"})
    assert _longitudes(read_folder(path)) == [79.92] * 4


def _place_asked(path: Path) -> None:
    for k in range(4):
        _one(path, k, KAZAKHSTAN, CANADA)
    with pytest.raises(
        PictureError, match=r"0\.jpg \(and 3 more\): EXIF says .* 79\.92000 E, XMP .* 79\.92000 W.*--place"
    ):
        read_folder(path)
    assert _longitudes(read_folder(path, place="xmp")) == [-79.92] * 4
    assert _longitudes(read_folder(path, place="exif")) == [79.92] * 4


def _place(path: Path) -> None:
    for number, case in enumerate((_place_by_letters, _place_by_neighbours, _place_by_clock, _place_asked)):
        inner = path / str(number)
        inner.mkdir()
        case(inner)


def _height(path: Path) -> None:
    flight(path, 4)
    photo(
        path / "x.jpg",
        exif((46.8404, -91.99), taken="2024:05:01 10:00:35"),
        xmp(DJI | {"drone-dji:RelativeAltitude": "0.00"}),
    )
    assert [shot.height for shot in read_folder(path).shots] == [60.0] * 5, "its altitude is that of the others"
    ground = DJI | {"drone-dji:RelativeAltitude": "0.00"}
    photo(path / "x.jpg", exif((46.8404, -91.99), altitude=100.0, taken="2024:05:01 10:00:35"), xmp(ground))
    assert [each.name for each in read_folder(path).left_out] == ["x.jpg"], "both tags say that it is on the ground"


def _altitude(path: Path) -> None:
    flight(path, 4)
    photo(path / "x.jpg", exif((46.8404, -91.99), altitude=0.0, taken="2024:05:01 10:00:35"), xmp(DJI))
    assert [shot.height for shot in read_folder(path, height_m=50.0).shots] == [50.0] * 5
    bare = xmp({name: value for name, value in DJI.items() if "Altitude" not in name})
    for k, altitude in enumerate((160.0, 160.0, 0.0, 160.0)):
        photo(path / f"DJI_{k:04d}.JPG", exif((46.84 + 1e-4 * k, -91.99), altitude=altitude), bare)
    (path / "x.jpg").unlink()
    read = read_folder(path, height_m=50.0)
    assert [shot.height for shot in read.shots] == [50.0] * 3
    assert [(each.name, each.reason.split(";")[0]) for each in read.left_out] == [
        ("DJI_0002.JPG", "gives no height, the others do")
    ]


def _pitch(path: Path) -> None:
    flight(path, 4)
    tags = {name: value for name, value in DJI.items() if "Yaw" not in name} | {"drone-dji:GimbalPitchDegree": "-40.0"}
    photo(path / "x.jpg", exif((46.8404, -91.99)), xmp(tags))
    read = read_folder(path)
    assert [(each.name, "looks 50 degrees off" in each.reason) for each in read.left_out] == [("x.jpg", True)]
    photo(path / "x.jpg", exif((46.8404, -91.99)), xmp(tags | {"drone-dji:GimbalPitchDegree": "-80.0"}))
    shot = next(shot for shot in read_folder(path).shots if shot.name == "x.jpg")
    assert shot.attitude is not None
    assert shot.attitude[1] == pytest.approx(0.1745, abs=1e-3)
    assert not shot.yaw_is_sure


def _zoom(path: Path) -> None:
    lens = {"drone-dji:CalibratedFocalLength": "60.0", "drone-dji:CalibratedOpticalCenterX": "40.2"}
    flight(path, 2, tags=lens, photo={0xA404: 2.0})
    camera = read_folder(path).shots[0].camera
    assert (camera.fx, camera.fy) == (120.0, 120.0)
    assert camera.cx == pytest.approx(39.5 + 2 * 0.2)


def _size(path: Path) -> None:
    flight(path, 8)
    flight(path, 1, first=20, minute=1, size=(60, 80))
    read = read_folder(path)
    assert len(read.shots) == 8
    assert [each.name for each in read.left_out] == ["DJI_0020.JPG"]
    assert (
        "is of another camera, size, lens or flight than the others (8 of DJI FC330, 80 x 60" in read.left_out[0].reason
    )
    assert "--group 2 maps it" in read.left_out[0].reason
    assert [shot.name for shot in read_folder(path, group=2).shots] == ["DJI_0020.JPG"]


def _light(path: Path) -> None:
    flight(path, 4)
    photo(path / "a.jpg", exif(), xmp(DJI | {"drone-dji:ImageSource": "InfraredCamera"}))
    photo(path / "b.jpg", exif(), xmp(DJI | {"Camera:BandName": "NIR"}))
    photo(path / "c.jpg", exif(make="FLIR", model="Vue Pro R 640"), xmp(DJI))
    photo(path / "d_T.JPG", exif(model="MAVIC2-ENTERPRISE-ADVANCED"), xmp(DJI))
    photo(path / "e_T.JPG", exif(photo={0x9291: "5"}), xmp(DJI | {"drone-dji:ImageSource": "WideCamera"}))
    read = read_folder(path, group=1)
    reasons = {each.name: each.reason for each in read.left_out}
    assert set(reasons) == {"a.jpg", "b.jpg", "c.jpg", "d_T.JPG"}, "a camera that says what it is is believed"
    assert all("is thermal (infrared)" in reasons[name] for name in ("a.jpg", "c.jpg", "d_T.JPG"))
    assert "is the band NIR alone" in reasons["b.jpg"]


def _by_pictures(path: Path) -> None:
    """The pictures are the witness: test_scale.py and reconstruction/test_tilt.py, test_headings.py hold it."""


COMPARED: dict[str, Callable[[Path], None]] = {
    "place": _place,
    "height above the take-off place": _by_pictures,
    "height 0": _height,
    "altitude 0": _altitude,
    "pitch without yaw": _pitch,
    "no angles": _by_pictures,
    "yaw": _by_pictures,
    "focal length": _by_pictures,
    "digital zoom": _zoom,
    "size, camera, lens": _size,
    "kind of light": _light,
}


@pytest.mark.parametrize("tag", COMPARED)
def test_a_tag_that_decides_has_a_second_witness(tag: str, tmp_path: Path) -> None:
    COMPARED[tag](tmp_path)


def test_the_page_names_the_tags_that_are_compared() -> None:
    table = PAGE.read_text(encoding="utf-8").partition("## Tags that are compared")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| ([^|]+) \|", table, re.MULTILINE)
    assert [row for row in rows if row != "tag" and not row.startswith("-")] == list(COMPARED)
