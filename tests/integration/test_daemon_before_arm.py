"""The real daemon over hawk-sim before Arm: the remote control and its switch, and Remote ID on the wire."""

from __future__ import annotations

from pathlib import Path

import pytest

from hawk.comm.protocol.commands import Arm
from hawk.comm.protocol.heartbeat import CheckItem, Heartbeat
from hawk.model.operation import StateName
from tests.integration.daemon_support import LOW, STEP_S, health, operator, over_a_picture

pytestmark = pytest.mark.integration

SETTINGS = f"""{LOW}
[remote_control]
switch_must_move = true
[remote_id]
enabled = true
operator_id = "FIN87astrdge12k8"
description = "parking survey"
"""

LEFT_S = 2.0
"""The check's remedy asks for this time in each position of the switch, seconds of the drone's clock."""


def check(beat: Heartbeat, name: str) -> CheckItem:
    return next(item for item in beat.checks if item.name == name)


@pytest.mark.fault("the remote control is lost in flight")
async def test_both_are_seen_before_arm_and_reported_in_flight(tmp_path: Path) -> None:
    stack = over_a_picture(tmp_path, SETTINGS)
    try:
        async with operator((await stack.start()).url) as hand:
            beat = await hand.until(lambda b: b.connected and bool(b.checks) and check(b, "Remote ID").passed, STEP_S)
            await hand.take_control()
            beat = await hand.until(lambda b: "not moved yet" in check(b, "Remote control").value)
            assert check(beat, "Remote control").value == "switch at STABILIZE (position 6), not moved yet"
            left = beat.time + LEFT_S
            await hand.until(lambda b: b.time >= left)
            await stack.inject({"mode_switch": 2})
            beat = await hand.until(lambda b: check(b, "Remote control").passed)
            assert check(beat, "Remote control").value == "switch at STABILIZE (position 2), 8 channels"
            await stack.inject({"remote_id": "lost"})
            await hand.until(lambda b: not check(b, "Remote ID").passed)
            await stack.inject({"remote_id": "ok", "radio": "lost"})
            await hand.until(lambda b: check(b, "Remote ID").passed and not check(b, "Remote control").passed)
            assert (await hand.refusal(Arm())).startswith("Remote control: not heard by the autopilot")
            await stack.inject({"radio": "ok"})
            await hand.take_off()
            await stack.inject({"remote_id": "lost"})
            await hand.until(lambda b: not health(b, "remote id").healthy)
            assert hand.beat.state == StateName.HOVER
            await stack.inject({"radio": "lost"})
            await hand.until(lambda b: not health(b, "remote control").healthy)
            await hand.until_state(StateName.RETURN_TO_LAUNCH)
            await hand.until_down()
    finally:
        await stack.stop()
