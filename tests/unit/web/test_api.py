from __future__ import annotations

import re
from typing import Any

import pytest

from hawk.comm.protocol.heartbeat import (
    DroneStatus,
    HealthItem,
    OperationStatus,
    PartsStatus,
    PerceptionStatus,
    TravelStatus,
)
from hawk.config.sections import WebSettings
from hawk.model.lot_map import Counts, EncodedTile, OccupancyMap, Stall, StallState
from hawk.model.operation import StateName
from hawk.model.pictures import AnnotatedFrame
from tests.unit.web.rig import Connect, Rig, browser

HEALTHY = HealthItem(name="link", healthy=True, reason="")
ILL = HealthItem(name="camera", healthy=False, reason="No picture for 3 s")


def stall(number: int, state: StallState) -> Stall:
    return Stall(number, 5.0, 2.0 * number, 0.5, 2.6, 5.4, 0.1, state, 0.9, 4, 1.0, 1)


MAP = OccupancyMap(
    mosaic={(-1, 2): EncodedTile(3, b"jpeg of -1/2")},
    stalls={1: stall(1, StallState.FREE), 2: stall(2, StallState.TAKEN)},
    counts=Counts(1, 1, 0),
    lot_area_m2=120.0,
    map_id="m1",
)


async def get(rig: Rig, path: str, **options: Any) -> tuple[int, str, Any]:
    server = rig.server or await rig.start()
    async with browser() as session, session.get(server.make_url(path), **options) as response:
        return response.status, await response.text(), response.headers


async def get_json(rig: Rig, path: str) -> tuple[int, dict[str, Any]]:
    server = rig.server or await rig.start()
    async with browser() as session, session.get(server.make_url(path)) as response:
        return response.status, await response.json()


async def test_the_schema_describes_every_message(rig: Rig) -> None:
    status, schema = await get_json(rig, "/api/schema.json")
    assert status == 200
    assert {"Heartbeat", "Ack", "KillToken", "Welcome"} <= set(schema["fromDrone"])
    assert "Autonomous Explore" in str(schema["toDrone"])


async def test_a_mosaic_tile_and_its_caching(rig: Rig) -> None:
    assert (await get(rig, "/api/mosaic/-1/2.jpg"))[0] == 404
    rig.map.publish(MAP)
    status, body, headers = await get(rig, "/api/mosaic/-1/2.jpg?v=3&map=m1")
    assert (status, body, headers["Content-Type"]) == (200, "jpeg of -1/2", "image/jpeg")
    assert "immutable" in headers["Cache-Control"]
    _, _, headers = await get(rig, "/api/mosaic/-1/2.jpg?v=2")
    assert headers["Cache-Control"] == "no-cache"
    assert (await get(rig, "/api/mosaic/-1/2.jpg", headers={"If-None-Match": headers["ETag"]}))[0] == 304


@pytest.mark.parametrize("path", ["/api/mosaic/0/0.jpg", "/api/mosaic/a/b.jpg", "/api/mosaic/0/99999999999.jpg"])
async def test_a_tile_that_is_not_there_is_404(rig: Rig, path: str) -> None:
    rig.map.publish(MAP)
    assert (await get(rig, path))[0] == 404


async def test_the_report_is_of_the_present_map(rig: Rig) -> None:
    status, report = await get_json(rig, "/api/report.json")
    assert (status, report["stalls"], report["state"]) == (200, None, None)
    rig.map.publish(MAP)
    rig.publish(
        DroneStatus(
            operation=OperationStatus(state=StateName.HOVER),
            perception=PerceptionStatus(explored=0.5, free_range=(1, 4)),
            travel=TravelStatus(distance_flown=12.0),
        )
    )
    _, report = await get_json(rig, "/api/report.json")
    del report["version"], report["simulation"], report["utc"], report["datum"], report["explore_done"]
    assert report.pop("flight_time_s") is None
    assert report == {
        "stalls": 2,
        "free": 1,
        "taken": 1,
        "unknown": 0,
        "suggested": 0,
        "free_range": [1, 4],
        "lot_area_m2": 120.0,
        "explored": 0.5,
        "distance_flown_m": 12.0,
        "state": "Hover",
    }


