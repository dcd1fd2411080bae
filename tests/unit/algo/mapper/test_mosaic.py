from __future__ import annotations

import cv2
import numpy as np
import pytest

from hawk.algo.mapper.mosaic import Mosaic
from hawk.algo.mapper.published import nearest_first
from hawk.algo.vision.seen import GroundImage
from hawk.model.lot_map import TILE_CELLS, EncodedTile
from tests.unit.algo.synthetic import ground_affine, pose_at


def picture(north: float, east: float, grey: int) -> GroundImage:
    pose = pose_at(north, east, 0.4)
    values = np.full((200, 300, 3), grey, np.uint8)
    return GroundImage(values, ground_affine(pose, (200, 300), 0.1), np.ones((200, 300), np.bool_))


def pixels(tile: EncodedTile) -> np.ndarray:
    image = cv2.imdecode(np.frombuffer(tile.data, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert image is not None
    return np.asarray(image)


def test_a_picture_is_placed_where_it_was_taken() -> None:
    mosaic = Mosaic()
    mosaic.add(picture(-12.8, 12.8, 150), (-12.8, 12.8), 35.0)
    while mosaic.encode(1, 1):
        pass
    tile = pixels(mosaic.encoded[0, 0])
    assert abs(int(tile[128, 128]) - 150) < 4
    assert tile[2, 250] < 10


def test_the_view_from_straight_above_wins_whatever_the_order() -> None:
    for order in ((0, 1), (1, 0)):
        mosaic = Mosaic()
        shots = [((-12.8, 12.8), 200), ((-12.8, 22.8), 50)]
        for i in order:
            (north, east), grey = shots[i]
            mosaic.add(picture(north, east, grey), (north, east), 35.0)
        while mosaic.encode(1, 1):
            pass
        assert pixels(mosaic.encoded[0, 0])[128, 110] > 150


def test_encoding_is_bounded_and_the_backlog_comes_round() -> None:
    mosaic = Mosaic()
    mosaic.add(picture(0.0, 0.0, 150), (0.0, 0.0), 35.0)
    assert mosaic.encode(1, 1)
    assert len(mosaic.encoded) == 1
    for _ in range(3):
        mosaic.encode(1, 2)
    assert len(mosaic.encoded) == 4
    assert not mosaic.encode(1, 3)


def test_tiles_far_behind_rest_as_jpeg_and_wake_unchanged() -> None:
    mosaic = Mosaic()
    for step in range(0, 800, 20):
        mosaic.add(picture(-12.8, float(step), 150), (-12.8, float(step)), 35.0)
        while mosaic.encode(4, step):
            pass
    assert mosaic.loaded <= 24
    mosaic.add(picture(-12.8, 12.8, 90), (-12.8, 12.8), 30.0)
    while mosaic.encode(4, 999):
        pass
    assert abs(int(pixels(mosaic.encoded[0, 0])[128, 30]) - 150) < 8


def test_a_restored_tile_is_improved_upon_by_any_new_look() -> None:
    first, again = Mosaic(), Mosaic()
    first.add(picture(-12.8, 12.8, 150), (-12.8, 12.8), 35.0)
    first.encode(9, 7)
    again.restore((0, 0), 7, first.encoded[0, 0].data)
    assert again.encoded[0, 0].version == 7
    again.add(picture(-12.8, 12.8, 60), (-12.8, 12.8), 35.0)
    again.encode(9, 8)
    assert abs(int(pixels(again.encoded[0, 0])[128, 128]) - 60) < 4


@pytest.mark.parametrize("data", [b"", b"no picture", cv2.imencode(".jpg", np.zeros((8, 8, 3), np.uint8))[1].tobytes()])
def test_what_is_no_tile_is_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match="not a picture"):
        Mosaic().restore((0, 0), 1, data)


def test_a_picture_without_valid_parts_changes_nothing() -> None:
    mosaic, image = Mosaic(), picture(0, 0, 1)
    mosaic.add(GroundImage(image.values, image.to_map, np.zeros((200, 300), np.bool_)), (0.0, 0.0), 35.0)
    assert not mosaic.encode(9, 1)


def test_nearest_first() -> None:
    assert nearest_first([(5, 5), (0, 0), (1, 0)], -12.8, 12.8)[0] == (0, 0)
    assert TILE_CELLS == 256
