"""Names of sessions, and the question for control."""

from __future__ import annotations

import secrets

import pytest

from hawk.config.sections import OperatorSettings
from hawk.web.sessions import AGAIN_S, ANSWER_S, OPEN_S, PAUSE_S, RENAME_S, ControlDesk
from tests.manual_clock import ManualClock
from tests.unit.web.rig import Connect, Rig


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(100.0)


@pytest.fixture
def desk(clock: ManualClock) -> ControlDesk:
    """Ana has control; ben and cleo watch."""
    made = ControlDesk(clock, OperatorSettings(operator_timeout_s=10, operator_hold_s=30, control_lease_s=30))
    for client in ("ana", "ben", "cleo"):
        made.connect(client, None)
        made.call(client, client.capitalize())
    made.request("ana")
    return made


def pass_time(desk: ControlDesk, clock: ManualClock, seconds: float) -> None:
    """Let time pass in which the page of the one in control sends its signs of life."""
    while seconds > 0.0:
        clock.advance(min(5.0, seconds))
        seconds -= 5.0
        desk.sign_of_life("ana")


# -- names ------------------------------------------------------------------------------------------------------------


def test_a_session_has_a_number_until_it_gives_a_name(desk: ControlDesk, clock: ManualClock) -> None:
    desk.connect("dan", None)
    assert desk.names()["dan"] == "Operator 4"
    assert desk.call("dan", "Dan") is None
    assert desk.names()["dan"] == "Dan"
    clock.advance(RENAME_S)
    assert desk.call("dan", None) is None
    assert desk.names()["dan"] == "Operator 4"


@pytest.mark.fault("a session calls itself by the pilot's name", "it gets a number behind the name, and no right")
def test_two_sessions_never_have_the_same_name(desk: ControlDesk) -> None:
    desk.connect("thief", None)
    assert desk.call("thief", "ANA") is None
    assert desk.names()["thief"] == "ANA 2"
    assert desk.controller() == "Ana"
    assert not desk.has_control("thief")


def test_a_session_that_comes_back_to_a_name_that_was_taken_gets_a_number(desk: ControlDesk) -> None:
    secret = secrets.token_urlsafe(32)
    desk.connect("dan", secret)
    desk.call("dan", "Dan")
    desk.disconnect("dan")
    desk.connect("other", None)
    desk.call("other", "Dan")
    assert desk.names()["other"] == "Dan"
    desk.connect("dan again", secret)
    assert desk.names()["dan again"] == "Dan 2"


def test_names_do_not_change_in_quick_succession(desk: ControlDesk, clock: ManualClock) -> None:
    assert desk.call("ben", "Ben") is None, "the same name again, after a new connection"
    assert (desk.call("ben", "Bob") or "").startswith("Name: was changed a moment ago")
    clock.advance(RENAME_S)
    assert desk.call("ben", "Bob") is None


# -- the question -----------------------------------------------------------------------------------------------------


def test_the_one_in_control_gives_it(desk: ControlDesk) -> None:
    assert desk.ask("ben") is None
    assert not desk.has_control("ben"), "asking grants nothing"
    assert desk.seen_by("ana").asked_by == "Ben"
    assert desk.seen_by("ben").free_in == ANSWER_S
    assert desk.answer("ana", gives=True) is None
    assert desk.controller() == "Ben"
    assert (desk.seen_by("ben").asked_by, desk.taken_by("ana")) == (None, None)
    assert desk.operator_present(100.0)


@pytest.mark.fault("somebody who does not have control answers the question for it", "refused, control stays")
@pytest.mark.parametrize("client", ["ben", "cleo"])
@pytest.mark.parametrize("gives", [True, False])
def test_only_the_one_in_control_answers(desk: ControlDesk, client: str, gives: bool) -> None:
    desk.ask("ben")
    assert desk.answer(client, gives=gives) == "You do not have control."
    assert (desk.controller(), desk.seen_by("ana").asked_by) == ("Ana", "Ben")


def test_without_a_question_nothing_is_given(desk: ControlDesk) -> None:
    assert desk.answer("ana", gives=True) == "Nobody asks for control any more."
    assert desk.controller() == "Ana"


@pytest.mark.fault(
    "the one in control does not answer the question for control",
    "after 20 s the asker may take it, not before, and nobody else; a command of the one in control begins "
    "the time again",
)
def test_control_is_not_taken_before_the_time_for_an_answer_is_over(desk: ControlDesk, clock: ManualClock) -> None:
    desk.ask("ben")
    pass_time(desk, clock, ANSWER_S - 1)
    assert (desk.request("ben") or "").startswith("Someone else has control.")
    assert desk.seen_by("ana").free_in == 1.0
    pass_time(desk, clock, 1)
    assert (desk.request("cleo") or "").startswith("Someone else has control."), "it was not cleo who asked"
    assert desk.controller() == "Ana", "nothing is handed over by itself"
    assert desk.request("ben") is None
    assert (desk.controller(), desk.taken_by("ana")) == ("Ben", "Ben")


def test_a_pilot_who_flies_is_not_absent(desk: ControlDesk, clock: ManualClock) -> None:
    desk.ask("ben")
    pass_time(desk, clock, ANSWER_S - 5)
    desk.acted("ana")
    desk.acted("cleo")
    pass_time(desk, clock, ANSWER_S - 5)
    assert desk.request("ben") is not None
    pass_time(desk, clock, 5)
    assert desk.request("ben") is None


