"""The remote control before Arm: whatever keeps a pilot from taking over by hand refuses it. In flight it is shown."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.comm.autopilot.remote_control import RemoteControl
from hawk.comm.protocol.commands import Arm, SetFailsafes
from hawk.comm.protocol.heartbeat import CheckItem
from hawk.comm.topic import Stamped, Topic
from hawk.config.sections import RemoteControlSettings
from hawk.ddc.readings.belief import Belief
from hawk.ddc.readings.instant import Instant
from hawk.ddc.readings.remote_control import (
    HAND_FLOWN,
    MODE_NAMES,
    RemoteControlFacts,
    RemoteControlReading,
    remote_control_check,
    switch_position,
)
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode, LandedState, VehicleState
from tests.unit.ddc.fakes import SAFE_PARAMETERS, Rig

SETTINGS = RemoteControlSettings()
WELL = RemoteControlFacts(age=0.1, channels=8, receiver=True, channel=5, pulse=1800, has_moved=False)
VALUES = {"FLTMODE_CH": 5.0, **dict.fromkeys(MODE_NAMES, 4.0), "FLTMODE6": 5.0}
"""GUIDED in five positions, LOITER in the last."""


def shown(rig: Rig) -> CheckItem:
    return next(item for item in rig.manager.situation().checks if item.name == "Remote control")


@pytest.mark.parametrize(
    ("pulse", "position"),
    [
        (0, None), (899, None), (900, 1), (1230, 1), (1231, 2), (1360, 2), (1361, 3), (1490, 3), (1491, 4),
        (1620, 4), (1621, 5), (1749, 5), (1750, 6), (2100, 6), (2101, None),
    ],
)  # fmt: skip
def test_the_positions_are_ardupilots(pulse: int, position: int | None) -> None:
    assert switch_position(pulse) == position


def test_a_switch_that_lets_a_pilot_take_over_passes_and_is_shown() -> None:
    found = remote_control_check(WELL, VALUES, SETTINGS)
    assert found.passed
    assert found.value == "switch at LOITER (position 6), 8 channels"


@pytest.mark.fault(
    "no remote control: RC_CHANNELS missing or old, receiver lost, no mode switch, its pulse not valid, its "
    "parameters not read",
    "Arm is refused with consequence and remedy",
)
@pytest.mark.parametrize(
    ("facts", "values", "value"),
    [
        (RemoteControlFacts(), VALUES, "no word of it"),
        (replace(WELL, age=3.1), VALUES, "no word of it for 3 s"),
        (replace(WELL, receiver=None), VALUES, "the autopilot does not report its receiver's health"),
        (replace(WELL, receiver=False), VALUES, "not heard by the autopilot"),
        (WELL, {}, "mode switch not read yet"),
        (WELL, {name: value for name, value in VALUES.items() if name != "FLTMODE3"}, "mode switch not read yet"),
        (replace(WELL, channel=None), VALUES, "mode switch not read yet"),
        (replace(WELL, channel=6), VALUES, "mode switch not read yet"),
        (replace(WELL, channel=0), {**VALUES, "FLTMODE_CH": 0.0}, "no mode switch (FLTMODE_CH 0)"),
        (replace(WELL, pulse=0), VALUES, "mode switch, channel 5: no pulse"),
        (replace(WELL, pulse=880), VALUES, "mode switch, channel 5: 880 µs"),
        (
            WELL,
            {"FLTMODE_CH": 5.0, **dict(zip(MODE_NAMES, (4.0, 3.0, 6.0, 9.0, 17.0, 4.0), strict=True))},
            "its switch has only GUIDED, AUTO, RTL, LAND, BRAKE",
        ),
        (WELL, {**VALUES, "FLTMODE6": 99.0}, "its switch has only GUIDED, MODE(99)"),
    ],
)
def test_each_case_without_a_pilot_fails_with_consequence_and_remedy(
    facts: RemoteControlFacts, values: dict[str, float | None], value: str
) -> None:
    found = remote_control_check(facts, values, SETTINGS)
    assert not found.passed
    assert found.value == value
    assert found.consequence
    assert found.remedy


@pytest.mark.fault(
    "no position of the mode switch commands a mode that is flown by hand",
    "Arm is refused and names the modes",
)
@pytest.mark.parametrize("mode", sorted(set(CopterMode)))
def test_one_position_of_a_hand_flown_mode_is_enough_and_no_other_mode_is(mode: CopterMode) -> None:
    found = remote_control_check(WELL, {**VALUES, "FLTMODE6": 4.0, "FLTMODE2": float(mode)}, SETTINGS)
    assert found.passed is (mode in HAND_FLOWN)


def test_a_switch_that_must_have_moved_fails_until_it_has() -> None:
    settings = RemoteControlSettings(switch_must_move=True)
    failed = remote_control_check(WELL, VALUES, settings)
    assert not failed.passed
    assert failed.value.endswith("not moved yet")
    assert remote_control_check(replace(WELL, has_moved=True), VALUES, settings).passed


def test_without_the_requirement_it_passes_and_says_so() -> None:
    settings = RemoteControlSettings(required=False)
    assert remote_control_check(WELL, VALUES, settings).value == "not required, heard"
    alone = remote_control_check(RemoteControlFacts(), {}, settings)
    assert alone.passed
    assert alone.value == "not required, none is heard: nobody can take over by hand"


class Heard:
    """The reading, and the remote control as it hears it."""

    def __init__(self) -> None:
        self._radio: Topic[RemoteControl] = Topic("remote control", lambda: 0.0)
        self.reading = RemoteControlReading(self._radio, SETTINGS)

    def hear(
        self, heard: RemoteControl | None, channel: float, now: float, *, is_armed: bool = False
    ) -> RemoteControlFacts:
        self._radio.latest = None if heard is None else Stamped(heard, now)
        vehicle = VehicleState(True, is_armed, CopterMode.GUIDED, LandedState.IN_AIR, now, now)
        instant = Instant(now, belief=Belief(vehicle), is_linked=True, parameters={"FLTMODE_CH": channel})
        self.reading.update(instant)
        return self.reading.facts(instant)


class TestSwitchSeen:
    """``has_moved``: two positions that lasted, by a receiver that is heard, since the boot."""

    def look(
        self,
        heard: Heard,
        seconds: tuple[float, float],
        pulse: int,
        *,
        hears: bool = True,
        boots: int = 0,
    ) -> bool:
        begin, end = seconds
        for step in range(round((end - begin) / 0.1) + 1):
            now = begin + step * 0.1
            pulses = (1500, 1500, 1000, 1500, pulse, *(0,) * 13)
            heard.hear(RemoteControl(pulses, 8, now, hears, now, boots), 5, now)
        return heard.reading.facts(Instant(end)).has_moved

    def test_two_positions_that_lasted(self) -> None:
        heard = Heard()
        assert not self.look(heard, (0.0, 2.0), 1800)
        assert self.look(heard, (2.1, 4.1), 1295)
        assert self.look(heard, (4.2, 4.3), 1800)

    def test_one_position_is_not_a_move_nor_is_a_short_one(self) -> None:
        heard = Heard()
        assert not self.look(heard, (0.0, 30.0), 1800)
        assert not self.look(heard, (30.1, 31.2), 1295)
        assert not self.look(heard, (31.3, 60.0), 1800)

    @pytest.mark.fault(
        "a dying receiver invents pulses",
        "they are no move of the switch (`switch_must_move`); a boot forgets a move",
    )
    def test_the_pulses_of_a_lost_receiver_are_not(self) -> None:
        heard = Heard()
        self.look(heard, (0.0, 5.0), 1800)
        self.look(heard, (5.1, 6.1), 1500)
        assert not self.look(heard, (6.2, 20.0), 1500, hears=False)

    @pytest.mark.fault("a dying receiver invents pulses")
    def test_a_boot_forgets_it(self) -> None:
        heard = Heard()
        self.look(heard, (0.0, 2.0), 1800)
        assert self.look(heard, (2.1, 4.1), 1295)
        assert not self.look(heard, (4.2, 9.0), 1295, boots=1)

    def test_another_channel_forgets_it(self) -> None:
        heard = Heard()
        self.look(heard, (0.0, 2.0), 1800)
        assert self.look(heard, (2.1, 4.1), 1295)
        assert not heard.hear(None, 6, 4.2).has_moved


def test_in_flight_it_is_lost_after_two_seconds_and_heard_again_at_once() -> None:
    heard = Heard()

    def look(now: float, *, hears: bool) -> float | None:
        return heard.hear(RemoteControl((1500,) * 18, 8, now, hears, now, 0), 5, now, is_armed=True).lost_s

    assert look(10.0, hears=True) is None
    assert look(11.0, hears=False) is None
    assert look(12.9, hears=False) is None
    assert look(13.0, hears=False) == 0.0
    assert look(14.5, hears=False) == 1.5
    assert look(14.6, hears=True) is None
    assert not RemoteControlFacts().has_moved


def no_channels(rig: Rig) -> None:
    rig.autopilot.radio_flows = False


def receiver_lost(rig: Rig) -> None:
    rig.autopilot.radio = False


def no_switch(rig: Rig) -> None:
    rig.autopilot.report("FLTMODE_CH", 0)


def no_pulse(rig: Rig) -> None:
    rig.autopilot.switch_pulse = 0


def no_hand_flown(rig: Rig) -> None:
    for name in MODE_NAMES:
        rig.autopilot.report(name, CopterMode.GUIDED)


@pytest.mark.slow
@pytest.mark.fault(
    "no remote control: RC_CHANNELS missing or old, receiver lost, no mode switch, its pulse not valid, its "
    "parameters not read"
)
@pytest.mark.parametrize("spoil", [no_channels, receiver_lost, no_switch, no_pulse, no_hand_flown])
async def test_arm_is_refused_without_a_pilot_who_could_take_over(rig: Rig, spoil: Callable[[Rig], None]) -> None:
    assert shown(rig).passed
    spoil(rig)
    await rig.run(3.5)
    assert not shown(rig).passed
    answer = rig.command(Arm())
    assert not answer.accepted
    assert answer.reason.startswith("Remote control: ")
    rig.expect(StateName.IDLE)
    assert rig.autopilot.count("arm") == 0


async def test_a_switch_that_was_not_read_refuses_arm(tmp_path: Path) -> None:
    rig = Rig(tmp_path, parameters={name: v for name, v in SAFE_PARAMETERS.items() if name != "FLTMODE4"})
    await rig.run(3.0)
    assert shown(rig).value == "mode switch not read yet"
    assert rig.command(Arm()).reason.startswith("Remote control: ")
    await rig.close()


@pytest.mark.nightly
async def test_flown_without_a_remote_control_where_none_is_required(tmp_path: Path) -> None:
    settings = DdcSettings(remote_control=RemoteControlSettings(required=False))
    rig = Rig(tmp_path, parameters={**SAFE_PARAMETERS, "FS_THR_ENABLE": 0, "FS_GCS_ENABLE": 0}, settings=settings)
    rig.autopilot.radio = None
    rig.autopilot.radio_flows = False
    await rig.run(2.0)
    rig.order(SetFailsafes())
    await rig.run(2.0)
    assert rig.autopilot.values["FS_THR_ENABLE"] == 0  # on, it would never let such a drone arm
    assert rig.autopilot.values["FS_GCS_ENABLE"] == 1
    assert shown(rig).value.startswith("not required")
    rig.order(Arm())
    await rig.run(3.0)
    assert rig.topics.vehicle.state.value is not None
    assert "The remote control is lost: nobody can take over by hand." not in rig.log
    await rig.close()


@pytest.mark.fault("the receiver is lost and ArduCopter repeats its last pulses")
async def test_a_remote_control_whose_failsafe_is_off_is_refused_where_it_is_required(tmp_path: Path) -> None:
    rig = Rig(tmp_path, parameters={**SAFE_PARAMETERS, "FS_THR_ENABLE": 0})
    await rig.run(2.0)
    assert rig.command(Arm()).reason.startswith("Remote-control failsafe: ")
    await rig.close()


@pytest.mark.slow
@pytest.mark.fault(
    "the remote control is lost in flight",
    "health and one message; the flight goes on, the autopilot's failsafe decides",
)
async def test_a_receiver_lost_in_flight_is_reported_once_and_the_flight_goes_on(fresh: Rig) -> None:
    rig = fresh
    await rig.enter(StateName.HOVER)
    await rig.run(3.0)
    words = "The remote control is lost: nobody can take over by hand."
    assert words not in rig.log
    rig.autopilot.radio = False
    await rig.run(10.0)
    rig.expect(StateName.HOVER)
    assert rig.log.count(words) == 1
    reported = next(item for item in rig.shown.parts.health if item.name == "remote control")
    assert (reported.healthy, reported.reason) == (False, words)
    rig.autopilot.radio = True
    await rig.run(0.5)
    assert next(item for item in rig.shown.parts.health if item.name == "remote control").healthy
    assert rig.log.count(words) == 1
