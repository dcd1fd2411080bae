from __future__ import annotations

import asyncio
import json
import random
import shutil
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest

from benchmarks.figures import BenchmarkError, flat
from benchmarks.figures import Section as Shown
from benchmarks.video import __main__ as program
from benchmarks.video import measure as measuring
from benchmarks.video import pictures, servers
from benchmarks.video.clients import SLOW_TICK_S, Client, Slow
from benchmarks.video.measure import SOCKET, STREAM, USTREAMER, Run, Setting, figures, measure
from benchmarks.video.wire import Reader, SocketReader, StreamReader, WireError, client_frame
from hawk.formats.image import decode, jpeg_size
from hawk.model.pictures import AnnotatedFrame
from hawk.web.video.video_wire import opening, part, socket_frame

STREAM_HEAD = b"HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=hawkframe\r\n\r\n"
SOCKET_HEAD = b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\n\r\n"
TIMES = [5.25, 5.5, 1234567.875]


@pytest.fixture(scope="module")
def drawn() -> list[bytes]:
    return pictures.draw(2)


def pieces(data: bytes, seed: int) -> Iterator[memoryview]:
    rng = random.Random(seed)
    while data:
        size = rng.choice((1, 2, 7, 100, 5000, 200_000))
        yield memoryview(data[:size])
        data = data[size:]


def read(reader: Reader, data: bytes, seed: int) -> list[tuple[int, int]]:
    return [found for piece in pieces(data, seed) for found in reader.feed(piece)]


@pytest.mark.slow
def test_pictures_have_a_real_size_and_differ(drawn: list[bytes]) -> None:
    assert all(abs(len(each) - pictures.BYTES) < 0.1 * pictures.BYTES for each in drawn)
    assert {jpeg_size(each) for each in drawn} == {(1280, 720)}
    assert drawn[0] != drawn[1]


def test_a_stamp_stays_a_picture_and_can_be_read(drawn: list[bytes]) -> None:
    stamped = pictures.stamped(drawn[0], 2**40 + 5)
    assert pictures.stamp_of(stamped[: pictures.STAMP_ENDS]) == 2**40 + 5
    assert (decode(stamped) == decode(drawn[0])).all()
    with pytest.raises(ValueError, match="no stamp"):
        pictures.stamp_of(drawn[0])


def test_pictures_are_written_as_they_are_read(tmp_path: Path) -> None:
    several = [b"one", b"", b"three" * 1000]
    pictures.write(tmp_path / "file", several)
    assert pictures.read(tmp_path / "file") == several


@pytest.mark.parametrize("seed", range(5))
def test_hawks_stream_is_read_however_it_is_cut(seed: int) -> None:
    parts = [part(AnnotatedFrame(1, time, b"\xff\xd8" + bytes(50_000) + b"\r\n\r\n\xff\xd9")) for time in TIMES]
    found = read(StreamReader("/x", "host", is_stamped=False), STREAM_HEAD + opening() + b"".join(parts), seed)
    assert found == [(round(time * 1e9), 50_008) for time in TIMES]


@pytest.mark.parametrize("seed", range(5))
def test_ustreamers_stream_is_read_however_it_is_cut(seed: int, drawn: list[bytes]) -> None:
    data = b"HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary=b\r\n\r\n--b\r\n"
    sizes = []
    for number, jpeg in enumerate(drawn):
        stamped = pictures.stamped(jpeg, number)
        sizes.append(len(stamped))
        data += b"Content-Type: image/jpeg\r\nContent-Length: %d\r\nX-Timestamp: 17.5\r\n\r\n" % len(stamped)
        data += stamped + b"\r\n--b\r\n"
    found = read(StreamReader("/stream", "host", is_stamped=True), data, seed)
    assert found == list(zip((0, 1), sizes, strict=True))


@pytest.mark.parametrize("seed", range(5))
def test_hawks_socket_is_read_and_each_picture_acknowledged_when_it_is_whole(seed: int) -> None:
    sent: list[bytes] = []
    reader = SocketReader("/video", "host", sent.append)
    frames = [AnnotatedFrame(n, time, b"\xff\xd8" + bytes(70_000 * (n % 2))) for n, time in enumerate(TIMES)]
    data = SOCKET_HEAD + b"\x89\x00" + b"\x89\x02hi" + b"".join(socket_frame(each) for each in frames)
    assert read(reader, data, seed) == [(round(each.captured * 1e9), len(each.jpeg)) for each in frames]
    assert sent == [
        client_frame(10, b""),
        client_frame(10, b"hi"),
        *(client_frame(1, b'{"ack":%d}' % n) for n in range(3)),
    ]


def test_a_server_that_refuses_or_closes_is_an_error() -> None:
    with pytest.raises(WireError, match="no WebSocket"):
        read(SocketReader("/video", "h", lambda _: None), b"HTTP/1.1 503 Service Unavailable\r\n\r\n", 0)
    with pytest.raises(WireError, match="closed"):
        read(SocketReader("/video", "h", lambda _: None), SOCKET_HEAD + b"\x88\x02" + struct.pack(">H", 1001), 0)
    with pytest.raises(WireError, match="X-Timestamp"):
        read(StreamReader("/x", "h", is_stamped=False), b"--b\r\nContent-Length: 3\r\n\r\n123", 0)


