"""The daemon gives the algorithms the gimbal's attitude where the settings say that there is a gimbal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hawk.algo.loop import fixed_mount
from hawk.config.sections import CameraSettings, Config, StoreSettings, WatchdogSettings
from hawk.daemon import root as daemon_module
from hawk.daemon.root import Daemon, DaemonOptions
from hawk.runtime.program_log import ProgramLog


class FakeLoop:
    """Keeps what the daemon gives to the algorithms."""

    given: tuple[Any, ...] = ()

    def __init__(self, *given: Any) -> None:
        FakeLoop.given = given

    def start(self) -> None: ...

    async def changes_since(self, version: int) -> None:
        return None

    async def close(self) -> None: ...


@pytest.mark.parametrize("has_gimbal", [True, False])
async def test_pictures_are_turned_by_the_gimbal_that_the_settings_name(
    has_gimbal: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(daemon_module, "AlgorithmLoop", FakeLoop)
    monkeypatch.setattr(daemon_module, "_make_manager", lambda *_: None)
    output = ProgramLog("info")
    camera = CameraSettings(url="file:///there/is/none.mp4", gimbal=has_gimbal)
    store, watchdog = StoreSettings(directory=tmp_path), WatchdogSettings(enabled=False)
    daemon = Daemon(Config(camera=camera, store=store, watchdog=watchdog), DaemonOptions(), output)
    try:
        await daemon._start_algorithms()
        aim = FakeLoop.given[-1]
        assert aim == (daemon.autopilot.telemetry.gimbal.aim if has_gimbal else fixed_mount)
    finally:
        await daemon._close()
        output.close()
