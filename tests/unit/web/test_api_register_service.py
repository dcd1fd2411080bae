"""BlueOS's question for a name: answered to this computer without a token, and to nobody else."""

from __future__ import annotations

import json
from typing import Any
from urllib.parse import urljoin

import aiohttp
import pytest
from aiohttp.test_utils import make_mocked_request
from pydantic import BaseModel, ConfigDict

from hawk.comm.protocol.authority import Role
from hawk.web import api
from hawk.web.api import ADDRESS, is_for_everybody_here
from tests.unit.web.rig import Rig, browser
from tests.unit.web.stand import Stand

REDIRECTS = 10
"""Redirects that BlueOS's helper follows."""


class ServiceMetadata(BaseModel):
    """Keys that BlueOS reads (core/services/helper/main.py of bluerobotics/BlueOS)."""

    model_config = ConfigDict(extra="forbid", strict=True)

    name: str
    description: str
    icon: str
    company: str
    version: str
    webpage: str
    route: str | None = None
    new_page: bool | None = None
    extra_query: str | None = None
    avoid_iframes: bool | None = None
    api: str
    sanitized_name: str | None = None
    works_in_relative_paths: bool | None = None
    extras: dict[str, str] | None = None


async def helper_asks(rig: Rig, path: str, **headers: str) -> tuple[int, str]:
    """Request as BlueOS's helper does: from 127.0.0.1, and after a Location whatever the status is."""
    assert rig.server is not None
    url = str(rig.server.make_url(path))
    async with browser(skip_auto_headers=("Accept",)) as session:
        for _ in range(REDIRECTS):
            async with session.get(url, headers=headers, allow_redirects=False) as response:
                text = await response.text()
                if "Location" not in response.headers:
                    return response.status, text
                url = urljoin(url, response.headers["Location"])
    raise AssertionError("BlueOS does not follow more than that")


@pytest.mark.parametrize("accept", [{}, {"Accept": "*/*"}])
async def test_blueos_finds_a_page_and_reads_name_and_version_without_a_token(
    stand: Stand, accept: dict[str, str]
) -> None:
    """Its helper asks for a service's name only where ``/`` leads to a page with status 200."""
    status, page = await helper_asks(stand.rig, "/", **accept)
    assert (status, "<title>" in page) == (200, True)
    status, text = await helper_asks(stand.rig, ADDRESS, Accept="application/json")
    assert status == 200
    metadata = ServiceMetadata.model_validate_json(text)
    assert (metadata.name, metadata.version) == ("Hawk", "1.2.3")


async def test_the_page_is_opened_at_its_own_port(stand: Stand) -> None:
    """In a frame, or below another path, it would not open: it forbids frames, and its addresses begin at the root."""
    _, text = await helper_asks(stand.rig, ADDRESS)
    metadata = ServiceMetadata.model_validate_json(text)
    assert (metadata.avoid_iframes, metadata.new_page, metadata.works_in_relative_paths) == (True, True, False)
    assert stand.rig.server is not None
    async with browser() as session, session.get(stand.rig.server.make_url("/login")) as response:
        assert "frame-ancestors 'none'" in response.headers["Content-Security-Policy"]


async def test_nothing_of_the_drone_is_in_it(stand: Stand) -> None:
    before = await helper_asks(stand.rig, ADDRESS)
    stand.rig.publish()
    after = await helper_asks(stand.rig, ADDRESS)
    assert before == after
    values = [value for value in json.loads(after[1]).values() if isinstance(value, str)]
    for secret in (*stand.tokens.values(), str(stand.rig.folder)):
        assert not any(secret in value for value in values)


async def test_another_computer_needs_a_token(stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(api, "is_loopback_peer", lambda host: False)
    assert await stand.status(await stand.browser(), ADDRESS) == 401
    assert await stand.status(await stand.tool(Role.VIEWER), ADDRESS) == 200


@pytest.mark.parametrize(
    ("path", "peer", "is_open"),
    [
        (ADDRESS, "127.0.0.1", True),
        (ADDRESS, "::1", True),
        (ADDRESS, "::ffff:127.0.0.1", True),
        (ADDRESS, "192.168.2.2", False),
        (ADDRESS, "172.17.0.1", False),
        (f"{ADDRESS}/", "127.0.0.1", False),
        ("/api/health", "127.0.0.1", False),
    ],
)
def test_who_is_answered_without_a_token(path: str, peer: str, is_open: bool) -> None:
    assert is_for_everybody_here(make_mocked_request("GET", path, transport=_Transport(peer))) is is_open


class _Transport:
    """The far end of a connection."""

    def __init__(self, peer: str) -> None:
        self._peer = peer

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return (self._peer, 50000) if name == "peername" else default


@pytest.mark.parametrize(
    ("method", "headers", "status"),
    [
        ("HEAD", {}, 200),
        ("POST", {}, 405),
        ("DELETE", {}, 405),
        ("POST", {"Origin": "http://elsewhere.example"}, 403),
        ("GET", {"Host": "elsewhere.example"}, 403),
    ],
)
async def test_other_methods_and_names(stand: Stand, method: str, headers: dict[str, str], status: int) -> None:
    assert stand.rig.server is not None
    url = stand.rig.server.make_url(ADDRESS)
    async with browser() as session, session.request(method, url, headers=headers) as response:
        assert response.status == status
        assert "Access-Control-Allow-Origin" not in response.headers


async def test_no_program_takes_the_login_page_for_the_page(stand: Stand) -> None:
    """The address of the login page stands beside the refusal: a program that follows redirects is still refused."""
    assert stand.rig.server is not None
    async with browser() as session, session.get(stand.rig.server.make_url("/")) as response:
        assert (response.status, response.headers["Location"]) == (401, "/login")
        assert response.headers["WWW-Authenticate"]
    async with browser() as session, session.post(stand.rig.server.make_url("/")) as response:
        assert (response.status, "Location" in response.headers) == (401, False)
    async with aiohttp.ClientSession(headers={"Accept": "text/html"}) as session:
        for path in ("/", "/docs/", "/api/health"):
            async with session.get(stand.rig.server.make_url(path)) as response:
                assert response.status == 401
                assert "Location" not in response.headers


async def test_without_tokens_it_is_there_too(rig: Rig) -> None:
    await rig.start()
    assert (await helper_asks(rig, ADDRESS))[0] == 200
