from __future__ import annotations

import asyncio
import contextlib
import json
import os
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from hawk.calibrate.flight_command import use_least_priority
from hawk.cli import make_parser
from hawk.config.sections import CameraSettings
from hawk.daemon.flight_offer import COMMAND, FlightOffer
from tests.unit.comm.waiting import until

ANSWER = {
    "recording": "r.mcap",
    "settings": [
        {
            "setting": "camera.latency_s",
            "value": 0.125,
            "spread": 0.001,
            "present": 0.08,
            "offered": True,
            "problem": "",
        },
        {
            "setting": "camera.mount_yaw_deg",
            "value": 0.1,
            "spread": 0.2,
            "present": 0.0,
            "offered": False,
            "problem": "",
        },
    ],
}


class Said:
    """Messages, with an event for the next one."""

    def __init__(self) -> None:
        self.all: list[tuple[str, str]] = []
        self.next = asyncio.Event()

    def __call__(self, text: str, details: str) -> None:
        self.all.append((text, details))
        self.next.set()


def printing(text: str, status: int = 0) -> list[str]:
    return [sys.executable, "-S", "-c", f"import sys; print({text!r}); sys.exit({status})"]


@asynccontextmanager
async def running(
    command: list[str], said: Said, recorded: Callable[[], Path | None] = lambda: Path("r.mcap"), **camera: float
) -> AsyncIterator[FlightOffer]:
    offer = FlightOffer(CameraSettings.model_validate(camera), recorded, said, command, look_s=0.01)
    task = asyncio.create_task(offer.run())
    yield offer
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task


def fly(offer: FlightOffer) -> None:
    offer.note(armed=True)
    offer.note(armed=False)


def is_running(pid_file: Path) -> bool:
    return Path(f"/proc/{pid_file.read_text()}").exists()


async def test_a_setting_that_the_flight_shows_otherwise_is_offered_with_the_command() -> None:
    said = Said()
    async with running(printing(json.dumps(ANSWER)), said) as offer:
        fly(offer)
        async with asyncio.timeout(30):
            await said.next.wait()
    ((text, details),) = said.all
    assert text == "The flight shows other settings of the camera."
    assert details.startswith("camera.latency_s = 0.125 ± 0.001 (set: 0.08). hawk-drone calibrate --in-flight")
    assert "mount_yaw_deg" not in details


async def test_nothing_is_said_of_a_flight_that_agrees_or_shows_nothing(tmp_path: Path) -> None:
    same = {"settings": [{**ANSWER["settings"][0], "offered": False}]}  # type: ignore[dict-item]
    for k, command in enumerate([printing(json.dumps(same)), printing(json.dumps(ANSWER), 1), printing("no JSON")]):
        said, ended = Said(), tmp_path / str(k)
        command[3] = command[3].replace("import sys;", f"import sys; open({str(ended)!r}, 'w').close();")
        async with running(command, said) as offer:
            fly(offer)
            await until(ended.exists)
            await until(lambda: offer._process is None)
        assert said.all == []


async def test_the_present_settings_are_those_of_the_daemon() -> None:
    code = (
        "import json, os; print(json.dumps({'settings': [{'setting': 'camera.latency_s', 'value': 1, 'spread': 0.1, "
        "'present': float(os.environ['HAWK_CAMERA__LATENCY_S']), 'offered': True}]}))"
    )
    said = Said()
    async with running([sys.executable, "-S", "-c", code], said, latency_s=0.3) as offer:
        fly(offer)
        async with asyncio.timeout(30):
            await said.next.wait()
    assert "(set: 0.3)" in said.all[0][1]


async def test_an_estimate_ends_when_the_motors_are_switched_on(tmp_path: Path) -> None:
    here = tmp_path / "pid"
    code = f"import os, time; open({str(here)!r} + '.new', 'w').write(str(os.getpid())); " + (
        f"os.rename({str(here)!r} + '.new', {str(here)!r}); time.sleep(60)"
    )
    said = Said()
    async with running([sys.executable, "-S", "-c", code], said) as offer:
        fly(offer)
        await until(here.exists)
        offer.note(armed=True)
        await until(lambda: offer._process is None)
    assert not is_running(here)
    assert said.all == []


async def test_the_end_of_the_daemon_ends_the_estimate(tmp_path: Path) -> None:
    here = tmp_path / "pid"
    code = f"import os, time; open({str(here)!r} + '.new', 'w').write(str(os.getpid())); " + (
        f"os.rename({str(here)!r} + '.new', {str(here)!r}); time.sleep(60)"
    )
    async with running([sys.executable, "-S", "-c", code], Said()) as offer:
        fly(offer)
        await until(here.exists)
    assert not is_running(here)


async def test_it_waits_until_the_recording_is_complete() -> None:
    said, looks = Said(), iter([None, None, Path("r.mcap")])
    async with running(printing(json.dumps(ANSWER)), said, lambda: next(looks)) as offer:
        fly(offer)
        async with asyncio.timeout(30):
            await said.next.wait()
    assert next(looks, "all were used") == "all were used"


async def test_a_daemon_that_starts_on_the_ground_offers_nothing() -> None:
    def fail() -> Path | None:
        raise AssertionError

    async with running(printing(json.dumps(ANSWER)), Said(), fail) as offer:
        offer.note(armed=False)
        await asyncio.sleep(0)
        assert not offer._landed.is_set()


def test_the_command_is_one_that_the_command_line_knows(tmp_path: Path) -> None:
    recording = tmp_path / "r.mcap"
    recording.touch()
    options = make_parser().parse_args([*COMMAND[3:], str(recording)])
    assert (options.in_flight, options.json, options.in_background) == (recording, True, True)


@pytest.mark.slow
def test_an_estimate_in_the_background_runs_at_low_priority(tmp_path: Path) -> None:
    """In a process of its own: niceness cannot be taken back."""
    score = tmp_path / "score"
    pid = os.fork()
    if pid == 0:
        use_least_priority(score)
        os._exit(os.getpriority(os.PRIO_PROCESS, 0))
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 19
    assert score.read_text() == "800"
