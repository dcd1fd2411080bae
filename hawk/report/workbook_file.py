"""Writes the sheets of `hawk.report.workbook` as a file, in a process of its own, which starts without the rest."""

from __future__ import annotations

import io
import json
from typing import TYPE_CHECKING, Any, Final, Literal

from hawk.runtime.late import late

if TYPE_CHECKING:
    import xlsxwriter
else:
    xlsxwriter = late("xlsxwriter")  # the process that asks does without it

WRITER: Final = "hawk.report.workbook_file:written"
"""Name of `written` for `hawk.formats.box`."""
Kind = Literal["text", "share", "number", "count", "moment", "day"]
_FORMS: Final[dict[Kind, str]] = {
    "text": "@", "share": "0.0%", "number": "0.0", "count": "0", "moment": "yyyy-mm-dd hh:mm", "day": "yyyy-mm-dd",
}  # fmt: skip


def written(data: bytes, _: dict[str, Any]) -> bytes:
    """Return sheets as a workbook. A text stays text, whatever it begins with; heads stay in view, with a filter."""
    given = json.loads(data)
    out = io.BytesIO()
    workbook = xlsxwriter.Workbook(out, {"constant_memory": True, "default_date_format": _FORMS["moment"]})
    workbook.set_properties({"title": given["title"], "author": given["author"]})
    head = workbook.add_format({"bold": True, "bottom": 1, "text_wrap": True, "valign": "bottom"})
    forms = {kind: workbook.add_format({"num_format": form}) for kind, form in _FORMS.items()}
    for each in given["sheets"]:
        _write(workbook.add_worksheet(each["name"]), each, head, forms)
    workbook.close()
    return out.getvalue()


def _write(sheet: Any, given: dict[str, Any], head: Any, forms: dict[Kind, Any]) -> None:
    columns = given["columns"]
    for number, column in enumerate(columns):
        sheet.set_column(number, number, column["width"])
        sheet.write_string(0, number, column["head"], head)
    for line, row in enumerate(given["rows"], 1):
        for number, cell in enumerate(row):
            kind, value = cell if isinstance(cell, list) else (columns[number]["kind"], cell)
            if isinstance(value, str):
                sheet.write_string(line, number, value)
            elif value is not None:
                sheet.write_number(line, number, value, forms[kind])
    sheet.freeze_panes(1, 1)
    sheet.autofilter(0, 0, max(len(given["rows"]), 1), len(columns) - 1)
    sheet.set_landscape()
    sheet.repeat_rows(0)
    sheet.fit_to_pages(1, 0)
