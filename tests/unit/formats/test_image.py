from __future__ import annotations

import cv2
import numpy as np
import pytest

from hawk.formats.image import (
    DamagedImage,
    NoImage,
    decode,
    decode_any,
    jpeg_size,
    largest_step,
    read_jpeg,
    upright,
    whole_jpeg,
)
from tests.unit.comm.cameras.pictures import picture
from tests.unit.jpegs import jpeg, oriented, scene, with_extra_bytes, without

SHARES = [each / 40 for each in range(40)]


@pytest.mark.parametrize(("width", "height"), [(64, 48), (1280, 720), (1, 1), (3000, 7)])
def test_size_is_read_without_decoding(width: int, height: int) -> None:
    assert jpeg_size(picture(width, height)) == (width, height)


@pytest.mark.parametrize(
    "data", [b"", b"\xff", b"PNG", b"\xff\xd8", b"\xff\xd8\xff\xe0\x00\x10" + b"\0" * 14 + b"rest"]
)
def test_what_is_no_jpeg_has_no_size(data: bytes) -> None:
    with pytest.raises(ValueError, match="not a JPEG"):
        jpeg_size(data)
    assert whole_jpeg(data) is None


def test_a_segment_that_leads_nowhere_ends_the_search() -> None:
    with pytest.raises(ValueError, match="no frame header"):
        jpeg_size(b"\xff\xd8\xff\xe0\xff\xff" + b"\0" * 20)


def test_fill_bytes_are_passed_over() -> None:
    data = picture(20, 10)
    assert jpeg_size(data[:2] + b"\xff\xff" + data[2:]) == (20, 10)


@pytest.mark.parametrize("progressive", [False, True])
@pytest.mark.parametrize("behind", [b"", b"\0" * 16, b"\0" * 5000, b"\xff" * 70, b"a trailer", jpeg()[900:], jpeg()])
def test_what_follows_the_end_is_no_part_of_a_picture(behind: bytes, progressive: bool) -> None:
    data = jpeg(progressive=progressive)
    assert whole_jpeg(data + behind) == data
    np.testing.assert_array_equal(decode(data + behind), decode(data))


