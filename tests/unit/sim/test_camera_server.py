from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import replace
from datetime import datetime
from typing import Any

import aiohttp
import pytest

from hawk.sim.camera_server import Backend, CameraServer
from hawk.sim.faults import CameraFaults, Fault
from hawk.sim.flight_record import WatchedFence
from hawk.sim.geometry import Origin
from hawk.worlds.moment import clock_of
from hawk.worlds.stays import Demand, LotStays
from tests.unit.sim.camera.test_camera import Bench


class Site:
    """A server on a free port, and a client."""

    def __init__(self, bench: Bench, client: aiohttp.ClientSession) -> None:
        self.bench = bench
        self.client = client
        self.faults = CameraFaults()
        self.fences: list[WatchedFence | None] = []
        self.asked: list[Fault] = []
        self.problems: list[str] = []
        self.url = ""
        self.backend = Backend(
            camera=bench.camera,
            origin=Origin(),
            truth={"stalls": []},
            status=lambda: {"landed": True},
            watch_fence=self.fences.append,
            apply_fault=self._apply,
            faults=self.faults,
        )
        self.server = CameraServer(self.backend)

    def _apply(self, fault: Fault) -> list[str]:
        self.asked.append(fault)
        return self.problems

    async def expose_until(self, task: asyncio.Task[Any]) -> Any:
        """Let pictures come until a request is done."""
        height = 1.0
        while not task.done():
            self.bench.shot(height)
            height += 1.0
            await asyncio.wait({task}, timeout=0.01)
        return task.result()

    async def post(self, path: str, body: object) -> tuple[int, Any]:
        async with self.client.post(self.url + path, json=body) as answer:
            return answer.status, await answer.json()


@pytest.fixture
async def site() -> AsyncIterator[Site]:
    bench = Bench()
    async with aiohttp.ClientSession() as client:
        made = Site(bench, client)
        made.url = await made.server.start("127.0.0.1", 0)
        own = made.server
        yield made
        await own.stop()
        await bench.camera.close()


async def read_parts(site: Site, count: int) -> list[tuple[dict[str, str], bytes]]:
    async with site.client.get(f"{site.url}/stream") as answer:
        reader = aiohttp.MultipartReader.from_response(answer)
        parts = []
        for _ in range(count):
            part = await reader.next()
            assert isinstance(part, aiohttp.BodyPartReader)
            parts.append((dict(part.headers), bytes(await part.read())))
        return parts


async def test_every_part_has_its_length_and_stamp(site: Site) -> None:
    parts = await site.expose_until(asyncio.create_task(read_parts(site, 3)))
    for headers, body in parts:
        assert headers["Content-Type"] == "image/jpeg"
        assert int(headers["Content-Length"]) == len(body)
        assert headers["X-Timestamp"] == "100.000000"
        assert body[:2] == b"\xff\xd8"
        assert body[-2:] == b"\xff\xd9"


async def test_a_viewer_that_leaves_is_counted_out(site: Site) -> None:
    await site.expose_until(asyncio.create_task(read_parts(site, 1)))
    while site.bench.camera.is_watched:
        site.bench.shot(1.0)
        await asyncio.sleep(0.01)


async def test_a_snapshot(site: Site) -> None:
    async def get() -> tuple[int, bytes, str]:
        async with site.client.get(f"{site.url}/snapshot") as answer:
            return answer.status, await answer.read(), answer.headers["X-Timestamp"]

    status, body, stamp = await site.expose_until(asyncio.create_task(get()))
    assert (status, body[:2], stamp) == (200, b"\xff\xd8", "100.000000")


@pytest.mark.parametrize(("fault", "broken", "stamped"), [("garbage", True, True), ("unstamped", False, False)])
async def test_bad_parts(site: Site, fault: str, broken: bool, stamped: bool) -> None:
    setattr(site.faults, fault, True)
    ((headers, body),) = await site.expose_until(asyncio.create_task(read_parts(site, 1)))
    assert (body[-2:] != b"\xff\xd9") is broken
    assert ("X-Timestamp" in headers) is stamped


@pytest.mark.parametrize("path", ["/stream", "/snapshot"])
async def test_a_closed_camera_says_so(site: Site, path: str) -> None:
    site.faults.closed = True
    async with site.client.get(site.url + path) as answer:
        assert answer.status == 503


async def test_truth_and_status(site: Site) -> None:
    async with site.client.get(f"{site.url}/truth") as answer:
        assert await answer.json() == {"stalls": []}
    async with site.client.get(f"{site.url}/status") as answer:
        assert await answer.json() == {"frames_due": 0, "frames_drawn": 0, "frames_late": 0, "landed": True}


@pytest.fixture
def stays(site: Site) -> LotStays:
    """Stays of three stalls, which the site serves."""
    lot = LotStays(7, {k: Demand(0.5) for k in range(3)}, clock_of(Origin().longitude))
    site.server = CameraServer(replace(site.backend, stays=lot))
    return lot


