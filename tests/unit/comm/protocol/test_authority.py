from __future__ import annotations

from typing import get_args

import pytest

from hawk.comm.protocol.authority import Role, Tenure, authority_refusal, role_refusal
from hawk.comm.protocol.command_table import COMMAND_TABLE, sender_of
from hawk.comm.protocol.commands import AnyCommand
from tests.sweep import sweep

KINDS = sorted(model.model_fields["type"].default for model in get_args(get_args(AnyCommand)[0]))
OF_THE_SESSION = {"Name", "Control", "Heartbeat", "Map Resync"}
JUDGED = [kind for kind in KINDS if kind not in OF_THE_SESSION]

ASKING = {"Route Request", "Check Fence"}
FOR_SAFETY = {"Return To Launch", "Land", "Kill Request", "Kill"}


def test_the_web_server_answers_what_concerns_the_session_and_nothing_else() -> None:
    assert {kind for kind in KINDS if COMMAND_TABLE[kind].answered_by_web_server} == OF_THE_SESSION


@sweep("homing", [False, True])
@sweep("control", [Tenure.HELD, Tenure.LOST])
@sweep("kind", JUDGED)
def test_the_client_in_control_may_send_every_command(kind: str, control: Tenure, homing: bool) -> None:
    assert authority_refusal(sender_of(kind), has_control=True, control=control, homing=homing) == ""


@sweep("homing", [False, True])
@sweep("kind", JUDGED)
def test_while_someone_else_has_control(kind: str, homing: bool) -> None:
    refusal = authority_refusal(sender_of(kind), has_control=False, control=Tenure.HELD, homing=homing)
    allowed = kind in ASKING or (kind == "Hold" and not homing)
    assert refusal == ("" if allowed else "Someone else has control.")


@sweep("homing", [False, True])
@sweep("control", [Tenure.FREE, Tenure.LOST])
@sweep("kind", JUDGED)
def test_while_nobody_has_control_or_its_holder_is_lost(kind: str, control: Tenure, homing: bool) -> None:
    refusal = authority_refusal(sender_of(kind), has_control=False, control=control, homing=homing)
    allowed = kind in ASKING | FOR_SAFETY or (kind == "Hold" and not homing)
    lost = "The operator in control is lost: take control first."
    assert refusal == ("" if allowed else lost if control is Tenure.LOST else "Take control first.")


@pytest.mark.parametrize("control", list(Tenure))
def test_a_command_that_the_table_does_not_list_needs_control(control: Tenure) -> None:
    assert authority_refusal(sender_of("Fly"), has_control=False, control=control, homing=False)
    assert not authority_refusal(sender_of("Fly"), has_control=True, control=Tenure.HELD, homing=False)


@sweep("kind", KINDS)
def test_a_viewer_commands_nothing_and_an_operators_role_forbids_nothing(kind: str) -> None:
    assert role_refusal(sender_of(kind), Role.OPERATOR) == ""
    assert (role_refusal(sender_of(kind), Role.VIEWER) == "") is (kind in ("Heartbeat", "Map Resync"))
