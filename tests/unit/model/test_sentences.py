"""Sentences keep their code and their values from where they are made to the message that carries them."""

from __future__ import annotations

import copy
import json

import pytest

from hawk.comm.message_base import listed
from hawk.comm.messages import Ack
from hawk.comm.status import CheckItem, CommandOption, DroneStatus, HealthItem, LogEntry, OperationStatus, PartsStatus
from hawk.model.sentences import Sentence, joined, parts_of, say, sentence


def test_a_sentence_is_its_english_text_with_code_and_values() -> None:
    said = say("home-moved", "Home was moved {away:.1f} m by {who}.", away=3.26, who="Ana")
    assert said == "Home was moved 3.3 m by Ana."
    assert (said.code, said.values) == ("home-moved", {"away": 3.3, "who": "Ana"})


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
    said = say("number", template, n=value)
    assert (said, said.values["n"]) == (text, sent)
    json.dumps(dict(said.values), allow_nan=False)


def test_a_full_stop_behind_one_is_left_out() -> None:
    assert say("check", "{name}: {value}. {remedy}", name="GPS", value="Wait!", remedy="") == "GPS: Wait!"
    assert sentence("no fix") == "no fix."
    assert sentence("no fix.") == "no fix."
    assert sentence("  ") == ""
    stopped = say("lost", "Lost.")
    assert sentence(stopped) is stopped


def test_a_value_too_many_or_too_few_and_an_unknown_format_are_errors() -> None:
    with pytest.raises(ValueError, match="uses"):
        say("a", "{one}", one=1, two=2)
    with pytest.raises(ValueError, match="uses"):
        say("a", "{one} {two}", one=1)
    with pytest.raises(ValueError, match=r"use \.Nf, g or d"):
        say("a", "{one:>8}", one=1)


def test_joined_leaves_empty_ones_out_and_keeps_each() -> None:
    one, two = say("one", "One."), say("two", "Two.")
    assert joined() == ""
    assert joined("", one) is one
    both = joined(one, "", two, "Words of others.")
    assert both == "One. Two. Words of others."
    assert [part.code for part in parts_of(both)] == ["two-sentences", "two-sentences", "one", "two"]


def test_a_copy_keeps_the_code() -> None:
    said = copy.deepcopy(say("one", "One {n}.", n=1))
    assert isinstance(said, Sentence)
    assert (said.code, said.values) == ("one", {"n": 1})


def test_an_answer_lists_the_sentences_of_its_reason_once() -> None:
    reason = say("outer", "Not now: {why}", why=say("inner", "it rains."))
    answer = json.loads(Ack(id=1, accepted=False, reason=reason).to_json())
    assert answer["Reason"] == "Not now: it rains."
    assert answer["Sentences"] == [
        {"Text": "Not now: it rains.", "Code": "outer", "Values": {"why": "it rains."}},
        {"Text": "it rains.", "Code": "inner", "Values": {}},
    ]
    assert "Sentences" not in Ack(id=1, accepted=False, reason="Plain.").to_json()


def test_a_heartbeat_lists_those_of_checks_options_and_parts() -> None:
    no, bad = say("no", "No."), say("bad", "Bad.")
    check = CheckItem(name=say("gps", "GPS"), passed=False, value=bad, remedy=no)
    status = DroneStatus(
        operation=OperationStatus(
            detail=say("detail", "It waits."),
            options=(CommandOption(command="Arm", possible=False, reason=no),),
            checks=(check,),
        ),
        parts=PartsStatus(health=(HealthItem(name="camera", healthy=False, reason=say("dark", "Dark.")),)),
    )
    listed_codes = [item["Code"] for item in json.loads(status.shared_json)["Sentences"]]
    assert sorted(listed_codes) == ["bad", "dark", "detail", "gps", "no"]


def test_a_line_of_the_log_lists_its_own() -> None:
    entry = listed(LogEntry(number=1, time="", level="info", text=say("up", "Up."), details="words"))
    assert [item.code for item in entry.sentences] == ["up"]
