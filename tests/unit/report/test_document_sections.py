"""Sections in a report: what the newest survey counted, by hour where they are asked, apart from stalls."""

from __future__ import annotations

from pathlib import Path

import pytest

from hawk.lots.survey.pictures import PictureFolder
from hawk.lots.values import LotInputError
from hawk.report.document import document
from hawk.report.options import Form, Wanted
from hawk.report.queries import read_report
from hawk.report.values import Report
from hawk.report.workbook import sheets
from hawk.report.workbook_file import written
from hawk.stats.use_query import asked_of
from tests.unit.lots.plan.plans import Person
from tests.unit.report.read_back import Book
from tests.unit.stats.test_section_use import ACROSS, MONDAY, ann, flown

__all__ = ["ann", "flown"]
NOW = MONDAY + 8 * 86_400


def report_of(person: Person, folder: Path, *sections: str) -> Report:
    with person.store.reading() as connection:
        wanted = Wanted(person.lot, asked_of(sections=sections), None, None, None, has_ground=False)
        return read_report(connection, PictureFolder(folder), wanted, NOW)


@pytest.mark.slow
def test_the_newest_counts_are_a_table_of_their_own(ann: Person, tmp_path: Path) -> None:
    ann.do("draw_section", name="<b>Yard", **ACROSS)
    found = report_of(ann, tmp_path)
    assert found.sections is not None
    assert [(each.name, each.look and each.look.parked) for each in found.sections.sections] == [
        ("<b>Yard", 1), ("Elm Street", 4),
    ]  # fmt: skip
    text = document(found, Form())
    assert "Sections count vehicles, of the places that they have; all other figures count stalls." in text
    elm = found.sections.sections[1].look
    assert elm is not None
    assert (
        f"<td>Elm Street</td><td>4</td><td>{elm.least} to {elm.most}</td><td>4</td><td>100\N{NO-BREAK SPACE}%</td>"
        in text
    )
    assert "<td>&lt;b&gt;Yard</td>" in text
    assert "Sections, weekday by hour" not in text
    assert found.asked.unit == "stalls"


@pytest.mark.slow
def test_a_question_about_a_section_has_its_hours(ann: Person, tmp_path: Path) -> None:
    ann.do("draw_section", name="Yard", **ACROSS)
    found = report_of(ann, tmp_path, "Elm Street")
    text = document(found, Form(language="fr"))
    assert "Sections, jour par heure : Elm Street" in text
    assert "par rapport à 4 places" in text
    assert "125\N{NO-BREAK SPACE}%" in text
    assert found.asked.unit == "stalls", "the figures of stalls are those of the lot"
    assert "Nobody said how many places there are" in document(report_of(ann, tmp_path, "Yard"), Form())
    with pytest.raises(LotInputError, match="none that is called 'Oak'"):
        report_of(ann, tmp_path, "Oak")


@pytest.mark.slow
def test_the_workbook_has_both(ann: Person, tmp_path: Path) -> None:
    found = report_of(ann, tmp_path, "Elm Street")
    assert found.sections is not None
    look = found.sections.sections[0].look
    assert look is not None
    book = Book.of(written(sheets(found, "en"), {})).sheets
    head, row = book["Sections"]
    cells = dict(zip(head, row, strict=True))
    assert [cells[name] for name in ("Section", "Vehicles", "Low", "High", "Places", "Of the places")] == [
        "Elm Street", 4, look.least, look.most, 4, 1,
    ]  # fmt: skip
    hours = [row for row in book["Sections, weekday by hour"][1:] if row[3]]
    assert [(row[0], row[1], row[7]) for row in hours] == [
        ("Monday", 11, 3.5), ("Monday", 13, 5), ("Tuesday", 11, 1), ("Tuesday", 13, 0),
    ]  # fmt: skip
