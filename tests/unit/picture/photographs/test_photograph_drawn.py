"""All that is read of photographs of many makers, and of flights of them: values, lenses, heights, notes, refusals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from PIL import Image

from hawk.model.pictures import CameraModel
from hawk.picture.photographs import places, tags
from hawk.picture.photographs.exif import Exif, read_exif
from hawk.picture.photographs.folder import read_folder
from hawk.picture.photographs.heights import assign_heights, doubt_of, guess_heights
from hawk.picture.photographs.lenses import Lenses
from hawk.picture.photographs.photograph import Photograph, other_light
from hawk.picture.values import PictureError, Shot
from tests.golden import check_values
from tests.unit.picture.photographs.photos import DJI, exif, flight, photo, xmp

HERE = Path(__file__).parent / "drawn"
CAMERA = CameraModel(80, 60, 60.0, 60.0, 39.5, 29.5)
Json = dict[str, Any]


def said(read: Callable[..., Any], *given: Any) -> Any:
    """Return what is read, as JSON with 9 decimals, or the words of the refusal."""
    try:
        return _plain(read(*given))
    except (ValueError, PictureError) as refused:
        return f"{type(refused).__name__}: {refused}"


def _plain(value: Any) -> Any:
    if isinstance(value, Shot):
        return _plain([value.name, value.height, value.altitude])
    if isinstance(value, Photograph):
        return _plain([value.shot.name, value.shot.latitude, value.shot.longitude])
    if hasattr(value, "__dataclass_fields__"):
        value = asdict(value)
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return round(value, 9) if isinstance(value, float) else value


SKYDIO, ALBUM = "drone-skydio:", "Camera:"
TAGS: dict[str, dict[str, str]] = {
    "dji": DJI | {"drone-dji:GimbalRollDegree": "+1.5", "drone-dji:GimbalPitchDegree": "-88.0"},
    "dji past down": DJI | {"drone-dji:GimbalRollDegree": "180", "drone-dji:GimbalPitchDegree": "-92"},
    "dji rtk": DJI | {"drone-dji:RtkStdLon": "0.012", "drone-dji:RtkStdLat": "0.02", "drone-dji:RtkStdHgt": "0.03"},
    "dji finer than any": DJI
    | {"drone-dji:RtkStdLon": "0.001", "drone-dji:RtkStdLat": "0", "drone-dji:RtkStdHgt": "0"},
    "dji without yaw": {name: each for name, each in DJI.items() if "Yaw" not in name},
    "dji places": {"drone-dji:GpsLatitude": "46.5", "drone-dji:GpsLongtitude": "-91.5"},
    "autel": {"drone:RelativeAltitude": "31.5", "drone:GimbalPitchDegree": "-90", "drone:GimbalYawDegree": "350"},
    "parrot": {
        f"drone-parrot:Camera{name}Degree": each for name, each in (("Pitch", "-89"), ("Yaw", "12"), ("Roll", "3"))
    }
    | {
        f"{ALBUM}AboveGroundAltitude": "40.5",
        f"{ALBUM}IMULinearVelocity": "1.5,-2.5,0",
        f"{ALBUM}LineReadoutTime": "30000",
    },
    "pix4d": {f"{ALBUM}Yaw": "33", f"{ALBUM}Pitch": "2", f"{ALBUM}Roll": "-4", f"{ALBUM}GPSXYAccuracy": "1.25"},
    "pix4d heights": {
        f"{ALBUM}GPSZAccuracy": "2.5",
        f"{ALBUM}IMULinearVelocity": "nan,1",
        f"{ALBUM}LineReadoutTime": "-5",
    },
    "skydio": {
        f"{SKYDIO}CameraOrientationNED/{SKYDIO}{name}": each for name, each in (("Pitch", "-90"), ("Yaw", "-170"))
    }
    | {
        f"{SKYDIO}GpsHorizontalAccuracy": "0.8",
        f"{SKYDIO}GpsVerticalAccuracy": "1.1",
        f"{SKYDIO}AbsoluteAltitude": "99",
    },
    "nothing": {},
}


def test_tags_of_every_maker() -> None:
    found = {}
    for name, given in TAGS.items():
        for make in ("DJI", "senseFly")[: 2 if name == "pix4d" else 1]:
            found[f"{name}, {make}"] = [
                said(read, given, *more)
                for read, *more in (
                    (tags.attitude, make),
                    (tags.tilt_alone, make),
                    (tags.has_gimbal,),
                    (tags.velocity,),
                    (tags.line_s,),
                    (tags.height,),
                    (tags.altitude,),
                    (tags.place,),
                    (tags.sigma,),
                )
            ]
    check_values(HERE / "tags.json", found, digits=9)


EXIF: dict[str, Json] = {
    "whole": {"gps": {31: 3.5, 7: (10.0, 20.0, 30.5), 29: "2024:05:01"}, "base": {274: 3}},
    "below the sea": {"altitude": -12.5, "place": (-33.5, 151.25)},
    "no letters": {"gps": {1: None}},
    "no fix": {"gps": {9: "V"}},
    "south by a word": {"gps": {1: "south"}},
    "degrees alone": {"gps": {2: (46.5,)}},
    "beyond": {"gps": {4: (180.5, 0.0, 0.0)}},
    "at the pole": {"gps": {2: (90.0, 0.0, 0.0)}},
    "clock": {"photo": {0x9011: "-05:30", 0x9291: "125"}},
    "no zone": {"photo": {0x9011: "x", 0x9291: "a1"}},
    "saved in a minute": {"base": {306: "2024:05:01 10:01:00", 305: "x"}},
    "saved later": {"base": {306: "2024:05:01 10:01:01", 305: "Editor\x00 9"}},
    "focal lengths": {"photo": {0x920A: 0.0, 0xA405: 24, 0xA404: 0.5}},
    "zoom": {"photo": {0xA404: 2.5}},
    **{
        f"plane {unit}": {"photo": {0xA20E: 400.0, 0xA210: unit, 0xA002: 5472, 0xA003: 3648}}
        for unit in (1, 2, 3, 4, 5)
    },
    "plane of 2 mm": {"photo": {0xA20E: 2000.0, 0xA210: 4}},
    "plane of 70 mm": {"photo": {0xA20E: 57.142857, 0xA210: 4}},
    "plane beyond": {"photo": {0xA20E: 57.0, 0xA210: 4}},
    "gnss in part": {"gps": {7: (10.0, 20.0), 29: "2024:05:01"}},
}


def _exif(found: Image.Exif) -> Exif:
    return read_exif(found.tobytes().removeprefix(b"Exif\x00\x00"), 4000)


def test_exif_of_many_files() -> None:
    found = {name: said(_exif, exif(**given)) for name, given in EXIF.items()}
    check_values(HERE / "exif.json", found | {"none": said(read_exif, b"", 4000)}, digits=9)


LENSES: dict[str, tuple[dict[str, str], Exif, tuple[int, int]]] = {
    "table": ({}, Exif(make="DJI", model="FC330", focal_mm=3.61), (4000, 3000)),
    "table, upright": ({}, Exif(make="DJI", model="FC330", focal_mm=3.61), (3000, 4000)),
    "table, cut": ({}, Exif(make="DJI", model="FC330", focal_mm=3.61), (4096, 2160)),
    "table, zoomed": ({}, Exif(make="DJI", model="fc330 ", focal_mm=3.61, zoom=2.0), (4000, 3000)),
    "plane": ({}, Exif(focal_mm=10.0, sensor_mm=13.2), (5472, 3648)),
    "film": ({}, Exif(focal_35_mm=24.0), (4000, 3000)),
    "film, wide": ({}, Exif(focal_35_mm=24.0), (4000, 2250)),
    "film, 1.6": ({}, Exif(focal_35_mm=24.0), (1600, 1000)),
    "film, 1.61": ({}, Exif(focal_35_mm=24.0), (1610, 1000)),
    "nothing": ({}, Exif(make="X", model="Y"), (4000, 3000)),
    "fisheye": ({"Camera:ModelType": "Fisheye"}, Exif(), (4000, 3000)),
    "too wide": ({}, Exif(focal_mm=3.4, sensor_mm=10.0), (1000, 750)),
    "wide": ({}, Exif(focal_mm=3.5, sensor_mm=10.0), (1000, 750)),
    "tele": ({}, Exif(focal_mm=150.0, sensor_mm=10.0), (1000, 750)),
    "too long": ({}, Exif(focal_mm=151.0, sensor_mm=10.0), (1000, 750)),
    "dji": (
        {
            "drone-dji:CalibratedFocalLength": "3666.6",
            "drone-dji:CalibratedOpticalCenterX": "2736.0",
            "drone-dji:CalibratedOpticalCenterY": "1824.0",
        },
        Exif(),
        (5472, 3648),
    ),
    "dji, half": ({"drone-dji:CalibratedFocalLength": "3666.6"}, Exif(zoom=1.5), (2736, 1824)),
    "dewarp": (
        {"drone-dji:DewarpData": "2024-01-01;3700,3701,-9.5,7.25,-0.1,0.02,1e-4,-2e-4,0.003"},
        Exif(),
        (5280, 3956),
    ),
    "dewarp, turned": (
        {
            "drone-dji:DewarpData": "d;3700,3701,-9,7,-0.1,0.02,1e-4,-2e-4,0.003",
            "drone-dji:CalibratedOpticalCenterX": "2640",
            "drone-dji:CalibratedOpticalCenterY": "1978",
        },
        Exif(zoom=2.0),
        (3956, 5280),
    ),
    "dewarped": (
        {"drone-dji:DewarpData": "d;3700,3701,0,0,1,1,1,1,1", "drone-dji:DewarpFlag": "1"},
        Exif(),
        (5280, 3956),
    ),
    "skydio": (
        {
            f"{SKYDIO}CalibratedFocalLengthX": "3030",
            f"{SKYDIO}CalibratedOpticalCenterX": "2027.5",
            f"{SKYDIO}CalibratedOpticalCenterY": "1519.5",
            f"{SKYDIO}DewarpData": "0.1,0.2",
        },
        Exif(),
        (2028, 1520),
    ),
    "pix4d": (
        {
            "Camera:PerspectiveFocalLength": "4.88",
            "Camera:PrincipalPoint": "3.1,2.3",
            "Camera:PerspectiveDistortion": "0.1,-0.2,0.3,1e-4,2e-4",
        },
        Exif(sensor_mm=6.17),
        (4608, 3456),
    ),
    "pix4d, no middle": ({"Camera:PerspectiveFocalLength": "4.88"}, Exif(sensor_mm=6.17), (3456, 4608)),
}


def test_lenses_of_many_sources() -> None:
    table = Lenses()
    found = {name: said(table.of, *given) for name, given in LENSES.items()}
    films = [("FC330", (3840, 2160)), ("FC3582", (1920, 1080)), ("FC8482", (3840, 2160)), ("unknown", (1920, 1080))]
    found["films"] = [said(table.of_film, *film) for film in films]
    check_values(HERE / "lenses.json", found, digits=9)


def _shots(*levels: tuple[float | None, float | None]) -> list[Shot]:
    return [
        Shot(Path("abcdefg"[k]), CAMERA, 46.0, -91.0, altitude, height, None, (2.0, 3.0), None)
        for k, (height, altitude) in enumerate(levels)
    ]


LEVELS: dict[str, tuple[list[Shot], float | None]] = {
    "own": (_shots((60.0, 160.0), (61.0, 161.0), (2.99, 103.0), (3.0, 103.0)), None),
    "some by altitude": (_shots((60.0, 160.0), (None, 163.0), (None, None), (62.0, 162.5)), None),
    "zeros": (_shots((0.0, 160.0), (61.0, 161.0), (62.0, 0.0), (0.0, 102.9)), None),
    "altitudes of 0 by the sea": (_shots((60.0, 0.0), (61.0, 9.0), (62.0, 10.0)), None),
    "altitudes of 0 above it": (_shots((60.0, 0.0), (61.0, 11.0), (62.0, 10.5)), None),
    "none": (_shots((None, 100.0), (None, 110.0), (None, None)), None),
    "one": (_shots((None, None)), None),
    "too high": (_shots((60.0, 160.0), (500.5, None)), None),
    "high": (_shots((60.0, 160.0), (500.0, None)), None),
    "altitudes": (_shots((312.4, 312.414), (313.1, 313.1)), None),
    "near": (_shots((312.4, 312.416), (313.1, 313.1)), None),
    "given": (_shots((60.0, 160.0), (70.0, 170.0), (0.0, 100.0)), 80.0),
    "given to all": (_shots((None, None), (None, None)), 80.0),
    "given 0": (_shots((60.0, 160.0)), 0.0),
    "given 500": (_shots((60.0, 160.0)), 500.0),
    "given 501": (_shots((60.0, 160.0)), 501.0),
    "given the altitude": (_shots((40.0, 163.0)), 160.0),
    "given near it": (_shots((40.0, 163.1)), 160.0),
    "given twice its own": (_shots((80.0, 160.0)), 160.0),
    "given by altitude": (_shots((None, 160.0), (None, 170.0)), 50.0),
}


def test_heights_of_flights() -> None:
    found = {
        name: [said(assign_heights, shots, given), doubt_of(shots), said(guess_heights, shots)]
        for name, (shots, given) in LEVELS.items()
    }
    check_values(HERE / "heights.json", found, digits=9)


def test_places_that_differ() -> None:
    (shot,) = _shots((60.0, 160.0))
    sure = Photograph(replace(shot, path=Path("sure")), None, 1)
    doubted = Photograph(replace(shot, latitude=46.008), None, 1, other_place=(46.02, -91.0))
    cases: dict[str, tuple[list[Photograph], Any]] = {
        "exif is near": ([sure, replace(doubted, other_place=(46.5, 91.0))], None),
        "xmp is near": ([sure, replace(doubted, shot=replace(shot, latitude=47.0), other_place=(46.008, -91.0))], None),
        "both are near": ([sure, doubted, replace(doubted, other_place=(46.0079, -91.0))], None),
        "no letters": (
            [replace(doubted, has_hemisphere=False), replace(doubted, zone_h=-6.0, other_place=(46.0, 91.0))],
            None,
        ),
        "clock": ([replace(doubted, zone_h=-3.0, other_place=(46.0, -90.0))], None),
        "clock says nothing": ([replace(doubted, zone_h=-6.0), replace(doubted, zone_h=6.0)], None),
        "named": ([sure, doubted], "xmp"),
        "named the other": ([sure, doubted], "exif"),
        "sure": ([sure], None),
    }
    found = {name: said(places.resolve_places, *case) for name, case in cases.items()}
    found["apart"] = [
        said(places.apart_m, *each)
        for each in (
            ((46.0, 179.999), (46.001, -179.999)),
            ((46.0, 0.0), (47.0, 0.0)),
            ((46.0, 0.0), (47.01, 0.0)),
            ((0.0, 0.0), (0.0, 10.1)),
            ((0.0, 174.75), (0.0, -174.75)),
        )
    ]
    found["words"] = [places.words(each) for each in ((0.0, 0.0), (-1.5, -2.25))]
    check_values(HERE / "places.json", found, digits=9)


def test_pictures_of_other_light() -> None:
    small, large = (640, 512), (1281, 1024)
    cases: list[tuple[str, dict[str, str], Exif, tuple[int, int]]] = [
        ("a.jpg", {"drone-dji:ImageSource": "InfraredCamera"}, Exif(), large),
        ("a.jpg", {"drone:ImageSource": "Thermal"}, Exif(), large),
        ("a_T.JPG", {"drone-dji:ImageSource": "WideCamera"}, Exif(make="DJI"), small),
        ("a_T.JPG", {}, Exif(make="DJI"), small),
        ("a_T.JPG", {}, Exif(make="DJI"), large),
        ("a_T.JPG", {}, Exif(make="DJI"), (1280, 1024)),
        ("a_T.JPG", {}, Exif(), small),
        ("a.jpg", {"Camera:BandName": "Red, Green, Blue"}, Exif(), large),
        ("a.jpg", {"Camera:BandName": " Red "}, Exif(), large),
        ("a.jpg", {"Camera:BandName": "Blue, LWIR"}, Exif(), large),
        ("a.jpg", {}, Exif(make="FLIR"), small),
        ("a.jpg", {}, Exif(make="FLIR"), large),
        ("a.jpg", {}, Exif(make="DJI", model="XT2"), small),
        ("a.jpg", {}, Exif(), small),
    ]
    check_values(HERE / "light.json", [other_light(*case) for case in cases])


def test_folders_of_many_kinds(tmp_path: Path) -> None:
    made: dict[str, list[Callable[[Path], Any]]] = {
        "one flight": [lambda at: flight(at, 3)],
        "a pause of 45 minutes": [lambda at: flight(at, 2), lambda at: flight(at, 2, 10, minute=45)],
        "a longer one": [lambda at: flight(at, 2), lambda at: flight(at, 2, 10, minute=46)],
        "1 km away": [lambda at: flight(at, 2), lambda at: flight(at, 2, 10, 1, north=0.0093)],
        "one of another camera": [lambda at: flight(at, 5), lambda at: flight(at, 1, 10, 1, model="FC220")],
        "one of four": [lambda at: flight(at, 4), lambda at: flight(at, 1, 10, 1, model="FC220")],
        "two of eleven": [lambda at: flight(at, 11), lambda at: flight(at, 2, 20, 2, model="FC220")],
        "two of twenty": [lambda at: flight(at, 20), lambda at: flight(at, 2, 30, 3, model="FC220")],
        "twice": [lambda at: flight(at, 2), lambda at: flight(at, 2, 10)],
        "saved later": [lambda at: flight(at, 2, base={306: "2024:05:02 10:00:00", 305: "Editor", 274: 6})],
        "without angles": [lambda at: photo(at / "a.jpg", exif(), xmp({"drone-dji:RelativeAltitude": "60"}))],
        "with other files": [
            lambda at: flight(at, 1),
            lambda at: (at / "b.txt").write_text(""),
            lambda at: (at / "c").mkdir(),
        ],
        "without photographs": [
            lambda at: (at / "b.txt").write_text(""),
            *(lambda at, n=n: (at / f"d{n}").mkdir() for n in range(6)),
        ],
        "nothing to use": [
            lambda at: photo(at / "a.jpg", exif(None)),
            lambda at: photo(at / "b.jpg", exif(None)),
            lambda at: photo(at / "c.jpg", exif(model="X", photo={0x920A: None})),
            lambda at: photo(at / "d.jpg", exif(), xmp(DJI | {"drone-dji:GimbalPitchDegree": "-60"})),
            lambda at: photo(at / "e_T.JPG", exif()),
            lambda at: (at / "f.jpg").write_bytes(b"GIF"),
        ],
    }
    found: Json = {}
    for name, files in made.items():
        folder = tmp_path / name
        folder.mkdir()
        for make in files:
            make(folder)
        try:
            read = read_folder(folder)
            found[name] = [[shot.name for shot in read.shots], _plain(read.left_out), read.notes, read.time_is_sure]
        except PictureError as refused:
            found[name] = str(refused).replace(f"{tmp_path}/", "")
    check_values(HERE / "folders.json", _plain(found))
