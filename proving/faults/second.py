"""A second daemon beside the one of the stack."""

from __future__ import annotations

import asyncio
from pathlib import Path

from hawk.sim.launch import end_process

_STOP_S = 12.0


class SecondProcess:
    """Its process, and its output in a file."""

    def __init__(self, log: Path) -> None:
        self._log = log
        self._process: asyncio.subprocess.Process | None = None

    async def start(self, command: list[str]) -> None:
        """Start it; whether it becomes ready is not waited for."""
        with self._log.open("wb") as log:
            self._process = await asyncio.create_subprocess_exec(
                *command, stdin=asyncio.subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True
            )

    @property
    def seen(self) -> tuple[int | None, str] | None:
        """Exit status (None: it runs) and output; None before it is started."""
        if self._process is None:
            return None
        return self._process.returncode, self._log.read_text(errors="replace")

    async def wait(self) -> None:
        """Wait for its end."""
        if self._process is not None:
            await self._process.wait()

    async def stop(self) -> None:
        """End it."""
        if self._process is not None:
            await end_process(self._process, _STOP_S)
