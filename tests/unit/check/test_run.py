from __future__ import annotations

import asyncio
import errno
import io
import json
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from rich.console import Console

from hawk import cli
from hawk.algo.vision.network import NetworkMaps
from hawk.algo.vision.network_file import VisionModelError
from hawk.check import actions
from hawk.check.camera import CameraTimes
from hawk.check.machine import DiskReading, ground_size, look_at_model
from hawk.check.network import NetworkTools
from hawk.check.result import (
    CheckResult,
    Look,
    Outcome,
    all_passed,
    as_object,
    failed,
    last_line,
    not_looked_at,
    passed,
    print_json,
    print_table,
    run_looks,
    warning,
)
from hawk.check.run import Tools, check_all
from hawk.comm.clock import Clock
from hawk.config.loader import load_settings
from hawk.config.sections import Config, ConfigError
from hawk.runtime.programs import Kind, Processes
from hawk.web.access.tls import RELEASED
from tests.unit.check.fakes import GOOD, FakeVehicle, Pictures
from tests.unit.comm.cameras.pictures import picture

CONFIG = Config.model_validate({"remote_control": {"required": False}})


def tools(proc: Path, vehicle: FakeVehicle, taken: int | None = None) -> Tools:
    def bind(_kind: Kind, _host: str, port: int) -> None:
        if port == taken:
            raise OSError(errno.EADDRINUSE, "Address already in use")

    return Tools(
        NetworkTools(bind, Processes(proc), lambda: ["10.0.0.5"]),
        vehicle.tools(proc),
        lambda _settings, clock: Pictures(picture(), clock),
        CameraTimes(0.5, 0.5),
        lambda folder: DiskReading(folder, 10**11, 5e7, owner=1000),
        lambda: True,
        lambda _config: passed("Model", "fast"),
        lambda: RELEASED.timestamp() + 10.0,
        lambda: RELEASED,
    )


@pytest.mark.nightly
async def test_a_drone_in_order_passes_every_check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hawk.check.run.os.geteuid", lambda: 1000)
    config = CONFIG.model_copy(update={"store": CONFIG.store.model_copy(update={"directory": tmp_path})})
    found = await check_all(lambda: config, tools(tmp_path, FakeVehicle(GOOD)), Clock())
    assert all(each.outcome is Outcome.PASSED for each in found), found
    names = [each.name for each in found]
    for name in ("Configuration", "Camera", "Autopilot", "Store", "Disk space", "Page's port", "Autopilot's port"):
        assert name in names
    assert {"Clock", "Network", "Tokens", "Certificate", "Model"} <= set(names)
    assert len(names) == len(set(names))


async def test_wrong_settings_fail_and_the_rest_is_not_looked_at(tmp_path: Path) -> None:
    def load() -> Config:
        raise ConfigError("web.port: must lie between 0 and 65535")

    vehicle = FakeVehicle(GOOD)
    found = {each.name: each for each in await check_all(load, tools(tmp_path, vehicle), Clock())}
    assert found["Configuration"].outcome is Outcome.FAILED
    assert "web.port" in found["Configuration"].value
    assert found["Autopilot"].outcome is found["Camera"].outcome is Outcome.NOT_LOOKED_AT
    assert found["Clock"].outcome is Outcome.PASSED  # it needs no settings
    assert vehicle.links == []


@pytest.mark.slow
async def test_an_autopilot_whose_port_is_taken_is_not_opened(tmp_path: Path) -> None:
    vehicle = FakeVehicle(GOOD)
    found = {each.name: each for each in await check_all(lambda: CONFIG, tools(tmp_path, vehicle, 14550), Clock())}
    assert found["Autopilot's port"].outcome is Outcome.FAILED
    assert found["Autopilot"].outcome is Outcome.NOT_LOOKED_AT
    assert vehicle.links == []


@pytest.mark.slow
async def test_a_check_that_breaks_leaves_the_others(tmp_path: Path) -> None:
    def broken(_folder: Path) -> DiskReading:
        raise RuntimeError("a fault inside")

    wrong = replace(tools(tmp_path, FakeVehicle(GOOD)), read_disk=broken)
    found = {each.name: each for each in await check_all(lambda: CONFIG, wrong, Clock())}
    assert found["Store"].outcome is Outcome.FAILED
    assert "a fault inside" in found["Store"].value
    assert found["Autopilot"].outcome is Outcome.PASSED


