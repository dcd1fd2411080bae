from __future__ import annotations

import asyncio
import json
from typing import Any

import aiohttp
import numpy as np
import pytest

from hawk.sim.autopilot.parameters import AutopilotOptions
from hawk.sim.camera.camera import Camera, Shot, SimulationClock
from hawk.sim.geometry import Origin
from hawk.sim.link.udp import UdpUrl
from hawk.sim.runner import CHUNK_S, Flyer, RunOptions, fly, follow
from tests.unit.sim.camera.test_camera import GreyRenderer, HandClock

NO_STALLS: dict[str, Any] = {"stalls": [], "lots_m": []}


class Shots(Camera):
    """Notes every shot."""

    def __init__(self, clock: SimulationClock) -> None:
        super().__init__(GreyRenderer(), clock, np.random.default_rng(1))
        self.shots: list[Shot] = []

    def expose(self, shot: Shot) -> None:
        self.shots.append(shot)


def options(**changes: Any) -> RunOptions:
    values: dict[str, Any] = {
        "start": (12.0, 30.0),
        "mavlink": UdpUrl("udpin", "127.0.0.1", 0),
        "http": ("127.0.0.1", 0),
        "autopilot": AutopilotOptions(start=(-30.0, 12.0), gnss_sigma=0.0, gnss_wait_s=0.5),
        **changes,
    }
    return RunOptions(**values)


def test_time_passes_with_the_clock_and_shots_come_in_their_slots() -> None:
    clock = HandClock()
    camera = Shots(clock)
    flyer = Flyer(options(), camera, clock)
    for _ in range(200):
        clock.real += 0.01
        flyer.advance()
    assert flyer.autopilot.time == pytest.approx(2.0, abs=0.011)
    assert len(camera.shots) in (30, 31)
    assert all(shot.stamp == shot.slot for shot in camera.shots)
    gaps = np.diff([shot.slot for shot in camera.shots])
    assert gaps.min() > 0.055
    assert gaps.max() < 0.08


def test_shots_come_at_the_rate_that_was_asked_for() -> None:
    clock = HandClock()
    camera = Shots(clock)
    flyer = Flyer(options(camera_rate=5.0), camera, clock)
    for _ in range(200):
        clock.real += 0.01
        flyer.advance()
    assert len(camera.shots) in (10, 11)
    assert np.diff([shot.slot for shot in camera.shots]) == pytest.approx(0.2, abs=0.011)


def test_the_speed_is_simulated_seconds_per_second() -> None:
    clock = HandClock(4.0)
    flyer = Flyer(options(speed=4.0), Shots(clock), clock)
    for _ in range(100):
        clock.real += 0.01
        flyer.advance()
    assert flyer.autopilot.time == pytest.approx(4.0, abs=0.011)


def test_what_was_missed_is_caught_up_in_pieces() -> None:
    clock = HandClock()
    flyer = Flyer(options(), Shots(clock), clock)
    clock.real += 1.0
    done = [flyer.advance()[1] for _ in range(5)]
    assert done[0] is False
    assert done[-1] is True
    assert flyer.autopilot.time == pytest.approx(1.0, abs=0.011)
    clock.real += CHUNK_S / 2
    assert flyer.advance()[1] is True


def test_the_camera_is_at_the_true_place_with_y_to_the_south() -> None:
    clock = HandClock()
    flyer = Flyer(
        options(autopilot=AutopilotOptions(start=(-30.0, 12.0), yaw=0.5, gnss_sigma=5.0)), Shots(clock), clock
    )
    flyer.autopilot.estimator.jump(50.0, 0.0, 0.0)
    shot = flyer.shot()
    assert (shot.x_east, shot.y_south, shot.height, shot.yaw) == (12.0, 30.0, 0.0, 0.5)


def test_equal_seeds_are_equal_flights() -> None:
    bodies = []
    for seed in (3, 3, 4):
        clock = HandClock()
        flyer = Flyer(options(seed=seed, autopilot=AutopilotOptions(gnss_sigma=1.0)), Shots(clock), clock)
        clock.real = 5.0
        while not flyer.advance()[1]:
            pass
        bodies.append(flyer.autopilot.estimate)
    assert bodies[0] == bodies[1] != bodies[2]


async def serve(half: Any, run: RunOptions) -> tuple[asyncio.Task[None], dict[str, str]]:
    said: asyncio.Queue[str] = asyncio.Queue()
    task = asyncio.create_task(half(NO_STALLS, GreyRenderer(), run, said.put_nowait))
    async with asyncio.timeout(10.0):
        return task, json.loads(await said.get())


async def end(task: asyncio.Task[None]) -> None:
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)


async def test_the_whole_drone_serves_truth_status_and_pictures() -> None:
    task, ready = await serve(fly, options())
    async with aiohttp.ClientSession() as client, asyncio.timeout(20.0):
        async with client.get(f"{ready['http']}/truth") as answer:
            truth = await answer.json()
        latitude, longitude, _ = Origin().to_geodetic((-30.0, 12.0, 0.0))
        assert (truth["start"]["latitude"], truth["start"]["longitude"]) == pytest.approx((latitude, longitude))
        assert truth["stalls"] == []
        async with client.get(f"{ready['http']}/snapshot") as answer:
            assert float(answer.headers["X-Timestamp"]) > 0
        async with client.post(f"{ready['http']}/fault", json={"wind": 5}) as answer:
            assert answer.status == 200
        async with client.get(f"{ready['http']}/status") as answer:
            status = await answer.json()
    assert status["landed"] is True
    assert status["frames_drawn"] >= 1
    assert abs(status["lag_s"]) < 1.0
    assert ready["mavlink"].startswith("udpin:127.0.0.1:")
    await end(task)


async def test_an_address_in_use_is_reported() -> None:
    task, ready = await serve(fly, options())
    port = int(ready["http"].rsplit(":", 1)[1])
    with pytest.raises(OSError, match="address already in use"):
        await fly(NO_STALLS, GreyRenderer(), options(http=("127.0.0.1", port)), lambda _: None)
    await end(task)


@pytest.mark.slow
async def test_the_camera_alone_follows_another_drone() -> None:
    following, eye = await serve(follow, options())
    port = eye["mavlink"].rsplit(":", 1)[1]
    flying, _ = await serve(fly, options(mavlink=UdpUrl("udpout", "127.0.0.1", int(port)), speed=4.0))
    async with aiohttp.ClientSession() as client, asyncio.timeout(20.0):
        async with client.get(f"{eye['http']}/snapshot") as answer:
            assert answer.status == 200
        async with client.get(f"{eye['http']}/status") as answer:
            status = await answer.json()
        assert status["following"] is True
        assert (status["position"]["x"], status["position"]["y"]) == pytest.approx((12.0, 30.0), abs=0.1)
        async with client.post(f"{eye['http']}/fault", json={"gps": "lost"}) as answer:
            assert (answer.status, await answer.json()) == (
                409,
                {"problems": ["gps: only the camera can fail here"]},
            )
    await end(flying)
    await end(following)


async def test_a_camera_that_follows_nobody_says_so() -> None:
    task, ready = await serve(follow, options())
    async with aiohttp.ClientSession() as client, client.get(f"{ready['http']}/status") as answer:
        assert (await answer.json())["following"] is False
    await end(task)