class Source:
    """In place of a client: as many bytes as asked, or none."""

    def __init__(self, *, is_empty: bool = False) -> None:
        self.taken = 0
        self.is_empty = is_empty

    def read(self, into: memoryview, _is_measured: bool) -> int:
        if self.is_empty:
            return 0
        self.taken += len(into)
        return len(into)


def test_the_slow_link_carries_its_bytes_and_never_makes_up_for_an_empty_time() -> None:
    now, source = [0.0], Source()
    slow = Slow(cast(Client, source), 1_500_000.0, lambda: now[0])
    into = memoryview(bytearray(1 << 18))
    for _ in range(1000):
        now[0] += SLOW_TICK_S
        slow.read(into, is_measured=True)
    assert source.taken == pytest.approx(1_500_000.0 * 1000 * SLOW_TICK_S, rel=0.001)
    source.taken = 0
    now[0] += 10.0
    slow.read(into, is_measured=True)
    assert source.taken <= 1_500_000.0 * 10 * SLOW_TICK_S


def run(transport: str, fast_ms: float, slow_ms: float, cpu_us: float, share: float = 1.0) -> Run:
    """A run of 16 viewers over 10 s."""
    fast = [fast_ms] * round(14 * 300 * share)
    found = Run(transport, 16, 14, fast, [slow_ms] * 160, [5.0] * 200, seconds=10.0, memory_mb=50.0)
    found.cpu_s = cpu_us * 1e-6 * found.delivered
    found.control_ms = [] if transport == USTREAMER else [4.0] * 100
    return found


def values(*runs: Run) -> dict[str, float | None]:
    return flat([Shown("video", figures(runs))])


def test_limits_hold_for_the_worse_transport() -> None:
    found = values(run(SOCKET, 5.0, 80.0, 90.0), run(STREAM, 6.0, 70.0, 60.0, 0.5), run(USTREAMER, 20.0, 1000.0, 100.0))
    assert found["socket_fast_p99_over_ustreamer"] == pytest.approx(0.25)
    assert found["fast_p99_over_ustreamer"] == pytest.approx(0.3)
    assert found["slow_p50_over_ustreamer"] == pytest.approx(0.08)
    assert found["cpu_per_frame_over_ustreamer"] == pytest.approx(0.9)
    assert found["stream_cpu_per_frame_over_ustreamer"] == pytest.approx(0.6)
    assert found["control_rtt_p99_ms"] == pytest.approx(4.0)
    assert found["fast_share"] == pytest.approx(0.5)
    assert found["ustreamer_16_slow_age_p50_ms"] == pytest.approx(1000.0)
    verdicts = {
        each.key: each.passed for each in figures([run(SOCKET, 15.0, 80.0, 90.0), run(USTREAMER, 20.0, 1e3, 100)])
    }
    assert verdicts["fast_p99_over_ustreamer"] is False
    assert verdicts["slow_p50_over_ustreamer"] is True
    assert verdicts["cpu_per_frame_over_ustreamer"] is False


def test_without_ustreamer_there_are_no_ratios() -> None:
    found = values(run(SOCKET, 5.0, 80.0, 90.0), run(STREAM, 6.0, 70.0, 60.0))
    assert not [key for key in found if "ustreamer" in key]
    assert found["control_rtt_p99_ms"] == pytest.approx(4.0)


def test_a_transport_that_delivered_nothing_has_no_ratio() -> None:
    silent = Run(SOCKET, 16, 14, seconds=10.0)
    found = values(silent, run(STREAM, 6.0, 70.0, 60.0), run(USTREAMER, 20.0, 1000.0, 100.0))
    assert found["socket_cpu_per_frame_over_ustreamer"] is None
    assert found["cpu_per_frame_over_ustreamer"] is None


def test_a_feeder_that_is_no_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(BenchmarkError, match=r"--ustreamer-feeder: .*nothing\.so is no file"):
        servers.compiled(tmp_path / "nothing.so", tmp_path)


@pytest.mark.parametrize("words", [["--viewers", "0"], ["--viewers", "21"], ["--seconds", "0.5"], ["--seconds", "nan"]])
def test_a_wrong_word_is_refused(words: list[str]) -> None:
    with pytest.raises(SystemExit):
        program.main(words)


@pytest.mark.slow
@pytest.mark.parametrize("with_ustreamer", [False, True])
@pytest.mark.nightly
def test_real_servers_are_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, with_ustreamer: bool, drawn: list[bytes]
) -> None:
    if with_ustreamer and not (servers.is_there() and (shutil.which("cc") or shutil.which("gcc"))):
        pytest.skip("ustreamer or a C compiler is not installed")
    monkeypatch.setattr(measuring, "WARM_UP_S", 1.0)
    file = tmp_path / "pictures.bin"
    pictures.write(file, drawn)
    feeder = servers.compiled(servers.FEEDER, tmp_path) if with_ustreamer else None

    async def work() -> Any:
        return await measure(Setting(file, tmp_path, 2.0, feeder), (3,), 1)

    runs = {each.transport: each for each in asyncio.run(work())}
    assert set(runs) == {SOCKET, STREAM} | ({USTREAMER} if with_ustreamer else set())
    for each in runs.values():
        assert len(each.fast_ms) >= 20
        assert len(each.slow_ms) >= 5
        assert min(each.fast_ms) > 0.0
        assert each.cpu_s > 0.0
        assert each.memory_mb > 1.0
    assert len(runs[SOCKET].control_ms) >= 20
    found = values(*runs.values())
    assert json.dumps(found)
    assert ("fast_p99_over_ustreamer" in found) == with_ustreamer
