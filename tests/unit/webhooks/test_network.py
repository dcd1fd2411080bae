from __future__ import annotations

import socket

import pytest
from aiohttp.abc import AbstractResolver, ResolveResult

from hawk.webhooks.network import PrivateAddressError, PublicResolver, check_literal, is_public


@pytest.mark.parametrize(
    "host",
    ["127.0.0.1", "10.1.2.3", "192.168.1.1", "172.16.0.1", "169.254.169.254", "0.0.0.0", "100.64.0.1", "224.0.0.1",
     "::1", "fe80::1", "fe80::1%eth0", "fd00::1", "ff02::1", "::ffff:10.0.0.1", "2002:7f00:1::", "no address",
     "64:ff9b::10.0.0.1", "64:ff9b::7f00:1", "64:ff9b:1::5db8:d822", "64:ff9b:1:a00:0:100::", "2001:0:4136:e378::1",
     "::10.0.0.1", "::93.184.216.34"],
)  # fmt: skip
def test_what_is_not_of_the_public_internet_is_private(host: str) -> None:
    assert not is_public(host)


@pytest.mark.parametrize(
    "host",
    [
        "93.184.216.34",
        "2606:2800:220:1:248:1893:25c8:1946",
        "::ffff:93.184.216.34",
        "64:ff9b::93.184.216.34",
        "2002:5db8:d822::1",
    ],
)
def test_other_addresses_are_public(host: str) -> None:
    assert is_public(host)


@pytest.mark.parametrize(
    "url",
    ["http://127.0.0.1/x", "https://[::1]:8443/", "http://me:pass@10.0.0.1/",
     "http://\N{FULLWIDTH DIGIT ONE}\N{FULLWIDTH DIGIT ZERO}.0.0.1/", "http://10\N{IDEOGRAPHIC FULL STOP}0.0.1/",
     "http://10\N{HALFWIDTH IDEOGRAPHIC FULL STOP}0.0.1/"],
)  # fmt: skip
def test_an_address_in_a_url_is_refused_with_the_setting_that_allows_it(url: str) -> None:
    with pytest.raises(PrivateAddressError, match=r"is in a private network; set webhooks.allow_private = true"):
        check_literal(url)


@pytest.mark.parametrize("url", ["https://example.org/", "https://93.184.216.34/x"])
def test_names_and_public_addresses_pass(url: str) -> None:
    check_literal(url)


class Names(AbstractResolver):
    def __init__(self, *hosts: str) -> None:
        self.hosts = hosts
        self.is_closed = False

    async def resolve(
        self, host: str, port: int = 0, family: socket.AddressFamily = socket.AF_INET
    ) -> list[ResolveResult]:
        return [
            ResolveResult(hostname=host, host=each, port=port, family=family, proto=0, flags=0) for each in self.hosts
        ]

    async def close(self) -> None:
        self.is_closed = True


async def test_of_a_name_s_addresses_the_public_ones_alone_are_used() -> None:
    names = Names("10.0.0.1", "93.184.216.34")
    resolver = PublicResolver(names)
    assert [each["host"] for each in await resolver.resolve("example.org", 443)] == ["93.184.216.34"]
    await resolver.close()
    assert names.is_closed


async def test_a_name_of_a_private_network_is_refused() -> None:
    with pytest.raises(PrivateAddressError, match=r"rebound.example is in a private network \(127.0.0.1\)"):
        await PublicResolver(Names("127.0.0.1", "::1")).resolve("rebound.example")


async def test_a_name_without_addresses_has_none() -> None:
    assert await PublicResolver(Names()).resolve("nowhere.example") == []
