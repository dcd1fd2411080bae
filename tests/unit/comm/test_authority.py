from __future__ import annotations

from typing import get_args

import pytest

from hawk.comm.authority import ANSWERED_BY_THE_WEB_SERVER, RIGHTS, authority_refusal
from hawk.comm.messages import AnyCommand

KINDS = sorted(model.model_fields["type"].default for model in get_args(get_args(AnyCommand)[0]))
JUDGED = [kind for kind in KINDS if kind not in ANSWERED_BY_THE_WEB_SERVER]

ASKING = {"Route Request", "Check Fence"}
BRINGING_DOWN = {"Return To Launch", "Land"}


def test_every_command_is_either_judged_or_answered_by_the_web_server() -> None:
    assert set(RIGHTS) | ANSWERED_BY_THE_WEB_SERVER == set(KINDS)
    assert not set(RIGHTS) & ANSWERED_BY_THE_WEB_SERVER


@pytest.mark.parametrize("homing", [False, True])
@pytest.mark.parametrize("kind", JUDGED)
def test_the_client_in_control_may_send_every_command(kind: str, homing: bool) -> None:
    assert authority_refusal(kind, has_control=True, is_controlled=True, homing=homing) == ""


@pytest.mark.parametrize("homing", [False, True])
@pytest.mark.parametrize("kind", JUDGED)
def test_while_someone_else_has_control(kind: str, homing: bool) -> None:
    refusal = authority_refusal(kind, has_control=False, is_controlled=True, homing=homing)
    allowed = kind in ASKING or (kind == "Hold" and not homing)
    assert refusal == ("" if allowed else "Someone else has control.")


@pytest.mark.parametrize("homing", [False, True])
@pytest.mark.parametrize("kind", JUDGED)
def test_while_nobody_has_control(kind: str, homing: bool) -> None:
    refusal = authority_refusal(kind, has_control=False, is_controlled=False, homing=homing)
    allowed = kind in ASKING | BRINGING_DOWN or (kind == "Hold" and not homing)
    assert refusal == ("" if allowed else "Take control first.")


@pytest.mark.parametrize("is_controlled", [False, True])
def test_a_command_that_the_table_does_not_list_needs_control(is_controlled: bool) -> None:
    assert authority_refusal("Fly", has_control=False, is_controlled=is_controlled, homing=False)
    assert not authority_refusal("Fly", has_control=True, is_controlled=True, homing=False)
