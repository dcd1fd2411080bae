"""The built page, served from memory: nothing is read while the drone flies, and no file name comes from a request."""

from __future__ import annotations

import gzip
import hashlib
import mimetypes
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from aiohttp import hdrs, web

PAGE_DIRECTORY: Final = Path(__file__).parent / "static"
INDEX: Final = "index.html"
WORTH_COMPRESSING: Final = re.compile(r"text/.*|application/(javascript|json|manifest\+json)|image/svg\+xml")
HASHED: Final = re.compile(r"[-.][A-Za-z0-9_-]{8,}\.\w+$")
"""Bundlers name files by their content: such a name never means anything else."""

NOT_BUILT: Final = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>hawk: the page is not built</title>
<h1>The page is not built</h1>
<p>The drone's server runs, but this checkout has no operator page yet. Build it with</p>
<pre>make page</pre>
<p>or <code>python packaging/build_page.py</code>, then start again. The picture is at
<a href="/stream.mjpg">/stream.mjpg</a>, the messages are described at
<a href="/api/schema.json">/api/schema.json</a>.</p></html>
"""


@dataclass(frozen=True, slots=True)
class Asset:
    """A file of the page in every encoding that it is kept in ("identity", "gzip", "br")."""

    content_type: str
    etag: str
    immutable: bool
    encodings: dict[str, bytes] = field(repr=False)

    def response(self, request: web.Request) -> web.Response:
        """Answer a request for it: 304 when the browser has it."""
        headers = {
            hdrs.ETAG: self.etag,
            hdrs.VARY: hdrs.ACCEPT_ENCODING,
            hdrs.CACHE_CONTROL: "public, max-age=31536000, immutable" if self.immutable else "no-cache",
        }
        if self.etag in request.headers.get(hdrs.IF_NONE_MATCH, ""):
            return web.Response(status=304, headers=headers)
        encoding = self._choose(request.headers.get(hdrs.ACCEPT_ENCODING, ""))
        if encoding != "identity":
            headers[hdrs.CONTENT_ENCODING] = encoding
        headers[hdrs.CONTENT_TYPE] = self.content_type
        return web.Response(body=self.encodings[encoding], headers=headers)

    def _choose(self, accepted: str) -> str:
        for encoding in ("br", "gzip"):
            if encoding in self.encodings and re.search(rf"\b{encoding}\b(?!\s*;\s*q=0(\.0*)?\s*(,|$))", accepted):
                return encoding
        return "identity"


class Page:
    """All files of the built page by path."""

    def __init__(self, assets: dict[str, Asset]) -> None:
        self._assets = assets

    @classmethod
    def load(cls, directory: Path = PAGE_DIRECTORY) -> Page:
        """Read the page (before the loop runs); a page that was not built says how to build it."""
        files = sorted(p for p in directory.rglob("*") if p.is_file() and p.suffix not in (".br", ".gz"))
        assets = {path.relative_to(directory).as_posix(): _asset(path) for path in files}
        if INDEX not in assets:
            assets = {INDEX: _make("text/html; charset=utf-8", NOT_BUILT.encode(), immutable=False, br=None)}
        return cls(assets)

    @property
    def is_built(self) -> bool:
        """Whether there is more than the note on how to build it."""
        return self._assets[INDEX].encodings["identity"] != NOT_BUILT.encode()

    async def handle(self, request: web.Request) -> web.StreamResponse:
        """Serve a file of the page."""
        asset = self._assets.get(request.match_info.get("path", "") or INDEX)
        if asset is None:
            raise web.HTTPNotFound(text="There is nothing at this address.")
        return asset.response(request)


def _asset(path: Path) -> Asset:
    kind, _ = mimetypes.guess_type(path.name)
    kind = {".js": "text/javascript", ".mjs": "text/javascript", ".map": "application/json"}.get(path.suffix, kind)
    kind = kind or "application/octet-stream"
    if kind.startswith("text/"):
        kind += "; charset=utf-8"
    compressed = path.with_name(path.name + ".br")
    br = compressed.read_bytes() if compressed.is_file() else None
    return _make(kind, path.read_bytes(), immutable=HASHED.search(path.name) is not None, br=br)


def _make(content_type: str, body: bytes, *, immutable: bool, br: bytes | None) -> Asset:
    encodings = {"identity": body}
    if WORTH_COMPRESSING.match(content_type):
        encodings["gzip"] = gzip.compress(body, 9, mtime=0)
        if br is not None:
            encodings["br"] = br
    return Asset(content_type, f'"{hashlib.sha256(body).hexdigest()[:32]}"', immutable, encodings)
