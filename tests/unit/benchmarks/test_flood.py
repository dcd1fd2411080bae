from __future__ import annotations

import asyncio
from typing import Any

import pytest
from aiohttp import web

from benchmarks import flood
from benchmarks.figures import Figure
from benchmarks.flood import Run, Traffic, figures, void
from benchmarks.flood_viewers import valid_commands
from hawk.comm.protocol.commands import parse_command

QUIET = {"tick_p50_ms": 1.0, "tick_p99_ms": 3.0, "tick_max_ms": 8.0, "loop_lag_p99_ms": 5.0, "vision_fps": 9.0}


def run(tick_p99: float = 6.0, seconds: float = 60.0, others: float = 0.1) -> Run:
    flooded: dict[str, Any] = QUIET | {"tick_p99_ms": tick_p99}
    traffic = Traffic(sent=6000, answered=3000, refused_as_too_many=1500, disconnected=4, waits_ms=[10.0, 50.0, 90.0])
    return Run(QUIET, flooded, Traffic(waits_ms=[20.0, 25.0]), traffic, seconds, {"daemon": 0.9, "others": others})


def by_key(found: list[Figure]) -> dict[str, Figure]:
    return {figure.key: figure for figure in found}


def test_the_tick_stands_beside_the_tick_before_the_flood_and_its_limit() -> None:
    found = by_key(figures(run()))
    assert found["flood_tick_p99_ms"].ratio == pytest.approx(2.0)
    assert found["flood_tick_p99_ms"].passed
    assert not by_key(figures(run(tick_p99=10.1)))["flood_tick_p99_ms"].passed
    assert found["flood_answer_p50_ms"].value == 50.0
    assert found["flood_answer_max_ms"].ratio == pytest.approx(90 / 25)
    assert found["flood_sent_per_s"].value == pytest.approx(100.0)
    assert found["flood_refused_share"].value == pytest.approx(0.5)


def test_a_busy_machine_and_a_flood_too_short_for_the_daemons_figures_are_reported() -> None:
    assert void(run()) == ""
    assert "1.50 cores" in void(run(others=1.5))
    assert "lasted 12 s" in void(run(seconds=12.0))


def test_every_command_of_the_flood_is_valid() -> None:
    assert len({type(parse_command(text)) for text in valid_commands()}) == len(valid_commands())


@pytest.mark.slow
async def test_the_viewers_send_from_a_process_of_their_own_and_their_counts_come_back() -> None:
    heard = asyncio.Event()

    async def answer(request: web.Request) -> web.WebSocketResponse:
        socket = web.WebSocketResponse()
        await socket.prepare(request)
        async for _ in socket:
            heard.set()
            await socket.send_str('{"Type":"Ack","Reason":"Too many commands"}')
        return socket

    app = web.Application()
    app.router.add_get("/ws", answer)
    runner = web.AppRunner(app)
    await runner.setup()
    site = web.TCPSite(runner, "127.0.0.1", 0)
    await site.start()
    traffic = Traffic()
    try:
        async with flood._flood(f"http://127.0.0.1:{runner.addresses[0][1]}/", traffic, niceness=0):
            async with asyncio.timeout(30.0):
                await heard.wait()
    finally:
        await runner.cleanup()
    assert traffic.sent > 0
    assert traffic.answered >= traffic.refused_as_too_many
