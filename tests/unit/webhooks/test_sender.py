from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path

import aiohttp
import pytest
from sqlalchemy import func, select, update

from hawk.config.secrets import SecretUrl
from hawk.config.sections import WebhooksSettings
from hawk.lots.ingest import save
from hawk.lots.storage.schema import DELIVERY, OUTBOX
from hawk.lots.store import LotStore
from hawk.webhooks.delivery import WARNED_AT, SenderTimes
from hawk.webhooks.sender import WebhookSender, target_of
from tests.unit.comm.waiting import until
from tests.unit.lots.surveys import BEGAN, later, survey
from tests.unit.webhooks.receivers import Receiver, receiving

SECRET = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw"


class Stand:
    """A store with one survey, and a sender to a receiver."""

    def __init__(self, store: LotStore) -> None:
        self.store = store
        self.now = BEGAN + 1000.0
        self.is_flown = False
        self.said: list[tuple[str, str, str]] = []

    def sender(self, *urls: str, private: bool = True, try_s: float = 5.0) -> WebhookSender:
        settings = WebhooksSettings(urls=urls, secret=SECRET, allow_private=private)
        times = SenderTimes(look_s=0.01, try_s=try_s)
        return WebhookSender(
            self.store, settings, lambda: self.now, lambda: self.is_flown,
            lambda level, text, details: self.said.append((level, text, details)), times,
        )  # fmt: skip

    async def rows(self) -> list[tuple[int, int, bool]]:
        """Return message, tries and whether it was sent, of each delivery."""
        found = await self.store.read(lambda c: c.execute(select(DELIVERY)).all())
        return [(row.message, row.tries, row.sent is not None) for row in found]

    async def has(self, wanted: list[tuple[int, int, bool]]) -> None:
        """Wait until the deliveries are those wanted."""
        async with asyncio.timeout(10):
            while await self.rows() != wanted:  # noqa: ASYNC110 - another program may have written them
                await asyncio.sleep(0.005)

    async def add(self, number: int) -> None:
        await self.store.write(partial(save, survey=later(survey(), number)))

    async def damage(self, message: int) -> None:
        cut = update(OUTBOX).where(OUTBOX.c.seq == message).values(body=func.substr(OUTBOX.c.body, 1, 9))
        await self.store.write(lambda c: c.execute(cut).close())


@pytest.fixture
async def stand(tmp_path: Path) -> AsyncIterator[Stand]:
    store = LotStore(tmp_path / "lots.db")
    await store.write(partial(save, survey=survey()))
    yield Stand(store)
    await store.close()


@asynccontextmanager
async def running(sender: WebhookSender) -> AsyncIterator[None]:
    task = asyncio.create_task(sender.run())
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def types(receiver: Receiver) -> list[str]:
    return [json.loads(body)["type"] for _, body in receiver.got]


async def test_each_survey_and_layout_is_reported_once_and_signed(stand: Stand) -> None:
    async with receiving() as receiver, running(stand.sender(receiver.url)):
        await until(lambda: len(receiver.got) == 2)
        await stand.add(1)
        await stand.has([(1, 1, True), (2, 1, True), (5, 1, True)])
    assert types(receiver) == ["layout.changed", "survey.stored", "survey.stored"]
    assert len({headers["webhook-id"] for headers, _ in receiver.got}) == 3
    assert all(headers["webhook-signature"].startswith("v1,") for headers, _ in receiver.got)


@pytest.mark.slow
async def test_a_receiver_that_refuses_gets_the_same_message_again_later(stand: Stand) -> None:
    async with receiving() as receiver, running(stand.sender(receiver.url)):
        receiver.answer = 503
        await stand.has([(1, 1, False), (2, 1, False)])
        receiver.answer = 204
        stand.now += 60
        await until(lambda: len(receiver.got) == 4)
    first, again = receiver.got[0], receiver.got[2]
    assert first[1] == again[1]
    assert first[0]["webhook-id"] == again[0]["webhook-id"]
    assert first[0]["webhook-timestamp"] != again[0]["webhook-timestamp"]


@pytest.mark.slow
async def test_a_damaged_message_is_left_out_and_holds_up_no_other_one(stand: Stand) -> None:
    await stand.damage(1)
    async with receiving() as receiver, running(stand.sender(receiver.url)):
        await stand.has([(1, 1, False), (2, 1, True)])
        stand.now += 3600
        await stand.add(1)
        await stand.has([(1, 1, False), (2, 1, True), (5, 1, True)])
    assert types(receiver) == ["survey.stored", "survey.stored"]
    assert [text for _, text, _ in stand.said] == [
        f"A report to the receiver {SecretUrl(receiver.url).host} is damaged in the store: it is left out."
    ]


