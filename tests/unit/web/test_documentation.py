"""The documentation under /docs/: the built site, offline, for everybody who may open the page."""

from __future__ import annotations

import gzip
import threading
from pathlib import Path

import pytest

from hawk.comm.protocol.authority import Role
from hawk.web.documentation import Documentation
from tests.unit.web.rig import Rig, browser
from tests.unit.web.stand import Stand

PAGE = b"<!doctype html><title>hawk: first flight</title>" * 50
SEARCH = "/docs/search.html?q=GPS"


@pytest.fixture
def site(tmp_path: Path) -> Path:
    folder = tmp_path / "docs_site"
    (folder / "_static").mkdir(parents=True)
    (folder / "how-to").mkdir()
    (folder / ".sources").write_text("0" * 64)
    for name in ("index.html", "search.html", "how-to/add-a-state.html"):
        (folder / name).write_bytes(PAGE)
        (folder / f"{name}.gz").write_bytes(gzip.compress(PAGE))
    (folder / "_static" / "furo.css").write_bytes(b"body {}")
    (folder / "_static" / "page.png").write_bytes(b"\x89PNG")
    (tmp_path / "secret.html").write_text("not of the site")
    return folder


@pytest.fixture
def served(rig: Rig, site: Path) -> Rig:
    rig.documentation = Documentation.load(site)
    return rig


@pytest.mark.slow
@pytest.mark.parametrize("path", ["/docs/", "/docs/index.html", SEARCH, "/docs/how-to/add-a-state.html"])
async def test_the_pages_of_the_site_are_served(served: Rig, path: str) -> None:
    server = await served.start()
    async with browser() as session, session.get(server.make_url(path)) as response:
        assert (response.status, response.content_type, response.charset) == (200, "text/html", "utf-8")
        assert await response.read() == PAGE


async def test_the_folder_without_its_slash_leads_to_the_first_page(served: Rig) -> None:
    server = await served.start()
    async with browser() as session, session.get(server.make_url("/docs"), allow_redirects=False) as response:
        assert (response.status, response.headers["Location"]) == (308, "/docs/")


@pytest.mark.parametrize(
    "path",
    [
        "/docs/nothing.html",
        "/docs/how-to",
        "/docs/how-to/",
        "/docs/../secret.html",
        "/docs/%2e%2e/secret.html",
        "/docs/..%2fsecret.html",
        "/docs/how-to/..%2f..%2fsecret.html",
        "/docs//etc/passwd",
        "/docs/%2fetc/passwd",
        "/docs/index.html%00",
        "/docs/index.html.gz",
        "/docs/.sources",
    ],
)
async def test_nothing_but_the_site_is_served(served: Rig, path: str) -> None:
    server = await served.start()
    async with browser() as session, session.get(f"http://127.0.0.1:{server.port}{path}") as response:
        assert response.status == 404
        assert b"not of the site" not in await response.read()


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH"])
async def test_it_can_be_read_only(served: Rig, method: str) -> None:
    server = await served.start()
    async with browser() as session, session.request(method, server.make_url("/docs/index.html")) as response:
        assert response.status == 405


async def test_the_policy_allows_files_of_the_site_and_nothing_else(served: Rig) -> None:
    server = await served.start()
    async with browser() as session:
        async with session.get(server.make_url("/docs/")) as response:
            policy = response.headers["Content-Security-Policy"]
            assert response.headers["X-Content-Type-Options"] == "nosniff"
        async with session.get(server.make_url("/")) as response:
            of_the_page = response.headers["Content-Security-Policy"]
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    site = f"http://127.0.0.1:{server.port}/docs/"
    assert rules == {
        "default-src": "'none'",
        "script-src": site,
        "style-src": site,
        "img-src": f"{site} data:",
        "connect-src": site,
        "form-action": site,
        "base-uri": "'none'",
        "frame-ancestors": "'none'",
    }
    assert "/docs/" not in of_the_page, "the page's own policy is what it was"


async def test_texts_are_compressed_where_the_browser_takes_it(served: Rig) -> None:
    server = await served.start()
    async with browser(auto_decompress=False) as session:
        for accepted, encoding in (("gzip, br", "gzip"), ("identity", None)):
            headers = {"Accept-Encoding": accepted}
            async with session.get(server.make_url("/docs/"), headers=headers) as response:
                assert response.headers.get("Content-Encoding") == encoding
                body = await response.read()
                assert (gzip.decompress(body) if encoding else body) == PAGE
        async with session.get(server.make_url("/docs/_static/page.png")) as response:
            assert (response.content_type, "Content-Encoding" in response.headers) == ("image/png", False)


async def test_a_browser_asks_again_but_for_what_is_named_by_its_content(served: Rig) -> None:
    server = await served.start()
    async with browser() as session:
        for path, caching in (
            ("/docs/", "no-cache"),
            ("/docs/?v=1", "no-cache"),
            ("/docs/_static/furo.css", "no-cache"),
            ("/docs/_static/furo.css?v=8dab3a3b", "private, max-age=31536000, immutable"),
        ):
            async with session.get(server.make_url(path)) as response:
                assert response.headers["Cache-Control"] == caching, path
                etag = response.headers["ETag"]
            async with session.get(server.make_url(path), headers={"If-None-Match": etag}) as response:
                assert response.status == 304
                assert await response.read() == b""


async def test_a_site_that_was_not_built_says_how(rig: Rig) -> None:
    assert not rig.documentation.is_built
    server = await rig.start()
    async with browser() as session:
        for path in ("/docs/", "/docs/settings.html"):
            async with session.get(server.make_url(path)) as response:
                assert response.status == 404
                assert "make docs" in await response.text()


async def test_a_file_that_has_gone_is_not_found(served: Rig, site: Path) -> None:
    server = await served.start()
    (site / "search.html").unlink()
    async with browser() as session, session.get(server.make_url(SEARCH)) as response:
        assert response.status == 404


async def test_the_files_are_not_read_on_the_loop(served: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    readers: list[str] = []
    read = Path.read_bytes

    def noted(path: Path) -> bytes:
        readers.append(threading.current_thread().name)
        return read(path)

    server = await served.start()
    monkeypatch.setattr(Path, "read_bytes", noted)
    async with browser() as session, session.get(server.make_url("/docs/")) as response:
        assert response.status == 200
    assert readers
    assert all(name.startswith("documentation") for name in readers)


# -- with tokens ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("role", list(Role))
async def test_both_roles_read_it(rig: Rig, site: Path, tmp_path: Path, role: Role) -> None:
    rig.documentation, rig.folder = Documentation.load(site), tmp_path
    stand = Stand(rig, tmp_path)
    await rig.start()
    assert await stand.status(await stand.browser(role), "/docs/") == 200
    assert await stand.status(await stand.tool(role), "/docs/_static/furo.css") == 200
    await stand.close()


async def test_without_a_login_nothing_of_it_is_served(rig: Rig, site: Path, tmp_path: Path) -> None:
    rig.documentation, rig.folder = Documentation.load(site), tmp_path
    stand = Stand(rig, tmp_path)
    server = await rig.start()
    stranger = await stand.browser()
    for path in ("/docs", "/docs/", "/docs/nothing.html", "/docs/_static/furo.css"):
        assert await stand.status(stranger, path) == 401, path
    async with stranger.get(server.make_url("/docs/"), headers={"Accept": "text/html"}) as response:
        assert (response.status, response.content_type) == (401, "text/html")
        assert 'action="/login"' in await response.text(), "a browser is shown the login page"
    await stand.close()
