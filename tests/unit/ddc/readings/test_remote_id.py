"""Remote ID before Arm, where it is on: each word that is missing, old or bad refuses it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from hawk.comm.autopilot.remote_id import RemoteIdReport
from hawk.comm.protocol.commands import Arm
from hawk.comm.protocol.heartbeat import CheckItem
from hawk.config.sections import RemoteIdSettings
from hawk.ddc.readings.remote_id import AGE_S, RemoteIdFacts, remote_id_checks, remote_id_health
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import StateName
from tests.unit.ddc.fakes import Rig

ON = RemoteIdSettings(enabled=True, operator_id="FIN87astrdge12k8")
GOOD = RemoteIdFacts(good=True, age=0.5)


def shown(rig: Rig) -> CheckItem | None:
    return next((item for item in rig.manager.situation().checks if item.name == "Remote ID"), None)


def test_where_it_is_off_there_is_no_check() -> None:
    assert remote_id_checks(RemoteIdFacts(), RemoteIdSettings()) == ()


def test_a_transmitter_that_is_good_to_arm_passes() -> None:
    (found,) = remote_id_checks(GOOD, ON)
    assert found.passed
    assert found.value == "good to arm, operator FIN87astrdge12k8"


@pytest.mark.parametrize(
    ("facts", "value"),
    [
        (RemoteIdFacts(), "no word of a transmitter"),
        (replace(GOOD, age=3.1), "no word of the transmitter for 3 s"),
        (replace(GOOD, good=False, error="missing OP_ID SYS"), "missing OP_ID SYS"),
        (replace(GOOD, good=False), "the transmitter is not ready, and does not say why"),
        (replace(GOOD, good=False, error="missing SYS", age=9.0), "no word of the transmitter for 9 s"),
    ],
)
def test_each_other_word_fails_with_consequence_and_remedy(facts: RemoteIdFacts, value: str) -> None:
    (found,) = remote_id_checks(facts, ON)
    assert not found.passed
    assert found.value == value
    assert found.consequence
    assert found.remedy


def test_in_flight_it_is_a_fault_that_is_shown() -> None:
    assert remote_id_health(GOOD, ON, is_armed=True).is_healthy
    bad = replace(GOOD, good=False, error="missing SYS")
    assert remote_id_health(bad, ON, is_armed=True).reason == "Remote ID: missing SYS."
    assert remote_id_health(bad, ON, is_armed=False).is_healthy
    assert remote_id_health(bad, RemoteIdSettings(), is_armed=True).is_healthy


@pytest.mark.slow
@pytest.mark.fault(
    "Remote ID is on, and the transmitter is missing, silent for 3 s, or not good to arm",
    "Arm is refused with the transmitter's words",
)
async def test_arm_is_refused_until_the_transmitter_is_ready(tmp_path: Path) -> None:
    rig = Rig(tmp_path, settings=DdcSettings(remote_id=ON))
    await rig.run(2.0)
    assert rig.command(Arm()).reason.startswith("Remote ID: no word of a transmitter")
    rig.autopilot.remote_id = RemoteIdReport(False, "missing OP_ID")
    await rig.run(0.1)
    assert rig.command(Arm()).reason.startswith("Remote ID: missing OP_ID")
    rig.autopilot.remote_id = RemoteIdReport(True)
    await rig.run(0.1)
    item = shown(rig)
    assert item is not None
    assert item.passed
    rig.autopilot.remote_id = None
    await rig.run(3.2)
    assert rig.command(Arm()).reason.startswith("Remote ID: no word of the transmitter for 3 s")
    rig.expect(StateName.IDLE)
    assert rig.autopilot.count("arm") == 0
    rig.autopilot.remote_id = RemoteIdReport(True)
    await rig.run(0.1)
    rig.order(Arm())
    await rig.close()


async def test_where_it_is_off_nothing_of_it_is_shown(rig: Rig) -> None:
    assert shown(rig) is None
    rig.order(Arm())


@pytest.mark.parametrize(
    ("good", "age", "waits"), [(False, AGE_S, True), (False, AGE_S + 0.1, False), (True, AGE_S + 1, False)]
)
def test_only_a_transmitter_that_is_heard_and_not_ready_is_waited_for(good: bool, age: float, waits: bool) -> None:
    (check,) = remote_id_checks(RemoteIdFacts(good=good, age=age), ON)
    assert not check.passed
    assert check.remedy.startswith("Wait a moment") is waits