async def test_a_check_that_hangs_fails_at_its_deadline() -> None:
    ended: list[str] = []

    async def hang() -> Sequence[CheckResult]:
        try:
            await asyncio.sleep(60)
        finally:
            ended.append("released")
        return []

    async def quick() -> Sequence[CheckResult]:
        return [passed("Quick", "well")]

    begun = time.monotonic()
    found = await run_looks([Look("Slow", hang, 0.1), Look("Quick", quick, 0.1)])
    assert time.monotonic() - begun < 10
    assert [(each.name, each.outcome) for each in found] == [("Slow", Outcome.FAILED), ("Quick", Outcome.PASSED)]
    assert ended == ["released"]


ALL = [passed("A", "one"), warning("B", "two", "do this"), failed("C", "three", "do that"), not_looked_at("D", "four")]


@pytest.mark.parametrize(("count", "is_well"), [(0, False), (1, True), (2, True), (3, False)])
def test_warnings_pass_and_what_was_not_looked_at_does_not(count: int, is_well: bool) -> None:
    assert all_passed(ALL[:count]) is is_well
    assert not all_passed([ALL[0], ALL[3]])


def test_the_table_shows_every_result_and_remedy() -> None:
    shown = io.StringIO()
    print_table(Console(file=shown, width=100), [*ALL, failed("E", "serial [/dev/x] [red]", "sudo [a]")])
    text = shown.getvalue()
    for each in ALL:
        assert all(word in text for word in (each.name, each.value, each.remedy, each.outcome.value))
    assert "[/dev/x] [red]" in text  # no markup
    assert "1 passed, 1 warning, 2 failed, 1 not looked at." in text
    assert "can be started" in last_line(ALL[:2])


def test_json_is_one_object_whatever_the_console_s_width() -> None:
    shown = io.StringIO()
    print_json(Console(file=shown, width=20), [failed("C", "long words " * 30 + "[bold]", "do")])
    said = json.loads(shown.getvalue())
    assert said["passed"] is False
    assert said["checks"][0]["outcome"] == "failed"
    assert as_object(ALL[:2])["passed"] is True


def maps(_picture: NDArray[np.uint8]) -> NetworkMaps:
    empty = np.zeros((1, 1), np.float32)
    return NetworkMaps(*(empty,) * 12)


@pytest.mark.parametrize(("seconds", "outcome"), [(0.2, Outcome.PASSED), (0.4, Outcome.WARNING)])
def test_a_network_too_slow_for_the_flight_is_a_warning(seconds: float, outcome: Outcome) -> None:
    moments = iter(np.arange(0.0, 60.0, seconds))
    found = look_at_model(CONFIG, lambda _: maps, lambda: float(next(moments)))
    assert found.outcome is outcome
    assert f"{seconds * 1000:.0f} ms" in found.value


def test_a_network_that_cannot_be_used_fails(tmp_path: Path) -> None:
    def load(_config: Config) -> None:
        raise VisionModelError("vision.model: x.onnx cannot be read")

    assert look_at_model(CONFIG, load).outcome is Outcome.FAILED  # type: ignore[arg-type]
    wrong = tmp_path / "wrong.onnx"
    wrong.write_bytes(b"no network")
    config = Config.model_validate({"vision": {"model": wrong}})
    assert look_at_model(config).outcome is Outcome.FAILED


def test_the_package_s_network_looks_at_a_frame() -> None:
    low = Config.model_validate({"heights": {"minimum_m": 6, "desired_m": 8}})
    assert ground_size(low) == (112, 64)
    assert "112 x 64" in look_at_model(low).value


def test_the_command_line_gives_status_and_settings(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[Config] = []
    result = [ALL]

    def make(options: object, _end_s: float) -> list[CheckResult]:
        asked.append(load_settings(options))  # type: ignore[arg-type]
        return result[0]

    monkeypatch.setattr(actions, "make_checks", make)
    given = ["--autopilot", "serial:///dev/ttyAMA0:921600", "--camera", "v4l2:///dev/video0", "--port", "3001"]
    assert cli.main(["check", "--json", *given]) == 1
    assert json.loads(capsys.readouterr().out)["passed"] is False
    assert (asked[0].autopilot.url, asked[0].web.port) == ("serial:///dev/ttyAMA0:921600", 3001)
    result[0] = ALL[:2]
    assert cli.main(["check"]) == 0
    assert cli.main(["check", "--arm"]) == 2
