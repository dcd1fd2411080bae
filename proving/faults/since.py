"""Counts at the moment when a fault began, and what came of it since."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Awaitable, Mapping
from typing import Any


class Since:
    """Counts at the moment when the fault began."""

    def __init__(
        self,
        log: int = -1,
        exits: int = 0,
        starts: int = 0,
        passed: Counter[str] | None = None,
        truth: Mapping[str, Any] | None = None,
    ) -> None:
        self.log = log
        self.exits = exits
        self.starts = starts
        self.passed = passed or Counter()
        self.truth = truth or {}
        self.answers: list[str | None] = []
        self.flood: Awaitable[Any] | None = None
        self.surveying: asyncio.Task[None] | None = None
        self.survey: dict[str, float] = {}
