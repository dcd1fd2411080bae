from __future__ import annotations

import secrets

import pytest

from hawk.config.sections import OperatorSettings
from hawk.web.sessions import ControlDesk
from tests.manual_clock import ManualClock


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(100.0)


@pytest.fixture
def desk(clock: ManualClock) -> ControlDesk:
    made = ControlDesk(clock, OperatorSettings(operator_timeout_s=10, operator_hold_s=30, control_lease_s=30))
    made.connect("a", None)
    made.connect("b", None)
    return made


def test_nobody_has_control_at_first(desk: ControlDesk) -> None:
    assert desk.controller() is None
    assert not desk.has_control("a")
    assert not desk.operator_present(100.0)


def test_control_is_granted_to_one_at_a_time(desk: ControlDesk) -> None:
    assert desk.request("a") is None
    assert desk.request("a") is None, "asking again keeps it"
    refusal = desk.request("b")
    assert refusal is not None
    assert refusal.startswith("Someone else has control.")
    assert desk.controller() == "Operator 1"
    assert (desk.has_control("a"), desk.has_control("b")) == (True, False)


def test_control_is_given_back_by_its_holder_only(desk: ControlDesk) -> None:
    desk.request("a")
    assert desk.release("b") == "You do not have control."
    assert desk.has_control("a")
    assert desk.release("a") is None
    assert desk.request("b") is None


def test_the_lease_runs_out_in_silence(desk: ControlDesk, clock: ManualClock) -> None:
    desk.request("a")
    clock.advance(20)
    desk.sign_of_life("a")
    clock.advance(30)
    assert desk.controller() == "Operator 1", "at the limit it is still held"
    clock.advance(0.1)
    assert desk.controller() is None
    assert desk.request("b") is None
    desk.sign_of_life("a")
    assert not desk.has_control("a"), "a late sign of life takes nothing back"


def test_the_operator_is_present_by_its_own_signs_only(desk: ControlDesk, clock: ManualClock) -> None:
    desk.request("a")
    clock.advance(10)
    assert desk.operator_present(clock())
    desk.sign_of_life("b")
    clock.advance(0.1)
    assert not desk.operator_present(clock())
    assert desk.has_control("a"), "lost, but the lease lasts"
    assert (desk.is_lost("a"), desk.is_lost("b")) == (True, False)
    desk.sign_of_life("a")
    assert desk.operator_present(clock())
    assert not desk.is_lost("a")


def test_the_lease_of_a_lost_operator_is_free_for_the_asking(desk: ControlDesk, clock: ManualClock) -> None:
    desk.request("a")
    clock.advance(10)
    refusal = desk.request("b")
    assert refusal is not None, "at the limit the operator is still there"
    assert "after 10 s of silence" in refusal
    clock.advance(0.1)
    assert desk.controller_is_lost()
    assert desk.request("b") is None
    assert (desk.controller(), desk.controller_is_lost()) == ("Operator 2", False)
    assert (desk.has_control("a"), desk.has_control("b")) == (False, True)


def test_a_lost_operator_who_comes_back_in_time_goes_on(desk: ControlDesk, clock: ManualClock) -> None:
    desk.request("a")
    clock.advance(29)
    desk.sign_of_life("a")
    assert desk.has_control("a")
    assert desk.operator_present(clock())
    assert desk.taken_by("a") is None
    assert desk.request("b") is not None


@pytest.mark.parametrize("silence", [11.0, 40.0])
def test_a_lost_operator_learns_who_took_control(desk: ControlDesk, clock: ManualClock, silence: float) -> None:
    desk.request("a")
    clock.advance(silence)
    desk.request("b")
    assert (desk.taken_by("a"), desk.taken_by("b")) == ("Operator 2", None)
    desk.sign_of_life("a")
    assert not desk.has_control("a"), "a late sign of life takes nothing back"
    desk.release("b")
    assert desk.taken_by("a") is None, "control is free again"
    desk.request("a")
    desk.release("a")
    desk.request("b")
    assert desk.taken_by("a") is None, "this time it was given back"


def test_control_that_was_given_back_is_reported_to_nobody(desk: ControlDesk, clock: ManualClock) -> None:
    desk.request("a")
    desk.release("a")
    clock.advance(40)
    desk.request("b")
    assert desk.taken_by("a") is None


