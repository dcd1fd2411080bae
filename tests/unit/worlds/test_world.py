import json
import struct
from pathlib import Path

import cv2
import numpy as np
import pytest

from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.world import TrueStall, World, WorldError, load_truth, picture_world
from tests.unit.jpegs import jpeg, oriented, scene, without

STALL = [[3.0, 7.0], [8.0, 7.0], [8.0, 4.5], [3.0, 4.5]]  # long side first, as people label them


def _world(**changes: object) -> World:
    fields: dict[str, object] = {"name": "w", "metres_per_pixel": 0.5, "ground": np.zeros((100, 160, 3), np.uint8)}
    return World(**{**fields, **changes})  # type: ignore[arg-type]


def _truth_file(path: Path, **fields: object) -> Path:
    data = {"metres_per_pixel": 0.1, "stalls": [{"corners_m": STALL, "covered": 1.0, "state": "taken"}], "lots_m": []}
    path.write_text(json.dumps({**data, **fields}))
    return path


@pytest.mark.slow
def test_truth_survives_saving(tmp_path: Path) -> None:
    world = generate_world(2, WorldOptions(metres_per_pixel=0.25))
    path = tmp_path / "truth.json"
    path.write_text(json.dumps(world.truth_json()))
    truth = load_truth(path)
    assert truth.seed == 2
    assert truth.metres_per_pixel == 0.25
    assert truth.start == pytest.approx(world.start(), abs=1e-3)
    assert len(truth.lots) == len(world.lots)
    for saved, stall in zip(truth.stalls, world.stalls, strict=True):
        assert saved.corners == pytest.approx(stall.corners, abs=1e-3)
        assert (saved.id, saved.taken, saved.hidden, saved.worn, saved.kind) == (
            (stall.id, stall.taken, stall.hidden, stall.worn, stall.kind)
        )


def test_labels_without_our_own_fields_are_read(tmp_path: Path) -> None:
    truth = load_truth(_truth_file(tmp_path / "t.json", lots_m=[[[0, 0], [9, 0], [9, 9]]]))
    (stall,) = truth.stalls
    assert stall.taken
    assert stall.id == 0
    assert not stall.hidden
    assert np.linalg.norm(stall.corners[1] - stall.corners[0]) == pytest.approx(2.5)  # short end first
    assert truth.lots[0].shape == (3, 2)


def test_unclear_is_neither_free_nor_taken(tmp_path: Path) -> None:
    path = _truth_file(tmp_path / "t.json", stalls=[{"corners_m": STALL, "state": "unclear"}, {"corners_m": STALL}])
    assert [stall.state for stall in load_truth(path).stalls] == ["unclear", "unclear"]
    assert TrueStall(1, np.array(STALL), taken=False).state == "free"


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"stalls": {}}, "must be lists"),
        ({"stalls": [3]}, r"stalls\[0\].*corners_m"),
        ({"stalls": [{"corners_m": STALL[:3]}]}, r"stalls\[0\].corners_m.*4"),
        ({"stalls": [{"corners_m": [*STALL, [0, 0]]}]}, "4 corners, not 5"),
        ({"stalls": [{"corners_m": [["a", 1]] * 4}]}, r"corners_m: must be a list"),
        ({"stalls": [{"corners_m": STALL, "state": "parked"}]}, "state.*free, taken, unclear"),
        ({"lots_m": [[[0, 0], [1, float("nan")], [1, 1]]]}, r"lots_m\[0\].*finite"),
        ({"start_m": [1]}, "start_m"),
        ({"metres_per_pixel": 0}, "metres_per_pixel.*above 0"),
        ({"metres_per_pixel": True}, "metres_per_pixel"),
    ],
)
def test_bad_truth_names_the_field(tmp_path: Path, fields: dict[str, object], message: str) -> None:
    with pytest.raises(WorldError, match=message):
        load_truth(_truth_file(tmp_path / "t.json", **fields))


def test_truth_that_is_no_json_or_is_missing(tmp_path: Path) -> None:
    bad = tmp_path / "bad.json"
    bad.write_text("{")
    with pytest.raises(WorldError, match=r"bad\.json: is not JSON"):
        load_truth(bad)
    bad.write_text("[]")
    with pytest.raises(WorldError, match="must be an object"):
        load_truth(bad)
    with pytest.raises(WorldError, match="cannot be read"):
        load_truth(tmp_path / "none.json")


