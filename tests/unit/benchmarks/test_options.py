from __future__ import annotations

import pytest

from benchmarks.options import parse_seeds


@pytest.mark.parametrize(("text", "seeds"), [("1-5", [1, 2, 3, 4, 5]), ("2", [2]), ("1,4-6", [1, 4, 5, 6])])
def test_seeds_are_a_list_or_a_range(text: str, seeds: list[int]) -> None:
    assert parse_seeds(text) == seeds


@pytest.mark.parametrize("text", ["", "a", "5-1", "1,,2", "-1"])
def test_what_names_no_seeds_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="names no seeds"):
        parse_seeds(text)