def test_a_short_lease_is_named_as_the_wait(clock: ManualClock) -> None:
    desk = ControlDesk(clock, OperatorSettings(operator_timeout_s=10, operator_hold_s=30, control_lease_s=4))
    desk.connect("a", None)
    desk.connect("b", None)
    desk.request("a")
    assert "after 4 s of silence" in (desk.request("b") or "")
    clock.advance(4.1)
    assert desk.request("b") is None


def test_a_session_comes_back_with_its_control(desk: ControlDesk) -> None:
    secret = secrets.token_urlsafe(32)
    desk.connect("c", secret)
    desk.request("c")
    desk.disconnect("c")
    assert desk.controller() is not None, "the lease outlives the connection"
    assert not desk.has_control("c")
    desk.connect("d", secret)
    assert desk.has_control("d")


def test_the_shown_name_is_no_key(desk: ControlDesk) -> None:
    desk.request("a")
    name = desk.controller()
    session = desk.connect("thief", name)
    assert session.name != name
    assert not desk.has_control("thief")


@pytest.mark.parametrize("cookie", [None, "", "short", "x" * 44, "ä" * 43, "a b" * 14 + "c"])
def test_a_cookie_not_of_our_making_gets_a_new_session(desk: ControlDesk, cookie: str | None) -> None:
    assert desk.connect("c", cookie).secret != cookie


def test_sessions_are_bounded_and_the_one_in_control_is_kept(desk: ControlDesk) -> None:
    secret = secrets.token_urlsafe(32)
    desk.connect("holder", secret)
    desk.request("holder")
    desk.disconnect("holder")
    for number in range(1100):
        desk.connect(f"n{number}", None)
        desk.disconnect(f"n{number}")
    assert desk.connect("again", secret).name == desk.controller()


# -- hidden pages -----------------------------------------------------------------------------------------------------


def test_a_hidden_page_shows_life_and_says_since_when_it_is_hidden(desk: ControlDesk, clock: ManualClock) -> None:
    desk.connect("phone", None)
    desk.request("phone")
    desk.sign_of_life("phone", is_hidden=False)
    assert desk.hidden_since() is None
    clock.advance(5.0)
    desk.sign_of_life("phone", is_hidden=True)
    hidden_at = clock()
    for _ in range(40):
        clock.advance(1.0)
        desk.sign_of_life("phone", is_hidden=True)
    assert desk.hidden_since() == hidden_at
    assert desk.operator_present(clock())
    desk.sign_of_life("phone", is_hidden=False)
    assert desk.hidden_since() is None


def test_a_shown_page_of_the_same_session_is_enough_while_it_shows_life(desk: ControlDesk, clock: ManualClock) -> None:
    session = desk.connect("phone", None)
    desk.connect("tablet", session.secret)
    desk.request("phone")
    for _ in range(40):
        clock.advance(1.0)
        desk.sign_of_life("phone", is_hidden=True)
        desk.sign_of_life("tablet", is_hidden=False)
    assert desk.hidden_since() is None
    for _ in range(12):  # the tablet froze
        clock.advance(1.0)
        desk.sign_of_life("phone", is_hidden=True)
    assert desk.hidden_since() == clock() - 1.0
    desk.disconnect("tablet")
    desk.sign_of_life("phone", is_hidden=True)
    assert desk.hidden_since() == clock() - 1.0


def test_a_program_that_says_nothing_of_a_page_counts_as_shown(desk: ControlDesk, clock: ManualClock) -> None:
    desk.connect("program", None)
    desk.request("program")
    for _ in range(40):
        clock.advance(1.0)
        desk.sign_of_life("program")
    assert desk.hidden_since() is None


def test_a_page_that_cannot_say_anything_is_lost_whatever_it_said_last(desk: ControlDesk, clock: ManualClock) -> None:
    desk.connect("phone", None)
    desk.request("phone")
    for hidden in (False, True):
        desk.sign_of_life("phone", is_hidden=hidden)
        assert desk.operator_present(clock())
        clock.advance(10.1)  # the browser froze the tab
        assert not desk.operator_present(clock())
