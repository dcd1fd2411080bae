"""The files of a report by their kinds: each is made here, or prepared for a process of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from markupsafe import Markup
from pydantic_core import to_json
from sqlalchemy import Connection

from hawk.formats.box import named
from hawk.lots.queries import NextDue, never_due
from hawk.lots.survey.pictures import PictureFolder
from hawk.report import pdf, workbook, workbook_file
from hawk.report.document import content_policy, document, lot_part, lots_document
from hawk.report.lots_report import LotLine, check_lots, line_of, lots_report
from hawk.report.options import Form, Kind, Wanted
from hawk.report.queries import read_report


@dataclass(frozen=True, slots=True)
class Prepared:
    """A file that is whole, or that ``maker`` makes of the data: a function as `hawk.formats.box` calls it.

    ``policy``: Content-Security-Policy of a document.
    """

    data: bytes = field(repr=False)
    maker: str | None = None
    policy: str = ""


def prepared(
    connection: Connection, pictures: PictureFolder, wanted: Wanted, kind: Kind, form: Form, now: float
) -> Prepared:  # fmt: skip
    """Read a report and prepare a file of it; ``now``: Unix seconds.

    Raises NotFoundError, LotInputError, LotStoreError.
    """
    report = read_report(connection, pictures, wanted, now)
    if kind == "xlsx":
        return Prepared(workbook.sheets(report, form.language), workbook_file.WRITER)
    html = document(report, form)
    return Prepared(html.encode(), pdf.READER if kind == "pdf" else None, content_policy(html))


def prepared_of_lots(
    connection: Connection, pictures: PictureFolder, lots: Sequence[str], wanted: Wanted, kind: Kind, form: Form,
    now: float, due: NextDue = never_due,
) -> Prepared:  # fmt: skip
    """Read a report over several lots and prepare a file of it.

    One lot is read, and written as a part, after the other: a report of it may take 30 MB.

    Args:
        connection: The store.
        pictures: Those of its surveys.
        lots: Ids, in the order of the report; one that is named again counts once.
        wanted: Question, without parts of a lot, and period; its lot is not asked for.
        kind: Of the file.
        form: Language and paper.
        now: Unix seconds.
        due: Says when the next survey of a lot is due.

    Raises NotFoundError, LotInputError, LotStoreError.
    """
    ids = list(dict.fromkeys(lots))
    check_lots(ids, wanted.asked)
    lines: list[LotLine] = []
    pages: list[Markup] = []
    documents: list[str] = []
    sheets: list[list[bytes]] = []
    for number, lot in enumerate(ids, 1):
        report = read_report(connection, pictures, replace(wanted, lot=lot), now)
        lines.append(line_of(connection, report, due))
        if kind == "xlsx":
            sheets.append(workbook.lot_sheets(report, form.language, number))
        elif kind == "pdf":
            documents.append(document(report, form))
        else:
            pages.append(lot_part(report, form))
    whole = lots_report(lines, wanted.asked, now)
    if kind == "xlsx":
        return Prepared(workbook.lots_sheets(whole, sheets, form.language), workbook_file.WRITER)
    html = lots_document(whole, pages, form)
    if kind == "pdf":
        return Prepared(to_json([html, *documents]), pdf.PARTS_READER)
    return Prepared(html.encode(), policy=content_policy(html))


def finished(file: Prepared) -> bytes:
    """Return a prepared file, made here. Raises LotStoreError."""
    return file.data if file.maker is None else named(file.maker)(file.data, {})
