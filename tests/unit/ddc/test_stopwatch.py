"""A doubt by values: when it begins, what it says while it lasts, and when it ends."""

from __future__ import annotations

from hawk.ddc.stopwatch import Doubt


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
