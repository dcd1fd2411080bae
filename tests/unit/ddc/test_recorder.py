"""Facts are recorded by their changes, and the decider's memory where it is due."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hawk.ddc.decider import Decision
from hawk.ddc.facts import Facts
from hawk.ddc.recorder import DECISION, LEAST_MEMORY_S, MEMORY, MEMORY_S, TICK, WHOLE_EVERY, Recorder
from hawk.ddc.replay import moments
from hawk.store.frame_codec import to_json
from tests.unit.ddc.fakes import Rig

NOTHING = Decision((), None, "", is_sound=True)


def recorded(rig: Rig) -> list[tuple[str, dict[str, Any]]]:
    return [(kind, json.loads(to_json(payload))) for kind, payload in rig.records]


@pytest.mark.slow
async def test_facts_come_back_equal_from_the_recording(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    gathered: list[Facts] = []
    tick = rig.manager._senses.tick

    def noted() -> Facts:
        gathered.append(tick())
        return gathered[-1]

    rig.manager._senses.tick = noted  # type: ignore[method-assign]
    await rig.run(3)
    rig.autopilot.put_in_air()
    await rig.run(2)
    await rig.close()
    assert [moment.facts for moment in moments(recorded(rig))] == gathered


@pytest.mark.slow
async def test_a_reader_may_begin_anywhere(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    await rig.tick(100)
    await rig.close()
    whole = [moment.facts for moment in moments(recorded(rig))]
    late = [moment.facts for moment in moments(recorded(rig)[37:])]
    assert 60 < len(late) < len(whole)
    assert whole[-len(late) :] == late


class Noted:
    """A recorder, what it recorded, and whether the recording wants a memory."""

    def __init__(self) -> None:
        self.records: list[tuple[str, dict[str, Any]]] = []
        self.wants = False
        self.recorder = Recorder(
            lambda kind, payload: self.records.append((kind, payload)), lambda: {"format": 7}, lambda: self.wants
        )

    def tick(self, now: float) -> None:
        self.recorder.prepare(now)
        self.recorder.tick(Facts(now), NOTHING)

    def memories(self) -> list[float]:
        """Return the time of the tick that follows each memory."""
        kinds = [kind for kind, _ in self.records]
        return [self.records[place + 1][1]["facts"]["now"] for place, kind in enumerate(kinds) if kind == MEMORY]


def test_the_memory_is_recorded_at_the_start_and_every_minute() -> None:
    noted = Noted()
    for now in range(200):
        noted.tick(float(now))
    assert noted.memories() == [0.0, MEMORY_S, 2 * MEMORY_S, 3 * MEMORY_S]


def test_a_recording_that_cannot_be_entered_gets_a_memory_at_once_but_not_with_each_tick() -> None:
    noted = Noted()
    noted.tick(0.0)
    noted.tick(10.0)
    noted.wants = True
    for tick in range(20):
        noted.tick(10.0 + 0.2 + tick * 0.1)
    assert noted.memories() == [0.0, 10.2, pytest.approx(10.2 + LEAST_MEMORY_S)]


def test_a_memory_that_cannot_be_written_down_keeps_nothing_else_from_being_recorded(
    caplog: pytest.LogCaptureFixture,
) -> None:
    def fails() -> dict[str, Any]:
        raise ValueError("an object of a foreign class")

    records: list[str] = []
    recorder = Recorder(lambda kind, _: records.append(kind), fails)
    recorder.prepare(1.0)
    recorder.tick(Facts(1.0), NOTHING)
    assert records == [TICK]
    assert "without the decider's memory: an object of a foreign class" in caplog.text


def test_facts_are_whole_after_a_memory_and_numbered_through() -> None:
    noted = Noted()
    noted.tick(0.0)
    noted.tick(1.0)
    noted.tick(1.0 + MEMORY_S)
    ticks = [payload for kind, payload in noted.records if kind == TICK]
    assert [len(tick["facts"]) > 1 for tick in ticks] == [True, False, True]
    assert [tick["number"] for tick in ticks] == [0, 1, 2]


def test_facts_are_whole_every_second_and_decisions_that_do_nothing_are_left_out() -> None:
    noted = Noted()
    for tick in range(2 * WHOLE_EVERY):
        noted.tick(tick / WHOLE_EVERY)
    ticks = [payload for kind, payload in noted.records if kind == TICK]
    assert [place for place, tick in enumerate(ticks) if len(tick["facts"]) > 1] == [0, WHOLE_EVERY]
    assert DECISION not in {kind for kind, _ in noted.records}
