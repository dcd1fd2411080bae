"""Waits for what happens on other threads or in other tasks, and fails loudly when it does not."""

from __future__ import annotations

import asyncio
from collections.abc import Callable


async def until(true: Callable[[], bool], timeout_s: float = 10.0) -> None:
    """Return as soon as ``true()`` is; TimeoutError when that takes too long."""
    async with asyncio.timeout(timeout_s):
        while not true():  # noqa: ASYNC110 - there is no event for what another thread does
            await asyncio.sleep(0.002)