def test_start_is_at_the_edge_nearest_to_a_corner() -> None:
    lot = np.array([[10.0, 20.0], [60.0, 20.0], [60.0, 45.0], [10.0, 45.0]])
    # of the edges' middles, (10, 32.5) is nearest to a corner of the 80 m x 50 m picture: (0, 50)
    assert _world(lots=(lot,)).start() == pytest.approx((11.0, 32.5))
    assert _world(lots=(lot,), start_m=(5.0, 6.0)).start() == (5.0, 6.0)
    assert _world().start() == (40.0, 25.0)


def test_of_several_lots_the_drone_starts_at_the_largest() -> None:
    large = np.array([[10.0, 20.0], [60.0, 20.0], [60.0, 45.0], [10.0, 45.0]])
    strip_in_a_corner = np.array([[70.0, 0.0], [80.0, 0.0], [80.0, 10.0], [70.0, 10.0]])
    assert _world(lots=(strip_in_a_corner, large)).start() == pytest.approx((11.0, 32.5))


def test_start_in_a_sliver_of_a_lot_is_still_inside() -> None:
    sliver = np.array([[10.0, 20.0], [60.0, 20.0], [60.0, 21.0], [10.0, 21.0]])
    x, y = _world(lots=(sliver,)).start()
    assert 10 < x < 60
    assert 20 < y < 21


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif"])
def test_picture_world(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"place{suffix}"
    cv2.imwrite(str(path), np.full((60, 100, 3), 77, np.uint8))
    truth = _truth_file(tmp_path / "t.json", start_m=[4.0, 5.0])
    world = picture_world(path, 0.1, truth)
    assert world.name == "place"
    assert world.size_m == pytest.approx((10.0, 6.0))
    assert (world.ground == 77).all()
    assert world.layers == ()
    assert len(world.stalls) == 1
    assert world.start() == (4.0, 5.0)
    assert picture_world(path, 0.1).stalls == ()


@pytest.mark.fault("a picture's EXIF has an orientation (1 to 8)")
@pytest.mark.parametrize("orientation", range(1, 9))
def test_north_is_up_as_viewers_show_the_picture(tmp_path: Path, orientation: int) -> None:
    path = tmp_path / "place.jpg"
    path.write_bytes(oriented(jpeg(), orientation))
    np.testing.assert_array_equal(picture_world(path, 0.1).ground, cv2.imread(str(path)))


def test_a_damaged_picture_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "place.jpg"
    for data in (jpeg()[:-2], without(jpeg(scene(640, 480)), 0.5, 3000)):
        path.write_bytes(data)
        with pytest.raises(WorldError, match=r"place\.jpg: the picture is (torn|damaged).*copy it again"):
            picture_world(path, 0.1)


@pytest.mark.parametrize("kind", [".png", ".tif"])
def test_a_picture_that_is_too_large_is_refused_by_its_header(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / f"huge{kind}"
    size = 30_000
    if kind == ".png":
        path.write_bytes(b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR" + struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0))
    else:
        cv2.imwrite(str(path), np.zeros((16, 20_001, 3), np.uint8))

    def decoded(*_: object) -> None:
        pytest.fail("it was decoded")

    monkeypatch.setattr(cv2, "imdecode", decoded)
    with pytest.raises(WorldError, match=r"must be 16 to 20000 pixels a side, not (30000 x 30000|20001 x 16); resize"):
        picture_world(path, 0.1)


def test_bad_pictures_say_what_is_wrong(tmp_path: Path) -> None:
    text = tmp_path / "a.png"
    text.write_text("no picture")
    tiny = tmp_path / "tiny.png"
    cv2.imwrite(str(tiny), np.zeros((4, 4, 3), np.uint8))
    empty = tmp_path / "empty.png"
    empty.touch()
    for path, scale, message in (
        (text, 0.1, "not a picture"),
        (empty, 0.1, "not a picture"),
        (tiny, 0.1, "16 to 20000 pixels"),
        (tmp_path / "none.png", 0.1, "cannot be read"),
        (tiny, 0.0, "metres_per_pixel"),
        (tiny, float("nan"), "metres_per_pixel"),
    ):
        with pytest.raises(WorldError, match=message):
            picture_world(path, scale)
