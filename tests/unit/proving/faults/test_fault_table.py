from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hawk.comm.protocol.heartbeat import CheckItem, HealthItem, Heartbeat, LogEntry
from hawk.model.lot_map import Stall, StallState
from hawk.model.operation import StateName
from hawk.sim.faults import Fault as DroneFault
from proving.faults import __main__ as command
from proving.faults.fault import (
    ACCEPTED,
    COMMANDED,
    DOWN,
    FELL,
    INSIDE,
    SILENT,
    UP,
    Drone,
    Fault,
    Forge,
    Moment,
    Outcome,
    See,
    Station,
    When,
    absent,
    asked,
    both,
    check_fails,
    either,
    exited,
    healthy,
    lower_than,
    mode,
    refused,
    reported,
    restarted,
    sent,
    state,
    stayed_within,
    surveyed,
    unhealthy,
)
from proving.faults.keeping import Kept, lost
from proving.faults.proxy import message
from proving.faults.report import BEGIN, END, line, names, reporter, rewrite, short_table, table
from proving.faults.run import ALL, SHORT
from tests.sweep import sweep

TRUTH: dict[str, Any] = {
    "time": 5.0,
    "mode": "GUIDED",
    "landed": False,
    "disarmed": False,
    "position": {"height": 20.0},
}


def beat_of(**values: Any) -> Heartbeat:
    """A heartbeat of which only this is known."""
    return Heartbeat.model_construct(**values)


def moment(**changes: Any) -> Moment:
    return replace(Moment(None, TRUTH, (), (), 0, {}, ()), **changes)


def test_there_are_at_least_a_hundred_and_ten_faults_each_with_an_end_and_a_time() -> None:
    assert len(ALL) >= 110
    assert len(set(names(ALL))) == len(ALL)
    for fault in ALL:
        sights = [step for step in fault.steps if isinstance(step, See)]
        assert sights, fault.name
        assert all(0 < see.within_s <= 240 for see in sights), fault.name


def test_faults_happen_in_every_part_of_a_flight() -> None:
    assert {fault.when for fault in ALL} == set(When)


def test_the_short_run_takes_faults_of_the_table() -> None:
    assert len(set(SHORT)) == 5
    assert set(SHORT) <= set(names(ALL))


@sweep("fault", ALL)
def test_what_a_fault_does_can_be_done(fault: Fault) -> None:
    for step in fault.steps:
        if isinstance(step, Forge | Station):
            fields = {name: 1 if value == "now" else value for name, value in step.fields.items()}
            message(step.kind, fields)
        elif isinstance(step, Drone):
            DroneFault.model_validate(step.values)


def test_sights_of_the_truth() -> None:
    assert mode("GUIDED", "RTL").test(moment())
    assert not mode("RTL").test(moment())
    assert UP.test(moment())
    assert not DOWN.test(moment())
    assert DOWN.test(moment(truth={**TRUTH, "landed": True, "disarmed": True}))
    assert lower_than(21).test(moment())
    assert not lower_than(20).test(moment())


def test_sights_of_a_heartbeat() -> None:
    beat = beat_of(
        state=StateName.HOVER,
        detail="Holding at 20 m.",
        health=(HealthItem(name="camera", healthy=False, reason="no picture for 2 s"),),
        checks=(CheckItem(name="GPS", passed=False, value="no fix"),),
    )
    seen = moment(beat=beat)
    for sight in (
        state(StateName.HOVER),
        reported("at 20 m"),
        unhealthy("camera", "no picture"),
        check_fails("GPS"),
        absent(healthy("camera")),
        both(state(StateName.HOVER), UP),
    ):
        assert sight.test(seen), sight.words
    for sight in (state(StateName.LAND), reported("landed"), unhealthy("camera", "still"), check_fails("Link")):
        assert not sight.test(seen), sight.words
        assert not sight.test(moment()), sight.words


def test_sights_of_what_was_done_since() -> None:
    entry = LogEntry(number=1, time="", level="info", text="Hover.", details="because")
    seen = moment(
        log=(entry,), exits=(-9,), starts=1, sent={"COMMAND_LONG": 2}, answers=("Not now.",), beat=beat_of(detail="")
    )
    for sight in (reported("because"), exited(-9), restarted(), sent("COMMAND_LONG", 2), refused("now")):
        assert sight.test(seen), sight.words
        assert not sight.test(moment()), sight.words
    assert not ACCEPTED.test(seen)
    assert ACCEPTED.test(moment(answers=("Not now.", None)))


@pytest.mark.parametrize(
    "kind", ["COMMAND 176", "COMMAND 400", "COMMAND 22", "SET_POSITION_TARGET_LOCAL_NED", "SET_MODE"]
)
def test_a_message_that_steers_breaks_the_silence(kind: str) -> None:
    seen = moment(sent={kind: 1})
    assert COMMANDED.test(seen)
    assert not SILENT.test(seen)


def test_heartbeats_and_questions_are_no_commands() -> None:
    seen = moment(sent={"HEARTBEAT": 9, "PARAM_REQUEST_READ": 3, "COMMAND_LONG": 1, "COMMAND 511": 1, "COMMAND 176": 0})
    assert SILENT.test(seen)
    assert not COMMANDED.test(seen)
    assert asked(511, "a rate").test(seen)
    assert not asked(176, "a mode").test(seen)


