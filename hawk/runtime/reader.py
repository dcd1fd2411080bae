"""Output whose reader has ended, as behind ``| head``: the program ends quietly, as others do."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Iterator
from typing import Final

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