@pytest.mark.slow
async def test_a_receiver_that_hangs_holds_no_other_one(stand: Stand, caplog: pytest.LogCaptureFixture) -> None:
    async with receiving() as slow, receiving() as quick:
        slow.answer = "hang"
        async with running(stand.sender(slow.url, quick.url, try_s=0.4)):
            await until(lambda: len(quick.got) == 2)
            await until(lambda: len(slow.got) == 2)
            await until(lambda: sum("gave no answer within 0.4 s" in line for line in caplog.messages) == 2)


async def test_an_endless_answer_is_read_no_further(stand: Stand) -> None:
    async with receiving() as receiver:
        receiver.answer = "endless"
        async with running(stand.sender(receiver.url)):
            await stand.has([(1, 1, True), (2, 1, True)])
        assert receiver.sent_bytes < 20_000_000


async def test_a_redirect_is_not_followed_and_says_what_to_write(
    stand: Stand, caplog: pytest.LogCaptureFixture
) -> None:
    async with receiving() as receiver, running(stand.sender(receiver.url)):
        receiver.answer = "elsewhere"
        await until(lambda: len(receiver.got) == 2)
        await until(lambda: "write its final address into webhooks.urls" in caplog.text)


async def test_a_private_address_is_refused_unless_the_settings_allow_it(
    stand: Stand, caplog: pytest.LogCaptureFixture
) -> None:
    async with receiving() as receiver:
        by_name = receiver.url.replace("127.0.0.1", "localhost")
        async with running(stand.sender(receiver.url, by_name, private=False)):
            await until(lambda: sum("is in a private network" in line for line in caplog.messages) == 4)
        assert receiver.got == []
    assert "webhooks.allow_private = true" in caplog.text


async def test_nothing_is_sent_while_the_motors_are_on(stand: Stand) -> None:
    stand.is_flown = True
    async with receiving() as receiver, running(stand.sender(receiver.url)):
        for _ in range(20):
            await asyncio.sleep(0.005)
        assert receiver.got == []
        stand.is_flown = False
        await until(lambda: len(receiver.got) == 2)


@pytest.mark.slow
async def test_the_operator_hears_of_a_receiver_that_takes_nothing_and_of_the_end(stand: Stand) -> None:
    async with receiving() as receiver:
        receiver.answer = 500
        async with running(stand.sender(receiver.url)):
            for tries in range(1, WARNED_AT + 1):
                await stand.has([(1, tries, False), (2, tries, False)])
                stand.now += 3601
            await until(lambda: len(stand.said) == 2)
            assert {text for _, text, _ in stand.said} == {
                f"The receiver {SecretUrl(receiver.url).host} takes no report; it is tried on."
            }
            stand.now += 7 * 86_400
            await until(lambda: any("given up" in text for _, text, _ in stand.said))
    assert all(details == "answered HTTP 500" for *_, details in stand.said)


async def test_the_host_alone_of_a_receiver_is_named(stand: Stand, caplog: pytest.LogCaptureFixture) -> None:
    async with receiving() as receiver, running(stand.sender(f"{receiver.url}secret-path?key=abc")):
        receiver.answer = 500
        await until(lambda: "answered HTTP 500" in caplog.text)
    assert "secret-path" not in caplog.text
    assert "abc" not in caplog.text
    assert "secret" not in target_of(SecretUrl("https://example.org/secret"))


async def test_what_a_library_says_of_a_receiver_holds_no_secret(
    stand: Stand, caplog: pytest.LogCaptureFixture
) -> None:
    async def garbled(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(b"HTTP/1.1 two hundred\r\n\r\n")  # aiohttp's error holds the whole address
        await writer.drain()
        writer.close()

    server = await asyncio.start_server(garbled, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    async with server, running(stand.sender(f"http://me:word-Ab1@127.0.0.1:{port}/secret-path?key=abcdefgh")):
        await until(lambda: "400" in caplog.text)
        stand.now += 86_400
        await until(lambda: bool(stand.said) or caplog.text.count("400") > 1)
    said = caplog.text + repr(stand.said)
    assert not [each for each in ("word-Ab1", "secret-path", "abcdefgh") if each in said]


async def test_a_message_that_cannot_be_sent_ends_no_other_receiver(
    stand: Stand, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    async with receiving() as broken, receiving() as good:
        sender = stand.sender(broken.url, good.url)
        send = sender.send_one

        async def fails(session: aiohttp.ClientSession, url: SecretUrl) -> bool:
            if url.get_secret_value() == broken.url:
                raise RuntimeError("a bug")
            return await send(session, url)

        monkeypatch.setattr(sender, "send_one", fails)
        async with running(sender):
            await until(lambda: len(good.got) == 2)
            await until(lambda: caplog.text.count("a bug") > 1)


async def test_without_receivers_the_store_is_not_opened(tmp_path: Path) -> None:
    store = LotStore(tmp_path / "none.db")
    async with running(Stand(store).sender()):
        await asyncio.sleep(0.05)
    assert not store.is_open
    await store.close()