async def ask(server: CameraServer, query: str) -> tuple[int, Any]:
    url = await server.start("127.0.0.1", 0)
    async with aiohttp.ClientSession() as client, client.get(f"{url}/truth?{query}") as answer:
        found = answer.status, await answer.json()
    await server.stop()
    return found


async def test_every_stay_of_a_time_is_served(site: Site, stays: LotStays) -> None:
    status, answer = await ask(site.server, "from=2026-05-04T10:00&to=2026-05-04T12:30")
    clock = clock_of(Origin().longitude)
    begin, end = datetime(2026, 5, 4, 10, tzinfo=clock), datetime(2026, 5, 4, 12, 30, tzinfo=clock)
    assert status == 200
    assert (answer["from"], answer["to"]) == (begin.isoformat(), end.isoformat())
    listed = [
        (one["stall"], datetime.fromisoformat(one["from"]), datetime.fromisoformat(one["to"]))
        for one in answer["stays"]
    ]
    assert listed == [(stay.stall, stay.begin, stay.end) for stay in stays.between(begin, end)]
    assert listed


@pytest.mark.usefixtures("stays")
@pytest.mark.parametrize(
    ("query", "field", "remedy"),
    [
        ("from=2026-05-04T10:00", "to", "is missing"),
        ("to=2026-05-04T10:00", "from", "is missing"),
        ("from=noon&to=2026-05-04T10:00", "from", "2026-05-04T10:30"),
        ("from=2026-05-04T10:00&to=2026-05-04", "to", "2026-05-04T10:30"),
        ("from=2026-05-04T10:00&to=2026-05-04T09:00", "to", "exchange"),
        ("from=2026-05-04T10:00&to=2026-06-24T09:00", "to", "ask for parts"),
        ("form=2026-05-04T10:00&to=2026-06-24T09:00", "form", "from and to"),
    ],
)
async def test_a_wrong_time_names_its_field_and_the_remedy(site: Site, query: str, field: str, remedy: str) -> None:
    status, answer = await ask(site.server, query)
    assert status == 400
    (error,) = answer["errors"]
    assert error["field"] == field
    assert remedy in error["problem"]


async def test_a_world_without_a_moment_has_no_stays(site: Site) -> None:
    async with site.client.get(f"{site.url}/truth?from=2026-05-04T10:00&to=2026-05-04T11:00") as answer:
        assert answer.status == 400
        assert "--at" in (await answer.json())["errors"][0]["problem"]


async def test_a_fence_is_watched_in_world_coordinates(site: Site) -> None:
    corners = [Origin().to_geodetic((n, e, 0.0))[:2] for n, e in ((0, 0), (20, 0), (20, 20), (0, 20))]
    assert await site.post("/fence", {"polygon": corners, "ceiling": 40.0}) == (200, {"watching": True})
    fence = site.fences[0]
    assert fence is not None
    assert fence.holds((10.0, 10.0, -30.0))
    assert fence.holds((-2.5, 10.0, -30.0))
    assert not fence.holds((-3.5, 10.0, -30.0))
    assert not fence.holds((10.0, 10.0, -43.5))


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({"polygon": [[43.0, -79.0], [43.1, -79.0]], "ceiling": 40}, "polygon"),
        ({"polygon": [[43.0, -79.0], [143.1, -79.0], [43, -79.1]], "ceiling": 40}, "polygon.1.0"),
        ({"polygon": [[43.0, -79.0], [43.1, -79.0], [43, -79.1]], "ceiling": -1}, "ceiling"),
        ({"polygon": [[43.0, -79.0], [43.1, -79.0], [43, -79.1]], "ceiling": 9, "height": 1}, "height"),
        ([1, 2], "body"),
    ],
)
async def test_a_wrong_fence_names_its_field(site: Site, body: object, field: str) -> None:
    status, answer = await site.post("/fence", body)
    assert status == 400
    assert answer["errors"][0]["field"] == field
    assert site.fences == []


async def test_faults_are_passed_on_and_problems_reported(site: Site) -> None:
    assert await site.post("/fault", {"gps": "lost"}) == (200, {"problems": []})
    assert site.asked[0].gps == "lost"
    site.problems.append("pilot_mode: no such mode 99")
    assert await site.post("/fault", {"pilot_mode": 99}) == (409, {"problems": site.problems})


async def test_what_is_no_json_is_refused(site: Site) -> None:
    async with site.client.post(f"{site.url}/fault", data=b"{") as answer:
        assert answer.status == 400
        assert "errors" in await answer.json()


async def test_stopping_ends_open_streams() -> None:
    bench = Bench()
    async with aiohttp.ClientSession() as client:
        made = Site(bench, client)
        made.url = await made.server.start("127.0.0.1", 0)
        async with client.get(f"{made.url}/stream") as answer:
            reading = asyncio.create_task(answer.content.read())
            start = asyncio.get_running_loop().time()
            await made.server.stop()
            await asyncio.wait({reading}, timeout=3.0)
            assert reading.done()
            reading.exception()
            assert asyncio.get_running_loop().time() - start < 3.0
    await bench.camera.close()
