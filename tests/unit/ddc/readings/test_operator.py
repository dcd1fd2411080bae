"""The operator in control as one tick knows it: the state of control, and names."""

from __future__ import annotations

import pytest

from hawk.comm.protocol.authority import Tenure
from hawk.ddc.readings.operator import NO_OPERATOR, OperatorFacts


@pytest.mark.parametrize(
    ("controlled", "present", "tenure"),
    [(True, True, Tenure.HELD), (True, False, Tenure.LOST), (False, False, Tenure.FREE), (False, True, Tenure.FREE)],
)
def test_control_is_held_lost_or_free(controlled: bool, present: bool, tenure: Tenure) -> None:
    assert OperatorFacts(is_present=present, is_controlled=controlled).tenure is tenure


def test_before_anybody_came_control_is_free_and_nobody_is_there() -> None:
    assert NO_OPERATOR.tenure is Tenure.FREE
    assert not NO_OPERATOR.is_present
    assert not NO_OPERATOR.is_controlled


def test_a_name_is_that_of_the_connection() -> None:
    facts = OperatorFacts(names=(("ana", "Ana"), ("eve", "Eve")))
    assert [facts.name(client) for client in ("eve", "ana", "bob")] == ["Eve", "Ana", ""]
