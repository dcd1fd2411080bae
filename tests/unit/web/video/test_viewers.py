"""The service of all viewers, with transports and a topic in the hands of the test."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator
from typing import Any

import pytest

from hawk.comm.topic import Topic
from hawk.model.pictures import AnnotatedFrame
from hawk.web.video import viewers as module
from hawk.web.video.viewers import AT_ONCE, STEPS, Departure, End, SmallFrames, Viewer, Viewers
from tests.manual_clock import ManualClock
from tests.unit.comm.waiting import until


class Transport(asyncio.Transport):
    """Keeps what is written."""

    def __init__(self) -> None:
        super().__init__()
        self.written: list[bytes] = []
        self.unsent = 0
        self.closing = False

    def write(self, data: Any) -> None:
        self.written.append(bytes(data))

    def get_write_buffer_size(self) -> int:
        return self.unsent

    def is_closing(self) -> bool:
        return self.closing


class Small(SmallFrames):
    """Makes small pictures when the test says so."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: list[tuple[int, int, asyncio.Future[AnnotatedFrame]]] = []

    def of(self, frame: AnnotatedFrame, step: int) -> asyncio.Future[AnnotatedFrame]:
        made: asyncio.Future[AnnotatedFrame] = asyncio.get_running_loop().create_future()
        self.asked.append((frame.sequence, step, made))
        return made


class Setup:
    def __init__(self) -> None:
        self.video: Topic[AnnotatedFrame] = Topic("video", ManualClock())
        self.small = Small()
        self.counted: list[int] = []
        self.viewers = Viewers(self.video, lambda frame: self.counted.append(frame.sequence), self.small)
        self.viewers.start()

    async def publish(self, number: int) -> AnnotatedFrame:
        frame = AnnotatedFrame(number, 0.5, b"jpeg %d" % number)
        self.video.publish(frame)
        await turns()
        return frame


def wire(frame: AnnotatedFrame) -> bytes:
    return frame.jpeg


def whole(transport: Transport, *, is_acknowledged: bool = True) -> Viewer:
    viewer = Viewer(transport, wire, is_acknowledged=is_acknowledged)
    viewer.pace.step = 0
    return viewer


async def turns(count: int = 10) -> None:
    for _ in range(count):
        await asyncio.sleep(0)


@pytest.fixture
async def setup() -> AsyncIterator[Setup]:
    made = Setup()
    yield made
    made.viewers.close()


async def test_a_publication_writes_nothing_before_the_publisher_is_done(setup: Setup) -> None:
    transport = Transport()
    with setup.viewers.watching(whole(transport)):
        setup.video.publish(AnnotatedFrame(1, 0.5, b"x"))
        assert transport.written == []
        await turns()
        assert transport.written == [b"x"]
    assert setup.counted == [1]


async def test_the_loop_turns_to_other_things_between_viewers(setup: Setup) -> None:
    transports = [Transport() for _ in range(3 * AT_ONCE)]
    watching = [setup.viewers.watching(whole(transport)) for transport in transports]
    for each in watching:
        each.__enter__()
    setup.video.publish(AnnotatedFrame(1, 0.5, b"x"))
    served = []
    for _ in range(4):
        await asyncio.sleep(0)
        served.append(sum(len(transport.written) for transport in transports))
    assert max(b - a for a, b in zip([0, *served], served, strict=False)) == AT_ONCE
    assert served[-1] == 3 * AT_ONCE
    for each in watching:
        each.__exit__(None, None, None)


