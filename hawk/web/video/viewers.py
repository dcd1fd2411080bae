"""All who watch the live pictures: each has one picture in flight, and receives the newest when the last has arrived.

One listener serves all viewers, without a task for each: sending a picture to a viewer costs one write.
"""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import logging
import math
import sys
import termios
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from enum import Enum
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.comm.topic import Topic
from hawk.formats.image import NoImage, decode, jpeg_size
from hawk.model.pictures import AnnotatedFrame
from hawk.web.video.video_wire import Wire, WireCache, sequence_of

STEPS: Final = 4
"""Steps below the whole picture; the number of the smallest one."""
LEAST_RATIO: Final = 1.5
"""Least ratio of a picture's bytes to those of the next smaller step."""
MOST_RATIO: Final = 3.0
"""Greatest ratio of a picture's bytes to those of the next smaller step, up to 1920 pixels wide."""
SLOW_S: Final = 1.0
"""Real seconds from sending a picture to its arrival, above which smaller ones follow."""
FRESH_S: Final = SLOW_S / MOST_RATIO
"""Real seconds within which pictures arrive before a larger step is tried: the larger one then takes `SLOW_S`."""
HOLD_S: Final = 5.0
"""Real seconds until the step of a slow picture is tried again, unless an acknowledged one shows room for it."""
LONGEST_HOLD_S: Final = 60.0
"""Real seconds until a step that was too large several times is tried again, at most."""
TRIAL_S: Final = 20.0
"""A slow picture within this time after a larger step shows that the step is too large, real seconds."""
_NONE: Final = -1


class LinkPace:
    """The step of one viewer's pictures."""

    def __init__(self, *, is_acknowledged: bool = True) -> None:
        """Begin with the smallest picture, which shows how fast the link is.

        Without acknowledgements by the viewer the first picture is whole: programs that read a stream scale every
        picture to the size of the first. There buffers may swallow a small picture, so that its arrival says little
        about a larger one: steps become larger by one at a time.
        """
        self.step = STEPS if is_acknowledged else 0
        self._is_acknowledged = is_acknowledged
        self._grown_at: float | None = None
        """Time of the last larger step while it is on trial."""
        self._grown_from = STEPS
        self._too_large = _NONE
        self._failed_at = float("-inf")
        self._hold_s = 0.0

    def arrived(self, now: float, seconds: float) -> None:
        """Note that a picture of the present step has arrived.

        Args:
            now: Real seconds.
            seconds: From sending it to its arrival; delay counts as if it were lack of speed.
        """
        if seconds > SLOW_S:
            self._shrink(now, seconds)
            return
        if self._grown_at is not None and now - self._grown_at > TRIAL_S:
            self._grown_at = None
            if self.step <= self._too_large:
                self._too_large, self._hold_s = _NONE, HOLD_S
        if self.step > 0 and seconds <= FRESH_S:
            self._grow(now, seconds)

    def _shrink(self, now: float, seconds: float) -> None:
        on_trial = self._grown_at is not None
        failed_again = on_trial and self.step <= self._too_large
        self._hold_s = min(2 * self._hold_s, LONGEST_HOLD_S) if failed_again else HOLD_S
        self._too_large, self._failed_at, self._grown_at = self.step, now, None
        smaller = math.ceil(math.log(seconds / SLOW_S) / math.log(LEAST_RATIO))
        was_enough = on_trial and seconds <= SLOW_S * MOST_RATIO  # else the link itself became slower
        self.step = min(self.step + max(1, smaller), self._grown_from if was_enough else STEPS)

    def _grow(self, now: float, seconds: float) -> None:
        room = math.floor(math.log(FRESH_S / max(seconds, 1e-6)) / math.log(MOST_RATIO)) if self._is_acknowledged else 0
        step = max(0, self.step - max(1, room))
        if room == 0 and now - self._failed_at < self._hold_s:  # room that an acknowledgement shows is not waited for
            step = max(step, self._too_large + 1)
        if step < self.step:
            self._grown_from, self.step = self.step, step
            self._grown_at = now


LOG = logging.getLogger(__name__)

