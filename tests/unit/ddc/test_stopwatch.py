"""A condition that is timed; and a doubt by values: when it begins, what it says while it lasts, and when it ends."""

from __future__ import annotations

from hawk.ddc.stopwatch import Doubt, Stopwatch


def test_it_begins_when_the_disagreement_has_lasted_and_says_so_once_it_has() -> None:
    doubt = Doubt(confirm_s=2.0, agrees_s=10.0)
    assert not doubt.begins(0.0, is_beyond=True)
    assert not doubt.begins(1.9, is_beyond=True)
    assert not doubt.begins(1.95, is_beyond=False), "an agreement begins it again"
    assert not doubt.begins(2.5, is_beyond=True)
    assert not doubt.begins(4.4, is_beyond=True)
    assert (doubt.holds, doubt.seconds(4.4)) == (False, None)
    assert doubt.begins(4.5, is_beyond=True)
    assert (doubt.holds, doubt.seconds(6.5)) == (True, 2.0)


def test_it_ends_when_the_agreement_has_lasted() -> None:
    doubt = Doubt(confirm_s=0.0, agrees_s=10.0)
    doubt.begins(0.0, is_beyond=True)
    assert doubt.begins(0.5, is_beyond=True)
    assert not doubt.ends(1.0, agrees=True)
    assert not doubt.ends(5.0, agrees=False)
    assert not doubt.ends(6.0, agrees=True)
    assert not doubt.ends(15.9, agrees=True)
    assert doubt.holds
    assert doubt.ends(16.0, agrees=True)
    assert not doubt.holds


def test_a_stopwatch_times_a_condition_and_begins_again() -> None:
    watch = Stopwatch()
    assert watch.update(False, 1.0) is None
    assert watch.update(True, 2.0) == 0.0
    assert watch.update(True, 5.0) == 3.0
    assert watch.read(6.0) == 4.0
    assert watch.update(False, 7.0) is None
    assert watch.update(True, 9.0) == 0.0
