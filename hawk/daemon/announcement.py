"""The page of a program that serves it, once it is up: its address, and the file for the program that started it."""

from __future__ import annotations

import json
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self

from hawk.config.sections import ConfigError, WebSettings
from hawk.daemon.start_checks import listening_problem
from hawk.runtime.files import write_private
from hawk.runtime.process import started_s
from hawk.web.access.tls import Tls
from hawk.web.app import WebServer

ADDRESS_FILE: Final = "page-address"


@dataclass(frozen=True, slots=True)
class PageShown:
    """The page as the web server serves it. ``fingerprint``: SHA-256 of its certificate; None without HTTPS."""

    url: str
    page_url: str
    asks_for_token: bool
    fingerprint: str | None

    @classmethod
    def of(cls, server: WebServer, tls: Tls | None) -> Self:
        """Return the page of a server that has started."""
        fingerprint = None if tls is None else tls.fingerprint
        return cls(server.url, server.page_url, server.asks_for_token, fingerprint)


async def serve(server: WebServer, web: WebSettings) -> None:
    """Serve the page. Raises ConfigError naming the setting at which the system takes offence."""
    try:
        await server.start()
    except OSError as error:
        raise ConfigError(listening_problem(error, web)) from error


def announcement(page: PageShown, folder: Path, *, is_simulation: bool, survey: str = "") -> list[str]:
    """Return the lines for standard output.

    ``folder``: the store, where the token is kept. ``survey``: place below the page's address of the survey to look at,
    "" for none.
    """
    address = shown_address(page.url, page.page_url, folder, on_terminal=sys.stdout.isatty())
    lines = [f"hawk: open {address}{'  (SIMULATION)' if is_simulation else ''}"]
    if page.asks_for_token and page.page_url == page.url:
        lines.append("hawk: log in with the token of a role; hawk-drone tokens rotate operator makes another")
    if page.fingerprint is not None:
        lines.append(f"hawk: certificate SHA-256 {page.fingerprint}")
    if survey:
        lines.append(f"hawk: the survey, with its stalls and counts: {page.url.rstrip('/')}/{survey}")
    return lines


def shown_address(url: str, page_url: str, folder: Path, *, on_terminal: bool) -> str:
    """Return what may be printed for the one who opens the page.

    An address with the token goes to a terminal, or into a file that only this user may read: a journal keeps what is
    printed, and others may read it.
    """
    if page_url == url or on_terminal:
        return page_url
    path = folder / ADDRESS_FILE
    try:
        write_private(path, f"{page_url}\n".encode())
    except OSError as error:
        return f"{url} with ?token= and web.token; {path} cannot be written: {error}"
    return f"the address in {path} ({url} with the token)"


def write_ready_file(file: Path, url: str, first_tick_s: float | None) -> None:
    """Write where the page is, and when the first tick was (seconds after the start of the process), as JSON."""
    partial = file.with_suffix(".partial")
    partial.write_text(json.dumps({"url": url, "first_tick_s": first_tick_s}))
    partial.rename(file)


def seconds_since_process_start() -> float:
    """Return real seconds since the kernel started this process."""
    return time.clock_gettime(time.CLOCK_BOOTTIME) - started_s(os.getpid())
