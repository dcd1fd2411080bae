"""The daemon's process: its tick, the watchdog that ends it when it hangs, its parent, the niceness of its threads.

MAVSDK's own threads keep talking to the autopilot when the Python loop hangs, so a hung process would hide from the
autopilot's failsafes: it has to end. The watchdog's timer is `faulthandler`'s, a C thread that needs no GIL. It writes
every stack first, and blocks for ever where nobody reads standard error. So the kernel's own timer (setitimer(2)) runs
beside it and ends the process by SIGALRM, which needs neither Python nor a write.

Linux's niceness (setpriority(2)) belongs to each thread, from -20 (first) to 19 (last), usually 0; a new thread
inherits it. Where the kernel shares the processor between sessions first (autogroups, sched(7)), niceness applies
within a session only, and each session has a niceness of its own.

A child that must not outlive its parent gets the parent's pid and watches it by a pidfd (pidfd_open(2)). Neither of the
other means is exact: getppid(2) and prctl(2)'s PR_SET_PDEATHSIG miss a parent that ended before the child asked, and a
pipe's end goes to every process that the parent forks.
"""

from __future__ import annotations

import asyncio
import contextlib
import faulthandler
import logging
import math
import os
import select
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Final, TextIO

_LOG = logging.getLogger(__name__)

LOOP_NICENESS = -5
"""Niceness of the event loop, of what it starts, and of the daemon's session; `hawk-drone.service` sets it too."""
WORKER_NICENESS = 10
"""Niceness of the vision worker."""
SIMULATOR_NICENESS = LOOP_NICENESS
"""Niceness of the simulator's session: a real drone and its camera do not slow down under the daemon's load."""
AUTOGROUP = Path("/proc/self/autogroup")
"""File with our session's niceness; absent where the kernel has no autogroups."""
PACE = 0.2
"""Share of the timeout after which progress is passed on again: each time `faulthandler` ends and starts a thread,
which on a busy machine delays the loop by up to tens of milliseconds."""

GROUND_S = 10.0
"""Least timeout where no drone can be in the air, real seconds: a busy computer that lets a start wait is no hang, and
a start that ends itself begins the same work again."""

DUMP_S = 0.5
"""Real seconds that `faulthandler` may take to write the stacks; then SIGALRM ends the process."""

SYSTEMD_S = 2.0
"""Real seconds after our own watchdog in which systemd's acts on the ground: a process that was stopped has none."""

END_S = 15.0
"""Real seconds for an orderly end: a part that never closes must not keep MAVSDK's heartbeats alive."""


class Ticker:
    """Ticks until it is stopped. Missed ticks are not made up for; one that raises does not end the ticking.

    Ticks keep to their schedule: after a late tick the next one comes at its scheduled time, but at least half an
    interval later. So what is done every N ticks (the heartbeat) keeps its rhythm.
    """

    def __init__(self, interval_s: float, tick: Callable[[], None], cost: Callable[[float], None]) -> None:
        """Make it; `start` begins.

        Args:
            interval_s: Real seconds between ticks.
            tick: Called at every tick.
            cost: Called after every tick with its duration, real seconds.
        """
        self._interval = interval_s
        self._tick = tick
        self._cost = cost
        self._handle: asyncio.TimerHandle | None = None
        self._due = 0.0

    def start(self) -> None:
        """Tick at once, then at the interval; needs the running loop."""
        self._due = asyncio.get_running_loop().time()
        self._run()

    def stop(self) -> None:
        """Stop ticking."""
        if self._handle is not None:
            self._handle.cancel()
            self._handle = None

    def _run(self) -> None:
        loop = asyncio.get_running_loop()
        late = loop.time() - self._due
        if self._interval > 0:
            self._due += max(1, math.ceil(late / self._interval + 0.5)) * self._interval
        self._handle = loop.call_at(self._due, self._run)
        started = time.perf_counter()
        try:
            self._tick()
        except Exception:
            _LOG.exception("a tick failed")
        self._cost(time.perf_counter() - started)


