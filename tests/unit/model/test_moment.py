from __future__ import annotations

import ctypes
from dataclasses import dataclass

import pytest

from hawk.model.moment import Moment, is_wall_clock_kept


@dataclass
class Library:
    state: int

    def adjtimex(self, _: object) -> int:
        return self.state


@pytest.mark.parametrize(("state", "is_kept"), [(0, True), (1, True), (5, False), (-1, True)])
def test_the_kernel_says_whether_the_wall_clock_is_kept(
    monkeypatch: pytest.MonkeyPatch, state: int, is_kept: bool
) -> None:
    monkeypatch.setattr(ctypes, "CDLL", lambda _: Library(state))
    assert is_wall_clock_kept() is is_kept


def test_a_system_without_the_call_is_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ctypes, "CDLL", lambda _: object())
    assert is_wall_clock_kept()


def test_moments_of_two_boots_have_no_distance() -> None:
    assert Moment("a", 5.0).since(Moment("a", 2.0)) == 3.0
    assert Moment("a", 5.0).since(Moment("b", 2.0)) is None
    assert Moment("a", 5.0, 100.0).before(2.0) == Moment("a", 3.0, 98.0)
