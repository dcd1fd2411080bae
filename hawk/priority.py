"""Which of our threads goes first where cores are few: the control loop and the autopilot's threads, then vision.

Linux's niceness (setpriority(2)) is each thread's own, from -20 (first) to 19 (last), 0 as a rule; a new thread has
that of the one that starts it.
"""

from __future__ import annotations

import contextlib
import os
import threading

LOOP_NICENESS = -5
"""Of the event loop and of what it starts; `hawk.service` sets the same for the whole process."""
WORKER_NICENESS = 10
"""Of the vision worker."""


def set_niceness(niceness: int) -> None:
    """Set the niceness of the calling thread; without the right to go before others (CAP_SYS_NICE) nothing changes."""
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), niceness)
