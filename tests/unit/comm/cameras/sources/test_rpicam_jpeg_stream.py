from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hawk.comm.cameras.sources.rpicam import JpegSplitter
from tests.unit.comm.cameras.pictures import picture

A, B, C = picture(32, 16, 10), picture(64, 48, 128), picture(16, 16, 240)


@given(st.lists(st.integers(1, 900), min_size=1, max_size=40))
def test_pictures_come_out_whole_however_the_bytes_are_cut(sizes: list[int]) -> None:
    splitter, stream, found = JpegSplitter(), A + B + C, []
    while stream:
        for size in sizes:
            found += splitter.feed(stream[:size])
            stream = stream[size:]
    assert [each.body for each in found] == [A, B, C]
    assert [each.number for each in found] == [0, 1, 2]
    assert splitter.torn == 0


def test_a_preview_in_the_headers_is_not_a_picture() -> None:
    segment = b"\xff\xe1" + (len(C) + 2).to_bytes(2, "big") + C
    with_preview = A[:2] + segment + A[2:]
    assert [each.body for each in JpegSplitter().feed(with_preview + B)] == [with_preview, B]


def test_a_torn_picture_is_dropped_counted_and_keeps_its_number() -> None:
    splitter = JpegSplitter()
    found = splitter.feed(A + b"\xff\xd8 no headers " + B)
    assert [(each.body, each.number) for each in found] == [(A, 0), (B, 2)]
    assert splitter.torn == 1


def test_words_before_a_picture_are_skipped() -> None:
    assert [each.body for each in JpegSplitter().feed(b"Made X/EGL preview window\n" + A)] == [A]


def test_a_picture_without_an_end_is_given_up() -> None:
    splitter = JpegSplitter(longest=2000)
    assert splitter.feed(A[:-2] + b"\0" * 3000) == []
    assert splitter.torn == 1
    assert [each.body for each in splitter.feed(B)] == [B]
