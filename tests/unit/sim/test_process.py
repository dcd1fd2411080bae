from __future__ import annotations

import asyncio
import os
import signal
import sys

import pytest

from hawk.runtime.process import ParentGoneError
from hawk.sim.cli import end_signal


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
async def test_a_signal_ends_it(number: int) -> None:
    with end_signal() as end:
        waiting = asyncio.create_task(end.wait())
        await asyncio.sleep(0)
        assert not waiting.done()
        os.kill(os.getpid(), number)
        async with asyncio.timeout(5.0):
            await waiting


async def test_the_end_of_the_parent_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hawk.runtime.process.started_s", lambda _: 0.0)  # a child of this test stands for a parent
    parent = await asyncio.create_subprocess_exec(
        sys.executable, "-c", "input()", stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.DEVNULL
    )
    with end_signal(parent.pid) as end:
        waiting = asyncio.create_task(end.wait())
        done, _ = await asyncio.wait({waiting}, timeout=0.1)
        assert not done
        parent.kill()
        async with asyncio.timeout(5.0):
            await waiting
    await parent.wait()


async def test_a_parent_that_is_gone_already_is_reported() -> None:
    parent = await asyncio.create_subprocess_exec(sys.executable, "-c", "")
    await parent.wait()
    with pytest.raises(ParentGoneError, match=str(parent.pid)), end_signal(parent.pid):
        pass


async def test_signals_are_given_back() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with end_signal():
        pass
    assert signal.getsignal(signal.SIGTERM) in (before, signal.SIG_DFL)
