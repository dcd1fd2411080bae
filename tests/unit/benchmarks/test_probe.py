from __future__ import annotations

import asyncio

import pytest

from benchmarks.probe import Probe, is_heartbeat, main
from hawk.comm.protocol.commands import Ack
from hawk.comm.protocol.heartbeat import DroneStatus
from hawk.web.clients import ClientView
from hawk.web.sessions import ControlView


@pytest.mark.slow
async def test_an_idle_loop_is_sampled_until_the_probe_is_ended() -> None:
    probe = Probe("idle")
    try:
        await probe.start()
        await asyncio.sleep(0.5)  # what is measured is time itself
        found = await probe.finish()
    finally:
        await probe.close()
    assert found["samples"] > 5
    assert 0 <= found["lag_p50_ms"] <= found["lag_p99_ms"] <= found["lag_max_ms"]
    assert found["jitter_p99_ms"] >= 0


def test_an_unknown_probe_is_refused() -> None:
    assert main(["nothing"]) == 2


def test_the_drones_heartbeats_are_counted_and_nothing_else() -> None:
    assert is_heartbeat(ClientView().heartbeat(DroneStatus(), None, ControlView("Operator 1", in_control=True)))
    assert not is_heartbeat(Ack(id=1, accepted=True).to_json())
