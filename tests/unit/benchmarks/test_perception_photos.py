"""Photographs of a flight: labels, places carried over, relief, and what is left out, over a drawn lot."""

from __future__ import annotations

import json
import math
import struct
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.perception import __main__ as command
from benchmarks.perception.eyes import Result
from benchmarks.perception.photo_labels import PHOTO_LOT, PhotoLabels, read_labels
from benchmarks.perception.photo_match import level, place
from benchmarks.perception.photo_shots import Shot, photographs, read_shot
from benchmarks.perception.photos import Offsets, Photos, lot_features, photo_section
from benchmarks.perception.places import state_array
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import Finding
from tests.unit.jpegs import jpeg

WIDTH, HEIGHT, FOCAL = 800, 600, 640.0
HEIGHT_M = 60.0
GROUND_PIXEL_M = 0.05
STALLS = np.array(
    [[[n, e], [n, e + 2.7], [n - 5.4, e + 2.7], [n - 5.4, e]] for n in (8.0, -4.0) for e in np.arange(-13.5, 13, 2.7)]
)
"""Metres north and east of the place that all photographs look at."""
LOT = np.array([[12.0, -18.0], [12.0, 18.0], [-12.0, 18.0], [-12.0, -18.0]])
FLIGHT: dict[str, tuple[tuple[float, float], tuple[float, float, float]]] = {
    "a.jpg": ((0.0, 0.0), (0.0, 0.0, 0.0)),
    "b.jpg": ((4.0, -6.0), (3.0, -2.0, 25.0)),
}
"""By photograph: the foot (metres north and east) and roll, pitch and yaw (degrees)."""
METRE_DEG = 1 / 111_100
LINE_S, VELOCITY = 1e-4, (10.0, -4.0)


