"""A report's documents as PDF, by WeasyPrint, which the extra ``report`` brings: it asks for no file and no address.

Of a report over several lots each becomes a file, and these one: a layout of fifty lots would take 3 GB.
"""

from __future__ import annotations

import gc
import io
import json
import logging
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final

from hawk.lots.values import LotStoreError
from hawk.report.options import EXTRA
from hawk.runtime.late import late, load
from hawk.runtime.programs import remedy

if TYPE_CHECKING:
    import pikepdf
else:
    pikepdf = late("pikepdf")

LIBRARIES: Final = "libpango-1.0-0, libpangoft2-1.0-0 and libharfbuzz-subset0"
"""Packages of Debian that WeasyPrint needs."""
READER: Final = "hawk.report.pdf:printed"
"""Name of `printed` for `hawk.formats.box`."""
PARTS_READER: Final = "hawk.report.pdf:printed_parts"
"""Name of `printed_parts` for `hawk.formats.box`."""


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


def printed_parts(documents: bytes, _: dict[str, Any]) -> bytes:
    """Return several documents, a list of HTML as JSON, as one PDF.

    Title, author and language are those of the first one; its links to ``#part-n`` lead to the document at n. Bookmarks
    and structure are those of all. Each document counts its own pages.

    Raises NoWriterError with the remedy where WeasyPrint, its libraries or pikepdf are missing.
    """
    try:
        load("pikepdf")
    except ImportError as error:
        words = f"a PDF of several lots needs pikepdf: {remedy(EXTRA)}; or ask for .html, which a browser prints"
        raise NoWriterError(words) from error
    return _joined(_each_printed(json.loads(documents)))


def _each_printed(documents: Sequence[str]) -> Iterator[bytes]:
    for each in documents:
        yield printed(each.encode(), {})
        gc.collect()  # a layout is full of circles; the next one takes its place


# -- files that become one ---------------------------------------------------------------------------------------------


def _joined(files: Iterator[bytes]) -> bytes:
    """Return files of WeasyPrint as one. Of each the pages go first: what is copied after them refers to the copies."""
    whole = pikepdf.open(io.BytesIO(next(files)))
    root, tops = whole.Root, [0]
    for number, file in enumerate(files, 1):
        tops.append(len(whole.pages))
        with pikepdf.open(io.BytesIO(file)) as part:
            _renumber(part, number, len(_parents(root)) // 2)
            whole.pages.extend(part.pages)
            _add_structure(root, whole.copy_foreign(part.Root.StructTreeRoot))
            _add_bookmarks(root.Outlines, whole.copy_foreign(part.Root.Outlines))
    root.Names.Dests = _destinations(whole, tops)
    out = io.BytesIO()
    whole.save(out, deterministic_id=True, object_stream_mode=pikepdf.ObjectStreamMode.generate)
    return out.getvalue()


def _parents(root: pikepdf.Object) -> pikepdf.Object:
    """Return the keys of pages and links, from 0, each with what it has in the structure (PDF 1.7, 14.7.4.4)."""
    return root.StructTreeRoot.ParentTree.Nums


def _renumber(part: pikepdf.Pdf, number: int, keys: int) -> None:
    """Give keys and ids of a file's structure those that no file before it has; these have that many keys."""
    for page in part.pages:
        page.obj.StructParents += keys
        for link in page.obj.get("/Annots", []):
            link.StructParent += keys
    nums = _parents(part.Root)
    for at in range(0, len(nums), 2):
        nums[at] += keys
    for each in part.objects:
        if isinstance(each, pikepdf.Dictionary) and each.get("/Type") == "/StructElem":
            if "/ID" in each:
                each.ID = pikepdf.String(f"{number}-{each.ID}")
            if "/Headers" in each.get("/A", {}):
                each.A.Headers = pikepdf.Array(pikepdf.String(f"{number}-{head}") for head in each.A.Headers)


def _add_structure(root: pikepdf.Object, copied: pikepdf.Object) -> None:
    """Put the structure of a file at the end of the first one's document."""
    document, part = root.StructTreeRoot.K[0], copied.K[0]
    part.S, part.P = pikepdf.Name.Part, document
    document.K.append(part)
    _parents(root).extend(copied.ParentTree.Nums)


def _add_bookmarks(outlines: pikepdf.Object, copied: pikepdf.Object) -> None:
    """Put the bookmark of a lot behind the others; those below it are not unfolded."""
    lot = copied.First
    lot.Parent, lot.Prev, lot.Count = outlines, outlines.Last, -lot.Count
    outlines.Last.Next = lot
    outlines.Last = lot
    outlines.Count += 1


def _destinations(whole: pikepdf.Pdf, tops: Sequence[int]) -> pikepdf.Dictionary:
    """Return where links lead: to the top of the page at which a part begins."""
    names: list[Any] = []
    for name, top in sorted((f"part-{number}", top) for number, top in enumerate(tops)):
        height = float(whole.pages[top].mediabox[3])
        place = pikepdf.make_page_destination(whole, top, pikepdf.PageLocation.XYZ, left=0, top=height)
        names += [pikepdf.String(name), place]
    return pikepdf.Dictionary(Names=names)
