"""Rasters on other computers: they come from hosts that a person allows by name, and from no other one.

GDAL asks for them through a door in this process, a proxy on the loopback that opens connections to allowed hosts
alone: a redirect, a file that a VRT names, and S3's own questions for keys pass it, too. TLS goes from GDAL to the
host.
"""

from __future__ import annotations

import contextlib
import http.client
import re
import select
import socket
import socketserver
import ssl
import threading
import urllib.error
import urllib.request
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from email.utils import parsedate_to_datetime
from pathlib import PurePosixPath
from typing import Any, Final, NoReturn
from urllib.parse import unquote, urlsplit

from hawk.formats.kind import HEAD_BYTES, Kind, kind_of

CURL: Final = "/vsicurl/"
S3: Final = "/vsis3/"
_SCHEMES: Final = ("http://", "https://")
_PORTS: Final = {"http": 80, "https": 443}
_ENDINGS: Final = (".tif", ".tiff", ".jp2", ".jpg", ".jpeg", ".png")
"""Of rasters that a VRT names; GDAL asks for no other file, as one beside a raster."""
TIMEOUT_S: Final = 20
"""Seconds without an answer."""
_MOST_HEAD: Final = 65_536
_AT_ONCE: Final = 8
_SECRETS: Final = re.compile(r"(?<=://)[^/@\s]*@|\?[^\s'\"<>)]*")


class RemoteError(ValueError):
    """A raster is not read; the text says why behind its name, with the remedy."""


@dataclass(frozen=True, slots=True)
class AllowedHost:
    """A host that may be asked. ``port``: None for those of HTTP and HTTPS."""

    name: str
    port: int | None = None

    def fits(self, name: str, port: int) -> bool:
        """Return whether a host's name (any case) and port are meant."""
        same = self.name.lower().rstrip(".") == name.lower().rstrip(".")
        return same and (port in _PORTS.values() if self.port is None else port == self.port)


Hosts = tuple[AllowedHost, ...]


@dataclass(frozen=True, slots=True)
class RemoteRaster:
    """A raster of a server (HTTP, HTTPS) or of S3. Its text, name and URI lack user, password and query of the address.

    ``gdal_name``: as GDAL has it, with its secrets.
    """

    gdal_name: str = field(repr=False)

    @classmethod
    def of(cls, text: str) -> RemoteRaster | None:
        """Return that of ``https://…``, ``s3://…`` or GDAL's name of them; None for other text.

        Raises RemoteError for one without host or file, or with user and password in it.
        """
        scheme, slashes, rest = text.partition("://")
        text = f"{scheme.lower()}{slashes}{rest}" if slashes else text
        name = S3 + text.removeprefix("s3://") if text.startswith("s3://") else text
        if text.startswith(_SCHEMES):
            name = CURL + text
        if not name.startswith((S3, *(CURL + scheme for scheme in _SCHEMES))):
            return None
        made = cls(name)
        if any(letter.isspace() or letter in ",\\" or not letter.isprintable() for letter in name):
            raise RemoteError("has a space, comma or backslash in its address: write %20, %2C or %5C in its place")
        if name.startswith(S3):
            bucket, _, key = name.removeprefix(S3).partition("/")
            if not bucket or not key:
                raise RemoteError("names no bucket and file: write s3://BUCKET/FILE.tif")
            return made
        made.place()
        if "@" in urlsplit(made.url).netloc:
            raise RemoteError("has a user or password in its address: leave them out, and sign the address instead")
        return made

    @property
    def is_s3(self) -> bool:
        """True for one of S3."""
        return self.gdal_name.startswith(S3)

    @property
    def url(self) -> str:
        """Address with its secrets; that of S3 is ``s3://…``."""
        return f"s3://{self.gdal_name.removeprefix(S3)}" if self.is_s3 else self.gdal_name.removeprefix(CURL)

    def place(self) -> tuple[str, int]:
        """Return host and port of one that is not of S3. Raises RemoteError."""
        try:
            parts = urlsplit(self.url)
            host, port = parts.hostname, _PORTS[parts.scheme] if parts.port is None else parts.port
        except ValueError:  # its text may hold the address, whose cause is not kept
            host, port = None, 0
        if not host or not port or not PurePosixPath(parts.path).name:
            raise RemoteError("names no host and file: write https://HOST/FILE.tif")
        return host, port

    def __str__(self) -> str:
        return without_secrets(self.url)

    @property
    def name(self) -> str:
        """Last part of the address."""
        return unquote(PurePosixPath(urlsplit(self.url).path).name)

    @property
    def stem(self) -> str:
        """Name without its ending."""
        return PurePosixPath(self.name).stem


@dataclass(frozen=True, slots=True)
class RemoteFacts:
    """Answer of a server about a raster: its kind, bytes in all, ETag or time of change as text ("" without).

    ``modified``: that time, seconds since 1970; None without.
    """

    kind: Kind
    size: int
    version: str
    modified: float | None = None


