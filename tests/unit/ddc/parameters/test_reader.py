"""The reader of the autopilot's parameters: quick, never by old values, watching in flight."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import CompulsiveMove, Hold
from hawk.config.sections import RemoteControlSettings
from hawk.ddc.acts import Act, Ask, Log, ReadParameter, SetParameters
from hawk.ddc.facts import Answer, Facts
from hawk.ddc.parameters.failsafes import ALL_NAMES, HIGHEST_ID_NAME, MAY_BE_MISSING, check_failsafes
from hawk.ddc.parameters.reader import AT_ONCE, ParameterReader
from hawk.ddc.readings.remote_control import SWITCH_NAMES, remote_control_check
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode, ForeignWrite
from tests.sweep import sweep
from tests.unit.ddc.by_facts import read_all, reads, standing
from tests.unit.ddc.fakes import DEFAULT_PARAMETERS, SAFE_PARAMETERS, Rig
from tests.unit.ddc.parameters.test_failsafes import SAFE_47, VIEW
from tests.unit.ddc.written_facts import flying, on_ground


class Bench:
    """A reader and an autopilot that answers at the next tick, except for ``silent`` names."""

    def __init__(self, values: Mapping[str, float | None], silent: frozenset[str] = frozenset()) -> None:
        self.reader = ParameterReader(245)
        self.values = dict(values)
        self.silent = silent
        self.now = 100.0
        self.asked: list[str] = []
        self.most = 0
        self.messages: list[Log] = []
        self.sets: list[SetParameters] = []
        self._open: list[tuple[float, Ask]] = []
        self.answer_s, self.silence_s = 0.1, 2.0

    def facts(self) -> Facts:
        answers = [self._answer(due, ask) for due, ask in self._open]
        return replace(on_ground(flying(self.now)), answers=tuple(answers))

    def tick(self) -> None:
        self.now += 0.05
        acts: tuple[Act, ...] = self.reader.tick(self.facts())
        for act in acts:
            if isinstance(act, Log):
                self.messages.append(act)
            elif isinstance(act, Ask):
                self._start(act)
        self.most = max(self.most, sum(due > self.now for due, _ in self._open))

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            self.tick()

    def _start(self, ask: Ask) -> None:
        name = ask.request.parameter if isinstance(ask.request, ReadParameter) else ""
        late = name in self.silent or (name and self.values.get(name) is None)
        if isinstance(ask.request, SetParameters):
            self.sets.append(ask.request)
        else:
            self.asked.append(name)
        self._open.append((self.now + (self.silence_s if late else self.answer_s), ask))

    def _answer(self, due: float, ask: Ask) -> Answer:
        if due > self.now:
            return Answer(ask.name, ask.at, "pending")
        if not isinstance(ask.request, ReadParameter):
            return Answer(ask.name, ask.at, "done")
        name = ask.request.parameter
        value = None if name in self.silent else self.values.get(name)
        if value is None:
            return Answer(ask.name, ask.at, "failed", "no answer")
        return Answer(ask.name, ask.at, "done", value=value)


def test_all_is_read_within_a_second_and_few_at_a_time() -> None:
    bench = Bench(SAFE_PARAMETERS)
    bench.run(1.0)
    assert all(check.passed for check in check_failsafes(bench.reader.values(), VIEW))
    assert bench.most <= AT_ONCE


def test_a_parameter_that_the_version_lacks_is_given_up_after_two_silences_beside_an_answer() -> None:
    bench = Bench({**SAFE_47, HIGHEST_ID_NAME: None})
    bench.run(2.5)
    assert HIGHEST_ID_NAME not in bench.reader.values()
    bench.run(2.5)
    assert bench.reader.values()[HIGHEST_ID_NAME] is None
    assert all(check.passed for check in check_failsafes(bench.reader.values(), VIEW))


@pytest.mark.slow
@pytest.mark.fault("autopilot answers no parameter at all", 'nothing is taken as "missing from this version"')
def test_an_autopilot_that_answers_nothing_lacks_nothing() -> None:
    bench = Bench(SAFE_47, frozenset(ALL_NAMES))
    bench.run(30)
    assert bench.reader.values() == {}


@pytest.mark.slow
@pytest.mark.fault("a parameter is not answered")
@sweep("name", sorted(set(SAFE_PARAMETERS) - {"RTL_ALT", "FENCE_ALT_MAX"} - MAY_BE_MISSING))
def test_a_parameter_that_every_version_has_is_never_given_up(name: str) -> None:
    bench = Bench(SAFE_PARAMETERS, frozenset({name}))
    bench.run(10)
    values = bench.reader.values()
    assert name not in values
    assert all(check.passed for check in check_failsafes(values, VIEW)) is (name in SWITCH_NAMES)
    heard = flying(bench.now).remote_control
    assert remote_control_check(heard, values, RemoteControlSettings()).passed is (name not in SWITCH_NAMES)


def test_a_missing_parameter_stays_known_over_a_setting() -> None:
    bench = Bench({**SAFE_47, HIGHEST_ID_NAME: None})
    bench.run(5.0)
    bench.reader.set_failsafes()
    bench.run(1.0)
    assert all(check.passed for check in check_failsafes(bench.reader.values(), VIEW))


@pytest.mark.fault(
    "a setting of failsafes that did not hold",
    "values from before it are void from its first tick; Arm waits for the reading after it (0.2 s hawk-sim)",
)
def test_what_was_read_before_the_setting_is_void() -> None:
    bench = Bench(SAFE_PARAMETERS)
    bench.run(2.0)
    bench.reader.set_failsafes()
    bench.tick()
    assert bench.sets
    assert bench.reader.values() == {}
    bench.values["FENCE_ENABLE"] = 0.0  # the setting did not hold
    while bench.reader.is_setting:
        bench.tick()
        assert bench.reader.values() == {}
    bench.run(1.0)
    assert bench.reader.values()["FENCE_ENABLE"] == 0


def test_a_parameter_that_fails_while_failsafes_are_to_be_set_is_reported() -> None:
    bench = Bench(DEFAULT_PARAMETERS, frozenset({"FS_THR_ENABLE"}))
    bench.run(2.5)
    bench.reader.set_failsafes()
    bench.run(5.0)
    assert not bench.reader.is_setting
    assert bench.sets == []
    assert [log.text for log in bench.messages] == ["The failsafes were not set."]


# -- in flight --------------------------------------------------------------------------------------------------------


@pytest.mark.nightly
async def test_a_flight_that_is_taken_up_reads_everything_once_and_watches_what_decides(flying: Rig) -> None:
    await flying.run(2)
    once = Counter(flying.autopilot.asked("get_parameter"))
    assert set(SAFE_PARAMETERS) <= set(once)
    flying.autopilot.calls.clear()
    await flying.run(35)
    again = Counter(flying.autopilot.asked("get_parameter"))
    assert set(again) == set(SAFE_PARAMETERS) - set(SWITCH_NAMES)
    assert all(4 <= count <= 5 for count in again.values())


CHANGES = [
    ("FENCE_ENABLE", 0, "Fence in the autopilot: off (FENCE_ENABLE 0). No new task until it is right."),
    ("FENCE_ACTION", 0, "Fence in the autopilot: only reports (FENCE_ACTION 0). No new task until it is right."),
    ("FENCE_TYPE", 2, "Fence in the autopilot: not known to be safe (FENCE_TYPE 2). No new task until it is right."),
    ("FS_GCS_ENABLE", 0, "Ground-station failsafe: off (FS_GCS_ENABLE 0). No new task until it is right."),
    ("SYSID_MYGCS", 255, "Ground-station failsafe: watches station 255, this is 245. No new task until it is right."),
    ("BATT_FS_LOW_ACT", 5, "Battery failsafe: cuts the motors (BATT_FS_LOW_ACT 5). No new task until it is right."),
    (
        "RALLY_TOTAL",
        1,
        "Autopilot's return: to a rally point where one is nearer (RALLY_TOTAL 1). No new task until it is right.",
    ),
]


SILENT_CHANGES = [change for change in CHANGES if change[0] != "FENCE_ENABLE"]
"""The comparison of the fence finds a fence that is off as well, and uploads it at once."""


@pytest.mark.slow
@pytest.mark.fault(
    "rally points, RTL_ALT_FINAL above 0, RTL_CLIMB_MIN above 3 m, RTL_ALT_TYPE terrain: RTL ends elsewhere, "
    "in the air, or above the ceiling"
)
@pytest.mark.fault(
    "another station sets BATT_FS_LOW_ACT 5 (or another failsafe, threshold, RTL_ALT, RTL_*, FENCE_*) to the "
    "worse in flight, with or without a PARAM_VALUE to all",
    "reported within 10 s, put back at once, no new task until it holds; the flight goes on",
)
@pytest.mark.parametrize(
    ("name", "value", "words", "messages"),
    [*((*change, True) for change in CHANGES), *((*change, False) for change in SILENT_CHANGES)],
)
async def test_a_change_in_flight_is_reported_and_put_back_and_refuses_new_tasks_until_then(
    flying: Rig, name: str, value: float, words: str, messages: bool
) -> None:
    await flying.run(2)
    flying.order(CompulsiveMove(x=30.0, y=0.0))
    before = flying.autopilot.values[name]
    path = "clear_rally_points" if name == "RALLY_TOTAL" else "set_parameter"
    flying.autopilot.refuse[path] = "busy"
    flying.autopilot.fence_on = True
    if messages:
        flying.autopilot.report(name, value)
        await flying.tick(2)
    else:
        flying.autopilot.values[name] = value
        for _ in range(20):
            if words not in flying.log:
                await flying.run(0.5)
    assert words in flying.log
    entry = next(entry for entry in flying.manager.log.entries if entry.text == words)
    assert entry.level == "warning"
    assert "It is being put back. Who changed it is not known" in entry.details
    refused = flying.command(CompulsiveMove(x=0.0, y=0.0))
    assert refused.reason.startswith(words.partition(":")[0])
    assert refused.reason.endswith("It is being put back: wait.")
    assert flying.state in (StateName.COMPULSIVE_MOVE, StateName.HOVER)  # the flight goes on
    del flying.autopilot.refuse[path]
    await flying.run(2.2)
    assert flying.autopilot.values[name] == before
    assert any("is right again" in text for text in flying.log)
    flying.order(CompulsiveMove(x=0.0, y=0.0))


@pytest.mark.slow
@pytest.mark.fault(
    "another station sets BATT_FS_LOW_ACT 5 (or another failsafe, threshold, RTL_ALT, RTL_*, FENCE_*) to the "
    "worse in flight, with or without a PARAM_VALUE to all"
)
@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("RTL_ALT", 30000),
        ("FENCE_ALT_MAX", 300),
        ("FS_OPTIONS", 0),
        ("FS_EKF_ACTION", 0),
        ("BATT_LOW_VOLT", 0),
        ("BATT_LOW_TIMER", 120),
        ("BATT_FS_CRT_ACT", 5),
        ("RTL_ALT_FINAL", 1000),
        ("RTL_ALT_TYPE", 1),
        ("RTL_CLIMB_MIN", 3000),
        ("RTL_LOIT_TIME", 10_000_000),
        ("RTL_SPEED", 1),
        ("FS_GCS_TIMEOUT", 120),
        ("FS_THR_ENABLE", 0),
    ],
)
async def test_whatever_another_station_sets_to_the_worse_in_flight_is_put_back(
    flying: Rig, name: str, value: float
) -> None:
    await flying.run(2)
    before = flying.autopilot.values[name]
    flying.autopilot.values[name] = value  # nobody broadcasts it
    await flying.run(10.5)
    assert flying.autopilot.values[name] == before
    assert any("No new task until it is right." in text for text in flying.log)
    flying.expect(StateName.HOVER)


@pytest.mark.slow
@pytest.mark.fault("another station changes a parameter to a value that is as safe", "it stays, nothing is refused")
@pytest.mark.parametrize(("name", "value"), [("BATT_FS_LOW_ACT", 1), ("RTL_ALT", 500), ("BATT_LOW_VOLT", 11.0)])
async def test_a_change_that_is_as_safe_needs_no_fight(flying: Rig, name: str, value: float) -> None:
    await flying.run(2)
    flying.autopilot.report(name, value)
    await flying.run(10.5)
    assert flying.autopilot.values[name] == value
    assert flying.autopilot.count("set_parameter") == 0
    flying.order(CompulsiveMove(x=0.0, y=0.0))


@pytest.mark.slow
@pytest.mark.fault(
    "another station changes it again after each put-back",
    "after three in a minute given up: returns home, Hold is refused",
)
async def test_who_changes_it_again_and_again_ends_the_flight_at_home(flying: Rig) -> None:
    await flying.run(2)
    for _ in range(4):
        flying.autopilot.report("BATT_FS_LOW_ACT", 5)
        await flying.run(3)
    flying.expect(StateName.RETURN_TO_LAUNCH)
    assert flying.autopilot.asked("set_parameter") == [("BATT_FS_LOW_ACT", 2)] * 3
    assert "BATT_FS_LOW_ACT cannot be put back to 2." in flying.log
    assert flying.autopilot.mode == CopterMode.RTL
    assert flying.command(Hold()).reason.startswith("Not while this lasts: Somebody changes the autopilot")


@pytest.mark.nightly
async def test_what_the_autopilot_refuses_to_take_back_ends_the_flight_at_home(flying: Rig) -> None:
    await flying.run(2)
    flying.autopilot.refuse["set_parameter"] = "no"
    flying.autopilot.report("BATT_FS_LOW_ACT", 5)
    await flying.run(5)
    flying.expect(StateName.HOVER)
    await flying.run(2)
    flying.expect(StateName.RETURN_TO_LAUNCH)


@pytest.mark.slow
@pytest.mark.fault("a change while a pilot flies", "reported, nothing written, put back afterwards")
async def test_while_a_pilot_flies_a_change_is_reported_and_nothing_is_written(flying: Rig) -> None:
    await flying.run(2)
    flying.autopilot.change_mode(CopterMode.LOITER)
    await flying.tick(2)
    flying.expect(StateName.MANUAL)
    flying.autopilot.report("BATT_FS_LOW_ACT", 5)
    await flying.run(40)
    assert flying.autopilot.count("set_parameter") == 0
    flying.expect(StateName.MANUAL)
    entry = next(entry for entry in flying.manager.log.entries if "cuts the motors" in entry.text)
    assert "It is put back when the drone is taken from the pilot." in entry.details


async def test_the_station_is_named_where_its_message_is_heard(flying: Rig) -> None:
    await flying.run(2)
    write = ForeignWrite(flying.clock(), 254, 190, "BATT_FS_LOW_ACT")
    flying.autopilot.topics.foreign_write.publish(write)
    flying.autopilot.report("BATT_FS_LOW_ACT", 5)
    await flying.tick(2)
    assert any("Station 254 (component 190) changed it." in text for text in flying.log)


async def test_outside_the_fence_it_is_not_switched_on_because_the_autopilot_would_act_at_once(flying: Rig) -> None:
    await flying.run(2)
    flying.autopilot.north = 170.0
    flying.autopilot.report("FENCE_ENABLE", 0)
    flying.autopilot.report("BATT_FS_LOW_ACT", 5)
    await flying.tick(3)
    assert flying.autopilot.asked("set_parameter") == [("BATT_FS_LOW_ACT", 2)]


@pytest.mark.fault(
    "a switch or MAV_CMD_DO_FENCE_ENABLE turns the fence off, FENCE_ENABLE stays 1",
    "seen in SYS_STATUS: warning and no new task (0.6 s on the real one); on the ground Arm is refused",
)
async def test_a_switch_that_turns_the_fence_off_is_seen_though_no_parameter_changes(flying: Rig) -> None:
    await flying.run(2)
    flying.autopilot.fence_on = False
    await flying.tick(2)
    assert "Fence in the autopilot: switched off. No new task until it is right." in flying.log
    assert not flying.command(CompulsiveMove(x=0.0, y=0.0)).accepted
    flying.autopilot.fence_on = True
    await flying.tick(2)
    flying.order(CompulsiveMove(x=0.0, y=0.0))


@pytest.mark.slow
@pytest.mark.fault("deciding parameters are not answered for a minute in flight", "new tasks are refused")
async def test_deciding_parameters_that_are_not_answered_for_a_minute_refuse_new_tasks(flying: Rig) -> None:
    await flying.run(2)
    flying.autopilot.refuse["get_parameter"] = "no answer"
    await flying.run(45)
    flying.order(CompulsiveMove(x=0.0, y=0.0))
    await flying.run(30)
    refused = flying.command(CompulsiveMove(x=10.0, y=0.0))
    assert refused.reason == "Ground-station failsafe: not read yet. Wait a moment."


async def test_a_name_of_another_version_is_no_warning(fresh: Rig, caplog: pytest.LogCaptureFixture) -> None:
    del fresh.autopilot.values["FS_OPTIONS"]
    with caplog.at_level(logging.DEBUG, "hawk.ddc.operations_manager"):
        await fresh.run(3.0)
    levels = {record.getMessage().split(":")[0]: record.levelno for record in caplog.records}
    assert levels["read RTL_ALT_M"] == levels["read MAV_GCS_SYSID"] == logging.DEBUG
    assert levels["read FS_OPTIONS"] == logging.WARNING


# -- times by value ----------------------------------------------------------------------------------------------------


READ: dict[str, float | None] = {**dict.fromkeys(ALL_NAMES, 0.0), **SAFE_PARAMETERS}


def test_on_the_ground_a_parameter_is_read_again_after_twenty_seconds() -> None:
    reader = ParameterReader(245)
    read_all(reader, standing(100.0), READ)
    assert reads(reader.tick(standing(119.9))) == []
    assert reads(reader.tick(standing(120.0))) != []


def test_a_read_that_failed_is_tried_again_after_three_seconds() -> None:
    reader = ParameterReader(245)
    read_all(reader, standing(100.0), READ, fails="FS_GCS_ENABLE")
    assert reads(reader.tick(standing(102.9))) == []
    assert reads(reader.tick(standing(103.0))) == ["FS_GCS_ENABLE"]
