from __future__ import annotations

import asyncio
import math

from hawk.comm.topic import Topic
from tests.manual_clock import ManualClock


def topic() -> tuple[Topic[int], ManualClock]:
    clock = ManualClock(10.0)
    return Topic("numbers", clock), clock


def test_nothing_was_published_yet() -> None:
    numbers, _ = topic()
    assert numbers.latest is None
    assert numbers.value is None
    assert numbers.age == math.inf
    assert numbers.fresh(1e9) is None


def test_a_reader_sees_the_newest_only_and_its_age() -> None:
    numbers, clock = topic()
    numbers.publish(1)
    clock.advance(1.0)
    numbers.publish(2)
    clock.advance(0.5)
    assert numbers.value == 2
    assert numbers.latest is not None
    assert numbers.latest.time == 11.0
    assert numbers.age == 0.5
    assert numbers.fresh(0.5) == 2
    assert numbers.fresh(0.4) is None


def test_listeners_are_called_in_order_until_they_end() -> None:
    numbers, _ = topic()
    heard: list[tuple[str, int]] = []
    end = numbers.listen(lambda value: heard.append(("first", value)))
    numbers.listen(lambda value: heard.append(("second", value)))
    numbers.publish(1)
    end()
    end()  # twice does no harm
    numbers.publish(2)
    assert heard == [("first", 1), ("second", 1), ("second", 2)]


def test_a_listener_may_end_itself_while_it_is_called() -> None:
    numbers, _ = topic()
    heard: list[int] = []

    def hear_once(value: int) -> None:
        heard.append(value)
        end()

    end = numbers.listen(hear_once)
    numbers.listen(heard.append)
    numbers.publish(1)
    numbers.publish(2)
    assert heard == [1, 1, 2]


async def test_everyone_who_waits_gets_the_next_value() -> None:
    numbers, _ = topic()
    numbers.publish(0)
    waiting = [asyncio.create_task(numbers.next()) for _ in range(3)]
    await asyncio.sleep(0)
    numbers.publish(7)
    assert await asyncio.gather(*waiting) == [7, 7, 7]


async def test_who_gives_up_waiting_is_forgotten() -> None:
    numbers, _ = topic()
    waiting = asyncio.create_task(numbers.next())
    await asyncio.sleep(0)
    waiting.cancel()
    await asyncio.gather(waiting, return_exceptions=True)
    numbers.publish(1)
    assert numbers.value == 1
