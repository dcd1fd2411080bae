from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.vision.picture import decode
from hawk.formats.image import NoImage, jpeg_size


def jpeg(width: int = 320, height: int = 200, value: int = 120) -> bytes:
    return cv2.imencode(".jpg", np.full((height, width, 3), value, np.uint8))[1].tobytes()


def with_size(data: bytes, width: int, height: int) -> bytes:
    at = data.index(b"\xff\xc0")
    return data[: at + 5] + height.to_bytes(2, "big") + width.to_bytes(2, "big") + data[at + 9 :]


def test_a_good_picture_is_decoded() -> None:
    image: NDArray[np.uint8] = decode(jpeg())
    assert image.shape == (200, 320, 3)
    assert abs(float(image.mean()) - 120) < 2


def test_the_size_is_read_before_decoding() -> None:
    assert jpeg_size(jpeg(100, 90)) == (100, 90)
    assert jpeg_size(b"\xff\xd8\xff\xff" + jpeg(100, 90)[3:]) == (100, 90)  # fill bytes before a marker are allowed


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "empty"),
        (b"not a picture at all", "not a JPEG"),
        (cv2.imencode(".png", np.zeros((99, 99, 3), np.uint8))[1].tobytes(), "not a JPEG"),
        (jpeg()[: len(jpeg()) // 2], "torn"),
        (jpeg()[:12], "torn"),
        (jpeg(40, 300), "at least 64"),
        (with_size(jpeg(), 65000, 65000), "at most 24 million"),
        (jpeg(value=0), "black"),
        (b"\xff\xd8\xff\xc0\x00\x0b\x08\x01\x00\x01\x00\x01\x01\x11\x00\xff\xd9", "cannot be decoded"),
    ],
)
def test_what_is_no_picture_is_refused_with_the_reason(data: bytes, words: str) -> None:
    with pytest.raises(NoImage, match=words):
        decode(data)


@given(st.binary(max_size=400), st.integers(0, 400), st.booleans())
@settings(max_examples=60)
def test_damage_gives_a_picture_or_a_reason_and_nothing_else(noise: bytes, at: int, cut: bool) -> None:
    good = jpeg()
    damaged = good[:at] + noise + (b"" if cut else good[at + len(noise) :])
    try:
        image = decode(damaged)
    except NoImage:
        return
    assert image.ndim == 3
