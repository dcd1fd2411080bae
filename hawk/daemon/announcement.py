"""The words of a daemon whose page is up: its address, and the file for the program that started it."""

from __future__ import annotations

import json
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from hawk.runtime.files import shown_address
from hawk.runtime.process import started_s


@dataclass(frozen=True, slots=True)
class PageShown:
    """The page as the web server serves it. ``fingerprint``: SHA-256 of its certificate; None without HTTPS."""

    url: str
    page_url: str
    asks_for_token: bool
    fingerprint: str | None


def announcement(page: PageShown, folder: Path, *, is_simulation: bool) -> list[str]:
    """Return the lines for standard output. ``folder``: the store, where the token is kept."""
    address = shown_address(page.url, page.page_url, folder, on_terminal=sys.stdout.isatty())
    lines = [f"hawk: open {address}{'  (SIMULATION)' if is_simulation else ''}"]
    if page.asks_for_token and page.page_url == page.url:
        lines.append("hawk: log in with the token of a role; hawk-drone tokens rotate operator makes another")
    if page.fingerprint is not None:
        lines.append(f"hawk: certificate SHA-256 {page.fingerprint}")
    return lines


def write_ready_file(file: Path, url: str, first_tick_s: float | None) -> None:
    """Write where the page is, and when the first tick was (seconds after the start of the process), as JSON."""
    partial = file.with_suffix(".partial")
    partial.write_text(json.dumps({"url": url, "first_tick_s": first_tick_s}))
    partial.rename(file)


def seconds_since_process_start() -> float:
    """Return real seconds since the kernel started this process."""
    return time.clock_gettime(time.CLOCK_BOOTTIME) - started_s(os.getpid())
