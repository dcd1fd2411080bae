from __future__ import annotations

import csv
import io
import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path

import pytest
from sqlalchemy import delete, select

from hawk.cli import main
from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LOOKS
from hawk.stats.serialize import NONE, bracket
from hawk.stats.turnover import Bracket
from tests.unit.stats.test_panel import later, register, seen

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    store = Database(tmp_path_factory.mktemp("made") / "lots.db")
    with store.writing() as connection:
        for number in (1, 2, 3):
            save(connection, later(seen({}), number) if number > 1 else seen({}), register)
    store.close()
    return store.path


@pytest.fixture
def run(made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    shutil.copy(made, tmp_path)

    def command(*options: str) -> tuple[int, str, str]:
        zone = () if "--time-zone" in options else ("--time-zone", "UTC")
        status = main(["stats", *options, "--store", str(tmp_path), *zone])
        return status, *capsys.readouterr()

    return command


@pytest.mark.slow
def test_the_figures_are_printed_with_their_intervals_and_the_clock(run: Run) -> None:
    status, out, _ = run("Lot 1")
    assert status == 0
    assert "Lot 1: 3 surveys, times by UTC" in out
    assert "90% intervals" in out
    assert "capacity: 20 stalls" in out
    assert "occupancy over" in out


@pytest.mark.slow
@pytest.mark.parametrize("by", ["hour", "row", "zone", "kind"])
def test_csv_has_a_line_a_part_that_names_lot_clock_and_surveys(run: Run, by: str) -> None:
    status, out, _ = run("Lot 1", "--by", by, "--csv")
    rows = list(csv.DictReader(io.StringIO(out)))
    assert status == 0
    assert len(rows) == (24 if by == "hour" else 1)
    assert {(row["lot"], row["clock"], row["surveys_in_period"]) for row in rows} == {("Lot 1", "UTC", "3")}


@pytest.mark.slow
def test_json_has_every_figure_with_low_high_and_surveys(run: Run) -> None:
    _, out, _ = run("Lot 1", "--by", "row", "--json")
    found = json.loads(out)
    assert out.startswith('{\n "lot": ')
    assert set(found["whole"]["occupancy"]) == {"value", "low", "high", "surveys"}
    assert found["parts"][0]["name"] == "A"
    assert [hour["occupancy"]["value"] is None for hour in found["hours"]].count(False) == 1


@pytest.mark.slow
def test_turnover_that_is_not_known_is_said_in_a_sentence(run: Run) -> None:
    day = json.loads(run("Lot 1", "--json")[1])["first"][:10]
    _, out, _ = run("Lot 1", "--from", day, "--to", day)
    assert "  arrivals: not known, since no two surveys of this period follow each other over the same stalls\n" in out
    assert out.endswith("  mean stay: not known, since no arrivals are known that limit it\n")


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (None, 4.5, "4.5 h or less"), (1.25, None, "1.2 h or more"), (1.0, 2.0, "1.0 to 2.0 h"), (None, None, NONE),
    ],
)  # fmt: skip
def test_the_unit_of_a_bracket_stands_behind_its_number(low: float | None, high: float | None, words: str) -> None:
    assert bracket(Bracket(low, high), 1, " h") == words


@pytest.mark.slow
def test_a_question_is_answered_by_a_sentence_and_a_table(run: Run) -> None:
    found = json.loads(run("Lot 1", "--row", "A", "--json")[1])
    (hour,) = {each["hour"] for each in found["cells"] if each["days"]}
    days = [(each["weekday"], f"{hour}:00") for each in found["cells"] if each["days"]]
    status, out, _ = run("Lot 1", "--row", "A", "--weekday", "mon-fri,sat-sun", "--hour", f"0-1,{hour}")
    assert status == 0
    assert out.startswith(f"Lot 1, row A: on any day, 0:00 to 1:00, {hour}:00 to {hour + 1}:00, ")
    assert "is taken, " in out.splitlines()[0]
    assert out.splitlines()[0].endswith(" of 20 stalls")
    assert "times by UTC; 90% intervals" in out
    assert "  nobody flew 0:00 to 1:00\n" in out
    assert [tuple(line.split()[:2]) for line in out.splitlines()[-len(days) :]] == days
    rows = list(csv.DictReader(io.StringIO(run("Lot 1", "--hour", str(hour), "--csv")[1])))
    assert sum(int(row["occupancy_surveys"]) for row in rows) == 3
    assert (len(rows), {row["clock"] for row in rows}) == (7, {"UTC"})


