from __future__ import annotations

from pathlib import Path

import pytest

from tests.sweep import sweep


def test_every_case_is_tried_and_each_that_fails_is_named() -> None:
    tried = []

    @sweep("low, high", [(1, 2), (4, 3), (5, 6), (9, 8)])
    def ordered(low: int, high: int) -> None:
        tried.append(low)
        assert low < high

    with pytest.raises(BaseExceptionGroup, match="2 of 4 cases failed") as caught:
        ordered()
    assert tried == [1, 4, 5, 9]
    assert "low=4, high=3\nlow=9, high=8" in str(caught.value)
    assert [error.__notes__ for error in caught.value.exceptions] == [["low=4, high=3"], ["low=9, high=8"]]


def test_what_pytest_itself_fails_is_a_failure_of_its_case() -> None:
    @sweep("number", [0, 1])
    def raised(number: int) -> None:
        with pytest.raises(ZeroDivisionError):
            assert 1 / number

    with pytest.raises(BaseExceptionGroup, match="1 of 2 cases failed:\nnumber=1"):
        raised()


seen: list[tuple[int, Path]] = []


@sweep("number", range(3))
async def test_cases_of_a_coroutine_share_its_fixtures(number: int, tmp_path: Path) -> None:
    seen.append((number, tmp_path))
    assert len({folder for _, folder in seen}) == 1


@sweep("letter", "ab")
@sweep("number", (1, 2))
def test_sweeps_of_a_test_are_multiplied(letter: str, number: int) -> None:
    assert f"{letter}{number}" in ("a1", "a2", "b1", "b2")


def test_a_sweep_without_cases_is_a_mistake() -> None:
    with pytest.raises(AssertionError, match="needs cases"):
        sweep("number", [])
