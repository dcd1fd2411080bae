"""The daemon gives the algorithms the gimbal's attitude and the sun where the settings say so."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hawk.algo.loop import fixed_mount, unknown_sun
from hawk.config.sections import CameraSettings, Config, StoreSettings, VisionSettings, WatchdogSettings
from hawk.daemon import root as daemon_module
from hawk.daemon.options import DaemonOptions
from hawk.daemon.root import Daemon
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


@pytest.mark.slow
@pytest.mark.parametrize("is_on", [True, False])
async def test_pictures_have_the_gimbal_and_the_sun_that_the_settings_name(
    is_on: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(daemon_module, "AlgorithmLoop", FakeLoop)
    monkeypatch.setattr(daemon_module, "_make_manager", lambda *_: None)
    output = ProgramLog("info")
    camera = CameraSettings(url="file:///there/is/none.mp4", gimbal=is_on)
    store, watchdog = StoreSettings(directory=tmp_path), WatchdogSettings(enabled=False)
    vision = VisionSettings(sun="auto" if is_on else "off")
    config = Config(camera=camera, store=store, watchdog=watchdog, vision=vision)
    daemon = Daemon(config, DaemonOptions(), output)
    try:
        await daemon._start_algorithms()
        telemetry = daemon.autopilot.telemetry
        *_, aim, sun_at = FakeLoop.given
        assert aim == (telemetry.gimbal.aim if is_on else fixed_mount)
        assert sun_at == (telemetry.sun_at if is_on else unknown_sun)
    finally:
        await daemon._close()
        output.close()
