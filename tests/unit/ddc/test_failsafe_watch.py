"""Failsafes that change in flight: each is reported once, and again when it is right."""

from __future__ import annotations

from hawk.ddc.acts import Acts, Log
from hawk.ddc.failsafe_watch import FailsafeWatch
from hawk.ddc.parameter_values import NOT_READ, FailsafeCheck
from tests.unit.ddc.written_facts import flying, on_ground

RIGHT = FailsafeCheck("Fence", True, "on")
WRONG = FailsafeCheck("Fence", False, "off", "It does nothing", "Set failsafes.", can_be_set=True)
UNREAD = FailsafeCheck("Fence", False, NOT_READ)
SWITCHED = FailsafeCheck("Fence", False, "off", "It does nothing", "Switch it on.")


def texts(acts: Acts) -> list[tuple[str, str]]:
    return [(act.level, act.text) for act in acts if isinstance(act, Log)]


def test_a_failsafe_that_becomes_wrong_is_reported_once_and_when_it_is_right_again() -> None:
    watch = FailsafeWatch()
    assert watch.tick(flying(1.0), (RIGHT,)) == ()
    warned = watch.tick(flying(1.1), (WRONG,))
    assert texts(warned) == [("warning", "Fence: off. No new task until it is right.")]
    assert watch.tick(flying(1.2), (WRONG,)) == ()
    assert texts(watch.tick(flying(1.3), (RIGHT,))) == [("ok", "Fence is right again: on.")]
    assert watch.tick(flying(1.4), (RIGHT,)) == ()


def test_one_that_is_wrong_from_the_beginning_is_reported_and_one_that_is_not_read_is_not() -> None:
    watch = FailsafeWatch()
    assert watch.tick(flying(1.0), (UNREAD,)) == ()
    assert texts(watch.tick(flying(1.1), (WRONG,)))[0][0] == "warning"
    assert watch.tick(flying(1.2), (UNREAD,)) == (), "not read is neither right nor wrong"
    assert watch.tick(flying(1.3), (WRONG,)) == ()


def test_one_that_is_not_read_hides_no_other() -> None:
    other = FailsafeCheck("Battery failsafe", False, "off", "The drone falls", "Set failsafes.")
    found = FailsafeWatch().tick(flying(1.0), (UNREAD, other, RIGHT))
    assert texts(found) == [("warning", "Battery failsafe: off. No new task until it is right.")]


def test_the_remedy_is_set_failsafes_only_where_that_helps() -> None:
    (settable,) = FailsafeWatch().tick(flying(1.0), (WRONG,))
    (switched,) = FailsafeWatch().tick(flying(1.0), (SWITCHED,))
    assert isinstance(settable, Log)
    assert isinstance(switched, Log)
    assert settable.details.endswith("Return or land, then Set failsafes.")
    assert switched.details.endswith("Switch it on.")


def test_each_flight_begins_without_memory() -> None:
    watch = FailsafeWatch()
    watch.tick(flying(1.0), (WRONG,))
    assert watch.tick(on_ground(flying(1.1)), (WRONG,)) == ()
    assert texts(watch.tick(flying(1.2), (WRONG,)))[0][0] == "warning"
