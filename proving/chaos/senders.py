"""Senders of many drones in one process: ``python -m proving.chaos.senders FOLDER URL COUNT``.

Each has a store ``FOLDER/NN/lots.db`` and a token ``FOLDER/NN/token``, as a drone's daemon does.
"""

from __future__ import annotations

import asyncio
import logging
import sys
import time
from pathlib import Path
from typing import Final

from hawk.config.secrets import SecretUrl
from hawk.config.sections import CollectSettings, StoreSettings
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots.store import FILE, LotStore
from hawk.store.recordings import Recordings
from hawk.webhooks.delivery import SenderTimes
from hawk.webhooks.documents import DocumentSender

TIMES: Final = SenderTimes(look_s=1.0, try_s=20.0)
TOKEN: Final = "token"  # noqa: S105 - a file's name


async def send(folder: Path, url: str, count: int) -> None:
    """Send until cancelled."""
    stores = [LotStore(folder / f"{number:02d}" / FILE, find_stalls) for number in range(count)]
    async with asyncio.TaskGroup() as group:
        for store in stores:
            own = store.path.parent
            settings = CollectSettings(url=SecretUrl(url), token_file=own / TOKEN, recordings="asked")
            recordings = Recordings(StoreSettings(directory=own))
            sender = DocumentSender(
                store, settings, time.time, lambda: False, lambda *_: None, TIMES, recordings=recordings
            )
            group.create_task(sender.run())


if __name__ == "__main__":
    logging.basicConfig(level=logging.WARNING)
    asyncio.run(send(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])))
