from __future__ import annotations

import contextlib
import io
import re
import sys
import zlib

import pikepdf
import pytest
from pydantic_core import to_json

from hawk.report.document import document
from hawk.report.options import Form
from hawk.report.pdf import NoWriterError, printed, printed_parts
from tests.unit.report.conftest import Read
from tests.unit.report.read_back import pdf_writer
from tests.unit.report.week import NAME

weasyprint = pdf_writer()


def unpacked(data: bytes) -> bytes:
    """Return a PDF with its streams unpacked."""
    found = [data]
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", data, re.DOTALL):
        with contextlib.suppress(zlib.error):
            found.append(zlib.decompress(stream))
    return b"\n".join(found)


@pytest.mark.nightly
def test_a_pdf_has_title_author_language_and_some_pages(read: Read) -> None:
    html = document(read(), Form("fr", "letter"))
    pages = weasyprint.HTML(string=html).render().pages
    assert 2 <= len(pages) <= 4
    assert {(round(page.width), round(page.height)) for page in pages} == {(816, 1056)}
    data = printed(html.encode(), {})
    assert data.startswith(b"%PDF-")
    inside = unpacked(data)
    assert b"/Lang (fr)" in inside
    assert len(re.findall(rb"/Type /Page\b", inside)) == len(pages)
    title, author = (re.search(rb"/%s <feff([0-9a-f]+)>" % name, inside) for name in (b"Title", b"Author"))
    assert title is not None
    assert bytes.fromhex(title[1].decode()).decode("utf-16-be").startswith(NAME)
    assert author is not None or b"/Author (Parking Lot Hawk" in inside


@pytest.mark.nightly
def test_no_page_is_wider_than_its_paper_or_ends_with_one_line(read: Read) -> None:
    for form in (Form("fr", "letter"), Form("en", "a4"), Form("fr", "a4")):
        for page in weasyprint.HTML(string=document(read(), form)).render().pages:
            texts = [box for box in page._page_box.descendants() if type(box).__name__ == "TextBox"]
            body = [box for box in texts if box.position_y < page.height - 76]
            assert max(box.position_x + box.width for box in texts) <= page.width - 56
            assert len({round(box.position_y) for box in body}) > 3


@pytest.mark.slow
def test_stalls_and_their_numbers_are_no_objects_of_the_file(read: Read) -> None:
    report = read()
    assert report.newest is not None
    assert report.newest.picture is not None
    file = pikepdf.open(io.BytesIO(printed(document(report, Form()).encode(), {})))
    drawn = [each for each in file.objects if isinstance(each, pikepdf.Stream) and "/Resources" in each]
    assert len(drawn) < len(report.newest.picture.stalls)


@pytest.mark.parametrize("address", ["file:///etc/hostname", "http://127.0.0.1:9/a.png"])
def test_a_document_that_asks_for_a_file_or_an_address_is_refused(address: str) -> None:
    with pytest.raises(weasyprint.urls.FatalURLFetchingError):
        printed(f'<img src="{address}">'.encode(), {})


def test_without_the_extra_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    documents = to_json(["<p>One", "<p>Two"])
    monkeypatch.setitem(sys.modules, "pikepdf", None)
    with pytest.raises(NoWriterError, match=r"several lots needs pikepdf: .*\[report\].*ask for .html") as refused:
        printed_parts(documents, {})
    assert refused.value.field == "report"
    monkeypatch.delitem(sys.modules, "pikepdf")
    monkeypatch.setitem(sys.modules, "weasyprint", None)
    for make, given in ((printed, b""), (printed_parts, documents)):
        with pytest.raises(NoWriterError, match=r"\[report\].*libpango-1.0-0.*ask for .html") as refused:
            make(given, {})
        assert refused.value.field == "report"


@pytest.mark.slow
def test_the_same_documents_are_the_same_file() -> None:
    documents = to_json(["<h1>All</h1><a id=part-1 href='#part-1'>One</a>", "<h1>One</h1><table><th>Head<tr><td>1"])
    assert printed_parts(documents, {}) == printed_parts(documents, {})


def test_one_of_several_documents_that_asks_for_a_file_is_refused() -> None:
    with pytest.raises(weasyprint.urls.FatalURLFetchingError):
        printed_parts(to_json(["<h1>All</h1>", '<img src="file:///etc/hostname">']), {})