@pytest.mark.slow
def test_an_hour_that_nobody_flew_says_so(run: Run) -> None:
    status, out, _ = run("Lot 1", "--from", "2031-01-01", "--kind", "normal")
    assert (status, out) == (
        0, "Lot 1, kind normal: nobody flew on any day, at any hour, or every survey was left out\n",
    )  # fmt: skip


@pytest.mark.slow
def test_a_period_without_surveys_says_so(run: Run) -> None:
    status, out, _ = run("Lot 1", "--from", "2031-01-01", "--to", "2031-01-02")
    assert status == 0
    assert "No survey of this period can be used" in out


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("Lot 1", "--from", "yesterday"), "--from: must be a date, as 2026-05-04"),
        (("Lot 1", "--to", "2026-13-01"), "--to: must be a date"),
        (("Lot 1", "--from", "2026-05-04", "--to", "2026-05-01"), "--to: 2026-05-01 is not after 2026-05-04"),
        (("Lot 1", "--by", "colour"), "--by: invalid choice: 'colour'"),
        (("Lot 1", "--time-zone", "Mars/Olympus"), "--time-zone: must be a name of the time zone database"),
        (("Lot 1", "--weekday", "workday"), "--weekday: must be days out of mon, tue"),
        (("Lot 1", "--hour", "11-7"), "--hour: must be hours from 0 to 24"),
        (("Lot 1", "--row", "Q"), "--row: the lot has none that is called 'Q'; there is A"),
        (("Lot 1", "--zone", "Q"), "--zone: the lot has none that is called 'Q'; there is no zone"),
        (("Lot 1", "--row", "A", "--by", "row"), "--by: not together with --weekday, --hour, --row, --zone, --kind"),
        (("Lot 9",), "LOT: no lot is called 'Lot 9'; there are 'Lot 1'"),
        (("Lot 1", "--csv", "--json"), "--json: not allowed with argument --csv"),
    ],
)
def test_what_cannot_be_used_is_refused_with_its_name_and_the_remedy(
    run: Run, options: tuple[str, ...], words: str
) -> None:
    status, _, error = run(*options)
    assert status == 2
    assert words in error


@pytest.mark.slow
def test_times_are_those_of_the_lot_unless_another_clock_is_named(
    run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["stats", "Lot 1", "--store", str(tmp_path), "--json"]) == 0
    here, there = json.loads(capsys.readouterr().out), json.loads(run("Lot 1", "--json")[1])
    assert (here["clock"], there["clock"]) == ("Europe/Amsterdam", "UTC")
    moments = [datetime.fromisoformat(each["first"]) for each in (here, there)]
    assert moments[0] == moments[1]
    assert (moments[0].utcoffset(), moments[1].utcoffset()) == (timedelta(hours=1), timedelta(0))


def test_a_store_that_there_is_not_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stats", "Lot 1", "--store", str(tmp_path)]) == 1
    assert "there is no store of lots; name its folder by --store" in capsys.readouterr().err


@pytest.mark.slow
def test_pieces_that_are_missing_are_kept_by_the_command(run: Run, tmp_path: Path) -> None:
    store = Database(tmp_path / "lots.db")
    with store.writing() as connection:
        connection.execute(delete(LOOKS))
    store.close()
    assert run("Lot 1")[0] == 0
    store = Database(tmp_path / "lots.db")
    with store.reading() as connection:
        assert len(connection.execute(select(LOOKS.c.survey)).all()) == 3
    store.close()


@pytest.mark.slow
def test_the_command_line_starts_without_numpy() -> None:
    code = "import sys, hawk.cli; hawk.cli.make_parser(); print('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout == "False\n"
