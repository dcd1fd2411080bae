"""Files of the built page and of the documentation, as they are served."""

from __future__ import annotations

import gzip
import hashlib
import mimetypes
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from aiohttp import hdrs, web

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
