"""Others on the link, another station that changes settings, and MAVLink 1."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v10 import ardupilotmega as first

from hawk.sim.autopilot.telemetry import BUILDERS
from tests.unit.sim.test_faults import put


def beats(station: Any) -> list[tuple[int, int, int]]:
    return [(m.get_srcSystem(), m.get_srcComponent(), m.type) for m in station.all("HEARTBEAT")]


def test_others_are_heard_once_a_second_before_the_copter(station: Any) -> None:
    put(station, others=["tracker", "gimbal", "copter", "station"])
    station.heard.clear()
    station.run(3.0)
    assert set(beats(station)) == {(2, 1, 5), (1, 154, 26), (3, 1, 13), (255, 190, 6), (1, 1, 2)}
    assert beats(station).count((2, 1, 5)) == 3
    assert beats(station).index((2, 1, 5)) < beats(station).index((1, 1, 2))
    place = next(m for m in station.all("GLOBAL_POSITION_INT") if m.get_srcSystem() == 3)
    assert place.relative_alt == 40_000
    put(station, others=[])
    station.heard.clear()
    station.run(3.0)
    assert set(beats(station)) == {(1, 1, 2)}


def test_a_station_s_parameters_are_sent_on_every_link_and_its_answers_on_its_own(station: Any) -> None:
    station.wait_for_position()
    station.heard.clear()
    problems, _, _ = put(station, parameters={"BATT_FS_LOW_ACT": 5, "NO_SUCH": 1})
    assert problems == ["parameters: there is no NO_SUCH"]
    station.listen()
    sent = station.last("PARAM_VALUE")
    assert (sent.param_id, sent.param_value) == ("BATT_FS_LOW_ACT", 5.0)
    command = {"target_system": 1, "target_component": 1, "command": 176, "confirmation": 0}
    command |= {f"param{n}": v for n, v in enumerate((1, 4, 0, 0, 0, 0, 0), 1)}
    assert put(station, station=[{"kind": "COMMAND_LONG", "fields": command}])[0] == []
    station.listen()
    assert station.autopilot.mode.name == "GUIDED"
    assert not station.all("COMMAND_ACK")


@pytest.mark.slow
def test_a_station_replaces_and_clears_the_fence(flying: Any) -> None:
    square = [(40.0, 40.0), (40.0, -40.0), (-40.0, -40.0), (-40.0, 40.0)]
    assert put(flying, fence=square)[0] == []
    assert flying.autopilot.parameters["FENCE_TOTAL"] == 4
    fields = {"target_system": 1, "target_component": 1, "mission_type": 1}
    assert put(flying, station=[{"kind": "MISSION_CLEAR_ALL", "fields": fields}])[0] == []
    assert flying.autopilot.fence.items == ()
    put(flying, fence=square)
    put(flying, fence=[])
    assert flying.autopilot.fence.items == ()


def test_what_a_station_cannot_send_is_named(station: Any) -> None:
    problems = put(station, station=[{"kind": "NO_SUCH", "fields": {}}, {"kind": "PARAM_SET", "fields": {"x": 1}}])[0]
    assert [problem.partition(":")[2].split(":")[0].strip() for problem in problems] == ["NO_SUCH", "PARAM_SET"]
    assert put(station, fence=[(1.0, 1.0)])[0] == ["fence: no home yet"]


def test_mavlink_1_has_no_extension_fields_and_no_late_messages(station: Any) -> None:
    put(station, link_version=1)
    station.wait_for_position()
    station.stream(*BUILDERS)
    station.heard.clear()
    decoder = first.MAVLink(None)
    data = []
    for _ in range(120):
        station.autopilot.step()
        data += station.link.poll()
    assert data
    assert {each[0] for each in data} == {0xFE}
    found = {m.get_type(): m for each in data for m in decoder.parse_buffer(each)}
    assert "BAD_DATA" not in found
    assert found["GPS_RAW_INT"].satellites_visible == 14
    assert not hasattr(found["GPS_RAW_INT"], "h_acc")
    lengths = {each[5]: each[1] for each in data}
    assert lengths[24] == 30
    assert lengths[1] == 31


@pytest.mark.parametrize("message_id", sorted(BUILDERS))
def test_every_message_packs_in_mavlink_1_or_not_at_all(flying: Any, message_id: int) -> None:
    from pymavlink.dialects.v20 import ardupilotmega as mavlink

    from hawk.sim.autopilot.telemetry import build
    from hawk.sim.link.mavlink_link import pack_1

    message = build(message_id, flying.autopilot)
    if message is None:
        return
    data = pack_1(message, mavlink.MAVLink(None, 1, 1))
    if message_id > 255:
        assert data == b""
    elif data:
        assert [m.get_msgId() for m in first.MAVLink(None).parse_buffer(data)] == [message_id]
