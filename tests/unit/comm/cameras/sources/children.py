"""Small programs that stand for ``rpicam-vid`` and ``gst-launch-1.0``, and a look at what of them still runs."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from hawk.comm.cameras.sources.child import ChildTimeouts

SHORT = ChildTimeouts(first_s=10.0, silence_s=0.3, end_s=0.3)
"""A child that hangs is found out at once, one that starts slowly is not."""

_HEAD = """#!{python}
import os, signal, sys, time
folder = {folder!r}
runs = os.path.join(folder, "runs")
run = os.path.getsize(runs) if os.path.exists(runs) else 0
open(runs, "a").write("x")
open(os.path.join(folder, "pids"), "a").write(f"{{os.getpid()}} ")
jpeg = open(os.path.join(folder, "picture.jpg"), "rb").read()
arguments = sys.argv[1:]
out = sys.stdout.buffer


def hang():
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    while True:
        time.sleep(60)

"""
_PART = """

def picture(data=jpeg):
    out.write(b"--hawk-gstreamer\\r\\nContent-Type: image/jpeg\\r\\nContent-Length: %d\\r\\n\\r\\n" % len(data))
    out.write(data + b"\\r\\n")
    out.flush()

"""
_RPICAM = """
metadata = open(arguments[arguments.index("--metadata") + 1], "w")


def picture(stamp_ns=None, data=jpeg):
    out.write(data)
    out.flush()
    stamp = "" if stamp_ns is None else f"SensorTimestamp={stamp_ns}\\n"
    metadata.write(f"ExposureTime=4000\\n{stamp}AnalogueGain=1.5\\n\\n")
    metadata.flush()

"""


def program(folder: Path, jpeg: bytes, lines: str, kind: str = "") -> str:
    """Write a program and return its path. ``lines`` may use ``picture()``, ``hang()``, ``run`` (0, 1, ...)."""
    (folder / "picture.jpg").write_bytes(jpeg)
    path = folder / "program"
    head = _HEAD.format(python=sys.executable, folder=str(folder))
    path.write_text(head + (_RPICAM if kind == "rpicam" else _PART) + lines)
    path.chmod(0o700)
    return str(path)


def running(folder: Path) -> list[int]:
    """Return the numbers of the program's processes that still run."""
    pids = [int(word) for word in (folder / "pids").read_text().split()]
    return [pid for pid in pids if _is_running(pid)]


def _is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True
