"""A report's document as PDF, by WeasyPrint, which the extra ``report`` brings: it asks for no file and no address."""

from __future__ import annotations

import logging
from typing import Any, Final

from hawk.lots.values import LotStoreError
from hawk.report.options import EXTRA
from hawk.runtime.late import load
from hawk.runtime.programs import remedy

LIBRARIES: Final = "libpango-1.0-0, libpangoft2-1.0-0 and libharfbuzz-subset0"
"""Packages of Debian that WeasyPrint needs."""
READER: Final = "hawk.report.pdf:printed"
"""Name of `printed` for `hawk.formats.box`."""


class NoWriterError(LotStoreError):
    """There is nothing here that writes PDF; ``reason`` says the remedy."""

    field = "report"

    def __init__(self, reason: str) -> None:
        super().__init__(f"report: {reason}")
        self.reason = reason


def printed(html: bytes, _: dict[str, Any]) -> bytes:
    """Return a document of `hawk.report.document` as PDF with its title, author, language and structure.

    Raises NoWriterError with the remedy where WeasyPrint or its libraries are missing.
    """
    try:
        weasyprint = load("weasyprint", "urls")
    except (ImportError, OSError) as error:  # OSError: of its libraries in C
        words = (
            f"a PDF needs WeasyPrint with Pango: {remedy(EXTRA)}, with Debian's {LIBRARIES}; or ask for .html, which a "
            "browser prints"
        )
        raise NoWriterError(words) from error
    logging.getLogger("weasyprint").setLevel(logging.ERROR)
    fetcher = weasyprint.urls.URLFetcher(allowed_protocols=("data",), fail_on_errors=True)
    data: bytes = weasyprint.HTML(string=html.decode(), url_fetcher=fetcher).write_pdf(pdf_tags=True)
    return data
