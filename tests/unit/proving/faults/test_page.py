from __future__ import annotations

import re

import pytest

from proving.faults.__main__ import PAGE
from proving.faults.fault import DOWN, Answer, Drone, Fault, Outcome, See, Subject, When, both, mode
from proving.faults.page import PageError, rows, section
from proving.faults.record import SIMULATED, read_outcomes
from proving.faults.report import rewritten
from proving.faults.run import ALL

ROWS = rows(ALL)
LOST = (Drone({"gps": "lost"}), See(both(mode("LAND"), DOWN), 9.0), See(mode("RTL"), 9.0), See(DOWN, 9.0, lasts=True))
FAULTS = [Fault("GNSS is lost", when, LOST) for when in (When.HOVERING, When.EXPLORING)]


def rows_of(drone: str, *outcomes: Outcome, flown: str = "GNSS is lost") -> list[str]:
    return section({Answer(Subject.POSITION, "no GNSS", drone, "wait"): (flown,)}, outcomes).splitlines()


def test_a_row_has_what_its_flights_measured() -> None:
    outcomes = [Outcome(fault, seconds) for fault, seconds in zip(FAULTS, [(1.5, 3.0), (0.5, 3.0)], strict=True)]
    drone = "LAND after {mode LAND}, down after {landed}, RTL after {mode R*}"
    title, _, head, _, row = rows_of(drone, *outcomes)
    assert title == "## Position, height, heading"
    assert head == "| fault | the drone | you | flights |"
    assert row == "| no GNSS | LAND after 0.5 s to 1.5 s, down after 0.5 s to 1.5 s, RTL after 3 s | wait | 2 |"


def test_a_flight_that_failed_is_counted_and_a_sight_that_it_lacks_is_named() -> None:
    row = rows_of("LAND after {mode LAND}", Outcome(FAULTS[0], (), ("not seen",)))[-1]
    assert row == "| no GNSS | LAND after **not seen** | wait | 1, **1 failed** |"


@pytest.mark.parametrize(
    ("drone", "flown", "words"),
    [
        ("it lands", "no such fault", "'no such fault' was not flown"),
        ("LAND after {mode LOITER}", "GNSS is lost", "no flight of it saw 'mode LOITER'"),
        ("down {landed, motors off} long", "GNSS is lost", "no flight of it saw 'landed, motors off'"),
    ],
)
def test_a_row_that_its_flights_do_not_carry_is_refused(drone: str, flown: str, words: str) -> None:
    with pytest.raises(PageError, match=re.escape(words)):
        rows_of(drone, Outcome(FAULTS[0], (1.0, 2.0, 9.0)), flown=flown)


def test_faults_with_one_answer_share_its_row_and_rows_stand_by_subject() -> None:
    answer = Answer(Subject.POSITION, "no GNSS", "lands after {mode LAND}", "wait")
    other = Answer(Subject.LINK, "no link", "holds", "wait")
    faults = [Fault("GNSS is lost", when, LOST, answer=answer) for when in (When.HOVERING, When.EXPLORING)]
    faults += [Fault("GNSS fails", When.HOVERING, LOST, answer=answer), Fault("no row", When.HOVERING, LOST)]
    faults += [Fault("no link", When.HOVERING, LOST, answer=other)]
    found = rows(faults)
    assert list(found.items()) == [(other, ("no link",)), (answer, ("GNSS is lost", "GNSS fails"))]


def test_every_fault_belongs_to_one_row() -> None:
    named = [name for names in ROWS.values() for name in names]
    assert sorted(named) == sorted({fault.name for fault in ALL})
    assert len({row.fault for row in ROWS}) == len(ROWS)


def test_times_in_the_rows_are_measured_ones() -> None:
    for row in ROWS:
        assert not re.search(r"after \d", row.drone), row.fault


def test_the_page_has_the_rows_and_the_last_outcomes() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert rewritten(page, section(ROWS, read_outcomes(SIMULATED, ALL))) == page, (
        "write it again: python -m proving.faults --page"
    )


def test_faults_that_tests_show_stand_at_their_tests_alone() -> None:
    assert ".py::" not in PAGE.read_text(encoding="utf-8")
