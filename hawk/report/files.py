"""The files of a report by their kinds: each is made here, or prepared for a process of its own."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from sqlalchemy import Connection

from hawk.formats.box import named
from hawk.lots.survey.pictures import PictureFolder
from hawk.report import pdf, workbook
from hawk.report.document import content_policy, document
from hawk.report.options import Form, Kind, Wanted
from hawk.report.queries import read_report

_MAKERS: Final[dict[Kind, str]] = {"pdf": pdf.READER, "xlsx": workbook.WRITER}


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
        return Prepared(workbook.sheets(report, form.language), workbook.WRITER)
    html = document(report, form)
    return Prepared(html.encode(), _MAKERS.get(kind), content_policy(html))


def finished(file: Prepared) -> bytes:
    """Return a prepared file, made here. Raises LotStoreError."""
    return file.data if file.maker is None else named(file.maker)(file.data, {})
