"""Look-up of receivers: an address in a private network is refused unless the settings allow it.

The address that was checked is the one that is connected to, so that a name cannot change in between.
"""

from __future__ import annotations

import ipaddress
import socket
import unicodedata
from typing import Final
from urllib.parse import urlsplit

from aiohttp.abc import AbstractResolver, ResolveResult
from aiohttp.resolver import ThreadedResolver

ALLOW: Final = "set webhooks.allow_private = true when that is meant"


class PrivateAddressError(OSError):
    """An address in a private network; the text names it and the setting that allows it."""


_NAT64: Final = ipaddress.ip_network("64:ff9b::/96")
"""Addresses that a translator makes of IPv4 ones (RFC 6052, 2.1)."""
_INNER: Final = (
    ipaddress.ip_network("64:ff9b:1::/48"),
    ipaddress.ip_network("2001::/32"),
    ipaddress.ip_network("::/96"),
)
"""Translation within a network (RFC 8215), Teredo (RFC 4380), and IPv4-compatible addresses (RFC 4291, 2.5.5.1): where
they lead is known to that network alone."""


def is_public(host: str) -> bool:
    """Return True for an address that belongs to the public Internet; False for text that is no address.

    Of an IPv6 address that stands for an IPv4 one, that one counts, too.
    """
    try:
        address = ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        return False
    if isinstance(address, ipaddress.IPv4Address):
        return _is_global(address)
    if any(address in network for network in _INNER):
        return False
    inner = address.ipv4_mapped or address.sixtofour
    if address in _NAT64:
        inner = ipaddress.IPv4Address(int(address) & 0xFFFFFFFF)
    return _is_global(inner or address)


def _is_global(address: ipaddress.IPv4Address | ipaddress.IPv6Address) -> bool:
    return address.is_global and not address.is_multicast


def check_literal(url: str) -> None:
    """Refuse a URL whose host is an address that is not public: such a host is never looked up.

    Full-width digits and other full stops are those of an address, too (IDNA, RFC 3490, 3.1).

    Raises PrivateAddressError.
    """
    host = unicodedata.normalize("NFKC", urlsplit(url).hostname or "").replace("\N{IDEOGRAPHIC FULL STOP}", ".")
    try:
        ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        return
    if not is_public(host):
        raise PrivateAddressError(f"{host} is in a private network; {ALLOW}")


class PublicResolver(AbstractResolver):
    """Finds public addresses alone."""

    def __init__(self, inner: AbstractResolver | None = None) -> None:
        self._inner = inner or ThreadedResolver()

    async def resolve(
        self, host: str, port: int = 0, family: socket.AddressFamily = socket.AF_INET
    ) -> list[ResolveResult]:
        """Return the public addresses of a host. Raises PrivateAddressError where it has none."""
        found = await self._inner.resolve(host, port, family)
        public = [each for each in found if is_public(each["host"])]
        if found and not public:
            raise PrivateAddressError(f"{host} is in a private network ({found[0]['host']}); {ALLOW}")
        return public

    async def close(self) -> None:
        """Release the look-up."""
        await self._inner.close()
