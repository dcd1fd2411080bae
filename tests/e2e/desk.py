"""A desk as a process of its own, which serves the store of a folder."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from tests.forked import start_program
from tests.pace import PATIENCE_S


@asynccontextmanager
async def desk_of(folder: Path) -> AsyncIterator[str]:
    """Serve the store of a folder; yield the page's address. It must end by itself on SIGTERM."""
    command = [sys.executable, "-m", "hawk.cli", "desk", "--port", "0", "--store", str(folder)]
    process = await start_program(*command, stdout=asyncio.subprocess.PIPE, env={**os.environ, "PYTHONUNBUFFERED": "1"})
    assert process.stdout is not None
    try:
        async with asyncio.timeout(PATIENCE_S):
            line = (await process.stdout.readline()).decode()
        assert line.startswith("hawk: open http")
        yield line.split()[2]
        process.terminate()
        async with asyncio.timeout(PATIENCE_S):
            assert await process.wait() == 0
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