def without_secrets(text: str) -> str:
    """Return a text whose addresses lack user, password and query."""
    return _SECRETS.sub("", text)


def check_part(name: str, hosts: Hosts) -> RemoteRaster | None:
    """Return the raster that an element of a VRT names, None for what is no such name. Raises RemoteError."""
    part = RemoteRaster.of(name) if name.startswith((CURL, S3)) else None
    if part is None or part.is_s3:
        return part if part is None or part.gdal_name.lower().endswith(_ENDINGS) else _no_ending()
    host, port = part.place()
    if not any(allowed.fits(host, port) for allowed in hosts):
        raise RemoteError(_closed([f"{host}:{port}"]))
    return part if part.gdal_name.lower().endswith(_ENDINGS) else _no_ending()


def _no_ending() -> NoReturn:
    raise RemoteError(f"the address does not end in one of {' '.join(_ENDINGS)}: name such rasters without a query")


def _closed(places: Iterable[str]) -> str:
    names = list(dict.fromkeys(place.removesuffix(":443").removesuffix(":80") for place in places))
    return f"asks {', '.join(names)}, which is not allowed: add --allow-host {names[0]} if you trust it"


class Door:
    """An open proxy. ``address``: its URL; ``refused``: places (``HOST:PORT``) that were asked for in vain."""

    def __init__(self, server: _Server) -> None:
        self.address = f"http://127.0.0.1:{server.server_address[1]}"
        self.refused = server.refused

    def check(self) -> None:
        """Raise RemoteError where a host was asked for that is not allowed."""
        if self.refused:
            raise RemoteError(_closed(self.refused))

    def options(self, raster: RemoteRaster | None) -> dict[str, str]:
        """Return GDAL's settings for one raster, or for those that a VRT names.

        Nothing is listed or guessed (https://gdal.org/en/stable/user/configoptions.html).
        """
        endings = ",".join(_ENDINGS) if raster is None else raster.gdal_name.partition("?")[0].rpartition("/")[2]
        return {
            "GDAL_HTTP_PROXY": self.address,
            "GDAL_HTTPS_PROXY": self.address,
            "CPL_VSIL_CURL_ALLOWED_EXTENSIONS": endings,
            "GDAL_DISABLE_READDIR_ON_OPEN": "EMPTY_DIR",
            "GDAL_HTTP_CONNECTTIMEOUT": str(TIMEOUT_S),
            "GDAL_HTTP_LOW_SPEED_TIME": str(TIMEOUT_S),
            "GDAL_HTTP_LOW_SPEED_LIMIT": "1000",
            "GDAL_HTTP_MAX_RETRY": "3",
            "GDAL_HTTP_RETRY_DELAY": "1",
            "GDAL_HTTP_NETRC": "NO",
            "GDAL_HTTP_UNSAFESSL": "NO",
        }


@contextlib.contextmanager
def door(hosts: Hosts) -> Iterator[Door]:
    """Open a door to hosts, until the block ends."""
    with _Server(hosts) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.02,), name="hawk-door", daemon=True)
        thread.start()
        try:
            yield Door(server)
        finally:
            server.shutdown()
            thread.join()
            server.end_all()


class _Server(socketserver.ThreadingTCPServer):
    daemon_threads = True
    block_on_close = False

    def __init__(self, hosts: Hosts) -> None:
        self.hosts = hosts
        self.refused: list[str] = []
        self._open: set[socket.socket] = set()
        super().__init__(("127.0.0.1", 0), _Passage)

    @contextlib.contextmanager
    def ended(self, one: socket.socket) -> Iterator[None]:
        """End a connection with the block, or with the server."""
        self._open.add(one)
        try:
            yield
        finally:
            self._open.discard(one)
            one.close()

    def end_all(self) -> None:
        for each in tuple(self._open):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing: GDAL says that its connection has ended."""


class _Passage(socketserver.BaseRequestHandler):
    """One connection: a tunnel, or one request of HTTP."""

    server: _Server

    def handle(self) -> None:
        client: socket.socket = self.request
        client.settimeout(TIMEOUT_S)
        head, rest = _head(client)
        method, target, _ = head.split(b"\r\n", 1)[0].decode("ascii").split(" ")
        is_tunnel = method == "CONNECT"
        parts = urlsplit(f"//{target}" if is_tunnel else target)
        host, port = parts.hostname or "", parts.port or 80
        if not any(allowed.fits(host, port) for allowed in self.server.hosts):
            self.server.refused.append(f"{host}:{port}")
            return client.sendall(_answer("403 Forbidden"))
        if not is_tunnel and (parts.scheme != "http" or method not in ("GET", "HEAD")):
            return client.sendall(_answer("405 Method Not Allowed"))
        try:
            host_side = socket.create_connection((host, port), TIMEOUT_S)
        except OSError:
            return client.sendall(_answer("502 Bad Gateway"))
        with self.server.ended(client), self.server.ended(host_side):
            if is_tunnel:
                client.sendall(b"HTTP/1.1 200 Connection established\r\n\r\n")
                host_side.sendall(rest)
            else:
                host_side.sendall(_own_request(method, target, head))
            _pass_on(client, host_side, both=is_tunnel)
        return None


def _head(client: socket.socket) -> tuple[bytes, bytes]:
    """Return a request's head, and what came behind it. Raises OSError."""
    read = b""
    while b"\r\n\r\n" not in read:
        more = client.recv(_MOST_HEAD)
        if not more or len(read) > _MOST_HEAD:
            raise ConnectionError("no request")
        read += more
    head, _, rest = read.partition(b"\r\n\r\n")
    return head, rest