def test_a_picture_without_its_end_is_not_whole() -> None:
    data = jpeg()
    for torn in (data[:-2], data[: len(data) // 2], data[:-1], data[: len(data) // 2] + data):
        assert whole_jpeg(torn) is None
        with pytest.raises(DamagedImage, match="torn"):
            decode(torn)


def test_the_end_of_a_preview_in_exif_is_not_the_end_of_the_picture() -> None:
    data, preview = jpeg(), picture()
    with_preview = data[:2] + b"\xff\xe1" + (len(preview) + 2).to_bytes(2, "big") + preview + data[2:]
    assert whole_jpeg(with_preview) == with_preview


@pytest.mark.fault(
    "a picture's EXIF has an orientation (1 to 8)",
    "neither size nor pixels turn, for camera, calibration and page; a world is turned as viewers show it",
)
@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("orientation", range(1, 9))
def test_orientation_is_read_and_turns_neither_size_nor_pixels(orientation: int, order: str) -> None:
    data = oriented(jpeg(), orientation, order)
    head = read_jpeg(data)
    assert head.orientation == orientation
    assert head.size == (320, 240)
    for reduction in (1, 2, 4):
        np.testing.assert_array_equal(decode(data, reduction), decode(jpeg(), reduction))
    np.testing.assert_array_equal(decode_any(data), decode(jpeg()))
    shown = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    np.testing.assert_array_equal(upright(decode(data), orientation), shown)


@pytest.mark.parametrize("orientation", [0, 9, 300])
def test_an_orientation_that_exif_does_not_know_is_none(orientation: int) -> None:
    assert read_jpeg(oriented(jpeg(), orientation)).orientation == 1


def test_exif_that_leads_nowhere_is_passed_over() -> None:
    data = oriented(jpeg(), 6)
    at = data.index(b"II*\0") + 4
    assert read_jpeg(data[:at] + b"\xff\xff\xff\x00" + data[at + 4 :]).orientation == 1


@pytest.mark.parametrize("reduction", [1, 2, 4])
def test_pixels_are_those_of_opencv(reduction: int) -> None:
    flags = {1: cv2.IMREAD_COLOR, 2: cv2.IMREAD_REDUCED_COLOR_2, 4: cv2.IMREAD_REDUCED_COLOR_4}
    for size in ((320, 240), (641, 479), (65, 66)):
        data = jpeg(scene(*size))
        usual = cv2.imdecode(np.frombuffer(data, np.uint8), flags[reduction])
        np.testing.assert_array_equal(decode(data, reduction), usual)


def test_grey_pictures_and_pictures_without_huffman_tables_are_decoded() -> None:
    grey = cv2.imencode(".jpg", scene()[:, :, 0])[1].tobytes()
    assert decode(grey).shape == (240, 320, 3)
    data = jpeg()  # Motion JPEG of USB cameras leaves the usual tables out
    first, last = data.index(b"\xff\xc4"), data.index(b"\xff\xda")
    np.testing.assert_array_equal(decode(data[:first] + data[last:]), decode(data))


@pytest.mark.slow
@pytest.mark.fault(
    "300 B to 3 kB are lost inside a JPEG, with or without restart markers, wherever it is",
    "the decoder's first warning refuses the picture: counted, reported, never fused",
)
@pytest.mark.parametrize("restarts", [0, 1, 20])
@pytest.mark.parametrize("count", [300, 1000, 3000])
def test_some_hundred_lost_bytes_are_noticed_wherever_they_were(count: int, restarts: int) -> None:
    data = jpeg(scene(640, 480), restarts)
    for share in SHARES:
        with pytest.raises(DamagedImage, match=r"damaged|torn"):
            decode(without(data, share, count))


@pytest.mark.slow
@pytest.mark.fault(
    "1 to 64 B are lost inside a JPEG and the decoder finds back without a warning",
    "a step of 5 grey levels in all that follows is noticed; else a few blocks differ",
)
@pytest.mark.parametrize("count", [1, 4, 16, 64])
def test_few_lost_bytes_are_noticed_or_change_little(count: int) -> None:
    """The decoder alone finds back to whole codes after half of such losses, without a warning."""
    data = jpeg(scene(640, 480))
    sound = decode(data).astype(np.int16)
    changed = []
    for share in SHARES[2:-2]:
        try:
            image = decode(without(data, share, count))
        except DamagedImage:
            continue
        off = np.abs(cv2.blur((image - sound).astype(np.float32), (33, 33)))  # without what a few blocks lost
        if np.mean(off.max(axis=2) > 8) > 0.1:
            changed.append(share)
    assert len(changed) <= 1, "a step that begins with a row of blocks may be an edge of the ground"


def test_edges_of_the_ground_and_black_bars_are_no_steps() -> None:
    for first in (64, 72, 80):
        image = scene(640, 480)
        image[:first] = 0
        assert decode(jpeg(image)).shape == image.shape
        image[first : first + 200, 200:] = 255
        assert decode(jpeg(image)).shape == image.shape


@pytest.mark.parametrize("size", [(640, 480), (643, 477)])
def test_a_step_of_all_that_follows_a_block_is_found(size: tuple[int, int]) -> None:
    image = scene(*size)
    assert largest_step(image, 16) == 0.0
    image[160:, :, 2] += 20  # from 60 to 200 before: none overflows
    image[160:176, :304, 2] -= 20
    assert largest_step(image, 16) == pytest.approx(20, abs=3)
    assert largest_step(image[:40, :100], 16) == 0.0  # too small to say


@pytest.mark.fault(
    "a webcam sends bytes too many before restart markers (C270, C910)",
    "its pictures are used; a lost run of blocks is noticed by the markers' count",
)
def test_webcams_with_bytes_too_many_before_restart_markers_give_sound_pictures() -> None:
    data = jpeg(restarts=10)
    np.testing.assert_array_equal(decode(with_extra_bytes(data, 10)), decode(data))


@pytest.mark.fault("a webcam sends bytes too many before restart markers (C270, C910)")
def test_a_lost_run_of_such_a_webcam_s_picture_is_noticed() -> None:
    """Eight restart markers further the numbers are the same again: they are counted."""
    data = with_extra_bytes(jpeg(scene(640, 480), restarts=10), 10)
    marks = [at for at in range(len(data) - 1) if data[at : at + 2] == b"\xff\xd3"]
    with pytest.raises(DamagedImage):
        decode(data[: marks[2]] + data[marks[3] :])
    with pytest.raises(DamagedImage):
        decode(data[: marks[2]] + data[marks[2] + 2 :])


def test_padding_before_the_end_is_no_damage_and_leftover_data_is() -> None:
    data = jpeg()
    np.testing.assert_array_equal(decode(data[:-2] + b"\0" * 200 + data[-2:]), decode(data))
    with pytest.raises(DamagedImage, match="extraneous"):
        decode(data[:-2] + b"\x12\x34\x56\x78" * 5 + data[-2:])


def test_other_kinds_of_pictures_are_decoded_and_what_is_none_has_a_reason() -> None:
    for suffix in (".png", ".tif"):
        np.testing.assert_array_equal(decode_any(cv2.imencode(suffix, scene())[1].tobytes()), scene())
    for data in (b"", b"no picture", b"\x89PNG\r\n\x1a\n"):
        with pytest.raises(NoImage):
            decode_any(data)


def test_a_kind_of_jpeg_that_cannot_be_decoded_is_not_called_damaged() -> None:
    data = jpeg()
    at = data.index(b"\xff\xc0")
    with pytest.raises(NoImage, match="cannot be decoded") as found:
        decode(data[:at] + b"\xff\xc3" + data[at + 2 :])  # lossless
    assert not isinstance(found.value, DamagedImage)
