"""The viewers, a process of their own: when pictures arrive, beside the stamps in them.

``python -m benchmarks.video.clients`` reads an `Order` as JSON from standard input and prints a `Report` as JSON.

One selector reads all of them, so that the viewers cost little and are served one after the other as the bytes come.
The slow one reads as many bytes as its link carries, into a small buffer of the kernel; the stalled one reads nothing
for some seconds.
"""

from __future__ import annotations

import json
import selectors
import socket
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Final

from benchmarks.video.wire import Reader, SocketReader, StreamReader

READ_BYTES: Final = 1 << 18
SLOW_TICK_S: Final = 0.002
SLOW_BUFFER_BYTES: Final = 32 * 1024
"""Buffer of the slow link; the kernel doubles it for its own use."""
CONNECT_S: Final = 10.0


@dataclass(frozen=True, slots=True)
class Order:
    """A task for the viewers: ``kind`` is "socket", "stream" or "ustreamer"; seconds are real."""

    kind: str
    host: str
    port: int
    path: str
    fast: int
    slow: int
    stalled: int
    slow_bytes_per_s: float
    warm_up_s: float
    seconds: float
    stall_s: float
    server_pid: int


@dataclass(slots=True)
class Report:
    """Age of each picture when its last byte came, milliseconds, by kind of viewer; what the server used meanwhile."""

    fast_ms: list[float] = field(default_factory=list)
    slow_ms: list[float] = field(default_factory=list)
    stalled_ms: list[float] = field(default_factory=list)
    fast_bytes: int = 0
    slow_bytes: int = 0
    cpu_s: float = 0.0
    memory_mb: float = 0.0
    seconds: float = 0.0


class Client:
    """One viewer."""

    def __init__(self, order: Order, ages: list[float], buffer_bytes: int | None = None) -> None:
        self._ages = ages
        self.bytes = 0
        """Of all pictures that were measured."""
        self.socket = socket.socket()
        if buffer_bytes is not None:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer_bytes)
        self.socket.settimeout(CONNECT_S)
        self.socket.connect((order.host, order.port))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        name = f"{order.host}:{order.port}"
        self._reader: Reader = (
            SocketReader(order.path, name, self.socket.sendall)
            if order.kind == "socket"
            else StreamReader(order.path, name, is_stamped=order.kind == "ustreamer")
        )
        self.socket.sendall(self._reader.request)
        self.socket.setblocking(False)

    def read(self, into: memoryview, is_measured: bool) -> int:
        """Read once; return the number of bytes, 0 when there are none. Raises ConnectionError at the end."""
        try:
            count = self.socket.recv_into(into)
        except BlockingIOError:
            return 0
        if count == 0:
            raise ConnectionError("the server closed a connection")
        now = time.monotonic_ns()
        for stamp, size in self._reader.feed(into[:count]):
            if is_measured:
                self._ages.append((now - stamp) / 1e6)
                self.bytes += size
        return count


class Slow:
    """Reads from a client at the pace of its link."""

    def __init__(self, client: Client, bytes_per_s: float, now: Callable[[], float] = time.monotonic) -> None:
        self.client = client
        self._bytes_per_s = bytes_per_s
        self._now = now
        self._since = now()

    def read(self, into: memoryview, is_measured: bool) -> None:
        """Read what the link has carried since the last call; what it could have carried before is lost."""
        now = self._now()
        allowed = int(min(now - self._since, 10 * SLOW_TICK_S) * self._bytes_per_s)
        self._since = now
        while allowed > 0:
            count = self.client.read(into[:allowed], is_measured)
            if count == 0:
                return
            allowed -= count


def run(order: Order) -> Report:
    """Watch for the warm-up and the measured seconds. Raises ConnectionError, WireError."""
    report = Report()
    selector = selectors.DefaultSelector()
    for ages, count in ((report.fast_ms, order.fast), (report.stalled_ms, order.stalled)):
        for _ in range(count):
            client = Client(order, ages)
            selector.register(client.socket, selectors.EVENT_READ, (client, ages is report.stalled_ms))
    slow = [Slow(Client(order, report.slow_ms, SLOW_BUFFER_BYTES), order.slow_bytes_per_s) for _ in range(order.slow)]
    begins = time.monotonic() + order.warm_up_s
    _watch(selector, slow, begins, lambda _now: False)
    cpu = cpu_seconds(order.server_pid)
    stall = begins + 0.2 * order.seconds
    _watch(selector, slow, begins + order.seconds, lambda now: stall <= now < stall + order.stall_s, is_measured=True)
    report.fast_bytes = sum(key.data[0].bytes for key in selector.get_map().values() if not key.data[1])
    report.slow_bytes = sum(each.client.bytes for each in slow)
    report.seconds = time.monotonic() - begins
    report.cpu_s = cpu_seconds(order.server_pid) - cpu
    report.memory_mb = memory_mb(order.server_pid)
    return report


def _watch(
    selector: selectors.BaseSelector,
    slow: list[Slow],
    until: float,
    is_stalled: Callable[[float], bool],
    *,
    is_measured: bool = False,
) -> None:
    into = memoryview(bytearray(READ_BYTES))
    aside: list[selectors.SelectorKey] = []
    while (now := time.monotonic()) < until:
        stalled = is_stalled(now)
        if stalled and not aside:
            aside = [key for key in selector.get_map().values() if key.data[1]]
            for key in aside:
                selector.unregister(key.fileobj)
        elif not stalled and aside:
            for key in aside:
                selector.register(key.fileobj, selectors.EVENT_READ, key.data)
            aside = []
        for key, _ in selector.select(SLOW_TICK_S if slow else 0.05):
            key.data[0].read(into, is_measured)
        for each in slow:
            each.read(into, is_measured)


def cpu_seconds(pid: int) -> float:
    """Return the processor seconds of a process so far: of all its threads, in nanoseconds (proc(5), schedstat)."""
    total = 0
    for task in Path(f"/proc/{pid}/task").iterdir():
        try:
            total += int((task / "schedstat").read_text().split()[0])
        except OSError:
            continue  # the thread has ended
    return total / 1e9


def memory_mb(pid: int) -> float:
    """Return the most memory that a process has held (VmHWM), megabytes."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) * 1024 / 1e6
    return float("nan")


if __name__ == "__main__":
    print(json.dumps(asdict(run(Order(**json.load(sys.stdin))))))
