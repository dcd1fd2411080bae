from __future__ import annotations

import json

import pytest

from hawk.comm.protocol.authority import LONGEST_PERSON, cleaned, distinct
from hawk.comm.protocol.commands import BadMessageError, OperatorName, parse_command


def sent(name: object) -> str | None:
    command = parse_command(json.dumps({"Type": "Name", "Name": name}))
    assert isinstance(command, OperatorName)
    return command.name


@pytest.mark.parametrize(
    ("given", "shown"),
    [
        ("Anna", "Anna"),
        ("  Anna   Maria ", "Anna Maria"),
        ("Zoe\u0308", "Zoë"),
        ("李小龙", "李小龙"),
        ("B2", "B2"),
        ("x" * LONGEST_PERSON, "x" * LONGEST_PERSON),
        (None, None),
    ],
)
def test_a_name_is_shown_with_single_spaces_and_composed(given: str | None, shown: str | None) -> None:
    assert sent(given) == shown


@pytest.mark.fault("a name with control characters, too long, or a word of the log", "refused with its field")
@pytest.mark.parametrize(
    "name",
    [
        "",
        "   ",
        "...",
        "x" * (LONGEST_PERSON + 1),
        "x" * 5000,
        "An\nna",
        "An\tna",
        "An\x00na",
        "An\u202ena",
        "An\u200bna",
        "An\u2028na",
        "a\u0301\u0301\u0301",
        "Operator 7",
        "OPERATOR  7",
        "you",
        "the operator",
        7,
        ["Anna"],
    ],
)
def test_a_name_that_cannot_be_shown_or_would_mislead_is_refused_by_its_field(name: object) -> None:
    with pytest.raises(BadMessageError, match=r"^Name: "):
        sent(name)


def test_names_that_look_alike_get_a_number() -> None:
    assert distinct("Anna", []) == "Anna"
    assert distinct("Anna", ["Ben"]) == "Anna"
    assert distinct("ANNA", ["Anna"]) == "ANNA 2"
    assert distinct("A nna", ["Anna", "anna 2"]) == "A nna 3"
    assert distinct(cleaned("Ａnna"), ["Anna"]) == "Ａnna 2", "another width"
