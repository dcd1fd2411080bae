from __future__ import annotations

import asyncio
import time
from functools import partial

import pytest

from hawk.webhooks import recordings
from tests.pace import PATIENCE_S
from tests.unit.comm.waiting import until as until_true
from tests.unit.lots.surveys import later, survey
from tests.unit.store.recorded import recorded
from tests.unit.webhooks.lines import ONE, Line, running

NAME = "20260501T100000Z.mcap"
SMALL = 64_000
"""Bytes of a part in tests that come between two of them."""


until = partial(until_true, timeout_s=PATIENCE_S)
"""The threads of stores step back behind all else on this computer."""


class Asked:
    """A survey on the drone with its recording, which the desk asks for."""

    def __init__(self, line: Line, kilobytes: int) -> None:
        given = survey()
        self.line = line
        self.survey = line.drone.add(given).survey
        self.data = recorded(
            line.folder / "drone" / "recordings" / NAME, given.name, range(kilobytes), f"{time.time()} " * 50
        )
        self.here = line.folder / "desk" / "recordings"
        assert line.rig.recording_requests is not None
        line.rig.recording_requests.ask(self.survey, ONE, given.name, 1.0)

    def received(self) -> int:
        """Return how many bytes the desk has."""
        found = [*self.here.glob("*.mcap"), *self.here.glob("requests/*/*.part")]
        return sum(path.stat().st_size for path in found if path.exists())

    def is_here(self) -> bool:
        path = self.here / NAME
        return path.is_file() and path.stat().st_size == len(self.data)

    def state(self) -> str:
        assert self.line.rig.recording_requests is not None
        return self.line.rig.recording_requests.progress(self.survey).state


@pytest.fixture
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("FIRST_PART", "LEAST_PART", "LARGEST_PART"):
        monkeypatch.setattr(recordings, name, SMALL)


@pytest.mark.slow
async def test_a_recording_that_is_asked_for_comes_where_the_settings_allow_it(line: Line) -> None:
    asked = Asked(line, 100)
    async with running(line.sender()):
        await until(lambda: asked.state() == "never")
    assert asked.received() == 0, "by default no recording leaves the drone"
    assert line.rig.recording_requests is not None
    line.rig.recording_requests.ask(asked.survey, ONE, survey().name, 2.0)
    async with running(line.sender(recordings="asked")):
        await until(asked.is_here)
    assert (asked.here / NAME).read_bytes() == asked.data
    assert asked.state() == "here"


@pytest.mark.slow
async def test_a_drone_that_has_it_no_more_says_so(line: Line) -> None:
    asked = Asked(line, 1)
    (line.folder / "drone" / "recordings" / NAME).unlink()
    async with running(line.sender(recordings="asked")):
        await until(lambda: asked.state() == "gone")


@pytest.mark.slow
@pytest.mark.fault(
    "the motors are switched on while a recording is sent",
    "sending ends within a second, and goes on after the landing from where it was",
)
async def test_arming_ends_it_and_it_goes_on_after_the_landing(line: Line, small_parts: None) -> None:
    asked = Asked(line, 5000)
    async with running(line.sender(recordings="asked")):
        await until(lambda: asked.received() > 2 * SMALL)
        line.is_flown = True
        await asyncio.sleep(1.0)  # the time in which it must have ended
        before = asked.received()
        assert 0 < before < len(asked.data)
        await asyncio.sleep(0.5)
        assert asked.received() == before
        line.is_flown = False
        await until(lambda: asked.received() != before)
        assert asked.received() > before, "nothing is sent again"
        await until(asked.is_here)
    assert (asked.here / NAME).read_bytes() == asked.data


@pytest.mark.slow
async def test_a_document_waits_for_no_recording(line: Line, small_parts: None) -> None:
    asked = Asked(line, 5000)
    async with running(line.sender(recordings="asked")):
        await until(lambda: asked.received() > 2 * SMALL)
        line.drone.add(later(survey(seed=2), 2))
        await line.is_received()
        assert not asked.is_here()
