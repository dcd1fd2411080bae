"""Offer after a flight: latency and mount of the camera as the flight shows them, where they differ from the settings.

`hawk-drone calibrate --in-flight` computes, in a process of its own at the lowest priority. Nothing of it runs while
the motors are on. The settings are changed by nobody: a message names the values and the command that writes them.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

from pydantic import BaseModel, ConfigDict, ValidationError

from hawk.config.loader import ENVIRONMENT_PREFIX
from hawk.config.sections import CameraSettings
from hawk.model.sentences import say

_LOG = logging.getLogger(__name__)

COMMAND: Final = (sys.executable, "-m", "hawk.cli", "calibrate", "--json", "--in-background", "--in-flight")
"""The recording's path follows."""
LONGEST_S: Final = 600.0
"""Real seconds for the estimate; then it is ended."""
FILE_S: Final = 30.0
"""Real seconds for the recording to be complete after the landing."""
_LOOK_S: Final = 0.5
_KEYS: Final = ("latency_s", "mount_roll_deg", "mount_pitch_deg", "mount_yaw_deg")


class _Setting(BaseModel):
    model_config = ConfigDict(extra="ignore")

    setting: str
    value: float
    spread: float
    present: float
    offered: bool


class _Answer(BaseModel):
    model_config = ConfigDict(extra="ignore")

    settings: list[_Setting]


class FlightOffer:
    """Looks at each flight after its landing. `note` and `run` belong to the loop."""

    def __init__(
        self,
        camera: CameraSettings,
        recorded: Callable[[], Path | None],
        say: Callable[[str, str], object],
        command: Sequence[str] = COMMAND,
        look_s: float = _LOOK_S,
    ) -> None:
        """Take the parts; nothing runs before `run`.

        Args:
            camera: The settings of this run; the results are compared with them.
            recorded: Returns the newest recording, None while it is not complete.
            say: Called with a message and its details.
            command: Program and options; the recording's path follows.
            look_s: Real seconds between two looks whether the recording is complete.
        """
        self._camera = camera
        self._recorded = recorded
        self._say = say
        self._command = tuple(command)
        self._look_s = look_s
        self._armed = False
        self._landed = asyncio.Event()
        self._process: asyncio.subprocess.Process | None = None

    def note(self, *, armed: bool) -> None:
        """Note whether the motors are on: an estimate that runs ends at once when they are switched on."""
        if armed:
            self._landed.clear()
            self._end()
        elif self._armed:
            self._landed.set()
        self._armed = armed

    async def run(self) -> None:
        """Offer after each flight until cancelled."""
        while True:
            await self._landed.wait()
            self._landed.clear()
            path = await self._complete()
            if path is not None:
                await self._look_at(path)

    async def _complete(self) -> Path | None:
        """Return the flight's recording once it is complete; None when it does not become so, or at the next Arm."""
        for _ in range(max(1, round(FILE_S / self._look_s))):
            await asyncio.sleep(self._look_s)
            if self._armed:
                return None
            path = self._recorded()
            if path is not None:
                return path
        return None

    async def _look_at(self, path: Path) -> None:
        present = {f"{ENVIRONMENT_PREFIX}CAMERA__{key.upper()}": repr(getattr(self._camera, key)) for key in _KEYS}
        try:
            self._process = await asyncio.create_subprocess_exec(
                *self._command,
                str(path),
                stdin=asyncio.subprocess.DEVNULL,
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.DEVNULL,
                env={**os.environ, **present},
                start_new_session=True,
            )
        except OSError as error:
            _LOG.warning("the flight's calibration cannot be started: %s", error)
            return
        try:
            if self._armed:
                return
            async with asyncio.timeout(LONGEST_S):
                said, _ = await self._process.communicate()
        except TimeoutError:
            _LOG.warning("the flight's calibration took more than %.0f s: it was ended", LONGEST_S)
            return
        finally:
            self._end()
            process, self._process = self._process, None
            await process.wait()
        if process.returncode == 0:
            self._offer(said)

    def _offer(self, said: bytes) -> None:
        try:
            answer = _Answer.model_validate_json(said)
        except ValidationError:
            _LOG.warning("the flight's calibration cannot be read")
            return
        offered = [each for each in answer.settings if each.offered]
        if not offered:
            return
        values = ", ".join(
            f"{each.setting} = {each.value:g} ± {each.spread:.2g} (set: {each.present:g})" for each in offered
        )
        self._say(
            say("The flight shows other settings of the camera."),
            say("{values}. hawk-drone calibrate --in-flight shows them, with --apply it writes them.", values=values),
        )

    def _end(self) -> None:
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()
