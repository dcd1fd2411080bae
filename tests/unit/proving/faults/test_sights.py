from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from hawk.comm.protocol.heartbeat import CheckItem, HealthItem, Heartbeat, LogEntry
from hawk.sim.autopilot.autopilot import Autopilot
from hawk.sim.autopilot.fence import FenceItem
from hawk.sim.autopilot.parameters import AutopilotOptions
from hawk.sim.faults import Fault as DroneFault
from hawk.sim.flight_record import FlightRecord
from hawk.sim.geometry import Origin
from proving.faults.fault import Moment
from proving.faults.rig import HONEST, WELL
from proving.faults.sights import (
    CLEAN,
    FENCE_IS_OURS,
    NO_RALLY,
    parameter,
    second_ended,
    second_says,
    stayed,
    truly_between,
    warned,
)

TRUTH: dict[str, Any] = {
    "position": {"x": 3.0, "y": 4.0, "height": 20.0},
    "parameters": {"RTL_ALT": 1500.0},
    "fence_mark": 7,
    "rally_points": 0,
}
BEFORE: dict[str, Any] = {**TRUTH, "position": {"x": 0.0, "y": 0.0, "height": 12.0}}


def beat_of(**values: Any) -> Heartbeat:
    """A heartbeat of which only this is known."""
    return Heartbeat.model_construct(**values)


def moment(**changes: Any) -> Moment:
    return replace(Moment(None, TRUTH, (), (), 0, {}, (), before=BEFORE), **changes)


def test_the_true_place_is_compared_with_that_of_before() -> None:
    assert stayed(5.0).test(moment())
    assert not stayed(4.9).test(moment())
    assert truly_between(20.0, 21.0).test(moment())
    assert not truly_between(5.0, 19.0).test(moment())


def test_what_another_changed_is_seen_in_the_autopilot() -> None:
    assert parameter("RTL_ALT", 1500.0).test(moment())
    assert not parameter("RTL_ALT", 30000.0).test(moment())
    assert not parameter("NO_SUCH", 1.0).test(moment())
    assert FENCE_IS_OURS.test(moment())
    assert not FENCE_IS_OURS.test(moment(truth={**TRUTH, "fence_mark": 8}))
    assert NO_RALLY.test(moment())
    assert not NO_RALLY.test(moment(truth={**TRUTH, "rally_points": 1}))


def test_the_simulator_s_account_has_all_of_it() -> None:
    autopilot = Autopilot(AutopilotOptions(), Origin(), np.random.default_rng(1))
    account = FlightRecord(autopilot).summary()
    assert account.keys() >= TRUTH.keys()
    assert account["parameters"]["RTL_ALT"] == 1500.0
    before = account["fence_mark"]
    corners = [(43.26, -79.92), (43.27, -79.92), (43.27, -79.91)]
    autopilot.load_fence([FenceItem(5001, 3, *corner) for corner in corners])
    assert FlightRecord(autopilot).summary()["fence_mark"] != before
    autopilot.load_fence([])
    assert FlightRecord(autopilot).summary()["fence_mark"] == before


@pytest.mark.parametrize("place", ["log", "detail", "health", "check"])
def test_a_warning_is_found_wherever_the_operator_reads_it(place: str) -> None:
    beat = beat_of(
        detail="The height is in doubt." if place == "detail" else "",
        health=(HealthItem(name="position", healthy=place != "health", reason="height in doubt"),),
        checks=(CheckItem(name="GPS", passed=place != "check", value="height in doubt"),),
    )
    log = (LogEntry(number=1, time="", level="warning", text="The height is in doubt."),) if place == "log" else ()
    assert warned("depth", "height").test(moment(beat=beat, log=log))
    assert not warned("depth").test(moment(beat=beat, log=log))


def test_control_characters_are_found() -> None:
    assert CLEAN.test(moment(log=(LogEntry(number=1, time="", level="info", text="wörds"),)))
    assert not CLEAN.test(moment(log=(LogEntry(number=1, time="", level="info", text="\x1b[31mred"),)))


def test_a_second_daemon_s_end_and_words() -> None:
    ended = moment(second=(2, "the store is used by process 7"))
    assert second_ended(2, "process 7").test(ended)
    assert not second_ended(1).test(ended)
    assert not second_ended(2).test(moment())
    assert not second_ended(2).test(moment(second=(None, "")))
    assert second_says("nobody", "process").test(ended)
    assert not second_says("nobody").test(ended)


def test_an_honest_drone_is_what_the_simulator_understands() -> None:
    DroneFault.model_validate(WELL | HONEST)
