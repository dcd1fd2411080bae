from __future__ import annotations

import asyncio
import re
import shutil
from asyncio.subprocess import PIPE, STDOUT
from pathlib import Path

import pytest

from hawk.comm.protocol.heartbeat import DroneStatus, HealthItem, PartsStatus, PerceptionStatus, VehicleStatus
from hawk.web.metrics import Access, computer_figures, metrics_text, processor_times, temperatures
from hawk.web.services import Counters
from tests.unit.web.rig import Rig

NO_BASE_UNIT = re.compile(
    r"_(percent|milliseconds|ms|minutes|hours|days|kilobytes|megabytes|mb|kb|bits|fahrenheit|kelvins?|kilometers|mv|ma)"
    r"(_|$)"
)
"""Units in place of which promtool wants ratio, seconds, bytes, celsius, metres, volts, amperes."""


def zone(thermal: Path, number: int, kind: str, temp: str) -> None:
    folder = thermal / f"thermal_zone{number}"
    folder.mkdir(parents=True)
    (folder / "type").write_text(f"{kind}\n")
    (folder / "temp").write_text(temp)


def test_temperatures_have_the_names_of_their_zones_and_broken_sensors_are_left_out(tmp_path: Path) -> None:
    zone(tmp_path, 0, "cpu-thermal", "48312\n")
    zone(tmp_path, 1, "acpitz", "27800\n")
    zone(tmp_path, 2, "acpitz", "30000\n")
    zone(tmp_path, 3, "iwlwifi", "")
    zone(tmp_path, 4, "cold", "-274000")
    (tmp_path / "thermal_zone5").mkdir()
    assert temperatures(tmp_path) == {"cpu-thermal": 48.312, "acpitz": 27.8, "acpitz-2": 30.0}


def test_processor_times_are_busy_and_idle(tmp_path: Path) -> None:
    stat = tmp_path / "stat"
    stat.write_text("cpu  100 20 30 4000 50 6 7 8 0 0\ncpu0 1 2 3\n")
    assert processor_times(stat) == {"busy": pytest.approx(1.71), "idle": pytest.approx(40.5)}
    stat.write_text("nonsense")
    assert processor_times(stat) == {}
    assert processor_times(tmp_path / "absent") == {}


def test_free_disk_and_our_own_time_are_read(tmp_path: Path) -> None:
    found = {name: value for name, _, _, value, _ in computer_figures(tmp_path)}
    assert 0 < found["disk_free_bytes"] <= found["disk_size_bytes"]
    assert found["cpu_seconds_total"] > 0
    assert "disk_free_bytes" not in {name for name, *_ in computer_figures(tmp_path / "absent")}


def all_metrics(tmp_path: Path) -> str:
    zone(tmp_path, 0, 'a "b" \\ c', "40000")
    rig = Rig()
    rig.publish(
        DroneStatus(
            vehicle=VehicleStatus(armed=True, battery_percentage=80.0),
            perception=PerceptionStatus(vision_rate=6.0),
            parts=PartsStatus(health=(HealthItem(name="link", healthy=True, reason=""),)),
        )
    )
    return metrics_text(rig.services(), Counters(frame_latency_s=0.1), Access(), computer_figures(tmp_path, tmp_path))


async def test_the_rules_of_prometheus_are_kept(tmp_path: Path) -> None:
    text = all_metrics(tmp_path)
    assert 'hawk_temperature_celsius{zone="a \\"b\\" \\\\ c"} 40.0' in text
    assert "hawk_battery_ratio 0.8" in text
    assert re.search(r'^hawk_build_info\{version="[^"]+",simulation="(true|false)"\} 1.0$', text, re.MULTILINE)
    kinds = dict(re.findall(r"^# TYPE (\w+) (\w+)$", text, re.MULTILINE))
    for name, kind in kinds.items():
        assert re.search(rf"^# HELP {name} \S", text, re.MULTILINE), name
        assert NO_BASE_UNIT.search(name) is None, name
        assert (kind == "counter") == name.endswith("_total"), name
        assert not re.search(r"_(bucket|count|sum)$|gauge|counter|histogram", name), name
    for labels in re.findall(r"\{(.*)\}", text):
        assert not {"quantile", "le"} & set(re.findall(r"(\w+)=", labels))


async def test_promtool_finds_nothing_to_say(tmp_path: Path) -> None:
    promtool = shutil.which("promtool")
    if promtool is None:
        pytest.skip("promtool is not installed (Debian's package prometheus)")
    text = all_metrics(tmp_path)
    checking = await asyncio.create_subprocess_exec(
        promtool, "check", "metrics", stdin=PIPE, stdout=PIPE, stderr=STDOUT
    )
    said, _ = await checking.communicate(text.encode())
    assert (checking.returncode, said) == (0, b"")