def drawn_ground(seed: int = 1) -> NDArray[np.uint8]:
    """Return 120 m x 120 m of asphalt with stains and the painted lot about its middle, north up."""
    rng = np.random.default_rng(seed)
    side = round(120 / GROUND_PIXEL_M)
    coarse = rng.integers(60, 140, (side // 16, side // 16, 3), dtype=np.uint8)
    image = np.ascontiguousarray(cv2.resize(coarse, (side, side), interpolation=cv2.INTER_CUBIC))
    for stall in STALLS:
        at = np.stack([60 + stall[:, 1], 60 - stall[:, 0]], axis=-1) / GROUND_PIXEL_M
        cv2.polylines(image, [np.rint(at).astype(np.int32)], True, (230, 230, 230), 2)
    return np.asarray(image, np.uint8)


def xmp(attitude: tuple[float, float, float]) -> bytes:
    roll, pitch, yaw = attitude
    scale = 6.17472 / WIDTH
    tags = {
        "RigName": "Sequoia", "Roll": roll, "Pitch": pitch, "Yaw": yaw, "PerspectiveFocalLength": FOCAL * scale,
        "PrincipalPoint": f"{WIDTH / 2 * scale},{HEIGHT / 2 * scale}", "PerspectiveDistortion": "0.02,-0.01,0,0.001,0",
        "LineReadoutTime": LINE_S * 1e9, "IMULinearVelocity": f"{VELOCITY[1]},{VELOCITY[0]},0.5",
    }  # fmt: skip
    attributes = " ".join(f'Camera:{name}="{value}"' for name, value in tags.items())
    spaces = 'xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#" xmlns:Camera="http://pix4d.com/camera/1.0/"'
    inner = f"<rdf:RDF {spaces}><rdf:Description {attributes}/></rdf:RDF>"
    return f'<x:xmpmeta xmlns:x="adobe:ns:meta/">{inner}</x:xmpmeta>'.encode()


def exif(latitude: float, longitude: float, altitude: float) -> bytes:
    """Return TIFF with a GPS directory (EXIF 2.32, 4.6.6); west and south by their letters."""
    entries: list[tuple[int, int, int, bytes | float]]
    entries = [(1, 2, 2, b"N\0\0\0"), (2, 5, 3, latitude), (3, 2, 2, b"W\0\0\0"), (4, 5, 3, -longitude)]
    entries += [(5, 1, 1, b"\0\0\0\0"), (6, 5, 1, altitude)]
    start = 26
    body, behind = struct.pack(">H", len(entries)), start + 2 + 12 * len(entries) + 4
    values = b""
    for tag, kind, count, value in entries:
        if isinstance(value, bytes):
            body += struct.pack(">HHI", tag, kind, count) + value
            continue
        body += struct.pack(">HHII", tag, kind, count, behind + len(values))
        values += struct.pack(">II", round(value * 1e7), 10**7) + struct.pack(">II", 0, 1) * (count - 1)
    first = struct.pack(">HHHIII", 1, 0x8825, 4, 1, start, 0)
    return b"MM\0*" + struct.pack(">I", 8) + first + body + struct.pack(">I", 0) + values


def write_photo(path: Path, image: NDArray[np.uint8], foot: tuple[float, float], angles: Any) -> None:
    data = jpeg(image)
    place_m = (41.0 + foot[0] * METRE_DEG, -81.0 + foot[1] * METRE_DEG / math.cos(math.radians(41)))
    parts = [b"Exif\0\0" + exif(*place_m, 300.0 + HEIGHT_M), b"http://ns.adobe.com/xap/1.0/\0" + xmp(angles)]
    segments = b"".join(b"\xff\xe1" + struct.pack(">H", len(part) + 2) + part for part in parts)
    path.write_bytes(data[:2] + segments + data[2:])


def taken_from(shot: Shot, ground: NDArray[np.uint8], foot: tuple[float, float]) -> NDArray[np.uint8]:
    """Return what the camera of ``shot`` sees of the ground."""
    x, y = np.meshgrid(*((np.arange(n // 8 + 2) - 0.5) * 8 - 0.5 for n in (WIDTH, HEIGHT)))
    points = shot.ground(np.column_stack([x.ravel(), y.ravel()]), HEIGHT_M) + foot
    coarse = (np.stack([60 + points[:, 1], 60 - points[:, 0]], axis=-1) / GROUND_PIXEL_M).astype(np.float32)
    fine = np.asarray(cv2.resize(coarse.reshape(*x.shape, 2), None, fx=8, fy=8))[8 : 8 + HEIGHT, 8 : 8 + WIDTH]
    seen = cv2.remap(ground, fine[..., 0], fine[..., 1], cv2.INTER_LINEAR)
    return np.asarray(seen, np.uint8)


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of two photographs of the lot, one of other ground, and the labels of the first."""
    folder = tmp_path_factory.mktemp("flight")
    stranger = {"c.jpg": ((2.0, 2.0), (0.0, 0.0, 0.0))}
    for name, (foot, angles) in {**FLIGHT, **stranger}.items():
        blank = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
        write_photo(folder / name, blank, foot, angles)
        ground = drawn_ground(9) if name in stranger else drawn_ground()
        if name in stranger:
            ground = np.asarray(cv2.GaussianBlur(ground, (0, 0), 20), np.uint8)
        write_photo(folder / name, taken_from(read_shot(folder / name), ground, foot), foot, angles)
    shot = read_shot(folder / "a.jpg")
    corners = {f"S{k}": shot.pixels(stall, HEIGHT_M).tolist() for k, stall in enumerate(STALLS)}
    labels = {
        "comment": "drawn", "licence": "none", "photograph": "a.jpg",
        "pose": {"height_m": HEIGHT_M, "attitude_deg": [0, 0, 0], "turning_deg_s": [0, 0, 0]},
        "lots": [shot.pixels(LOT, HEIGHT_M).tolist()], "stalls": corners,
        "taken": {"a.jpg": ["S1"], "b.jpg": ["S1", "S2"]}, "unclear": {"b.jpg": ["S3"]},
    }  # fmt: skip
    (folder / "labels.json").write_text(json.dumps(labels))
    return folder


@pytest.fixture(scope="module")
def labels(flight: Path) -> PhotoLabels:
    return read_labels(flight / "labels.json", flight)


def test_tags_give_lens_attitude_place_and_shutter(flight: Path) -> None:
    assert [path.name for path in photographs(flight)] == ["a.jpg", "b.jpg", "c.jpg"]
    shot = read_shot(flight / "b.jpg")
    assert (shot.camera.fx, shot.camera.cx, shot.camera.cy) == pytest.approx((FOCAL, 399.5, 299.5))
    assert shot.camera.distortion == (0.02, -0.01, 0.001, 0.0, 0.0)
    assert np.degrees(shot.attitude).tolist() == pytest.approx([3.0, -2.0, 25.0])
    assert shot.latitude == pytest.approx(41 + 4 * METRE_DEG, abs=1e-6)
    assert (shot.longitude < -81, shot.altitude) == (True, 360.0)
    assert shot.velocity == VELOCITY
    assert shot.line_s == pytest.approx(LINE_S)


def test_the_ground_moves_on_while_lines_are_read(flight: Path) -> None:
    shot = read_shot(flight / "a.jpg")
    points = np.array([[20.0, 3.0], [0.0, 0.0], [-15.0, -20.0]])
    pixels = shot.pixels(points, HEIGHT_M)
    assert shot.ground(pixels, HEIGHT_M) == pytest.approx(points, abs=1e-6)
    still = Shot(shot.name, shot.image, shot.camera, shot.attitude, 0.0, 0.0, 0.0)
    seconds = (pixels[:, 1:] - HEIGHT / 2) * LINE_S
    assert still.ground(pixels, HEIGHT_M) == pytest.approx(points - seconds * VELOCITY, abs=1e-4)


def test_labels_lie_on_the_ground_with_the_states_of_each_photograph(labels: PhotoLabels) -> None:
    assert labels.stalls == pytest.approx(STALLS, abs=1e-6)
    assert labels.states("a.jpg").tolist().count(StallState.TAKEN) == 1
    assert labels.states("b.jpg")[:4].tolist() == [
        StallState.FREE, StallState.TAKEN, StallState.TAKEN, StallState.UNKNOWN
    ]  # fmt: skip
    assert set(labels.states("c.jpg").tolist()) == {StallState.UNKNOWN}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"pose": {"height_m": -1, "attitude_deg": [0, 0, 0], "turning_deg_s": [0, 0, 0]}},
            r"pose.height_m: .*correct",
        ),
        ({"stalls": {"S1": [[0, 0], [1, 1]]}}, r"stalls.S1.*correct it as photo_lot.json has it"),
        ({"taken": {"a.jpg": ["Z9"]}}, "Z9: stalls with a state and without corners; add their corners"),
        ({"photograph": "z.jpg"}, "photograph z.jpg is not in .*; name the folder of that flight"),
    ],
)
def test_a_bad_label_file_is_named_with_a_remedy(
    flight: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], change: dict[str, object], said: str
) -> None:
    bad = tmp_path / "bad.json"
    bad.write_text(json.dumps(json.loads((flight / "labels.json").read_text()) | change))
    with pytest.raises(ValueError, match=rf"bad\.json: .*{said}"):
        read_labels(bad, flight)
    assert command.main(["--photos", str(flight), "--photo-labels", str(bad)]) == 2
    assert "--photos: " in capsys.readouterr().err


def test_a_photograph_without_tags_is_named(tmp_path: Path) -> None:
    (tmp_path / "plain.jpg").write_bytes(jpeg())
    with pytest.raises(ValueError, match=r"plain\.jpg has no GPS place; use the drone's own files"):
        read_shot(tmp_path / "plain.jpg")
    with pytest.raises(ValueError, match=r"gone\.json cannot be read: .*; name a label file"):
        read_labels(tmp_path / "gone.json", tmp_path)


def test_labels_are_carried_over_and_the_pose_is_found(flight: Path, labels: PhotoLabels) -> None:
    shot = read_shot(flight / "b.jpg")
    tagged = Shot(
        shot.name, shot.image, shot.camera, (0.0, 0.0, math.radians(30.0)), 0.0, 0.0, 0.0, VELOCITY, line_s=LINE_S
    )
    carried = place(lot_features(labels), tagged, HEIGHT_M * 1.03)
    assert carried is not None
    pixels = carried.shot.pixels(carried.carry(labels.stalls).reshape(-1, 2), carried.height_m)
    true = shot.pixels(STALLS.reshape(-1, 2) - FLIGHT["b.jpg"][0], HEIGHT_M)
    assert np.linalg.norm(pixels - true, axis=1).max() * HEIGHT_M / FOCAL < 0.1, "metres"
    assert carried.foot == pytest.approx(FLIGHT["b.jpg"][0], abs=0.6)
    assert carried.height_m == pytest.approx(HEIGHT_M, rel=0.01)
    assert carried.residual_m < 0.1


class TallEye:
    """Finds every stall of the drawn lot: the free ones where they are, the taken ones as if ``rise_m`` above it."""

    def __init__(self, labels: PhotoLabels, shots: dict[str, Shot], rise_m: float) -> None:
        self._labels, self._shots, self._rise_m = labels, list(shots.items()), rise_m

    def look(self, image: NDArray[np.uint8], metres_per_pixel: float, *, scale: float = 1.0) -> Result:
        name, shot = self._shots.pop(0)
        states = self._labels.states(name)
        stalls = STALLS - np.array(FLIGHT[name][0])
        taken = np.asarray(states == StallState.TAKEN)
        middle = stalls.mean(axis=1, keepdims=True)
        stalls = stalls + np.where(taken[:, None, None], middle * self._rise_m / HEIGHT_M, 0.0)
        corners = level(shot, HEIGHT_M).corners(stalls)
        assert image.shape[:2] == pytest.approx(level(shot, HEIGHT_M).missing.shape, abs=20)
        shift = (np.array(image.shape[1::-1]) - level(shot, HEIGHT_M).missing.shape[::-1]) * metres_per_pixel / 2
        said = state_array([StallState.TAKEN if one else StallState.FREE for one in taken.tolist()])
        return Result(Finding(corners + shift, said), taken.astype(float), np.zeros((10, 10), np.bool_))


def test_a_flight_gives_recall_scale_place_and_relief_and_names_what_shares_nothing(
    flight: Path, labels: PhotoLabels, capsys: pytest.CaptureFixture[str]
) -> None:
    shots = {name: read_shot(flight / name) for name in FLIGHT}
    section = photo_section(TallEye(labels, shots, 3.0), Photos(flight, labels))
    values = {figure.key: figure.value for figure in section.figures}
    assert "c.jpg: left out, too few features in common" in capsys.readouterr().out
    assert (values["photos_seen"], values["photos_left_out"]) == (1.0, 1.0)
    assert (values["photo_recall"], values["photo_precision"], values["photo_state_accuracy"]) == (1.0, 1.0, 1.0)
    assert (values["photos_recall"], values["photos_labels"]) == (1.0, 20.0)
    assert values["photos_scale"] == pytest.approx(1.0, abs=0.01)
    assert values["photos_relief_taken_m"] == pytest.approx(3.0, abs=0.8)
    assert values["photos_relief_free_m"] == pytest.approx(0.0, abs=0.3)
    assert values["photos_exif_place_m"] == pytest.approx(0.0, abs=1.0)


@pytest.mark.parametrize("rise_m", [0.0, 0.4])
def test_relief_of_a_known_height_is_recovered(rise_m: float) -> None:
    rng = np.random.default_rng(4)
    height = rng.uniform(40, 120, 400)
    places = rng.uniform(-0.4, 0.4, (400, 2))
    taken = np.arange(400) % 2 == 0
    noise = rng.normal(0, 0.05, (400, 2)) / height[:, None]
    errors = np.where(taken[:, None], places * rise_m / height[:, None], 0.0) + noise
    errors[:3] += 2.0
    offsets = Offsets(places, errors, height, taken)
    found, sigma, count = offsets.relief(taken=True)
    assert found == pytest.approx(rise_m, abs=4 * sigma)
    assert count == 198
    assert 0.0 < sigma < 0.03
    assert offsets.relief(taken=False)[0] == pytest.approx(0.0, abs=0.05)
    assert math.isnan(Offsets(places[:0], errors[:0], height[:0], taken[:0]).relief(taken=True)[0])


def test_the_shipped_labels_name_every_stall_once() -> None:
    shipped = json.loads(PHOTO_LOT.read_text())
    corners = np.array(list(shipped["stalls"].values()))
    assert corners.shape == (73, 4, 2)
    assert ((corners > 0) & (corners < (4608, 3456))).all()
    assert {name for names in shipped["taken"].values() for name in names} <= set(shipped["stalls"])
    assert "CC0" in shipped["licence"]
