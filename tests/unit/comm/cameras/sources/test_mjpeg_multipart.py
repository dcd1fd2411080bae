from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.comm.cameras.sources.mjpeg import BoundaryError, MultipartParser, boundary_of
from tests.unit.comm.cameras.pictures import BOUNDARY, part, picture

PICTURES = [picture(grey=grey) for grey in (0, 100, 200)]
MARK = BOUNDARY.encode()


def bodies(parser: MultipartParser, data: bytes) -> list[bytes]:
    return [found.body for found in parser.feed(data, 0.0)]


@pytest.mark.parametrize(
    ("content_type", "boundary"),
    [
        ("multipart/x-mixed-replace;boundary=frame", b"frame"),
        ('multipart/x-mixed-replace; boundary="my frame"', b"my frame"),
        ("multipart/x-mixed-replace; Boundary=--frame; charset=x", b"frame"),
        ("multipart/x-mixed-replace; boundary = abc", b"abc"),
    ],
)
def test_the_boundary_is_named_by_the_content_type(content_type: str, boundary: bytes) -> None:
    assert boundary_of(content_type) == boundary


@pytest.mark.parametrize("content_type", ["", "image/jpeg", "multipart/x-mixed-replace; boundary="])
def test_without_a_boundary_there_is_no_stream(content_type: str) -> None:
    with pytest.raises(BoundaryError, match="names no boundary"):
        boundary_of(content_type)


def test_a_part_with_its_length_is_given_before_the_next_boundary_comes() -> None:
    parser = MultipartParser(MARK)
    assert bodies(parser, part(PICTURES[0])) == [PICTURES[0]]


def test_a_part_without_a_length_ends_at_the_next_boundary() -> None:
    parser = MultipartParser(MARK)
    assert bodies(parser, part(PICTURES[0], length=None)) == []
    assert bodies(parser, part(PICTURES[1], length=None)) == [PICTURES[0]]


@pytest.mark.parametrize("line_end", [b"\r\n", b"\n"])
def test_a_boundary_that_ends_a_part_is_not_the_arrival_of_the_next(line_end: bytes) -> None:
    parser = MultipartParser(b"x")
    head = line_end.join((b"Content-Type: image/jpeg", b"Content-Length: %d" % len(PICTURES[0]), b"", b""))
    boundary = line_end + b"--x" + line_end
    assert parser.feed(boundary[len(line_end) :], 0.5) == []
    arrivals = [
        found.arrival for now in (1.0, 2.0, 3.0) for found in parser.feed(head + PICTURES[0] + boundary, now)
    ]  # fmt: skip
    assert arrivals == [1.0, 2.0, 3.0]


def test_headers_are_lower_case_and_arrival_is_that_of_the_first_bytes() -> None:
    parser = MultipartParser(MARK)
    data = part(PICTURES[0], stamp=12.5)
    assert parser.feed(data[:30], 1.0) == []
    assert parser.feed(data[30:200], 1.4) == []
    (found,) = parser.feed(data[200:], 1.9)
    assert found.headers["x-timestamp"] == "12.500000"
    assert found.headers["content-type"] == "image/jpeg"
    assert 1.0 <= found.arrival <= 1.4


@pytest.mark.slow
@given(st.lists(st.integers(1, 400), min_size=1, max_size=60), st.booleans(), st.binary(max_size=30))
def test_it_does_not_matter_how_the_network_cuts(cuts: list[int], with_length: bool, preamble: bytes) -> None:
    parser = MultipartParser(MARK)
    length = -1 if with_length else None
    data = preamble.replace(b"--frame", b"") + b"\r\n" + b"".join(part(one, length=length) for one in PICTURES)
    data += f"--{BOUNDARY}--\r\n".encode()
    found: list[bytes] = []
    position = 0
    for index in range(len(data)):
        if position >= len(data):
            break
        step = cuts[index % len(cuts)]
        found += bodies(parser, data[position : position + step])
        position += step
    assert found == PICTURES
    assert parser.torn == 0


@pytest.mark.slow
@given(st.lists(st.binary(max_size=200), max_size=20))
def test_rubbish_never_breaks_it_and_the_next_whole_picture_is_found(rubbish: list[bytes]) -> None:
    parser = MultipartParser(MARK, max_part=10_000)
    for data in rubbish:
        parser.feed(data, 0.0)
    found: list[bytes] = []
    for _ in range(60):
        found += bodies(parser, part(PICTURES[1]))
    assert PICTURES[1] in found


def test_a_length_that_is_a_lie_costs_no_picture() -> None:
    parser = MultipartParser(MARK)
    lie = part(PICTURES[0], length=len(PICTURES[0]) + 40)
    assert bodies(parser, lie + part(PICTURES[1]) + part(PICTURES[2])) == PICTURES[:3]
    assert parser.torn == 0


def test_a_torn_picture_is_dropped_and_counted() -> None:
    parser = MultipartParser(MARK)
    torn = part(PICTURES[0][: len(PICTURES[0]) // 2], length=None)
    assert bodies(parser, torn + part(PICTURES[1])) == [PICTURES[1]]
    assert parser.torn == 1


def test_a_picture_beyond_the_limit_is_dropped_and_memory_stays_bounded() -> None:
    parser = MultipartParser(MARK, max_part=5000)
    parser.feed(part(b"\xff\xd8" + b"x" * 6000, length=6002), 0.0)
    parser.feed(part(b"\xff\xd8", length=None)[:-4], 0.0)
    for _ in range(50):
        parser.feed(b"y" * 1000, 0.0)
        assert len(parser._buffer) < 8000
    assert parser.torn >= 2
    assert bodies(parser, b"\r\n" + part(PICTURES[0])) == [PICTURES[0]]


def test_endless_headers_are_given_up() -> None:
    parser = MultipartParser(MARK)
    parser.feed(b"--frame\r\n" + b"X: y\r\n" * 5000, 0.0)
    assert parser.torn == 1
    assert bodies(parser, part(PICTURES[0])) == [PICTURES[0]]


def test_a_part_without_headers_is_taken() -> None:
    parser = MultipartParser(MARK)
    data = b"--frame\r\n\r\n" + PICTURES[0] + b"\r\n--frame\r\n"
    assert bodies(parser, data) == [PICTURES[0]]
