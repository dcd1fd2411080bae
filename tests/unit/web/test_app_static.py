from __future__ import annotations

import gzip
from pathlib import Path

import pytest

from hawk.web.app import Page
from tests.unit.web.rig import Rig, browser

SCRIPT = b"export const answer = 42;\n" * 100


@pytest.fixture
def built(rig: Rig, tmp_path: Path) -> Rig:
    (tmp_path / "assets").mkdir()
    (tmp_path / "index.html").write_text("<!doctype html><title>hawk</title>")
    (tmp_path / "assets" / "main-Ab3dE6gH.js").write_bytes(SCRIPT)
    (tmp_path / "assets" / "main-Ab3dE6gH.js.br").write_bytes(b"brotli")
    (tmp_path / "worker.js").write_bytes(SCRIPT)
    (tmp_path / "fr-Ab3dE6gH.ftl").write_text("land = Atterrir à la verticale\n" * 100, encoding="utf-8")
    (tmp_path / "icon.png").write_bytes(b"\x89PNG")
    rig.page = Page.load(tmp_path)
    return rig


async def test_the_index_is_at_the_root_and_asked_for_again(built: Rig) -> None:
    server = await built.start()
    async with browser() as session:
        for path in ("/", "/index.html"):
            async with session.get(server.make_url(path)) as response:
                assert response.status == 200
                assert response.content_type == "text/html"
                assert response.headers["Cache-Control"] == "no-cache"
                assert "<title>hawk" in await response.text()


async def test_what_is_named_by_its_content_is_kept_for_good(built: Rig) -> None:
    server = await built.start()
    async with browser() as session:
        async with session.get(server.make_url("/assets/main-Ab3dE6gH.js")) as response:
            assert "immutable" in response.headers["Cache-Control"]
            assert response.content_type == "text/javascript"
        async with session.get(server.make_url("/worker.js")) as response:
            assert response.headers["Cache-Control"] == "no-cache"


async def test_messages_of_a_language_are_text_and_compressed(built: Rig) -> None:
    server = await built.start()
    async with browser() as session, session.get(server.make_url("/fr-Ab3dE6gH.ftl")) as response:
        assert response.headers["Content-Type"] == "text/plain; charset=utf-8"
        assert response.headers["Content-Encoding"] == "gzip"
        assert "immutable" in response.headers["Cache-Control"]
        assert "Atterrir à la verticale" in await response.text()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("accepted", "encoding"),
    [
        ("br, gzip", "br"),
        ("gzip", "gzip"),
        ("gzip, br;q=0", "gzip"),
        ("br;q=0.5", "br"),
        ("identity", None),
        ("deflate", None),
    ],
)
async def test_the_best_encoding_that_the_browser_takes(built: Rig, accepted: str, encoding: str | None) -> None:
    server = await built.start()
    async with browser(auto_decompress=False) as session:
        url = server.make_url("/assets/main-Ab3dE6gH.js")
        async with session.get(url, headers={"Accept-Encoding": accepted}) as response:
            assert response.headers.get("Content-Encoding") == encoding
            assert response.headers["Vary"] == "Accept-Encoding"
            body = await response.read()
    assert body == {"br": b"brotli", "gzip": body, None: SCRIPT}[encoding]
    if encoding == "gzip":
        assert gzip.decompress(body) == SCRIPT


async def test_pictures_are_not_compressed_again(built: Rig) -> None:
    server = await built.start()
    async with browser() as session, session.get(server.make_url("/icon.png")) as response:
        assert "Content-Encoding" not in response.headers
        assert response.content_type == "image/png"


async def test_304_for_what_the_browser_has(built: Rig) -> None:
    server = await built.start()
    async with browser() as session:
        async with session.get(server.make_url("/worker.js")) as response:
            etag = response.headers["ETag"]
        for sent, status in ((etag, 304), (f'W/"x", {etag}', 304), ('"other"', 200)):
            async with session.get(server.make_url("/worker.js"), headers={"If-None-Match": sent}) as response:
                assert response.status == status


@pytest.mark.parametrize(
    "path",
    [
        "/nothing.js",
        "/assets",
        "/../pyproject.toml",
        "/%2e%2e/app.py",
        "/assets/..%2findex.html",
        "//etc/passwd",
        "/main-Ab3dE6gH.js.br",
    ],
)
async def test_nothing_but_the_page_is_served(built: Rig, path: str) -> None:
    server = await built.start()
    async with browser() as session, session.get(f"http://127.0.0.1:{server.port}{path}") as response:
        assert response.status == 404


async def test_a_page_that_was_not_built_says_how(rig: Rig, tmp_path: Path) -> None:
    rig.page = Page.load(tmp_path)
    assert not rig.page.is_built
    server = await rig.start()
    async with browser() as session, session.get(server.make_url("/")) as response:
        assert response.status == 200
        assert "make page" in await response.text()
