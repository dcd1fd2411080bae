from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from proving.faults.ardupilot import BEGIN, MISSING, copter_of, fitting, main, make_parser, selected, world_of
from proving.faults.fault import See
from proving.faults.record import REAL, read_outcomes
from proving.faults.report import END, names, rewritten, short_table
from proving.faults.run import ALL, SEED, START
from proving.faults.table_vehicle import VEHICLE

ROOT = Path(__file__).parents[4]


@pytest.fixture
def program(tmp_path: Path) -> Path:
    made = tmp_path / "arducopter"
    made.touch()
    (tmp_path / "copter.parm").touch()
    return made


def test_every_flight_has_an_end_and_a_time_and_a_name_of_its_own() -> None:
    assert len(set(names(VEHICLE))) == len(VEHICLE) >= 8
    for flight in VEHICLE:
        sights = [step for step in flight.steps if isinstance(step, See)]
        assert sights, flight.name
        assert all(0 < see.within_s <= 420 for see in sights), flight.name
    falls = [flight for flight in VEHICLE if flight.falls]
    assert falls
    assert all(flight.ends_flight for flight in falls), "a fall ends the vehicle"


def test_words_select_flights(capsys: pytest.CaptureFixture[str]) -> None:
    assert selected([]) == VEHICLE
    assert [flight.name for flight in selected(["whole survey", "operator cuts the motors"])] == [
        "a whole survey",
        "the operator cuts the motors",
    ]
    assert main(["--list", "whole survey"]) == 0
    assert capsys.readouterr().out == "on the ground: a whole survey\n"


def test_what_must_be_seen_stands_beside_what_was_measured(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--table", "whole survey"]) == 0
    _, _, row = capsys.readouterr().out.splitlines()
    assert row.startswith("| a whole survey | on the ground | whole lot surveyed, recall ≥ 0.9, precision ≥ 0.9: ")
    assert " of 420 s; " in row


def test_faults_of_the_simulated_drone_come_after_the_flights_each_once() -> None:
    flights = selected([], fitting(ALL))
    assert flights[: len(VEHICLE)] == VEHICLE
    assert len(set(names(flights))) == len(flights) > len(VEHICLE) + 20
    assert main(["--list", "--others"]) == 0


@pytest.mark.parametrize("arguments", [[], ["--program", "/no/such/program"]])
def test_without_the_program_one_line_says_what_to_set(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert MISSING in line


def test_make_without_the_program_says_the_same_and_ends_with_2() -> None:
    done = subprocess.run(
        ["make", "--no-print-directory", "ardupilot", "ARDUPILOT="],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert MISSING in done.stderr.splitlines()[0]


def test_the_parameters_lie_beside_the_program_or_are_named(
    program: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def copter(*arguments: str) -> Path:
        return copter_of(make_parser().parse_args(["--program", str(program), *arguments])).defaults

    other = tmp_path / "other.parm"
    other.touch()
    assert copter() == tmp_path / "copter.parm"
    assert copter("--defaults", str(other)) == other
    (tmp_path / "copter.parm").unlink()
    assert main(["--program", str(program)]) == 2
    assert "set DEFAULTS=" in capsys.readouterr().err


def test_words_of_no_flight_are_an_error(program: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--program", str(program), "no such words"]) == 2
    assert "no such words" in capsys.readouterr().err


def test_the_world_is_drawn_or_a_picture(program: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drawn = world_of(make_parser().parse_args([]))
    assert (drawn.seed, drawn.start, drawn.world, drawn.speed) == (SEED, START, None, 1.0)
    picture = world_of(make_parser().parse_args(["--world", "lot.jpg", "--metres-per-pixel", "0.1", "--start", "6,7"]))
    assert (picture.world, picture.metres_per_pixel, picture.start) == (Path("lot.jpg"), 0.1, "6,7")
    assert main(["--program", str(program), "--world", "lot.jpg"]) == 2
    assert "--metres-per-pixel: is needed" in capsys.readouterr().err
    assert main(["--program", str(program), "--truth", "lot.json"]) == 2
    assert "--truth: only together with --world" in capsys.readouterr().err


def test_the_page_has_the_last_outcome_of_each_flight() -> None:
    page = (ROOT / "docs" / "ardupilot.md").read_text()
    assert page.count(BEGIN) == page.count(END) == 1
    flown = short_table(read_outcomes(REAL, VEHICLE))
    assert rewritten(page, flown, BEGIN) == page, "make ardupilot writes it"
    assert len(flown.splitlines()) == 2 + len(VEHICLE)
