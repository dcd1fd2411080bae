"""Transfer of files that come to a desk in the body of a request, and the thread that writes them.

A sender that falls silent is given up. In memory is one piece.
"""

from __future__ import annotations

import asyncio
import errno
from collections.abc import AsyncIterator, Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Final, TypeVar

from aiohttp import web

SILENCE_S: Final = 60.0
"""Real seconds without a byte after which a file is given up."""
CHUNK_BYTES: Final = 256 * 1024
FULL: Final = frozenset((errno.ENOSPC, errno.EDQUOT))
"""Errors of a disk that has no room."""
_WRITER: Final = web.AppKey("file_transfer", ThreadPoolExecutor)
T = TypeVar("T")


def prepare(app: web.Application) -> None:
    """Make the thread that writes."""
    app.cleanup_ctx.append(_writer)


async def write_away(request: web.Request, work: Callable[[], T]) -> T:
    """Return what the thread that writes did. Raises what the work raises."""
    return await asyncio.get_running_loop().run_in_executor(request.app[_WRITER], work)


async def receive(request: web.Request, write: Callable[[bytes], Awaitable[object]]) -> None:
    """Write what comes. Raises HTTPRequestTimeout, those of ``write``, and those of a lost connection."""
    clock = asyncio.get_running_loop().time
    try:
        async with asyncio.timeout(SILENCE_S) as limit:
            async for chunk in request.content.iter_chunked(CHUNK_BYTES):
                limit.reschedule(None)
                await write(chunk)
                limit.reschedule(clock() + SILENCE_S)
    except TimeoutError:
        raise web.HTTPRequestTimeout(text="The file did not come.") from None


async def _writer(app: web.Application) -> AsyncIterator[None]:
    with ThreadPoolExecutor(1, thread_name_prefix="web-file-transfer") as executor:
        app[_WRITER] = executor
        yield