ACK_TIMEOUT_S: Final = 10.0
"""Real seconds after which a viewer that does not acknowledge its picture, or does not read it, is disconnected."""
AT_ONCE: Final = 8
"""Viewers that are served before the loop turns to other things; 8 pictures of 100 kB take about half a millisecond."""
LEFT_POLL_S: Final = 0.01
"""Real seconds between two looks at whether pictures have left."""
SWEEP_S: Final = 0.25
"""Real seconds between two looks for viewers that have gone or do not read."""


class End(Enum):
    """Why a viewer is served no longer."""

    GONE = "the connection ended"
    OVERDUE = "frame not acknowledged"
    FAILED = "an error inside"
    STOPPED = "the drone's server stops"


class Viewer:
    """One connection: `ended` has a result when nothing more is sent."""

    def __init__(
        self,
        transport: asyncio.Transport,
        wire: Wire,
        *,
        is_acknowledged: bool = True,
        is_closed: Callable[[], bool] = lambda: False,
    ) -> None:
        """Take a connection whose answer has begun.

        Args:
            transport: Where the bytes go.
            wire: What this kind of viewer receives.
            is_acknowledged: True: `Viewers.acknowledged` is called for each picture. False: a picture has arrived when
                the system of the other side has received it. What buffers of the other side hold is not seen from here.
            is_closed: Returns True when nothing more may be sent.
        """
        self.transport = transport
        self.wire = wire
        self.pace = LinkPace(is_acknowledged=is_acknowledged)
        self.is_acknowledged = is_acknowledged
        self.ended: asyncio.Future[End] = asyncio.get_running_loop().create_future()
        self.sent: AnnotatedFrame | None = None
        """The last picture that was chosen for this viewer."""
        self.is_busy = False
        """True from the choice of a picture until it has arrived."""
        self.in_flight_since: float | None = None
        """Real seconds at which the picture was written; None while none is under way."""
        self.is_queued = False
        self._is_closed = is_closed
        found = transport.get_extra_info("socket")
        self._descriptor = None if found is None else found.fileno()

    @property
    def is_open(self) -> bool:
        """True while something may be sent."""
        return not (self.ended.done() or self.transport.is_closing() or self._is_closed())

    def unsent(self) -> int:
        """Return the bytes that the system of the other side has not received yet."""
        waiting = self.transport.get_write_buffer_size()
        return waiting if self._descriptor is None else waiting + unacknowledged(self._descriptor)

    def end(self, why: End) -> None:
        """Serve it no longer."""
        if not self.ended.done():
            self.ended.set_result(why)


class Departure:
    """A picture in flight to a viewer without acknowledgements, seen from time to time."""

    def __init__(self, now: float) -> None:
        """``now``: real seconds, as everywhere here."""
        self._unsent: int | None = None
        self._moved_at = now
        self.stalled_s = 0.0
        """Longest time without a byte, if longer than `SLOW_S`: a smaller picture would have waited as long."""

    def is_over(self, now: float, unsent: int) -> bool:
        """Note how many bytes have not arrived; return True when all have."""
        if unsent != self._unsent:
            waited = now - self._moved_at
            if self._unsent is not None and waited > SLOW_S:
                self.stalled_s = max(self.stalled_s, waited)
            self._unsent, self._moved_at = unsent, now
        return unsent == 0


