"""Sentences keep their code and their values from where they are made to the message that carries them."""

from __future__ import annotations

import copy
import json

import pytest

from hawk.comm.protocol.base import listed
from hawk.comm.protocol.commands import Ack
from hawk.comm.protocol.heartbeat import (
    CheckItem,
    CommandOption,
    DroneStatus,
    HealthItem,
    LogEntry,
    OperationStatus,
    PartsStatus,
)
from hawk.model.sentences import Sentence, code_of, joined, parts_of, say, sentence, series, words_of


def test_a_sentence_is_its_english_text_with_code_and_values() -> None:
    said = say("Home was moved {away:.1f} m by {who}.", away=3.26, who="Ana")
    assert said == "Home was moved 3.3 m by Ana."
    assert (said.code, said.values) == ("home-was-moved-away-m-by-who", {"away": 3.3, "who": "Ana"})


@pytest.mark.parametrize(
    ("template", "value", "text", "sent"),
    [
        ("{n:.0f} m", 2.4, "2 m", 2),
        ("{n:z.0f} m", -0.2, "0 m", 0),
        ("{n:g} m", 12.50, "12.5 m", 12.5),
        ("{n:d}", 7, "7", 7),
        ("{n}", 7, "7", 7),
        ("{n:.1f}", float("nan"), "nan", "nan"),
        ("{n:.1f}", float("inf"), "inf", "inf"),
    ],
)
def test_a_number_is_sent_as_the_text_shows_it(template: str, value: float, text: str, sent: float | str) -> None:
    said = say(template, n=value)
    assert (said, said.values["n"]) == (text, sent)
    json.dumps(dict(said.values), allow_nan=False)


def test_a_full_stop_behind_one_is_left_out() -> None:
    assert say("{name}: {value}. {remedy}", name="GPS", value="Wait!", remedy="") == "GPS: Wait!"
    assert sentence("no fix") == "no fix."
    assert sentence("no fix.") == "no fix."
    assert sentence("  ") == ""
    assert say("The autopilot: {words}", words="PreArm: wait...") == "The autopilot: PreArm: wait..."
    assert say("{text}. More... {text}.", text="No 1..2") == "No 1..2. More... No 1..2."
    stopped = say("Lost.")
    assert sentence(stopped) is stopped


def test_a_value_too_many_or_too_few_and_an_unknown_format_are_errors() -> None:
    with pytest.raises(ValueError, match="takes"):
        say("{one}", one=1, two=2)
    with pytest.raises(ValueError, match="takes"):
        say("{one} {two}", one=1)
    with pytest.raises(ValueError, match=r"use \.Nf, g or d"):
        say("{one:>8}", one=1)


def test_series_leaves_empty_ones_out_and_keeps_each() -> None:
    one, two = say("one"), say("{count:d} others", count=2)
    assert series() == ""
    assert series("", one, "") is one
    all_three = series(one, "", two, "words of others")
    assert all_three == "one, 2 others, words of others"
    assert [part.code for part in parts_of(all_three)] == ["one-other", "one-other", "one", "count-others"]


def test_joined_leaves_empty_ones_out_and_keeps_each() -> None:
    one, two = say("One."), say("Two.")
    assert joined() == ""
    assert joined("", one) is one
    both = joined(one, "", two, "Words of others.")
    assert both == "One. Two. Words of others."
    assert [part.code for part in parts_of(both)] == ["first-second", "first-second", "one", "two"]


def test_the_code_of_a_long_sentence_ends_with_a_whole_word() -> None:
    long = "Nothing of the outline lies inside the fence: set another outline, or clear it {by_hand:.1f} m away."
    assert code_of(long) == "nothing-of-the-outline-lies-inside-the-fence-set-another"
    assert code_of("At {place_2:g} m, 3 m") == "at-place-2-m-3-m"


def test_an_error_keeps_the_sentence_that_it_was_raised_with() -> None:
    said = say("Too far.")
    assert words_of(ValueError(said)) is said
    assert words_of(OSError(2, "No such file")) == "[Errno 2] No such file"


def test_a_copy_keeps_the_code() -> None:
    said = copy.deepcopy(say("One {n}.", n=1))
    assert isinstance(said, Sentence)
    assert (said.code, said.values) == ("one-n", {"n": 1})


def test_an_answer_lists_the_sentences_of_its_reason_once() -> None:
    reason = say("Not now: {why}", why=say("it rains."))
    answer = json.loads(Ack(id=1, accepted=False, reason=reason).to_json())
    assert answer["Reason"] == "Not now: it rains."
    assert answer["Sentences"] == [
        {"Text": "Not now: it rains.", "Code": "not-now-why", "Values": {"why": "it rains."}},
        {"Text": "it rains.", "Code": "it-rains", "Values": {}},
    ]
    assert "Sentences" not in Ack(id=1, accepted=False, reason="Plain.").to_json()


def test_a_heartbeat_lists_those_of_checks_options_and_parts() -> None:
    no, bad = say("No."), say("Bad.")
    check = CheckItem(name=say("GPS"), passed=False, value=bad, remedy=no)
    status = DroneStatus(
        operation=OperationStatus(
            detail=say("It waits."),
            options=(CommandOption(command="Arm", possible=False, reason=no),),
            checks=(check,),
        ),
        parts=PartsStatus(health=(HealthItem(name="camera", healthy=False, reason=say("Dark.")),)),
    )
    listed_codes = [item["Code"] for item in json.loads(status.shared_json)["Sentences"]]
    assert sorted(listed_codes) == ["bad", "dark", "gps", "it-waits", "no"]


def test_a_line_of_the_log_lists_its_own() -> None:
    entry = listed(LogEntry(number=1, time="", level="info", text=say("Up."), details="words"))
    assert [item.code for item in entry.sentences] == ["up"]