class SystemdNotifier:
    """The sd_notify protocol (man 3 sd_notify): datagrams to the socket that systemd names in NOTIFY_SOCKET."""

    def __init__(self, environment: Mapping[str, str] = os.environ) -> None:
        address = environment.get("NOTIFY_SOCKET", "")
        self._address = "\0" + address[1:] if address.startswith("@") else address
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) if address else None
        self._unit_us = environment.get("WATCHDOG_USEC", "")
        if self._socket is not None:
            self._socket.setblocking(False)

    def notify(self, message: str) -> None:
        """Send one assignment such as ``READY=1``; without systemd nothing happens."""
        if self._socket is None:
            return
        try:
            self._socket.sendto(message.encode(), self._address)
        except OSError:
            # systemd's queue may be full for a moment; the next progress repeats it
            return

    def expect(self, within_s: float | None) -> None:
        """Set the time within which systemd's own watchdog expects progress; None: that of the unit (WatchdogSec=)."""
        if self._unit_us:
            self.notify(f"WATCHDOG_USEC={self._unit_us if within_s is None else round(within_s * 1e6)}")

    def close(self) -> None:
        """Close the socket."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class Watchdog:
    """Ends this process ``timeout_s`` to 1.2 ``timeout_s`` real seconds after the last `progress`.

    Where no drone can be in the air the timeout is `GROUND_S` at least. Every stack goes to ``stream``; where it cannot
    be written, the process ends `DUMP_S` later without it.
    """

    def __init__(
        self,
        timeout_s: float,
        notifier: SystemdNotifier,
        stream: TextIO,
        enabled: bool = True,
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        """Nothing is armed before the first `progress`, which belongs on the main thread: it takes SIGALRM."""
        self._timeout = timeout_s
        self._notifier = notifier
        self._stream = stream
        self._enabled = enabled
        self._monotonic = monotonic
        self._due = -math.inf
        self._was_flying = True

    def progress(self, *, may_fly: bool) -> None:
        """Note a tick of the state machine: both watchdogs start again, at most once every `PACE` of the timeout.

        They start again at once when ``may_fly`` changes: False only where the drone is known to stand on the ground.
        """
        now = self._monotonic()
        if may_fly == self._was_flying and now < self._due:
            return
        timeout = self._timeout if may_fly else max(self._timeout, GROUND_S)
        self._due = now + timeout * PACE
        if self._enabled:
            end_within(timeout * (1 + PACE), self._stream)
        if may_fly != self._was_flying:
            self._notifier.expect(None if may_fly else timeout * (1 + PACE) + SYSTEMD_S)
            self._was_flying = may_fly
        self._notifier.notify("WATCHDOG=1")

    def ready(self) -> None:
        """Notify systemd that the daemon runs."""
        self._notifier.notify("READY=1")

    def stop(self) -> None:
        """Expect no more progress: the orderly end begins, and has `END_S`."""
        if self._enabled:
            end_within(END_S, self._stream)
        self._notifier.notify("STOPPING=1")
        self._notifier.close()


def end_within(timeout_s: float, stream: TextIO) -> None:
    """End this process after ``timeout_s`` real seconds, with every stack on ``stream``; a later call starts it again.

    The kernel ends it `DUMP_S` later by SIGALRM if the stacks cannot be written. Call it on the main thread.
    """
    # a parent may have left SIGALRM ignored or blocked
    if signal.getsignal(signal.SIGALRM) is not signal.SIG_DFL:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGALRM})
    signal.setitimer(signal.ITIMER_REAL, timeout_s + DUMP_S)
    faulthandler.dump_traceback_later(timeout_s, exit=True, file=stream)


class ParentGoneError(Exception):
    """The parent has ended; the text has its pid."""


@contextlib.contextmanager
def watched_parent(pid: int | None, ended: Callable[[], None]) -> Iterator[None]:
    """Call ``ended`` once, on the running loop, when the process ``pid`` ends; without a pid nothing is watched.

    Raises ParentGoneError where it has ended before, also where another process has its number now.
    """
    if pid is None:
        yield
        return
    loop = asyncio.get_running_loop()
    pidfd = _open_parent(pid)

    def has_ended() -> None:
        loop.remove_reader(pidfd)  # it stays readable
        ended()

    try:
        loop.add_reader(pidfd, has_ended)
        yield
    finally:
        loop.remove_reader(pidfd)
        os.close(pidfd)


def kill_with_parent(pid: int) -> None:
    """End this process by SIGKILL when the process ``pid`` ends: for work that can be cut off at any moment.

    Raises ParentGoneError as `watched_parent`.
    """
    pidfd = _open_parent(pid)

    def wait() -> None:
        select.select([pidfd], [], [])
        os.kill(os.getpid(), signal.SIGKILL)

    threading.Thread(target=wait, name="parent", daemon=True).start()


def _open_parent(pid: int) -> int:
    gone = ParentGoneError(f"no process {pid} that is older than this one")
    try:
        pidfd = os.pidfd_open(pid)
    except OSError as error:
        raise gone from error
    try:
        # a parent is no younger than its child; what is got the number after the parent had ended
        is_parent = started_s(pid) <= started_s(os.getpid())
    except OSError:  # it ended meanwhile
        is_parent = False
    if not is_parent:
        os.close(pidfd)
        raise gone
    return pidfd


def started_s(pid: int) -> float:
    """Return when the kernel started a process, seconds from boot (proc(5), stat, field 22). Raises OSError."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return int(fields[19]) / os.sysconf("SC_CLK_TCK")


def set_niceness(niceness: int) -> None:
    """Set the niceness of the calling thread; without the right to go before others (CAP_SYS_NICE) nothing changes."""
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), niceness)


def set_session_niceness(niceness: int, autogroup: Path = AUTOGROUP) -> None:
    """Set the niceness of our whole session, if we lead it: a session that others share is not ours to change.

    Without the right to go before others (CAP_SYS_NICE), and where there are no autogroups, nothing changes.
    """
    if os.getsid(0) == os.getpid() and autogroup.exists():
        with contextlib.suppress(OSError):
            autogroup.write_text(str(niceness))


READER_GONE: Final = 141
"""Exit status: 128 and the number of SIGPIPE, as shells give it."""


def readers_are_gone() -> bool:
    """Return whether standard output or standard error is a pipe that nobody reads any more."""
    asked = select.poll()
    for descriptor in _outputs():
        asked.register(descriptor, 0)
    return any(event & (select.POLLERR | select.POLLHUP) for _, event in asked.poll(0))


def lose_readers() -> None:
    """Send what is still to be written to nowhere: Python flushes its output at its end, and would fail again."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for descriptor in _outputs():
        os.dup2(nowhere, descriptor)
    os.close(nowhere)


def _outputs() -> Iterator[int]:
    """Yield the descriptors of the outputs; a test, or a program without a terminal, may have none."""
    for stream in (sys.stdout, sys.stderr):
        try:
            yield stream.fileno()
        except (AttributeError, OSError, ValueError):
            continue
