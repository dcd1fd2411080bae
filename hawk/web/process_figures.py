"""Memory, open files, threads and tasks of this process: they show a leak long before it ends a flight."""

from __future__ import annotations

import asyncio
import os
import resource
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Final

PROC: Final = Path("/proc/self")


def process_figures(proc: Path = PROC) -> Mapping[str, tuple[str, float]]:
    """Return the figures by their name in ``/metrics``, each with its description (proc(5): statm, fd)."""
    resident = int((proc / "statm").read_text().split()[1]) * resource.getpagesize()
    files = open_files(proc)
    sockets = sum(name.startswith("socket:") for name in files)
    return {
        "resident_memory_bytes": ("Resident memory.", float(resident)),
        "open_files": ("Open descriptors, sockets among them.", float(len(files))),
        "open_sockets": ("Open sockets.", float(sockets)),
        "threads": ("Python's threads.", float(threading.active_count())),
        "tasks": ("Tasks of the event loop.", float(len(asyncio.all_tasks()))),
    }


def open_files(proc: Path = PROC) -> list[str]:
    """Return the targets of all descriptors; one that is closed meanwhile is left out."""
    found = []
    for name in os.listdir(proc / "fd"):
        try:
            found.append(str((proc / "fd" / name).readlink()))
        except OSError:
            continue
    return found
