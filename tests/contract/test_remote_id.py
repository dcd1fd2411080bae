"""Rows: Remote ID. What the transmitter says (hawk-sim has one); what ArduPilot does with both sides' messages."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from mavsdk.plugins.action import ActionError
from mavsdk.plugins.mavlink_direct import MavlinkMessage
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.comm.autopilot.remote_id import EPOCH, TRANSMITTERS, OperatorPlace, where, who
from hawk.config.sections import RemoteIdSettings
from tests.contract.vehicle import GUIDED, SLACK_S, Vehicle

pytestmark = pytest.mark.contract
SETTINGS = RemoteIdSettings(enabled=True, operator_id="FIN87astrdge12k8", serial_number="1581F4ABC123")
PLACE = OperatorPlace(43.2609, -79.9192, 100.0)
GOOD, FAIL = 0, 1


def say(vehicle: Vehicle, *messages: tuple[str, Any]) -> None:
    for name, fields in messages:
        text = json.dumps({**fields, "target_system": 1, "target_component": 1})
        vehicle.pilot.direct.send_message(MavlinkMessage(name, 245, 190, 1, 1, text))


def system(*, whole: bool = True) -> tuple[str, Any]:
    return where(SETTINGS, PLACE, EPOCH + 7.0, whole=whole)


def keep_saying(vehicle: Vehicle, condition: Callable[[], bool], *messages: tuple[str, Any]) -> None:
    """Send once a second until something holds."""
    deadline = time.monotonic() + 5.0 / vehicle.speed + SLACK_S
    while not condition():
        assert time.monotonic() < deadline, f"{vehicle.pilot.messages.keys()}; {vehicle.pilot.texts[-5:]}"
        say(vehicle, *messages)
        vehicle.let_pass(0.8)


class TestTransmitter:
    """hawk-sim's transmitter says what ArduRemoteID says; a real ArduCopter in simulation has none."""

    @pytest.fixture
    def simulated(self, grounded: Vehicle) -> Vehicle:
        if grounded.knows("DID_ENABLE"):
            pytest.skip("a vehicle with AP_OpenDroneID needs a transmitter of its own")
        return grounded

    def word(self, vehicle: Vehicle) -> tuple[int, str] | None:
        heard = vehicle.pilot.messages.get("OPEN_DRONE_ID_ARM_STATUS")
        return None if heard is None else (int(heard["status"]), str(heard["error"]).rstrip("\0"))

    def test_it_is_good_to_arm_while_operator_and_place_come(self, simulated: Vehicle) -> None:
        keep_saying(simulated, lambda: self.word(simulated) == (FAIL, "missing SYS"), *who(SETTINGS))
        keep_saying(simulated, lambda: self.word(simulated) == (GOOD, ""), *who(SETTINGS), system())
        simulated.wait(lambda: self.word(simulated) == (FAIL, "missing SYS"), 10.0)
        keep_saying(simulated, lambda: self.word(simulated) == (GOOD, ""), system(whole=False))
        simulated.wait(lambda: self.word(simulated) == (FAIL, "missing OP_ID SYS"), 40.0)


class TestArduPilot:
    """For a vehicle with AP_OpenDroneID. The suite is its transmitter, on the same link."""

    @pytest.fixture
    def enforcing(self, grounded: Vehicle) -> Iterator[Vehicle]:
        if not grounded.knows("DID_ENABLE"):
            pytest.skip("the vehicle has no AP_OpenDroneID")
        grounded.set({"DID_ENABLE": 1})
        grounded.wait(lambda: grounded.knows("DID_OPTIONS"), 10.0)
        grounded.set({"DID_MAVPORT": 0, "DID_OPTIONS": 1})
        heard = grounded.pilot.counts["HEARTBEAT"]
        grounded.pilot.action.reboot()
        grounded.pilot.pause(2.0)
        grounded.wait(lambda: grounded.pilot.counts["HEARTBEAT"] > heard + 5, 60.0)
        grounded.set_mode(GUIDED)
        yield grounded
        grounded.relay.on_downlink = lambda _: None
        grounded.restore()
        grounded.reboot()

    def transmitted(self, vehicle: Vehicle) -> dict[str, dict[str, Any]]:
        """Return what the transmitter gets, by name. It bears the target that we wrote, so MAVSDK leaves it out."""
        decoder, got = mavlink.MAVLink(None), {}
        decoder.robust_parsing = True

        def take(data: bytes) -> None:
            for message in decoder.parse_buffer(data) or []:
                got[message.get_type()] = message.to_dict()

        vehicle.relay.on_downlink = take
        return got

    def refusal(self, vehicle: Vehicle) -> str:
        vehicle.pilot.texts.clear()
        with pytest.raises(ActionError):
            vehicle.pilot.action.arm()
        vehicle.wait(lambda: vehicle.said("OpenDroneID"), 5.0)
        return next(text for text in vehicle.pilot.texts if "OpenDroneID" in text)

    def test_it_repeats_what_it_was_sent_and_arms_by_the_transmitters_word_alone(self, enforcing: Vehicle) -> None:
        vehicle = enforcing
        transmitter = mavlink.MAVLink(vehicle.relay, 1, min(TRANSMITTERS))
        assert "UA_TYPE required in BasicID" in self.refusal(vehicle)
        say(vehicle, *who(SETTINGS))
        vehicle.let_pass(1.0)
        assert "operator location must be set" in self.refusal(vehicle)
        say(vehicle, system(), *who(SETTINGS))
        vehicle.let_pass(0.5)
        assert "ARM_STATUS not available" in self.refusal(vehicle)

        repeated = self.transmitted(vehicle)
        vehicle.wait(lambda: repeated.get("OPEN_DRONE_ID_OPERATOR_ID", {}).get("operator_id") == SETTINGS.operator_id)
        latitude = round(PLACE.latitude * 1e7)
        vehicle.wait(lambda: repeated.get("OPEN_DRONE_ID_SYSTEM", {}).get("operator_latitude") == latitude)
        say(vehicle, system())
        transmitter.open_drone_id_arm_status_send(FAIL, b"missing LOC")
        vehicle.let_pass(0.5)
        assert "missing LOC" in self.refusal(vehicle)
        transmitter.open_drone_id_arm_status_send(GOOD, b"")
        vehicle.let_pass(4.0)
        assert "ARM_STATUS not available" in self.refusal(vehicle)  # it is older than 3 s
        say(vehicle, system())
        vehicle.let_pass(4.0)
        transmitter.open_drone_id_arm_status_send(GOOD, b"")
        vehicle.let_pass(0.3)
        assert "SYSTEM not available" in self.refusal(vehicle)  # so is the operator's place
        say(vehicle, system(whole=False))
        vehicle.let_pass(0.3)
        vehicle.pilot.texts.clear()
        try:
            vehicle.pilot.action.arm()
        except ActionError:  # GPS may still settle; Remote ID is no reason any more
            vehicle.let_pass(0.5)
        assert not vehicle.said("OpenDroneID")
