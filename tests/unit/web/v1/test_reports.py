"""The report of a lot's use over HTTP."""

from __future__ import annotations

import asyncio
import shutil
import sys
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

import aiohttp
import pytest

from hawk.comm.protocol.authority import Role
from hawk.formats import box
from hawk.lots.store import LotStore
from hawk.report.options import MOST_LOTS
from hawk.web.v1 import reports
from tests.pace import PATIENCE_S
from tests.unit.report.read_back import Book, Page, Print, pdf_writer
from tests.unit.report.week import NAME, Week
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand


@dataclass
class Desk:
    stand: Stand
    rig: Rig
    session: aiohttp.ClientSession
    lot: str

    async def get(self, path: str, session: aiohttp.ClientSession | None = None) -> aiohttp.ClientResponse:
        assert self.rig.server is not None
        response = await (session or self.session).get(self.rig.server.make_url(f"/api/v1{path}"))
        await response.read()
        return response

    async def report(self, kind: str, options: str = "") -> aiohttp.ClientResponse:
        return await self.get(f"/lots/{self.lot}/report.{kind}{options}")


@pytest.fixture(scope="module")
def week(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    folder = tmp_path_factory.mktemp("week")
    made = Week(folder)
    made.store.close()
    return folder, made.lot


@pytest.fixture
async def desk(tmp_path: Path, rig: Rig, week: tuple[Path, str]) -> AsyncIterator[Desk]:
    folder = Path(shutil.copytree(week[0], tmp_path / "week"))
    store = rig.lots = LotStore(folder / "lots.db")
    stand, rig.folder = Stand(rig, tmp_path), tmp_path
    await rig.start()
    yield Desk(stand, rig, await stand.tool(Role.VIEWER), week[1])
    await stand.close()
    await store.close()


@pytest.mark.nightly
async def test_a_viewer_is_shown_the_document_which_a_frame_of_this_page_may_hold(desk: Desk) -> None:
    response = await desk.report("html", "?row=B&weekday=mon-fri&hour=7-11&language=fr&paper=letter")
    page = Page.of(await response.text())
    assert response.status == 200
    assert response.content_type == "text/html"
    assert "combien de places de la rangée B sont occupées, lundi à vendredi" in page.words
    assert NAME in page.words
    policy = response.headers["Content-Security-Policy"]
    assert policy.startswith("default-src 'none'; style-src 'sha256-")
    assert "img-src data:;" in policy
    assert "frame-ancestors 'self'" in policy
    assert response.headers["X-Frame-Options"] == "SAMEORIGIN"
    assert response.headers["Content-Disposition"] == f'inline; filename="report-{desk.lot[:8]}.html"'
    assert response.headers["ETag"]


@pytest.mark.nightly
async def test_pdf_and_workbook_are_written_by_a_process_of_their_own(desk: Desk) -> None:
    pdf_writer()
    pdf, book = await asyncio.gather(desk.report("pdf"), desk.report("xlsx", "?row=B"))
    assert (pdf.status, pdf.content_type) == (200, "application/pdf")
    assert (await pdf.read()).startswith(b"%PDF-")
    assert book.status == 200
    assert Book.of(await book.read()).sheets["Summary"][1][1] == NAME
    assert book.headers["Content-Disposition"].startswith("attachment")
    lots = await desk.get("/report.pdf")
    assert (lots.status, lots.content_type) == (200, "application/pdf")
    assert [name for name, _ in Print.of(await lots.read()).bookmarks] == ["One lot", NAME]


@pytest.mark.slow
async def test_in_flight_the_document_alone_is_made(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reports, "is_on_ground", lambda _: False)
    for kind in ("pdf", "xlsx"):
        refused = await desk.report(kind)
        assert refused.status == 409
        problem = await refused.json(content_type=None)
        assert problem["field"] == "report"
        assert "take report.html now, or this once the motors are off" in problem["detail"]
    assert (await desk.report("html")).status == 200


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "field", "words"),
    [
        ("?weekday=workday", "weekday", "must be days out of mon, tue"),
        ("?row=Q", "row", "the lot has none that is called 'Q'"),
        ("?language=de", "language", "en"),
        ("?paper=a3", "paper", "a4"),
        ("?from=2026-05-04&to=2026-05-01", "to", "is not after"),
        ("?colour=red", "colour", "is not known here"),
    ],
)
async def test_what_cannot_be_used_is_refused_with_its_name(desk: Desk, options: str, field: str, words: str) -> None:
    for kind in ("html", "pdf", "xlsx"):
        refused = await desk.report(kind, options)
        assert refused.status == 422
        problem = await refused.json(content_type=None)
        assert problem["field"] == field
        assert words in problem["detail"]


@pytest.mark.slow
async def test_a_lot_that_there_is_not_is_refused(desk: Desk) -> None:
    assert (await desk.get(f"/lots/{'0' * 36}/report.html")).status == 404
    assert (await desk.get(f"/lots/{desk.lot}/report.docx")).status == 404


