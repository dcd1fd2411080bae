from __future__ import annotations

import pytest

from hawk.comm.image import is_whole_jpeg, jpeg_size
from tests.unit.comm.pictures import picture


@pytest.mark.parametrize(("width", "height"), [(64, 48), (1280, 720), (1, 1), (3000, 7)])
def test_size_is_read_without_decoding(width: int, height: int) -> None:
    assert jpeg_size(picture(width, height)) == (width, height)


@pytest.mark.parametrize(
    "data", [b"", b"\xff", b"PNG", b"\xff\xd8", b"\xff\xd8\xff\xe0\x00\x10" + b"\0" * 14 + b"rest"]
)
def test_what_is_no_jpeg_has_no_size(data: bytes) -> None:
    with pytest.raises(ValueError, match="not a JPEG"):
        jpeg_size(data)


def test_a_segment_that_leads_nowhere_ends_the_search() -> None:
    with pytest.raises(ValueError, match="no frame header"):
        jpeg_size(b"\xff\xd8\xff\xe0\xff\xff" + b"\0" * 20)


def test_fill_bytes_are_passed_over() -> None:
    data = picture(20, 10)
    assert jpeg_size(data[:2] + b"\xff\xff" + data[2:]) == (20, 10)


def test_whole_is_from_start_to_end() -> None:
    data = picture()
    assert is_whole_jpeg(data)
    assert is_whole_jpeg(data + b"\0" * 16)  # padded
    assert not is_whole_jpeg(data[:-2])
    assert not is_whole_jpeg(data[1:])
    assert not is_whole_jpeg(b"")
