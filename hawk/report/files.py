"""The files of a report by their kinds: each is made here, or prepared for a process of its own."""

from __future__ import annotations

import json
from contextlib import closing
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Final

from sqlalchemy import Connection

from hawk.formats.box import named
from hawk.lots import lists
from hawk.lots.storage.database import Database
from hawk.lots.survey.pictures import PictureFolder, pictures_of
from hawk.report import pdf, workbook
from hawk.report.document import content_policy, document
from hawk.report.options import Form, Kind, Wanted
from hawk.report.queries import read_report
from hawk.stats.period import period_of_lot
from hawk.stats.use_query import Asked

DOCUMENT: Final = "hawk.report.files:document_apart"
"""Reads a report and makes its document, as `hawk.formats.box` calls it."""
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


def prepared_apart(connection: Connection, store: Path, wanted: Wanted, form: Form, now: float) -> Prepared:
    """Prepare a document that `document_apart` reads and makes in a process of its own; what is asked is checked here.

    Raises NotFoundError, LotInputError.
    """
    lists.lot(connection, wanted.lot)
    period_of_lot(connection, wanted.lot, wanted.begin, wanted.end, wanted.time_zone)
    job = {"store": str(store), "wanted": asdict(wanted), "form": asdict(form), "now": now}
    return Prepared(json.dumps(job).encode(), DOCUMENT)


def document_apart(data: bytes, _asked: dict[str, Any]) -> bytes:
    """Return the policy of a document, and on the following lines the document. Raises as `prepared`."""
    job = json.loads(data)
    question = Asked(**{name: tuple(values) for name, values in job["wanted"].pop("asked").items()})
    wanted, store = Wanted(asked=question, **job["wanted"]), Path(job["store"])
    with closing(Database(store)) as opened, opened.reading() as connection:
        file = prepared(connection, pictures_of(store), wanted, "html", Form(**job["form"]), job["now"])
    return file.policy.encode() + b"\n" + file.data


def finished(file: Prepared) -> bytes:
    """Return a prepared file, made here. Raises LotStoreError."""
    return file.data if file.maker is None else named(file.maker)(file.data, {})
