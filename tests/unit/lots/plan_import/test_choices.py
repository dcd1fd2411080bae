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


def test_numbers_at_their_limits_are_read_and_beyond_them_refused() -> None:
    assert asked_of({}, ["0,0,90,-180"]).pins == (Pin(0.0, 0.0, 90.0, -180.0),)
    assert asked_of({"name": "/a/" + "x" * 197}, []).name == "x" * 197
    for switch, is_on in (("", False), ("0", False), ("false", False), ("1", True), ("true", True)):
        assert asked_of({"rename": switch}, []).choices.rename is is_on
    for pin in ("0,0,90.5,5", "0,0,-90.5,5", "0,0,52,180.5", "0,0,52,-180.5", "inf,0,52,5", "0,nan,52,5", "0,0,52,inf"):
        with pytest.raises(
            LotInputError, match="pin: must be finite numbers: latitude -90 to 90, longitude -180 to 180"
        ):
            asked_of({}, [pin])
    for pin in ("0,0,52", "0,0,52,5,6", "a,0,52,5", ""):
        with pytest.raises(LotInputError, match="pin: must be x,y,latitude,longitude"):
            asked_of({}, [pin])
