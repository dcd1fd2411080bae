"""Which of our threads goes first where cores are few: the control loop and the autopilot's threads, then vision.

Linux's niceness (setpriority(2)) is each thread's own, from -20 (first) to 19 (last), 0 as a rule; a new thread has
that of the one that starts it. Where the kernel shares the processor between sessions first (autogroups, sched(7)),
niceness counts within a session only, and the session has one of its own.
"""

from __future__ import annotations

import contextlib
import os
import threading
from pathlib import Path

LOOP_NICENESS = -5
"""Of the event loop, what it starts, and the daemon's session; `hawk-drone.service` sets the same for the process."""
WORKER_NICENESS = 10
"""Of the vision worker."""
SIMULATOR_NICENESS = LOOP_NICENESS
"""Of the simulator's session: a real drone and its camera are not slowed down by the companion computer's load."""
AUTOGROUP = Path("/proc/self/autogroup")
"""The niceness of our session; not there where the kernel has no autogroups."""


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