@pytest.mark.fault("sending to one viewer raises", "that viewer is ended, the others and the publisher go on")
async def test_a_viewer_that_raises_is_ended_and_the_others_are_served(
    setup: Setup, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(_frame: AnnotatedFrame) -> bytes:
        raise ValueError("broken")

    broken, transport = Viewer(Transport(), fail), Transport()
    broken.pace.step = 0
    with caplog.at_level(logging.ERROR), setup.viewers.watching(broken), setup.viewers.watching(whole(transport)):
        await setup.publish(1)
        assert broken.ended.result() is End.FAILED
        assert transport.written == [b"jpeg 1"]


async def test_the_newest_picture_follows_the_acknowledgement_and_none_is_sent_twice(setup: Setup) -> None:
    transport = Transport()
    viewer = whole(transport)
    with setup.viewers.watching(viewer):
        for number in (1, 2, 3):
            await setup.publish(number)
        setup.viewers.acknowledged(viewer, 2)
        assert transport.written == [b"jpeg 1"]
        setup.viewers.acknowledged(viewer, 1)
        setup.viewers.acknowledged(viewer, 1)
        assert transport.written == [b"jpeg 1", b"jpeg 3"]
        setup.viewers.acknowledged(viewer, 3)
        setup.viewers.acknowledged(viewer, 3)
        assert len(transport.written) == 2
    await setup.publish(4)
    assert len(transport.written) == 2  # nobody watches


async def test_a_small_picture_is_sent_when_it_is_made_and_an_early_acknowledgement_counts_for_nothing(
    setup: Setup,
) -> None:
    transport = Transport()
    viewer = Viewer(transport, wire)
    with setup.viewers.watching(viewer):
        first = await setup.publish(1)
        await setup.publish(2)
        ((sequence, step, made),) = setup.small.asked
        assert (sequence, step) == (1, STEPS)
        setup.viewers.acknowledged(viewer, 1)
        assert viewer.is_busy
        made.set_result(AnnotatedFrame(1, first.captured, b"small"))
        await turns()
        assert transport.written == [b"small"]
        setup.viewers.acknowledged(viewer, 1)
        assert transport.written == [b"small", b"jpeg 2"]  # the link was quick


async def test_a_small_picture_that_cannot_be_made_ends_its_viewer(setup: Setup) -> None:
    viewer = Viewer(Transport(), wire)
    with setup.viewers.watching(viewer):
        await setup.publish(1)
        setup.small.asked[0][2].set_exception(MemoryError())
        await turns()
        assert viewer.ended.result() is End.FAILED


async def test_nothing_is_written_to_a_closing_connection(setup: Setup) -> None:
    transport, asked = Transport(), Transport()
    waiting = Viewer(asked, wire)
    with setup.viewers.watching(whole(transport)), setup.viewers.watching(waiting):
        transport.closing = True
        await setup.publish(1)
        asked.closing = True
        setup.small.asked[0][2].set_result(AnnotatedFrame(1, 0.0, b"small"))
        await turns()
        assert transport.written == asked.written == []


async def test_without_acknowledgements_the_next_picture_waits_until_the_last_has_left(
    setup: Setup, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "LEFT_POLL_S", 0.001)
    transport = Transport()
    with setup.viewers.watching(whole(transport, is_acknowledged=False)):
        transport.unsent = 10
        await setup.publish(1)
        await setup.publish(2)
        await asyncio.sleep(0.02)
        assert transport.written == [b"jpeg 1"]
        transport.unsent = 0
        await until(lambda: len(transport.written) == 2)
        assert transport.written == [b"jpeg 1", b"jpeg 2"]


@pytest.mark.parametrize(
    ("seen", "stalled"),
    [
        ([(0.1, 50), (5.0, 40), (5.1, 0)], 4.9),  # nothing was read for a while
        ([(0.1, 50), (1.0, 40), (1.9, 30), (2.8, 0)], 0.0),  # slow, but always moving
        ([(0.1, 90), (1.7, 60), (3.4, 30), (5.1, 0)], 1.7),  # a link that often drops: one gap only is a pause
        ([(5.0, 0)], 0.0),  # seen once only
    ],
)
def test_a_pause_of_the_viewer_is_no_slowness_of_its_link(seen: list[tuple[float, int]], stalled: float) -> None:
    departure = Departure(0.0)
    assert [departure.is_over(now, unsent) for now, unsent in seen] == [unsent == 0 for _, unsent in seen]
    assert departure.stalled_s == pytest.approx(stalled)


async def test_gone_and_overdue_viewers_are_ended(setup: Setup, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "ACK_TIMEOUT_S", 0.01)
    gone, late = whole(Transport()), whole(Transport())
    with setup.viewers.watching(gone), setup.viewers.watching(late):
        await setup.publish(1)
        setup.viewers.acknowledged(gone, 1)
        gone.transport.closing = True  # type: ignore[attr-defined]
        async with asyncio.timeout(5):
            assert await late.ended is End.OVERDUE
            assert await gone.ended is End.GONE


async def test_streams_end_when_the_server_stops_and_all_when_the_service_closes(setup: Setup) -> None:
    acknowledged, streamed = whole(Transport()), whole(Transport(), is_acknowledged=False)
    with setup.viewers.watching(acknowledged), setup.viewers.watching(streamed):
        setup.viewers.end_streams()
        assert (streamed.ended.done(), acknowledged.ended.done()) == (True, False)
        setup.viewers.close()
        assert acknowledged.ended.result() is End.STOPPED
