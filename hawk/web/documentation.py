"""Built files as answers, and the documentation under ``/docs/``: a site that works offline.

The names of its files are read at the start, and a request finds its file among them, so that no request leaves the
folder. The files are read when they are asked for, on a thread of their own: the site costs the flight no memory.
"""

from __future__ import annotations

import asyncio
import gzip
import hashlib
import mimetypes
import re
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from aiohttp import hdrs, web

from hawk.web.access.proxied import is_secure, place, prefix_of

WORTH_COMPRESSING: Final = re.compile(r"text/.*|application/(javascript|json|manifest\+json)|image/svg\+xml")
HASHED: Final = re.compile(r"[-.][A-Za-z0-9_-]{8,}\.\w+$")
"""Bundlers name files by their content, so such a file never changes."""
FOR_GOOD: Final = "public, max-age=31536000, immutable"
ASK_AGAIN: Final = "no-cache"


@dataclass(frozen=True, slots=True)
class Asset:
    """A file in each of its encodings ("identity", "gzip", "br")."""

    content_type: str
    etag: str
    caching: str
    encodings: dict[str, bytes] = field(repr=False)

    def response(self, request: web.Request) -> web.Response:
        """Return the answer to a request: 304 when the browser has the file."""
        headers = {hdrs.ETAG: self.etag, hdrs.VARY: hdrs.ACCEPT_ENCODING, hdrs.CACHE_CONTROL: self.caching}
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


def content_type_of(name: str) -> str:
    """Return the content type of a file by its name, with the character set of texts."""
    kind, _ = mimetypes.guess_type(name)
    suffix = Path(name).suffix
    kinds = {".js": "text/javascript", ".mjs": "text/javascript", ".map": "application/json", ".ftl": "text/plain"}
    kind = kinds.get(suffix, kind) or "application/octet-stream"
    return f"{kind}; charset=utf-8" if kind.startswith("text/") else kind


def etag_of(body: bytes) -> str:
    """Return the ETag of a content."""
    return f'"{hashlib.sha256(body).hexdigest()[:32]}"'


def page_asset(path: Path) -> Asset:
    """Read a file of the built page, and its Brotli form beside it where there is one."""
    compressed = path.with_name(path.name + ".br")
    br = compressed.read_bytes() if compressed.is_file() else None
    is_for_good = HASHED.search(path.name) is not None
    return make_asset(content_type_of(path.name), path.read_bytes(), immutable=is_for_good, br=br)


def make_asset(content_type: str, body: bytes, *, immutable: bool = False, br: bytes | None = None) -> Asset:
    """Return an asset with its encodings. ``immutable``: its name changes with its content."""
    encodings = {"identity": body}
    if WORTH_COMPRESSING.match(content_type):
        encodings["gzip"] = gzip.compress(body, 9, mtime=0)
        if br is not None:
            encodings["br"] = br
    return Asset(content_type, etag_of(body), FOR_GOOD if immutable else ASK_AGAIN, encodings)


DOCS_DIRECTORY: Final = Path(__file__).parent / "docs_site"
PREFIX: Final = "/docs/"
INDEX: Final = "index.html"
NOT_BUILT: Final = (
    "The documentation is not built. Build it with: make docs (or python packaging/docs_site.py), then start again. "
    "The same pages are Markdown files in the folder docs of the source."
)
PRIVATE_FOR_GOOD: Final = "private, max-age=31536000, immutable"
NOTHING_HERE: Final = "There is no page at this address: /docs/ is the first page of the documentation."
_READER = web.AppKey("documentation_reader", ThreadPoolExecutor)


class Documentation:
    """The files of the site by their address below ``/docs/``."""

    def __init__(self, files: dict[str, Path]) -> None:
        self._files = files

    @classmethod
    def load(cls, directory: Path = DOCS_DIRECTORY) -> Documentation:
        """List the files of the site; none where it was not built."""
        found = (path for path in directory.rglob("*") if path.suffix != ".gz" and path.is_file())
        return cls({path.relative_to(directory).as_posix(): path for path in found if not path.name.startswith(".")})

    @property
    def is_built(self) -> bool:
        """True when there is a first page."""
        return INDEX in self._files

    def add_routes(self, app: web.Application) -> None:
        """Add the routes of the site, and the thread that reads its files."""
        app.cleanup_ctx.append(_reader)
        app.router.add_get("/docs", to_first_page)
        app.router.add_get("/docs/{path:.*}", self.handle)

    async def handle(self, request: web.Request) -> web.StreamResponse:
        """Serve a file of the site; 404 with the remedy where it was not built."""
        name = request.match_info["path"] or INDEX
        path = self._files.get(name)
        if path is None:
            raise web.HTTPNotFound(text=NOTHING_HERE if self.is_built else NOT_BUILT, headers=_headers(request))
        # the site's own pages ask for a script or style with a checksum of its content
        caching = PRIVATE_FOR_GOOD if name.startswith("_static/") and "v" in request.query else ASK_AGAIN
        asset = await asyncio.get_running_loop().run_in_executor(request.app[_READER], read_asset, path, caching)
        if asset is None:
            raise web.HTTPNotFound(text=NOT_BUILT, headers=_headers(request))
        response = asset.response(request)
        response.headers.update(_headers(request))
        return response


async def to_first_page(request: web.Request) -> web.StreamResponse:
    """Redirect to the folder: the links of its pages are relative."""
    return web.Response(status=308, headers={hdrs.LOCATION: place(request, PREFIX)})


def read_asset(path: Path, caching: str) -> Asset | None:
    """Return a file with its gzip form beside it; None when it cannot be read any more."""
    compressed = path.with_name(f"{path.name}.gz")
    try:
        encodings = {"identity": path.read_bytes()}
        if compressed.is_file():
            encodings["gzip"] = compressed.read_bytes()
    except OSError:
        return None
    return Asset(content_type_of(path.name), etag_of(encodings["identity"]), caching, encodings)


def _headers(request: web.Request) -> dict[str, str]:
    """Return the policy of these pages: their own files and nothing else, so that none of them reaches the drone."""
    scheme = "https" if is_secure(request) else "http"
    site = f"{scheme}://{request.headers[hdrs.HOST]}{prefix_of(request)}{PREFIX}"
    return {
        "Content-Security-Policy": f"default-src 'none'; script-src {site}; style-src {site}; img-src {site} data:; "
        f"connect-src {site}; form-action {site}; base-uri 'none'; frame-ancestors 'none'"
    }


async def _reader(app: web.Application) -> AsyncIterator[None]:
    with ThreadPoolExecutor(1, thread_name_prefix="documentation") as executor:
        app[_READER] = executor
        yield
