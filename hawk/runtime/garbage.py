"""Collection of garbage, put off while many objects are made that are all freed again."""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Iterator


@contextlib.contextmanager
def uncollected() -> Iterator[None]:
    """Put the collection of garbage off, for every thread.

    A list of a thousand surveys is ten thousand objects for a moment. The collector takes them for lasting ones, and
    after some such lists it looks at every object of the program, 0.2 s in which no thread runs. Once they are freed,
    by their counts of references, there is nothing to look at.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
