from __future__ import annotations

import struct
import zlib

import cv2
import numpy as np
import pytest

from hawk.model.lot_map import TILE_CELLS
from hawk.model.tile_picture import MASK_MARK, decode_picture, encode_picture, has_mask

SHAPE = (TILE_CELLS, TILE_CELLS)


def ground() -> np.ndarray:
    rows, columns = np.mgrid[0:TILE_CELLS, 0:TILE_CELLS]
    return np.stack([90 + rows // 4, 120 + columns // 8, np.full(SHAPE, 110)], -1).astype(np.uint8)


def circle() -> np.ndarray:
    seen = np.zeros(SHAPE, np.uint8)
    cv2.circle(seen, (70, 60), 110, 255, -1)
    return seen


def with_mask(packed: bytes) -> bytes:
    jpeg = cv2.imencode(".jpg", ground())[1].tobytes()
    return jpeg[:2] + b"\xff\xfe" + struct.pack(">H", len(MASK_MARK) + len(packed) + 2) + MASK_MARK + packed + jpeg[2:]


def test_a_picture_and_its_mask_come_back() -> None:
    for seen in (circle(), np.full(SHAPE, 255, np.uint8), np.zeros(SHAPE, np.uint8)):
        pixels, mask = decode_picture(encode_picture(ground(), seen))
        assert np.array_equal(mask, seen)
        apart = np.abs(pixels.astype(int) - ground())[seen > 0]
        assert apart.sum() <= 2 * apart.size


def test_it_is_a_plain_jpeg_without_black_where_nothing_was_seen() -> None:
    seen, pixels = circle(), ground()
    pixels[seen == 0] = 0
    shown = cv2.imdecode(np.frombuffer(encode_picture(pixels, seen), np.uint8), cv2.IMREAD_COLOR)
    assert shown is not None
    assert shown.min() > 60
    beside = (cv2.dilate(seen, np.ones((9, 9))) > 0) & (seen == 0)
    assert np.abs(shown.astype(int) - ground())[beside].mean() < 12, "its edge has the colours beside it"


def test_the_mask_of_a_picture_without_one_is_what_is_not_black() -> None:
    pixels = ground()
    pixels[:, 160:] = 0
    old = cv2.imencode(".jpg", pixels)[1].tobytes()
    assert not has_mask(old)
    assert has_mask(encode_picture(pixels, circle()))
    _, seen = decode_picture(old)
    assert (seen[:, 170:].max(), seen[:, :150].min()) == (0, 255)


@pytest.mark.parametrize("packed", [b"no zlib", zlib.compress(b"too short")])
def test_a_mask_that_cannot_be_read_is_refused(packed: bytes) -> None:
    with pytest.raises(ValueError, match="mask cannot be read"):
        decode_picture(with_mask(packed))


@pytest.mark.parametrize("data", [b"", b"\xff\xd8\xff\xfe", cv2.imencode(".jpg", np.zeros((8, 8, 3)))[1].tobytes()])
def test_what_is_no_picture_of_a_tile_is_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match="not a picture"):
        decode_picture(data)