async def test_health_is_bad_without_a_status_with_an_old_one_or_an_ill_part(rig: Rig) -> None:
    assert (await get_json(rig, "/api/health"))[0] == 503
    rig.publish(DroneStatus(parts=PartsStatus(health=(HEALTHY,))))
    status, health = await get_json(rig, "/api/health")
    assert (status, health["healthy"], health["running"]) == (200, True, True)
    rig.publish(DroneStatus(parts=PartsStatus(health=(HEALTHY, ILL))))
    status, health = await get_json(rig, "/api/health")
    assert status == 503
    assert health["parts"]["camera"] == {"healthy": False, "reason": "No picture for 3 s"}
    rig.publish(DroneStatus(parts=PartsStatus(health=(HEALTHY,))))
    rig.clock.advance(1.1)
    status, health = await get_json(rig, "/api/health")
    assert (status, health["running"]) == (503, False)


async def test_metrics_are_in_the_prometheus_text_format(rig: Rig) -> None:
    rig.publish(
        DroneStatus(perception=PerceptionStatus(free=3, vision_rate=9.5), parts=PartsStatus(health=(HEALTHY, ILL)))
    )
    rig.video.publish(AnnotatedFrame(1, rig.clock() - 0.2, b"jpeg"))
    status, text, headers = await get(rig, "/metrics")
    assert status == 200
    assert headers["Content-Type"].startswith("text/plain; version=0.0.4")
    sample = re.compile(r'[a-z_]+(\{[a-z]+="[^"]*"(,[a-z]+="[^"]*")*\})? (\+Inf|[-+.e\d]+)')
    names = set()
    for line in text.strip().splitlines():
        if line.startswith("# TYPE "):
            name, kind = line.split()[2:]
            assert name not in names, "one TYPE a name"
            assert (kind == "counter") == name.endswith("_total")
            names.add(name)
        elif not line.startswith("# HELP "):
            assert sample.fullmatch(line), line
            assert line.split("{")[0].split()[0] in names
    assert 'hawk_loop_lag_seconds{statistic="p99"} 0.004' in text
    assert 'hawk_stalls{state="free"} 3.0' in text
    assert 'hawk_healthy{part="camera"} 0.0' in text
    assert "hawk_vision_rate_hertz 9.5" in text
    assert "hawk_camera_pictures_damaged_total 7.0" in text
    assert "hawk_wrong_tokens_total 0.0" in text
    assert "hawk_connections_waiting 0.0" in text
    for name in ("resident_memory_bytes", "open_files", "open_sockets", "threads", "tasks"):
        assert re.search(rf"^hawk_{name} [1-9]", text, re.MULTILINE), name


async def test_what_waits_in_queues_is_counted(rig: Rig, connect: Connect) -> None:
    page = await connect()
    for number in range(3):
        await page.send(Type="Arm", Id=number)
    await page.ask(Type="Map Resync", Id="read")
    _, text, _ = await get(rig, "/metrics")
    assert 'hawk_queued{queue="commands"} 3.0' in text
    assert 'hawk_queued{queue="answers"} 0.0' in text
    assert 'hawk_queued{queue="journal"} 5.0' in text


async def test_it_is_alive_without_a_camera_and_without_a_login(rig: Rig) -> None:
    rig.web = WebSettings(token="a-token-of-a-test-0123456789")
    assert await get_json(rig, "/api/alive") == (503, {"running": False})
    rig.publish(DroneStatus(parts=PartsStatus(health=(HEALTHY, ILL))))
    assert await get_json(rig, "/api/alive") == (200, {"running": True})
    assert (await get(rig, "/api/health"))[0] == 401
    rig.clock.advance(1.1)
    assert await get_json(rig, "/api/alive") == (503, {"running": False})


async def test_metrics_leave_out_what_is_not_known(rig: Rig) -> None:
    _, text, _ = await get(rig, "/metrics")
    assert "vision_rate" not in text
    assert "nan" not in text.lower()
    assert "hawk_status_age_seconds +Inf" in text


async def test_all_settings_come_with_unit_bounds_and_value_and_without_the_token(rig: Rig) -> None:
    rig.web = WebSettings(token="a-token-of-a-test-0123456789")
    server = await rig.start()
    async with (
        browser() as session,
        session.get(
            server.make_url("/api/settings.json"), headers={"Authorization": "Bearer a-token-of-a-test-0123456789"}
        ) as response,
    ):
        text = await response.text()
        listed = {(each["Section"], each["Key"]): each for each in (await response.json())["Settings"]}
    reserve = listed["flight", "battery_reserve_percent"]
    assert (reserve["Value"], reserve["Unit"], reserve["Lowest"], reserve["Highest"]) == (20.0, "%", 5.0, 80.0)
    assert "battery reserve on arrival" in reserve["Text"]
    assert listed["web", "token"]["Value"] == "(set)"
    assert "0123456789" not in text
