"""Checks of ports, addresses, tokens and certificate."""

from __future__ import annotations

import errno
import fcntl
import ipaddress
import socket
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

from hawk.check.result import CheckResult, failed, passed, warning
from hawk.config.sections import AutopilotSettings, Config, ConfigError, WebSettings
from hawk.runtime.programs import Kind, Processes
from hawk.web.access.tls import load_tls
from hawk.web.access.tokens import TOKEN_FILE, TokensError, read_tokens, with_configured
from hawk.web.security import InsecureBindingError, check_binding, is_loopback

_SIOCGIFADDR: Final = 0x8915
_NAME_BYTES: Final = 15
_ADDRESS: Final = slice(20, 24)  # of a struct ifreq (netdevice(7))
_SALT: Final = b"check"

Bind = Callable[[Kind, str, int], None]
"""Opens a port for a moment: kind, host, port. Raises OSError when the daemon could not open it."""


@dataclass(frozen=True, slots=True)
class NetworkTools:
    """Questions to this computer; each can be replaced in a test."""

    bind: Bind
    processes: Processes
    addresses: Callable[[], Sequence[str]]


def bind_port(kind: Kind, host: str, port: int) -> None:
    """Open every address of a host as the daemon does, and close it. Raises OSError."""
    wanted = socket.SOCK_STREAM if kind == "tcp" else socket.SOCK_DGRAM
    found = socket.getaddrinfo(host or None, port, type=wanted, flags=socket.AI_PASSIVE)
    for family, _, _, _, address in dict.fromkeys(found):
        if kind == "tcp":
            socket.create_server(address, family=family).close()
        else:
            with socket.socket(family, wanted) as opened:
                opened.bind(address)


def own_addresses(if_inet6: Path = Path("/proc/net/if_inet6")) -> list[str]:
    """Return this computer's addresses beyond loopback."""
    found = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asked:
        for _, name in socket.if_nameindex():
            request = struct.pack("256s", name.encode()[:_NAME_BYTES])
            try:
                answer = fcntl.ioctl(asked.fileno(), _SIOCGIFADDR, request)
            except OSError:  # no IPv4 address
                continue
            found.append(socket.inet_ntoa(answer[_ADDRESS]))
    try:
        lines = if_inet6.read_text().splitlines()
    except OSError:
        lines = []
    found += [str(ipaddress.IPv6Address(int(line.split()[0], 16))) for line in lines]
    plain = (ipaddress.ip_address(each) for each in found)
    return [str(each) for each in plain if not each.is_loopback and not each.is_link_local]


def page_port(web: WebSettings, tools: NetworkTools) -> CheckResult:
    """Return whether the page can be served at ``web.host`` and ``web.port``."""
    name, place = "Page's port", f"{web.host or '*'}:{web.port}"
    try:
        tools.bind("tcp", web.host, web.port)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            holder = tools.processes.holder_of_port("tcp", web.port)
            remedy = "Name a free port in web.port."
            if "hawk-drone" in holder:
                remedy = "A daemon runs already: stop it (sudo systemctl stop hawk-drone), or use its page."
            return failed(name, f"{place} is taken{f' by {holder}' if holder else ''}.", remedy)
        return failed(name, f"{place} cannot be opened: {_words(error)}.", _page_remedy(error))
    return passed(name, "Any free port is used (web.port 0)." if web.port == 0 else f"{place} is free.")


def autopilot_port(settings: AutopilotSettings, tools: NetworkTools) -> CheckResult | None:
    """Return whether the autopilot's port can be opened here; None for a URL that opens none."""
    place = urlsplit(settings.url)
    kind: Kind | None = {"udpin": "udp", "tcpin": "tcp"}.get(place.scheme)  # type: ignore[assignment]
    if kind is None:
        return None
    name = "Autopilot's port"
    try:
        host, port = place.hostname, place.port
    except ValueError:
        host, port = None, None
    if not host or not port:
        return failed(name, f"autopilot.url {settings.url} names no host and port.", "Write udpin://HOST:PORT.")
    try:
        tools.bind(kind, host, port)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            holder = tools.processes.holder_of_port(kind, port)
            remedy = "Stop that program, or let a router (mavlink-router) serve both and name another port."
            if "hawk-drone" in holder:
                remedy = "A daemon runs already: stop it before you check (sudo systemctl stop hawk-drone)."
            return failed(name, f"{host}:{port} is taken{f' by {holder}' if holder else ''}.", remedy)
        remedy = "Write an address of this computer into autopilot.url; 0.0.0.0 stands for all."
        return failed(name, f"{host}:{port} cannot be opened: {_words(error)}.", remedy)
    return passed(name, f"{host}:{port} is free.")


def address_result(web: WebSettings, tools: NetworkTools) -> CheckResult:
    """Return whether others can reach the page, where the settings want that."""
    name, found = "Network", list(tools.addresses())
    if is_loopback(web.host):
        return passed(name, f"The page is served on {web.host}: only this computer can open it.")
    if not found:
        return failed(name, "This computer has no address but loopback.", "Plug in the network, or join the Wi-Fi.")
    return passed(name, f"This computer's addresses: {', '.join(found)}.")


def token_result(config: Config) -> CheckResult:
    """Return whether the page is protected as the daemon demands at its start."""
    name, folder = "Tokens", config.store.directory
    try:
        kept = read_tokens(folder / TOKEN_FILE)
        tokens = with_configured(kept, config.web.token, _SALT)
        check_binding(config.web, tokens, folder.resolve())
    except (TokensError, InsecureBindingError) as error:
        value, _, remedy = str(error).partition("; ")
        return failed(name, f"{value}.", _sentence(remedy) or "Make one: hawk-drone tokens rotate operator.")
    people = [f"{len(tokens.people)} with a role for some lots"] if tokens.people else []
    roles = ", ".join([*(role.value for role in tokens.by_role), *people])
    return passed(name, f"There are tokens of: {roles}." if roles else "There is none; only this computer is served.")


def certificate_result(web: WebSettings, wall: float) -> CheckResult:
    """Return whether certificate and key can be used. ``wall``: seconds since 1970."""
    name = "Certificate"
    try:
        tls = load_tls(web)
    except ConfigError as error:
        return failed(name, f"{error}.", "Put that right, or make a pair: hawk-drone make-certificate.")
    if tls is not None:
        words = tls.warning(wall)
        if words:
            return warning(name, words, "Set the clock; else make another pair: hawk-drone make-certificate --replace.")
        return passed(name, f"It is valid for {tls.days_left(wall):.0f} days.")
    if is_loopback(web.host):
        return passed(name, "There is none, and none is needed on this computer alone.")
    return warning(
        name, "There is none: others on the network can read the token.", "Make one: hawk-drone make-certificate."
    )


def _page_remedy(error: OSError) -> str:
    if error.errno == errno.EACCES:
        return "Ports below 1024 belong to root: name a higher one in web.port."
    return "Write an address or name of this computer into web.host; 0.0.0.0 stands for all."


def _words(error: Any) -> str:
    return str(error.strerror or error)


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + "." if text else ""
