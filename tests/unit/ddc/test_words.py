from __future__ import annotations

import pytest

from hawk.ddc.words import metres


@pytest.mark.parametrize(("value", "words"), [(-0.3, "0 m"), (0.3, "0 m"), (-0.6, "-1 m"), (34.7, "35 m")])
def test_a_length_just_below_zero_has_no_sign(value: float, words: str) -> None:
    assert metres(value) == words
