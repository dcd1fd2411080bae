"""The daemon's side of the autopilot and the camera, through the real MAVSDK, against a hawk-sim that runs fast."""

from __future__ import annotations

import asyncio
import math
import threading
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hawk.comm.autopilot.autopilot import MavsdkAutopilot
from hawk.comm.autopilot.vehicle import AutopilotError, VehicleTopics
from hawk.comm.cameras.drone_camera import DroneCamera
from hawk.comm.clock import Clock
from hawk.config.sections import AutopilotSettings, CameraSettings
from hawk.model.plans import Fence
from hawk.model.poses import ArmPlace, MapPose
from hawk.model.vehicle import CopterMode, LandedState, StatusText
from tests.integration.sim_support import free_udp_port, get_json, simulation, small_picture
from tests.pace import PATIENCE_S, speed_here

pytestmark = pytest.mark.integration
SPEED = speed_here(4.0)
ANSWER_S = 2.0
"""A busy machine answers for a parameter within this, real seconds."""
HEIGHT = 8.0
ZONES = (((30.0, 30.0), (45.0, 30.0), (45.0, 45.0)), ((-40.0, -40.0), (-30.0, -40.0), (-30.0, -30.0), (-40.0, -30.0)))
FENCE = Fence((), ((-60.0, -60.0), (-60.0, 60.0), (60.0, 60.0), (60.0, -60.0)), 37.0, 40.0, autopilot_zones=ZONES)