class Viewers:
    """Serves every viewer with the newest picture: `start`, `watching`, `close`."""

    def __init__(
        self,
        video: Topic[AnnotatedFrame],
        handed_over: Callable[[AnnotatedFrame], None],
        small_frames: SmallFrames | None = None,
    ) -> None:
        """``handed_over`` is called with each picture that was written for a viewer."""
        self._video = video
        self._handed_over = handed_over
        self._small_frames = small_frames or SmallFrames()
        self._wires = WireCache()
        self._viewers: set[Viewer] = set()
        self._queue: deque[Viewer] = deque()
        self._leaving: dict[Viewer, Departure] = {}
        """Viewers without acknowledgements that have a picture in flight."""
        self._poll_timer: asyncio.TimerHandle | None = None
        self._sweep_timer: asyncio.TimerHandle | None = None
        self._stop: Callable[[], None] = lambda: None

    def start(self) -> None:
        """Serve from now on; needs the running loop."""
        self._loop = asyncio.get_running_loop()
        self._stop = self._video.listen(self._on_frame)
        self._sweep()

    def end_streams(self) -> None:
        """End the service of the viewers without acknowledgements; sockets are closed with a word."""
        for viewer in self._viewers:
            if not viewer.is_acknowledged:
                viewer.end(End.STOPPED)

    def close(self) -> None:
        """End the service, and the thread that makes small pictures."""
        self._stop()
        for viewer in self._viewers:
            viewer.end(End.STOPPED)
        for timer in (self._poll_timer, self._sweep_timer):
            if timer is not None:
                timer.cancel()
        self._small_frames.close()

    @contextlib.contextmanager
    def watching(self, viewer: Viewer) -> Iterator[None]:
        """Serve a viewer meanwhile, with the newest picture at once if there is one."""
        self._viewers.add(viewer)
        self._offer(viewer)
        try:
            yield
        finally:
            viewer.end(End.GONE)
            self._viewers.discard(viewer)
            self._leaving.pop(viewer, None)

    def acknowledged(self, viewer: Viewer, sequence: int | None) -> None:
        """Note that the picture with this sequence has arrived; that of another one is ignored."""
        if viewer.in_flight_since is not None and viewer.sent is not None and sequence_of(viewer.sent) == sequence:
            self._arrived(viewer)

    def _on_frame(self, _: AnnotatedFrame) -> None:
        """Listener of the topic: only notes who has to be served, so that it never holds up the publisher."""
        if not self._queue and self._viewers:
            self._loop.call_soon(self._serve)
        for viewer in self._viewers:
            if not viewer.is_queued:
                viewer.is_queued = True
                self._queue.append(viewer)

    def _serve(self) -> None:
        for _ in range(min(AT_ONCE, len(self._queue))):
            viewer = self._queue.popleft()
            viewer.is_queued = False
            self._offer(viewer)
        if self._queue:
            self._loop.call_soon(self._serve)

    def _offer(self, viewer: Viewer) -> None:
        """Send the newest picture if the viewer is ready for one and has not received it."""
        frame = self._video.value
        if frame is None or frame is viewer.sent or viewer.is_busy or not viewer.is_open:
            return
        viewer.sent, viewer.is_busy = frame, True
        if viewer.pace.step == 0:
            self._send(viewer, frame)
            return
        made = self._small_frames.of(frame, viewer.pace.step)
        if made.done():
            self._made(viewer, made)
        else:
            made.add_done_callback(lambda made: self._made(viewer, made))

    def _made(self, viewer: Viewer, made: asyncio.Future[AnnotatedFrame]) -> None:
        if made.cancelled():
            viewer.end(End.STOPPED)
        elif (error := made.exception()) is not None:
            LOG.error("a picture could not be made smaller", exc_info=error)
            viewer.end(End.FAILED)
        elif viewer.is_open:
            self._send(viewer, made.result())

    def _send(self, viewer: Viewer, fitting: AnnotatedFrame) -> None:
        try:
            viewer.in_flight_since = self._loop.time()
            viewer.transport.write(self._wires.of(viewer.wire, fitting))
            self._handed_over(fitting)
        except Exception:  # an error of one viewer must not reach the others
            LOG.exception("a picture could not be sent")
            viewer.end(End.FAILED)
            return
        if not viewer.is_acknowledged:
            self._leaving[viewer] = Departure(viewer.in_flight_since)
            if self._poll_timer is None:
                self._poll_timer = self._loop.call_later(LEFT_POLL_S, self._poll)

    def _arrived(self, viewer: Viewer, stalled_s: float = 0.0) -> None:
        now = self._loop.time()
        assert viewer.in_flight_since is not None  # noqa: S101 - narrows for the type checker
        viewer.pace.arrived(now, now - viewer.in_flight_since - stalled_s)
        viewer.in_flight_since, viewer.is_busy = None, False
        self._offer(viewer)

    def _poll(self) -> None:
        """Look which pictures have left for the other side."""
        self._poll_timer = None
        now = self._loop.time()
        for viewer, departure in tuple(self._leaving.items()):
            if viewer.is_open and departure.is_over(now, viewer.unsent()):
                del self._leaving[viewer]
                self._arrived(viewer, departure.stalled_s)
        if self._leaving and self._poll_timer is None:
            self._poll_timer = self._loop.call_later(LEFT_POLL_S, self._poll)

    def _sweep(self) -> None:
        now = self._loop.time()
        for viewer in tuple(self._viewers):
            if viewer.transport.is_closing():
                viewer.end(End.GONE)
            elif viewer.in_flight_since is not None and now - viewer.in_flight_since > ACK_TIMEOUT_S:
                viewer.end(End.OVERDUE)
        self._sweep_timer = self._loop.call_later(SWEEP_S, self._sweep)


