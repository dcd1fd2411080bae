"""Each value of the specification's heartbeat (18.4.5) under its own key, and each health under its own name.

Every number here differs from every other, so that one that stands for another is seen.
"""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hawk.algo.topic_interface import AlgorithmTopics
from hawk.config.sections import Config, StoreSettings, WatchdogSettings
from hawk.daemon.options import DaemonOptions
from hawk.daemon.root import Daemon
from hawk.model.lot_map import Counts, OccupancyMap
from hawk.model.operation import Health, StateName
from hawk.model.poses import GlobalPose, LocalPose, MapPose
from hawk.model.vehicle import BatteryInfo
from hawk.runtime.program_log import ProgramLog
from hawk.web.clients import ClientView
from hawk.web.sessions import ControlView
from tests.unit.ddc.fakes import PLACE, Rig

MAP = OccupancyMap(map_id="m", version=3, counts=Counts(free=5, taken=6, unknown=2))
LATITUDE, LONGITUDE = PLACE.latitude + 0.00011, PLACE.longitude + 0.00023


def heard(rig: Rig) -> dict[str, Any]:
    """Publish one moment in which every value differs; return the heartbeat that follows."""
    vehicle = rig.autopilot.topics
    rig.clock.advance(0.05)
    rig.autopilot.publish()
    rig.see()
    rig.inputs.mapper_health.publish(Health.bad("a mapper's fault"))
    assert vehicle.pose.value is not None
    vehicle.pose.publish(
        replace(
            vehicle.pose.value,
            global_=GlobalPose(LATITUDE, LONGITUDE, 231.0),
            relative_altitude=31.25,
            local=LocalPose(12.5, -7.75, -31.5),
            map=MapPose(13.5, -8.25, 30.75, 0.01, 0.02, 0.5),
            yaw=0.5,
        )
    )
    vehicle.battery.publish(BatteryInfo(81.0, 15.6, 14.2, rig.clock()))
    rig.manager.process()
    status = rig.manager.status.value
    assert status is not None
    found: dict[str, Any] = json.loads(ClientView().heartbeat(status, MAP, ControlView("Operator 1", in_control=True)))
    return found


async def test_the_heartbeat_has_each_value_of_the_specification_under_its_key(flying: Rig) -> None:
    flying.autopilot.below = lambda _north, _east: 4.0  # the height over ground is another than that over the arm place
    await flying.run(1.0)
    reported: dict[str, Any] = {}
    while reported.get("Relative Altitude") != 31.25:  # a status is due at every fourth tick
        reported = heard(flying)
    specified = {
        "Type": "Heartbeat",
        "State": "Hover",
        "Ardupilot State": "GUIDED",
        "Relative Altitude": 31.25,
        "Armed": True,
        "Latitude": LATITUDE,
        "Longitude": LONGITUDE,
        "Local Position X": 12.5,
        "Local Position Y": -7.75,
        "Battery Percentage": 81.0,
        "User Error": 0,
        "Health Status": 1,
    }
    assert {key: reported[key] for key in specified} == specified
    assert reported["Occupancy Map"]["Map Id"] == "m"
    assert len(specified) + 1 == 13


async def test_the_first_state_is_published_before_the_first_tick(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    assert rig.topics.curr_state_pub.value is StateName.IDLE
    await rig.close()


@pytest.mark.parametrize("part", ["vision", "mapper", "path_plan"])
async def test_each_part_s_health_is_its_own(part: str, rig: Rig) -> None:
    await rig.run(0.2)
    getattr(rig.inputs, f"{part}_health").publish(Health.bad(f"a fault of {part}"))
    healths = {
        "vision": rig.topics.get_vision_health(),
        "mapper": rig.topics.get_mapper_health(),
        "path_plan": rig.topics.get_path_plan_health(),
    }
    assert {name: health.reason for name, health in healths.items() if not health.is_healthy} == {
        part: f"a fault of {part}"
    }


@pytest.fixture
async def daemon(tmp_path: Path) -> AsyncIterator[Daemon]:
    output = ProgramLog("info")
    store = StoreSettings(directory=tmp_path / "store")
    made = Daemon(Config(store=store, watchdog=WatchdogSettings(enabled=False)), DaemonOptions(), output)
    yield made
    await made._close()
    output.close()


@pytest.mark.nightly
@pytest.mark.parametrize("part", ["vision", "mapper", "path_plan"])
async def test_the_daemon_takes_each_app_s_health_as_that_app_s(part: str, daemon: Daemon) -> None:
    results: AlgorithmTopics = daemon.results
    getattr(results, f"{part}_app_health").publish(Health.bad("broken"))
    bad = {
        name
        for name in ("vision", "mapper", "path_plan")
        if getattr(daemon.topics, f"get_{name}_health")().reason == "broken"
    }
    assert bad == {part}