@pytest.mark.slow
async def test_a_link_shows_the_report_of_its_lot_without_ground_and_without_a_login(desk: Desk) -> None:
    operator = await desk.stand.tool(Role.OPERATOR)
    assert desk.rig.server is not None
    url = desk.rig.server.make_url(f"/api/v1/lots/{desk.lot}/shares")
    async with operator.post(url, json={"days": 1}) as made:
        token = (await made.json())["token"]
    async with aiohttp.ClientSession() as nobody:
        shown = await desk.get(f"/shared/{token}/report.html", nobody)
        page = Page.of(await shown.text())
        assert shown.status == 200
        assert NAME in page.words
        assert not page.attributes("image")
        assert (await desk.get(f"/shared/{token}/report.xlsx", nobody)).status == 200
        assert (await desk.get(f"/shared/{'A' * 22}/report.html", nobody)).status == 404
        assert (await desk.get(f"/lots/{desk.lot}/report.html", nobody)).status == 401


@pytest.mark.slow
async def test_a_file_that_takes_too_much_names_what_to_do(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reports, "LIMITS", box.Limits(memory_bytes=2_000_000))
    refused = await desk.report("xlsx")
    assert refused.status == 409
    assert "ask for a shorter period" in (await refused.json(content_type=None))["detail"]


def test_a_desk_has_room_for_the_process_that_writes_the_largest_report() -> None:
    unit = (Path(__file__).parents[4] / "packaging/systemd/hawk-desk.service").read_text()
    assert "MemoryMax=2G" in unit
    most = reports.LIMITS.memory_bytes + (MOST_LOTS - 1) * reports.A_LOT.memory_bytes
    assert most <= (2 << 30) - 300_000_000, "beside the desk itself"


@pytest.mark.slow
async def test_too_many_files_at_once_are_refused(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reports, "MOST_WAITING", 1)
    answers = await asyncio.gather(*(desk.report("xlsx") for _ in range(3)))
    assert sorted(each.status for each in answers) == [200, 503, 503]


@pytest.mark.slow
async def test_a_file_that_nobody_waits_for_any_more_is_written_no_further(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    began, ended = asyncio.Event(), asyncio.Event()

    async def write(*_: object) -> bytes:
        began.set()
        try:
            await asyncio.Event().wait()
        finally:
            ended.set()
        return b""

    monkeypatch.setattr(box, "read_apart", write)
    asked = asyncio.create_task(desk.report("xlsx"))
    await began.wait()
    asked.cancel()
    async with asyncio.timeout(PATIENCE_S):
        await ended.wait()
    monkeypatch.undo()
    assert (await desk.report("xlsx")).status == 200


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("library", "lots", "words"),
    [
        ("weasyprint", "/lots/{}", "a PDF needs WeasyPrint"),
        ("weasyprint", "", "a PDF needs WeasyPrint"),
        ("pikepdf", "", "a PDF of several lots needs pikepdf"),
    ],
)
async def test_without_the_extra_the_remedy_is_named(
    desk: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, library: str, lots: str, words: str
) -> None:
    missing = tmp_path / "missing" / library
    missing.mkdir(parents=True)
    (missing / "__init__.py").write_text("raise ImportError('not installed')")
    paths = [str(missing.parent), *filter(None, sys.path)]
    monkeypatch.setenv("PYTHONPATH", ":".join(paths))
    refused = await desk.get(f"{lots.format(desk.lot)}/report.pdf")
    assert refused.status == 409
    detail = (await refused.json(content_type=None))["detail"]
    assert words in detail
    assert "ask for .html" in detail


@pytest.mark.slow
async def test_several_lots_are_one_file_or_all_where_none_is_named(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    for options in ("", f"?lot={desk.lot}&lot={desk.lot}&hour=7-11&language=fr"):
        shown = await desk.get(f"/report.html{options}")
        page = Page.of(await shown.text())
        assert shown.status == 200
        assert [row[0] for row in next(iter(page.tables.values()))[1:]] == [NAME, "Total"]
        assert shown.headers["Content-Disposition"] == 'inline; filename="report-lots.html"'
        assert shown.headers["Content-Security-Policy"].startswith("default-src 'none'")
    book = await desk.get("/report.xlsx")
    assert Book.of(await book.read()).sheets["Lots"][1][1] == NAME
    for options, field, words in (
        ("?row=A", "row", "is not known here"),
        ("?lot=North", "lot", "must be an id"),
        (f"?lot={'0' * 36}", "lot", "there is no lot with this id"),
    ):
        refused = await desk.get(f"/report.html{options}")
        problem = await refused.json(content_type=None)
        assert refused.status in (404, 422)
        assert problem["field"].startswith(field)
        assert words in problem["detail"]
    monkeypatch.setattr("hawk.report.lots_report.MOST_LOTS", 0)
    refused = await desk.get("/report.html")
    assert refused.status == 422
    assert "a report is over 0 lots at most, and these are 1: ask for fewer" in (await refused.text())
    monkeypatch.setattr(reports, "is_on_ground", lambda _: False)
    for kind in ("html", "pdf", "xlsx"):
        refused = await desk.get(f"/report.{kind}")
        assert refused.status == 409
        assert "over several lots is not made in flight" in (await refused.text())
