"""A program that stores surveys and reports them, made to be killed: ``killed_sender.py STORE URL COUNT SINCE``.

It stores its next survey, up to COUNT in the store, and reports what the outbox has; it ends when all is reported. Its
clock runs a hundred times as fast since a moment (Unix seconds): waits are short, and seven days are not over.
"""

from __future__ import annotations

import asyncio
import sys
import time
from functools import partial
from pathlib import Path

from sqlalchemy import Connection, func, select

from hawk.config.sections import WebhooksSettings
from hawk.lots.saving import save
from hawk.lots.store import LotStore
from hawk.lots.tables import DELIVERY, OUTBOX, SURVEY
from hawk.webhooks.sender import SenderTimes, WebhookSender
from tests.unit.lots.surveys import later, survey

FASTER = 100.0
SECRET = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw"


def is_done(connection: Connection, count: int) -> bool:
    stored = connection.execute(select(func.count()).select_from(SURVEY)).scalar_one()
    messages = connection.execute(select(func.count()).select_from(OUTBOX)).scalar_one()
    sent = connection.execute(select(func.count()).select_from(DELIVERY).where(DELIVERY.c.sent.is_not(None)))
    return bool(stored >= count and messages == sent.scalar_one())


async def main(path: Path, url: str, count: int, since: float) -> None:
    store = LotStore(path)
    settings = WebhooksSettings(urls=(url,), secret=SECRET, allow_private=True)
    began = survey().ended
    sender = WebhookSender(
        store,
        settings,
        lambda: began + FASTER * (time.time() - since),
        lambda: False,
        print,
        SenderTimes(0.01, 2.0),
    )
    await store.open()
    print("ready", flush=True)
    task = asyncio.create_task(sender.run())
    while not await store.read(partial(is_done, count=count)):
        stored = await store.read(lambda c: c.execute(select(func.count()).select_from(SURVEY)).scalar_one())
        if stored < count:
            await store.write(partial(save, survey=later(survey(), stored, hours=0.001 * stored)))
        await asyncio.sleep(0.02)
    task.cancel()
    await store.close()


asyncio.run(main(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), float(sys.argv[4])))
