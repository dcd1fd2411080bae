from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from hawk.cli import main
from tests.unit.report.read_back import Book, Page, pdf_writer
from tests.unit.report.week import NAME

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(folder: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    def command(out: str, *options: str, lot: str = NAME) -> tuple[int, str, str]:
        status = main(["report", lot, "--out", str(folder / out), *options, "--store", str(folder)])
        return status, *capsys.readouterr()

    return command


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "begin"), [("html", b"<!doctype html>"), ("pdf", b"%PDF-"), ("xlsx", b"PK")])
def test_the_end_of_the_name_says_the_kind_of_file(run: Run, folder: Path, kind: str, begin: bytes) -> None:
    if kind == "pdf":
        pdf_writer()
    status, out, error = run(f"report.{kind}")
    assert (status, error) == (0, "")
    assert out.startswith(f"{folder}/report.{kind}: 0.")
    assert (folder / f"report.{kind}").read_bytes().startswith(begin)


@pytest.mark.slow
def test_question_period_clock_language_and_paper_are_those_of_the_options(run: Run, folder: Path) -> None:
    options = "--row B --weekday mon-fri --hour 5-12 --from 2026-05-05 --to 2026-05-08 --time-zone UTC --language fr"
    assert run("r.html", *options.split(), "--paper", "letter")[0] == 0
    page = Page.of((folder / "r.html").read_text())
    assert "combien de places de la rangée B sont occupées, lundi à vendredi, de 5:00 à 12:00." in page.words
    assert "5 au 8 mai 2026" in page.words
    assert "Les heures sont celles de UTC." in page.words
    assert "jeu. 7 mai 2026, 07:59" in page.words
    assert run("r.xlsx", "--language", "fr")[0] == 0
    assert next(iter(Book.of((folder / "r.xlsx").read_bytes()).sheets)) == "Résumé"


@pytest.mark.parametrize(
    ("out", "options", "words"),
    [
        ("r.docx", (), "--out: "),
        ("r.pdf", ("--from", "yesterday"), "--from: must be a date, as 2026-05-04"),
        ("r.pdf", ("--from", "2026-05-04", "--to", "2026-05-01"), "--to: 2026-05-01 is not after 2026-05-04"),
        ("r.pdf", ("--weekday", "workday"), "--weekday: must be days out of mon, tue"),
        ("r.pdf", ("--row", "Q"), "--row: the lot has none that is called 'Q'; there is A, B, C"),
        ("r.pdf", ("--language", "de"), "--language: invalid choice: 'de'"),
        ("r.pdf", ("--paper", "a3"), "--paper: invalid choice: 'a3'"),
        ("r.pdf", ("--time-zone", "Mars/Olympus"), "--time-zone: must be a name of the time zone database"),
    ],
)
def test_what_cannot_be_used_is_refused_with_its_name_and_the_remedy(
    run: Run, folder: Path, out: str, options: tuple[str, ...], words: str
) -> None:
    status, _, error = run(out, *options)
    assert status == 2
    assert words in error
    assert not (folder / out).exists()


def test_a_lot_that_there_is_not_is_refused_by_its_name(run: Run) -> None:
    status, _, error = run("r.html", lot="Nowhere")
    assert status == 2
    assert "LOT: no lot is called 'Nowhere'" in error


@pytest.mark.slow
def test_without_the_extra_pdf_alone_is_refused(run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "weasyprint", None)
    status, _, error = run("r.pdf")
    assert status == 1
    assert "a PDF needs WeasyPrint" in error
    assert "[report]" in error
    assert not (folder / "r.pdf").exists()
    assert [run(name)[0] for name in ("r.html", "r.xlsx")] == [0, 0]


@pytest.mark.slow
def test_a_file_that_cannot_be_written_is_refused_with_its_option(run: Run, folder: Path) -> None:
    status, _, error = run("nowhere/r.html")
    assert status != 0
    assert "--out" in error


@pytest.mark.slow
def test_the_command_line_starts_without_templates_and_languages() -> None:
    code = (
        "import sys, hawk.cli; hawk.cli.make_parser();"
        "print([name for name in ('numpy', 'jinja2', 'babel', 'fluent', 'xlsxwriter') if name in sys.modules])"
    )
    assert subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout == "[]\n"
