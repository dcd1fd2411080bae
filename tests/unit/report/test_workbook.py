from __future__ import annotations

from datetime import UTC, datetime

import pytest

from hawk.report.document import document
from hawk.report.options import LANGUAGES, Form, Language
from hawk.report.workbook import sheets
from hawk.report.workbook_file import written
from tests.unit.report.conftest import Read
from tests.unit.report.read_back import Book, Page
from tests.unit.report.week import NAME, ZONE

EPOCH = datetime(1899, 12, 30, tzinfo=UTC)


def book(read: Read, language: Language = "en", **asked: tuple[str, ...]) -> Book:
    return Book.of(written(sheets(read(**asked), language), {}))


@pytest.mark.nightly
def test_the_figures_are_those_of_the_document(read: Read) -> None:
    report = read()
    found, page = Book.of(written(sheets(report, "en"), {})), Page.of(document(report, Form()))
    summary = {str(row[0]): row for row in found.sheets["Summary"]}
    mean = report.asked.occupancy
    assert summary["Taken, mean of the surveyed hours"][1:5] == pytest.approx([mean.value, mean.low, mean.high, 11])
    rows = {row[0]: row for row in found.sheets["Rows"]}
    for name, stalls, share, _, always in page.tables["Rows"][1:-1]:
        assert rows[name][3] == float(stalls)
        assert f"{float(rows[name][4] or 0):.0%}" == share.replace("\N{NO-BREAK SPACE}", "")
        ends = f"{float(rows[name][9] or 0):.0f} to {float(rows[name][10] or 0):.0f}"
        assert f"{float(rows[name][8] or 0):.0f}{ends}" == always
    hours = [row for row in found.sheets["Weekday by hour"][1:] if row[3]]
    shown = [cell for row in page.tables["Weekday by hour"][1:] for cell in row[1:] if cell]
    assert len(found.sheets["Weekday by hour"]) == 1 + 168
    assert sorted(f"{float(row[4] or 0):.0%}" for row in hours) == sorted(
        cell.partition("%")[0].strip() + "%" for cell in shown
    )
    surveys = found.sheets["Surveys"][1:]
    assert [row[7:10] for row in surveys[:11]] == [[float(n) for n in row[3:]] for row in page.tables["Surveys"][1:]]
    assert surveys[11][10] == "deleted by a person"


@pytest.mark.slow
def test_times_are_days_of_the_lots_clock_and_shares_are_numbers(read: Read) -> None:
    found = book(read)
    first = found.sheets["Surveys"][1]
    assert isinstance(first[0], float)
    assert round((first[0] - (datetime(2026, 5, 4, 8, 59, tzinfo=UTC) - EPOCH).total_seconds() / 86_400) * 1440) == 0
    assert "yyyy-mm-dd hh:mm" in found.parts["xl/styles.xml"]
    assert "0.0%" in found.parts["xl/styles.xml"]


@pytest.mark.slow
def test_a_stall_is_a_line_with_its_states_by_survey(read: Read) -> None:
    head, *stalls = book(read).sheets["Stalls"]
    assert head[:9] == ["Label", "Id", "Row", "Kind", "Zone", "Taken", "Low", "High", "Surveys with a state"]
    assert len(stalls) == 60
    assert len(head) == 9 + 11
    first = next(row for row in stalls if row[0] == "A 1")
    assert first[5] == 1.0
    assert set(first[9:]) == {"taken"}
    unclear = next(row for row in stalls if row[0] == "C 8")
    assert set(unclear[9:]) == {"unclear"}
    assert unclear[4] == ZONE


@pytest.mark.nightly
@pytest.mark.parametrize("language", LANGUAGES)
def test_a_text_is_text_whatever_it_begins_with_and_heads_stay_in_view(read: Read, language: Language) -> None:
    found = book(read, language)
    assert found.formulas == []
    assert len(found.sheets) == 6
    first = found.sheets[next(iter(found.sheets))]
    assert first[1][1] == NAME
    assert any(ZONE in row for row in found.sheets["Rows" if language == "en" else "Rangées"])
    for number in range(1, 7):
        sheet = found.parts[f"xl/worksheets/sheet{number}.xml"]
        assert 'state="frozen"' in sheet
        assert "<autoFilter" in sheet


@pytest.mark.slow
def test_a_question_about_a_part_marks_what_is_asked(read: Read) -> None:
    found = book(read, rows=("B",))
    assert [row[0] for row in found.sheets["Rows"][1:] if row[2] == "yes"] == ["of row B", "B"]


@pytest.mark.slow
def test_a_period_without_surveys_is_a_workbook_without_figures(read: Read) -> None:
    found = Book.of(written(sheets(read(begin="2031-01-01"), "en"), {}))
    assert len(found.sheets["Surveys"]) == 1
    assert found.sheets["Summary"][10][1:4] == [None, None, None]