def test_sights_of_a_place() -> None:
    there = moment(truth={**TRUTH, "outside": 2.0, "farthest_outside": 7.0, "disarmed": True})
    assert not INSIDE.test(there)
    assert stayed_within(7.0).test(there)
    assert not stayed_within(6.9).test(there)
    assert not FELL.test(there)
    assert FELL.test(moment(truth={**TRUTH, "disarmed": True, "position": {"height": 0.2}}))
    assert either(INSIDE, stayed_within(7.0)).test(there)
    assert not either(INSIDE, stayed_within(1.0)).test(there)


@pytest.mark.parametrize(
    ("measures", "seen"),
    [
        ({}, False),
        ({"status": 0.0, "stall_recall": 0.96, "stall_precision": 0.97}, True),
        ({"status": 4.0, "stall_recall": 0.96, "stall_precision": 0.97}, False),
        ({"status": 0.0, "stall_recall": 0.94, "stall_precision": 0.97}, False),
        ({"status": 0.0, "stall_recall": 0.96, "stall_precision": 0.94}, False),
    ],
)
def test_a_survey_is_seen_when_it_ended_well_and_found_enough(measures: dict[str, float], seen: bool) -> None:
    assert surveyed(recall=0.95, precision=0.95).test(moment(survey=measures)) is seen


def stall(number: int, north: float) -> Stall:
    return Stall(number, north, 0.0, 0.0, 2.5, 5.0, 0.1, StallState.FREE, 0.9, 5, 1.0, 1)


KEPT = Kept((12.0, 20.0, 30.0), tuple(stall(k, 3.0 * k) for k in range(40)), frozenset({"grid/0/0"}), "000001-a", 9.0)


def test_nothing_is_lost_when_a_stall_in_forty_moved_or_went() -> None:
    moved = (*[stall(k, 3.0 * k + 0.5) for k in range(39)], stall(60, 300.0))
    assert lost(KEPT, replace(KEPT, stalls=moved, tiles=frozenset({"grid/0/0", "grid/0/1"}))) == []


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"heights": (15.0, 35.0, 60.0)}, "heights"),
        ({"stalls": KEPT.stalls[:30]}, "75% of them are there"),
        ({"stalls": ()}, "40 stalls became 0"),
        ({"tiles": frozenset({"grid/0/1"})}, "1 of 1 parts of the journalled map are gone"),
        ({"survey": "000002-b"}, "survey 000001-a became 000002-b"),
    ],
)
def test_whatever_is_lost_is_named(change: dict[str, Any], words: str) -> None:
    (problem,) = lost(KEPT, replace(KEPT, **change))
    assert words in problem


def test_the_table_has_a_row_for_each_outcome_with_what_had_to_be_seen_and_what_was() -> None:
    lasting = See(UP, 3.0, lasts=True)
    steps = (Drone({"gps": "lost"}), See(mode("RTL"), 5.0), lasting, Drone({"gps": "ok"}), See(DOWN, 90.0))
    fault = Fault("a | b", When.HOVERING, steps)
    good, bad = Outcome(fault, (1.5, 3.0, 60.0), (), ("3 stalls",)), Outcome(fault, (1.5,), ("not seen",))
    rows = table([good, bad]).splitlines()[2:]
    seen = "mode RTL: 1.5 of 5 s; in the air (for 3 s); then gps ok; landed, motors off"
    assert rows[0] == f"| a / b | hovering | {seen}: 60 of 90 s | 3 stalls |"
    assert rows[1] == f"| a / b | hovering | {seen} (≤ 90 s); **failed**: not seen | - |"
    assert (
        short_table([replace(good, figures=("recall 1",))])
        .splitlines()[2]
        .endswith(" | hovering | mode RTL: 1.5; landed, motors off: 60; recall 1 |")
    )
    assert line(good) == "ok     hovering: a | b: 1.5 s, 3 s, 60 s"
    measured = replace(good, figures=("recall 0.980",))
    assert ": 60 of 90 s; recall 0.980 |" in table([measured])
    assert line(measured).endswith("60 s, recall 0.980")
    assert line(bad) == "FAILED hovering: a | b: not seen"


def test_the_marked_section_of_a_page_alone_is_replaced(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"# Before\n{BEGIN}\nold\n{END}\nafter\n")
    rewrite(page, "new")
    assert page.read_text() == f"# Before\n{BEGIN}\n\nnew\n\n{END}\nafter\n"
    page.write_text("no section")
    with pytest.raises(ValueError, match="add the two lines"):
        rewrite(page, "new")


def test_each_outcome_is_printed_and_kept_at_once(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = Outcome(Fault("one", When.HOVERING, (See(DOWN, 9.0),)), (1.0,))
    kept: list[Outcome] = []
    reporter(kept.append)(outcome)
    assert kept == [outcome]
    assert capsys.readouterr().out == "ok     hovering: one: 1 s\n"


def test_words_of_no_fault_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        command.main(["no such words"])
    assert "no fault has these words: no such words; --list without words shows all" in capsys.readouterr().err


def test_what_must_be_seen_stands_beside_what_was_measured(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["--table", "hovering: HEARTBEAT alone"]) == 0
    head, _, row = capsys.readouterr().out.splitlines()
    assert head.startswith("| fault | when | seen after it")
    assert row.startswith("| HEARTBEAT alone is lost before it reaches us | hovering | link unhealthy: ")
    assert " of 4 s; mode RTL: " in row


@pytest.mark.slow
def test_faults_that_tests_show_are_printed_with_their_tests(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["--tests"]) == 0
    rows = capsys.readouterr().out.splitlines()[2:]
    assert len(rows) > 100
    assert all(".py::test_" in row or ".py::Test" in row for row in rows)


def test_only_faults_with_the_words_are_selected(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["--list", "returning: GNSS is lost"]) == 0
    assert capsys.readouterr().out == "returning: GNSS is lost\n"
