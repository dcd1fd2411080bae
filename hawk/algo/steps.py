"""Work in steps: a generator that yields after a few milliseconds of it and returns its outcome at the end.

A frame does one step of long work, so that no frame waits for the whole.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import TypeVar, cast

Outcome = TypeVar("Outcome")
Steps = Generator[None, None, Outcome]


def outcome(steps: Steps[Outcome]) -> Outcome:
    """Do all the steps of some work and return its outcome."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return cast("Outcome", end.value)