def _own_request(method: str, target: str, head: bytes) -> bytes:
    """Return a request to a proxy as its host takes it; the connection ends with the answer: it serves one host."""
    parts = urlsplit(target)
    path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    lines = [each for each in head.split(b"\r\n")[1:] if not each.lower().startswith((b"proxy-", b"connection:"))]
    return b"\r\n".join([f"{method} {path} HTTP/1.1".encode(), *lines, b"Connection: close", b"", b""])


def _answer(status: str) -> bytes:
    return f"HTTP/1.1 {status}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n".encode()


def _pass_on(client: socket.socket, host_side: socket.socket, *, both: bool) -> None:
    """Pass bytes on until a side ends or is silent; without ``both`` nothing more goes to the host."""
    others = {client: host_side, host_side: client}
    while True:
        ready, _, _ = select.select(list(others), [], [], 3 * TIMEOUT_S)
        if not ready or (client in ready and not both):
            return
        for side in ready:
            data = side.recv(_MOST_HEAD)
            if not data:
                return
            others[side].sendall(data)


def facts_of(rasters: Iterable[RemoteRaster], hosts: Hosts) -> dict[RemoteRaster, RemoteFacts]:
    """Ask for the first bytes of rasters, but for S3's, whose requests GDAL signs. Raises RemoteError."""
    asked = [each for each in rasters if not each.is_s3]
    if not asked:
        return {}
    with door(hosts) as opened, ThreadPoolExecutor(_AT_ONCE) as pool:
        try:
            return dict(zip(asked, pool.map(lambda each: _facts(each, opened), asked), strict=True))
        except (urllib.error.URLError, http.client.HTTPException, OSError) as error:
            opened.check()
            raise RemoteError(_reason(error)) from None  # the chain would print the address


def _facts(raster: RemoteRaster, opened: Door) -> RemoteFacts:
    proxies = dict.fromkeys(_PORTS, opened.address)
    opener = urllib.request.OpenerDirector()
    for handler in (
        urllib.request.ProxyHandler(proxies), urllib.request.HTTPHandler(), urllib.request.HTTPDefaultErrorHandler(),
        urllib.request.HTTPSHandler(context=ssl.create_default_context()), urllib.request.HTTPRedirectHandler(),
        urllib.request.HTTPErrorProcessor(),
    ):  # fmt: skip
        opener.add_handler(handler)
    headers = {"Range": f"bytes=0-{HEAD_BYTES - 1}", "User-Agent": "hawk-drone"}
    request = urllib.request.Request(raster.url, headers=headers)  # noqa: S310 only http and https are named
    try:
        with opener.open(request, timeout=TIMEOUT_S) as answer:
            found = re.fullmatch(r"bytes 0-(\d+)/(\d+)", answer.headers.get("Content-Range", ""))
            if answer.status != 206 or found is None:
                raise RemoteError(f"{raster}: the server gives no parts of files (HTTP ranges): copy the picture here")
            head = answer.read(HEAD_BYTES)
            if len(head) != min(int(found[1]) + 1, HEAD_BYTES):
                raise http.client.IncompleteRead(head)
            version = answer.headers.get("ETag") or answer.headers.get("Last-Modified") or ""
    except urllib.error.HTTPError as error:
        error.close()
        raise
    modified = None
    with contextlib.suppress(ValueError, TypeError):
        modified = parsedate_to_datetime(answer.headers.get("Last-Modified")).timestamp()
    return RemoteFacts(kind_of(head), int(found[2]), version, modified)


def _reason(error: Exception) -> str:
    cause = error.reason if isinstance(error, urllib.error.URLError) else error
    if isinstance(error, urllib.error.HTTPError):
        return f"the server answers {error.code} ({error.reason}): check the address, and whether it has ended"
    if isinstance(cause, TimeoutError):
        return f"the server has not answered within {TIMEOUT_S} s: try again later, or copy the picture here"
    if isinstance(cause, http.client.IncompleteRead):
        return "the server's answer is cut off: try again later, or copy the picture here"
    return f"the server cannot be reached ({without_secrets(str(cause))[:160]}): check host, port and network"