class Rig:
    """The daemon's autopilot, and a simulation that is started when the test says so."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self._folder = folder
        self._stack = stack
        self._blocking = ThreadPoolExecutor(1, "test-blocking")
        self.port = free_udp_port()
        self.clock = Clock(SPEED)
        self.topics = VehicleTopics.create(self.clock)
        settings = AutopilotSettings(url=f"udpin://127.0.0.1:{self.port}")
        self.autopilot = MavsdkAutopilot(settings, self.clock, self.topics, parameter_answer_s=ANSWER_S)
        self.texts: list[StatusText] = []
        self.places: list[ArmPlace] = []
        self.jumps: list[float] = []
        self.topics.status_text.listen(self.texts.append)
        self.topics.arm_place.listen(self.places.append)
        self.topics.frame_jump.listen(self.jumps.append)
        self.http = ""

    async def blocking(self, call: Callable[[], Any]) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._blocking, call)

    async def start_simulation(self) -> None:
        arguments = (
            f"--world={small_picture(self._folder)}",
            "--metres-per-pixel=0.5",
            f"--speed={SPEED}",
            "--gnss-sigma=0",
            "--gnss-wait=2",
            f"--mavlink=udpout:127.0.0.1:{self.port}",
        )
        ready = await self.blocking(lambda: self._stack.enter_context(simulation(*arguments)))
        self.http = ready["http"]

    async def fault(self, **fields: Any) -> None:
        await self.blocking(lambda: get_json(f"{self.http}/fault", fields))

    async def status(self) -> Any:
        return await self.blocking(lambda: get_json(f"{self.http}/status"))

    async def until(self, true: Callable[[], bool], timeout_s: float = PATIENCE_S) -> None:
        """Wait until something holds: it is looked at whenever the autopilot says where it is, or a while passed."""
        try:
            async with asyncio.timeout(timeout_s):
                while not true():  # noqa: ASYNC110 - any topic may make it true
                    await asyncio.sleep(0.02)
        except TimeoutError:
            pytest.fail(f"not within {timeout_s} s: {self.topics.state.value}, {self.texts[-4:]}")

    @property
    def map(self) -> MapPose:
        pose = self.topics.pose.value
        assert pose is not None
        assert pose.map is not None
        return pose.map

    async def ready(self) -> None:
        """Wait until the vehicle can be armed."""
        await self.until(lambda: (found := self.topics.diagnostics.value) is not None and found.all_ok)
        await self.until(lambda: self.topics.pose.fresh(1.0) is not None)

    async def take_off(self) -> None:
        await self.autopilot.set_mode(CopterMode.GUIDED)
        await self.autopilot.arm()
        await self.until(lambda: self.topics.pose.value is not None and self.topics.pose.value.map is not None)
        await self.autopilot.takeoff(HEIGHT)
        await self.until(lambda: self.map.height > HEIGHT - 0.5)

    async def fly_to(self, north: float, east: float) -> None:
        """Send targets, as the state machine does, until the drone is there."""

        def there() -> bool:
            self.autopilot.send_target(north, east, HEIGHT, 0.5)
            return math.dist((self.map.north, self.map.east, self.map.height), (north, east, HEIGHT)) < 0.4

        await self.until(there)

    async def close(self) -> None:
        await self.autopilot.close()
        self._blocking.shutdown(wait=False)


@pytest.fixture
async def rig(tmp_path: Path) -> AsyncIterator[Rig]:
    with ExitStack() as stack:
        rig = Rig(tmp_path, stack)
        yield rig
        await rig.close()


async def test_a_flight_on_the_map_with_a_reset_of_ekf_local(rig: Rig) -> None:
    await rig.start_simulation()
    await rig.autopilot.start()
    await rig.ready()
    expected = {"FS_GCS_ENABLE": 0, "SYSID_MYGCS": 255, "FENCE_ENABLE": 0}
    assert {name: await rig.autopilot.get_parameter(name) for name in expected} == expected
    with pytest.raises(AutopilotError, match="MAV_GCS_SYSID"):
        await rig.autopilot.get_parameter("MAV_GCS_SYSID")
    assert await rig.autopilot.set_rtl_altitude(HEIGHT) == HEIGHT
    await rig.autopilot.upload_fence(FENCE)
    assert rig.autopilot.parameters["FENCE_ENABLE"] == 1
    with pytest.raises(AutopilotError, match="it has 2 exclusion zones, ours has 1"):
        await rig.autopilot.compare_fence(replace(FENCE, autopilot_zones=ZONES[:1]))
    await rig.autopilot.compare_fence(FENCE)

    await rig.autopilot.set_mode(CopterMode.BRAKE)
    with pytest.raises(AutopilotError, match="BRAKE mode not armable"):
        await rig.autopilot.arm()
    with pytest.raises(AutopilotError, match="refused"):
        await rig.autopilot.takeoff(HEIGHT)

    await rig.take_off()
    await rig.fly_to(8.0, -5.0)
    before = await rig.status()
    await rig.fault(ekf_shift=[30.0, -12.0, 1.5])
    await rig.until(lambda: bool(rig.jumps))
    assert rig.jumps[0] == pytest.approx(math.hypot(30.0, 12.0, 1.5), abs=0.3)
    await rig.until(lambda: rig.topics.pose.fresh(0.5) is not None)
    assert math.dist((rig.map.north, rig.map.east), (8.0, -5.0)) < 1.0
    await rig.fly_to(0.0, 5.0)
    after = await rig.status()
    assert _moved(before, after) == pytest.approx((-8.0, 10.0), abs=1.0)  # where it truly went

    await rig.autopilot.set_mode(CopterMode.RTL)
    await rig.until(lambda: not rig.topics.state.value.armed)  # type: ignore[union-attr]
    assert math.dist((rig.map.north, rig.map.east), (0.0, 0.0)) < 1.0
    await rig.until(lambda: rig.topics.state.value.landed is LandedState.ON_GROUND)  # type: ignore[union-attr]


def _moved(before: Any, after: Any) -> tuple[float, float]:
    """Return how far the true position moved, metres north and east (the simulation reports x east, y south)."""
    first, second = before["position"], after["position"]
    return first["y"] - second["y"], second["x"] - first["x"]


async def test_an_absent_autopilot_a_cut_link_and_a_boot(rig: Rig) -> None:
    await rig.autopilot.start()
    assert rig.topics.state.value is not None
    assert not rig.topics.state.value.connected
    with pytest.raises(AutopilotError, match="No link"):
        await rig.autopilot.arm()
    await rig.start_simulation()
    await rig.ready()
    await rig.autopilot.get_parameter("RTL_ALT")

    await rig.fault(link="cut")
    await rig.until(lambda: not rig.topics.state.value.connected)  # type: ignore[union-attr]
    with pytest.raises(AutopilotError, match="No link"):
        await rig.autopilot.set_mode(CopterMode.GUIDED)
    await rig.fault(link="ok")
    await rig.until(lambda: rig.topics.state.value.connected)  # type: ignore[union-attr]
    await rig.until(lambda: rig.topics.pose.fresh(0.5) is not None)

    boot = rig.autopilot.telemetry.from_boot(0.0)
    assert boot is not None
    await rig.fault(autopilot="power_cycle")
    await rig.until(lambda: (rig.autopilot.telemetry.from_boot(0.0) or 0.0) > boot + 1.0)
    assert rig.autopilot.parameters == {}
    await rig.ready()
    await rig.take_off()
    assert abs(rig.map.north) + abs(rig.map.east) < 1.0


async def test_kill_reaches_the_motors_while_every_other_thread_is_busy(rig: Rig) -> None:
    await rig.start_simulation()
    await rig.autopilot.start()
    await rig.ready()
    await rig.take_off()
    release = threading.Event()
    loop = asyncio.get_running_loop()
    loop.set_default_executor(ThreadPoolExecutor(1, "test-default"))
    waiting = [loop.run_in_executor(None, release.wait, PATIENCE_S) for _ in range(4)]
    waiting += [loop.create_task(rig.autopilot.calls.run("busy", release.wait, PATIENCE_S)) for _ in range(8)]
    await rig.autopilot.kill()
    assert not any(each.done() for each in waiting), "Kill waited for another call"
    await rig.until(lambda: not rig.topics.state.value.armed)  # type: ignore[union-attr]
    release.set()
    await asyncio.gather(*waiting, return_exceptions=True)


async def test_pictures_carry_the_moment_of_their_light_and_find_their_pose(rig: Rig) -> None:
    await rig.start_simulation()
    await rig.autopilot.start()
    settings = CameraSettings(url=f"{rig.http}/stream", reconnect_s=0.05)
    camera = DroneCamera(settings, rig.clock, rig.autopilot.telemetry.from_boot)
    camera.init()
    try:
        await rig.ready()
        for _ in range(5):
            async with asyncio.timeout(PATIENCE_S):
                frame = await camera.next_frame()
            assert (frame.width, frame.height) == (1280, 720)
        assert 0.0 <= frame.arrived - frame.captured < 2.0
        assert rig.autopilot.telemetry.pose_at(frame.captured) is not None
        assert camera.health.is_healthy
        await rig.fault(camera="closed")
        await rig.until(lambda: not camera.health.is_healthy)
        await rig.fault(camera="ok")
        await rig.until(lambda: camera.health.is_healthy)
    finally:
        await camera.close()
