"""Names of those who asked for Hold, a return or a landing, and control that was given back in the air."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import Command, Hold, Land, ReturnToLaunch
from hawk.ddc.acts import Log
from hawk.ddc.decider import Decider, Decision
from hawk.ddc.facts import Facts
from hawk.ddc.orders import ToExplore, ToHover
from hawk.ddc.readings.operator import NO_OPERATOR, OperatorFacts
from hawk.ddc.rules.kill import KillTokens
from hawk.model.operation import StateName as S
from tests.unit.ddc.fakes import Rig
from tests.unit.ddc.written_facts import SETTINGS, flying, follow

NAMES = (("client-1", "Ana"), ("client-2", "Eve"))
ANA = OperatorFacts(True, True, frozenset({"client-1"}), "Ana", NAMES)


def reported(decision: Decision) -> list[str]:
    return [act.text for act in decision.acts if isinstance(act, Log)]


def exploring(facts: Facts) -> Decider:
    program = Decider(SETTINGS, KillTokens(lambda: "t" * 32), 0.0)
    follow(program, facts, ToExplore())
    return program


@pytest.mark.parametrize(
    ("command", "client", "state", "line"),
    [
        (Hold(), "client-2", S.HOVER, "Stopped by Eve. Holding."),
        (Hold(), "client-1", S.HOVER, "Stopped by Ana. Holding."),
        (ReturnToLaunch(), "client-1", S.RETURN_TO_LAUNCH, "Returning home, asked by Ana."),
        (Land(), "client-1", S.LAND, "Landing, asked by Ana."),
        (Hold(), "client-9", S.HOVER, "Stopped by the operator. Holding."),
    ],
)
def test_the_log_and_the_state_name_the_one_who_asked(command: Command, client: str, state: S, line: str) -> None:
    facts = replace(flying(1.0), operator=ANA)
    program = exploring(facts)
    decision = program.command(facts, client, command)
    assert program.state.identity is state
    assert line in reported(decision)
    assert program.state.detail(facts).startswith(line.removesuffix(" Holding."))
    assert program.state.asked_by == dict(NAMES).get(client, "")


def test_facts_from_before_the_names_decide_as_before() -> None:
    """Recordings have no names: the same state follows, and the words name nobody."""
    facts = replace(flying(1.0), operator=OperatorFacts(True, True, frozenset({"client-1"})))
    program = exploring(facts)
    decision = program.command(facts, "client-1", ReturnToLaunch())
    assert "Returning home." in reported(decision)
    assert program.state.detail(facts) == "Returning home."


def test_a_name_gives_no_right() -> None:
    names = (("client-1", "Ana"), ("client-2", "Ana"))
    facts = replace(flying(1.0), operator=replace(ANA, names=names))
    program = exploring(facts)
    answer = program.command(facts, "client-2", Land()).answer
    assert (getattr(answer, "accepted", None), program.state.identity) == (False, S.AUTONOMOUS_EXPLORE)


def test_a_reaction_names_nobody() -> None:
    facts = replace(flying(1.0), operator=ANA)
    program = exploring(facts)
    program.command(facts, "client-2", Hold())
    follow(program, facts, ToHover("Outside the fence."))
    assert program.state.asked_by == ""


@pytest.mark.slow
@pytest.mark.fault(
    "control is given back in the air and nobody takes it",
    "the drone holds for `operator_hold_s`, then returns home; Hold is refused meanwhile",
)
async def test_control_given_back_in_the_air_holds_and_then_returns_home(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.desk.client, fresh.desk.former = None, "Ana"
    await fresh.tick()
    fresh.expect(S.COMMUNICATION_LOST)
    assert fresh.log[-1] == "Control was given back by Ana. Holds for 30 s, then returns home."
    await fresh.run(29.5)
    fresh.expect(S.COMMUNICATION_LOST)
    assert fresh.manager.status.value is not None
    assert fresh.manager.status.value.operation.detail.startswith("Control was given back by Ana. Returns home in")
    await fresh.run(0.8)
    fresh.expect(S.RETURN_TO_LAUNCH)
    assert fresh.log[-1] == "Nobody took control. Returning home."
    assert fresh.command(Hold()).accepted is False, "nobody has control, and the cause lasts"


async def test_one_who_takes_control_that_was_given_back_goes_on_from_hover(fresh: Rig) -> None:
    await fresh.enter(S.COMPULSIVE_MOVE)
    fresh.desk.client, fresh.desk.former = None, "Ana"
    await fresh.run(5)
    fresh.desk.client = "eve"
    await fresh.tick()
    fresh.expect(S.HOVER)
    assert fresh.log[-1].startswith("eve has taken control.")


async def test_control_that_goes_to_another_directly_leaves_the_task_alone(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.desk.client = "eve"
    await fresh.run(2)
    fresh.expect(S.AUTONOMOUS_EXPLORE)


def test_without_an_operator_no_name_is_known() -> None:
    assert NO_OPERATOR.name("client-1") == ""