def test_a_pilot_whose_link_is_back_has_the_time_for_an_answer_again(desk: ControlDesk, clock: ManualClock) -> None:
    desk.ask("ben")
    clock.advance(25)
    desk.sign_of_life("ana")
    assert desk.request("ben") is not None
    assert desk.seen_by("ben").free_in == ANSWER_S


def test_a_lost_operator_is_not_asked(desk: ControlDesk, clock: ManualClock) -> None:
    clock.advance(10.1)
    assert desk.ask("ben") is None
    assert desk.controller() == "Ben"


@pytest.mark.fault("the one who asked for control leaves", "the question ends, nothing is given to an absent session")
def test_a_question_is_withdrawn_by_its_asker_and_when_the_asker_leaves(desk: ControlDesk, clock: ManualClock) -> None:
    desk.ask("ben")
    assert desk.withdraw("cleo") == "You have not asked for control."
    assert desk.withdraw("ben") is None
    assert desk.seen_by("ana").asked_by is None
    pass_time(desk, clock, PAUSE_S)
    assert desk.ask("ben") is None
    desk.disconnect("ben")
    assert desk.seen_by("ana").asked_by is None
    assert desk.answer("ana", gives=True) == "Nobody asks for control any more."
    desk.connect("ben again", None)
    pass_time(desk, clock, ANSWER_S)
    assert desk.request("ben again") is not None, "the time did not run for one who had left"


def test_a_question_that_nobody_follows_lapses(desk: ControlDesk, clock: ManualClock) -> None:
    desk.ask("ben")
    pass_time(desk, clock, ANSWER_S + OPEN_S + 1)
    assert desk.seen_by("ana").asked_by is None
    assert desk.request("ben") is not None


def test_a_refused_client_is_notified_and_asks_again_after_a_while(desk: ControlDesk, clock: ManualClock) -> None:
    desk.ask("ben")
    assert desk.answer("ana", gives=False) is None
    assert [desk.seen_by(client).kept for client in ("ana", "ben", "cleo")] == [False, True, False]
    assert "ask again in 60 s" in (desk.ask("ben") or "")
    assert "ask again in 10 s" in (desk.ask("cleo") or ""), "a new session does not pass the limit"
    pass_time(desk, clock, PAUSE_S)
    assert desk.ask("cleo") is None
    assert desk.ask("ben") == "Cleo has asked already."
    desk.withdraw("cleo")
    pass_time(desk, clock, AGAIN_S - PAUSE_S)
    assert desk.ask("ben") is None
    assert not desk.seen_by("ben").kept


def test_control_given_back_is_shown_until_somebody_takes_it(desk: ControlDesk) -> None:
    desk.ask("ben")
    assert desk.release("ana") is None
    assert (desk.given_back_by(), desk.seen_by("ben").asked_by) == ("Ana", None)
    assert desk.ask("ben") is None
    assert (desk.controller(), desk.given_back_by()) == ("Ben", "")


def test_a_lost_operator_has_given_nothing_back(desk: ControlDesk, clock: ManualClock) -> None:
    clock.advance(30.1)
    assert (desk.controller(), desk.given_back_by()) == (None, "")


# -- over the wire ----------------------------------------------------------------------------------------------------


async def test_a_question_goes_from_page_to_page(rig: Rig, connect: Connect) -> None:
    ana, ben = await connect(), await connect()
    assert (await ana.ask(Type="Name", Name="Ana"))["Accepted"]
    refused = await ben.ask(Type="Name", Name="\u202eAna")
    assert (refused["Accepted"], refused["Reason"][:5]) == (False, "Name:")
    await ben.ask(Type="Name", Name="Ben")
    await ana.take_control()
    assert (await ben.ask(Type="Control", Action="Ask"))["Accepted"]
    rig.publish_status()
    asked, asking = await ana.next("Heartbeat"), await ben.next("Heartbeat")
    assert (asked["In Control"], asked["Control Asked By"], asked["Own Name"]) == (True, "Ben", "Ana")
    assert (asking["In Control"], asking["Control Free In"], asking["Own Name"]) == (False, ANSWER_S, "Ben")
    assert (await ben.ask(Type="Control", Action="Give"))["Reason"] == "You do not have control."
    assert (await ana.ask(Type="Control", Action="Give"))["Accepted"]
    rig.publish_status()
    given = await ben.next("Heartbeat")
    assert (given["In Control"], given["Control Asked By"]) == (True, None)


@pytest.mark.parametrize(("command", "free_in"), [("Hold", ANSWER_S), ("Heartbeat", ANSWER_S - 5.0)])
async def test_commands_of_the_pilot_are_signs_of_a_person_and_heartbeats_are_not(
    rig: Rig, connect: Connect, command: str, free_in: float
) -> None:
    ana, ben = await connect(), await connect()
    await ana.take_control()
    await ben.ask(Type="Control", Action="Ask")
    rig.clock.advance(5.0)
    await ana.ask(Type=command) if command == "Hold" else await ana.send(Type=command)
    await ana.ask(Type="Map Resync")
    assert rig.side.desk.seen_by("client-1").free_in == pytest.approx(free_in)
