from __future__ import annotations

from datetime import date, datetime

import pytest
from fluent.syntax import FluentParser, ast
from fluent.syntax.visitor import Visitor

from hawk.report.options import LANGUAGES, Language
from hawk.report.words import Words, resource
from hawk.stats.use_query import asked_of
from hawk.stats.values import NOTHING, Estimate


class Arguments(Visitor):
    """Names of the values that a message takes."""

    def __init__(self) -> None:
        self.names: set[str] = set()

    def visit_VariableReference(self, node: ast.VariableReference) -> None:  # noqa: N802 - the visitor's name
        self.names.add(node.id.name)


def messages(language: Language) -> dict[str, set[str]]:
    found = {}
    for entry in FluentParser().parse(resource(language)).body:
        assert not isinstance(entry, ast.Junk), entry.content
        if isinstance(entry, ast.Message):
            arguments = Arguments()
            arguments.visit(entry)
            found[entry.id.name] = arguments.names
    return found


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_has_the_same_messages_with_the_same_values(language: Language) -> None:
    assert messages(language) == messages("en")


def test_figures_stand_with_their_range_and_nothing_for_what_nobody_flew() -> None:
    english, french = Words("en"), Words("fr")
    share = Estimate(0.491, 0.46, 0.523, 3)
    assert (english.share(share), english.shares(share)) == ("49\N{NO-BREAK SPACE}%", "46 to 52\N{NO-BREAK SPACE}%")
    assert english.shares(Estimate(0.55, 0.548, 0.5512, 3)) == "54.8 to 55.1\N{NO-BREAK SPACE}%"
    assert french.shares(Estimate(0.55, 0.548, 0.5512, 3)) == "54,8 à 55,1\N{NO-BREAK SPACE}%"
    assert french.shares(share) == "46 à 52\N{NO-BREAK SPACE}%"
    assert english.amounts(Estimate(1234.4, 1200.0, 1300.0, 3)) == "1,200 to 1,300"
    assert {english.share(NOTHING), english.shares(NOTHING), french.amount(NOTHING), french.amounts(NOTHING)} == {"–"}


@pytest.mark.parametrize(
    ("first", "last", "english", "french"),
    [
        (date(2026, 5, 4), date(2026, 5, 4), "4 May 2026", "4 mai 2026"),
        (date(2026, 5, 4), date(2026, 5, 11), "4 to 11 May 2026", "4 au 11 mai 2026"),
        (date(2026, 4, 30), date(2026, 5, 1), "30 Apr to 1 May 2026", "30 avr. au 1 mai 2026"),
        (date(2025, 12, 30), date(2026, 1, 2), "30 Dec 2025 to 2 Jan 2026", "30 déc. 2025 au 2 janv. 2026"),
    ],
)
def test_the_ends_of_a_period_share_what_is_the_same(first: date, last: date, english: str, french: str) -> None:
    assert (Words("en").period(first, last), Words("fr").period(first, last)) == (english, french)


def test_a_question_is_a_sentence_in_each_language() -> None:
    asked = asked_of("mon-fri,sun", "7-11,16-18", ["B", "C"])
    assert Words("en").question(asked) == (
        "how many stalls of rows B and C are taken, Monday to Friday and Sunday, from 7:00 to 11:00 and from 16:00 to "
        "18:00."
    )
    assert (
        Words("fr").question(asked_of()) == "combien de places du parking sont occupées, tous les jours, à toute heure."
    )


def test_times_are_those_of_the_clock_that_they_are_on() -> None:
    at = datetime.fromisoformat("2026-05-04T08:59+02:00")
    assert Words("en").moment(at, with_year=True) == "Mon 4 May 2026, 08:59"
    assert Words("fr").moment(at) == "lun. 4 mai, 08:59"
    assert Words("en").clock_time(24) == "24:00"


def test_a_message_that_lacks_a_value_is_an_error() -> None:
    with pytest.raises(LookupError, match="period"):
        Words("en")("period", first="4")