def unacknowledged(descriptor: int) -> int:
    """Return the bytes in a TCP socket that the other side has not acknowledged; 0 where the system does not say."""
    try:
        return int.from_bytes(fcntl.ioctl(descriptor, termios.TIOCOUTQ, bytes(4)), sys.byteorder)
    except OSError:
        return 0


SMALL_WIDTH: Final = 320
"""Pixels of the smallest step; with its quality a picture of a lot has some 10 kB, an eighth of a whole one."""
QUALITIES: Final = (75, 67, 60, 52, 45)
"""JPEG qualities by step; that of step 0 is not used: whole pictures come encoded."""

_REDUCTIONS: Final = (1, 2, 4)
"""Parts of its size at which a JPEG is decoded for less time."""


class SmallFrames:
    """Makes the smaller forms of frames on a thread of its own."""

    def __init__(self) -> None:
        self._executor = ThreadPoolExecutor(1, thread_name_prefix="web-small-frames")
        self._maker = FrameShrinker()
        self._of: AnnotatedFrame | None = None
        self._made: dict[int, asyncio.Future[AnnotatedFrame]] = {}

    def of(self, frame: AnnotatedFrame, step: int) -> asyncio.Future[AnnotatedFrame]:
        """Return the form of a frame at a step from 1 to `STEPS`; the frame itself where it cannot be made smaller.

        The future is shared by all who ask: do not cancel it.
        """
        if self._of is not frame:
            self._of, self._made = frame, {}
        made = self._made.get(step)
        if made is None:
            made = asyncio.get_running_loop().run_in_executor(self._executor, self._maker.make, frame, step)
            self._made[step] = made
        return made

    def close(self) -> None:
        """End the thread."""
        self._executor.shutdown(wait=False, cancel_futures=True)


class FrameShrinker:
    """Decodes each frame at most once for the steps that need the same size; used by one thread."""

    def __init__(self) -> None:
        self._of: AnnotatedFrame | None = None
        self._pictures: dict[int, NDArray[np.uint8]] = {}

    def make(self, frame: AnnotatedFrame, step: int) -> AnnotatedFrame:
        """Return the frame at a step from 1 to `STEPS`; the frame itself where it has no picture, or a small one."""
        if self._of is not frame:
            self._of, self._pictures = frame, {}
        try:
            width, height = jpeg_size(frame.jpeg)
            size = (width_at(width, step), max(1, round(height * width_at(width, step) / width)))
            reduction = max(each for each in _REDUCTIONS if width >= each * size[0])
            if reduction not in self._pictures:
                self._pictures[reduction] = decode(frame.jpeg, reduction)
        except (NoImage, ValueError):
            return frame
        return frame if size[0] >= width else _encoded(frame, self._pictures[reduction], size, QUALITIES[step])


def width_at(whole: int, step: int) -> int:
    """Return the width in pixels at a step: from step to step by the same share, down to `SMALL_WIDTH`."""
    return whole if whole <= SMALL_WIDTH else round(whole * (SMALL_WIDTH / whole) ** (step / STEPS))


def _encoded(frame: AnnotatedFrame, picture: NDArray[np.uint8], size: tuple[int, int], quality: int) -> AnnotatedFrame:
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    done, data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return replace(frame, jpeg=data.tobytes()) if done and len(data) < len(frame.jpeg) else frame
