from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import pytest

from proving.faults.service import Service, socket_in


class Stack:
    """A daemon that ends at once whenever it is started."""

    def __init__(self) -> None:
        self.daemon: asyncio.subprocess.Process | None = None

    async def start_daemon(self) -> None:
        self.daemon = await asyncio.create_subprocess_exec(sys.executable, "-c", "raise SystemExit(7)")
        await self.daemon.wait()


@pytest.fixture
async def service(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Service:
    monkeypatch.setenv("NOTIFY_SOCKET", "")
    stack = Stack()
    await stack.start_daemon()
    return Service(cast("Any", stack), socket_in(tmp_path))


async def _wait(reached: Callable[[], bool]) -> None:
    for _ in range(2000):
        if reached():
            return
        await asyncio.sleep(0.01)
    raise AssertionError("it does not come")


async def test_a_daemon_that_ends_is_started_again(service: Service) -> None:
    service.start()
    await _wait(lambda: service.starts >= 2)
    await service.stop()
    assert service.exits[:2] == [7, 7]


async def test_a_withheld_daemon_stays_away_until_it_is_let_go(service: Service) -> None:
    service.withheld = True
    service.start()
    await _wait(lambda: bool(service.exits))
    await asyncio.sleep(0.1)
    assert (service.exits, service.starts) == ([7], 0)
    service.withheld = False
    await _wait(lambda: service.starts >= 1)
    await service.stop()
