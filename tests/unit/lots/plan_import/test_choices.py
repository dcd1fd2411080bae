"""Choices about an import, as a query or a command line has them."""

from __future__ import annotations

import pytest

from hawk.lots.plan_import.choices import asked_of
from hawk.lots.plan_import.placement import Pin
from hawk.lots.values import LotInputError


def test_choices_are_read() -> None:
    asked = asked_of({"name": "C:\\plans\\my  plan.dxf", "units": "mm", "replace": "1"}, ["1,2,52,5"])
    assert asked.name == "my plan.dxf"
    assert (asked.file.units, asked.choices.replace, asked.choices.rename) == ("mm", True, False)
    assert asked.pins == (Pin(1.0, 2.0, 52.0, 5.0),)
    assert asked_of({}, []).name == "a file"


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"colour": "red"}, "colour: is no field of this request: it takes name, layer"),
        ({"replace": "perhaps"}, "replace: must be 1 or 0"),
        ({"layer": "x" * 201}, "layer: is longer than 200 characters"),
        ({"name": "a\x00"}, "name: is longer than 200 characters, or holds some that cannot be shown"),
    ],
)
def test_choices_that_cannot_be_used_are_refused(given: dict[str, str], words: str) -> None:
    with pytest.raises(LotInputError, match=words):
        asked_of(given, [])
