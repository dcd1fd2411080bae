from __future__ import annotations

import asyncio
import re
import shutil
import ssl
import subprocess
from collections.abc import AsyncIterator
from http.cookies import SimpleCookie
from pathlib import Path
from urllib.parse import urljoin

import aiohttp
import pytest
from aiohttp import web
from aiohttp.test_utils import make_mocked_request

from hawk.comm.protocol.authority import Role
from hawk.config.sections import WebSettings
from hawk.web.access.proxied import forwarding_header, is_secure, place, prefix_of
from hawk.web.app import create_app
from hawk.web.documentation import Documentation
from hawk.web.security import InsecureBindingError
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand
from tests.unit.web.test_security import TOKEN, socket_status, status_of

ACCESS = Path(__file__).parents[4] / "docs" / "access.md"
HOST = "drones.example"
PROXY = {"Host": HOST, "X-Forwarded-For": "203.0.113.9", "X-Forwarded-Proto": "https", "X-Forwarded-Prefix": "/hawk-1"}
FORWARDING = {
    "X-Forwarded-For": "203.0.113.9",
    "X-Forwarded-Host": HOST,
    "X-Forwarded-Proto": "https",
    "X-Forwarded-Prefix": "/hawk",
    "X-Forwarded-Anything": "1",
    "Forwarded": "for=203.0.113.9",
    "Via": "1.1 caddy",
    "X-Real-IP": "203.0.113.9",
    "x-real-ip": "203.0.113.9",
    "CF-Connecting-IP": "203.0.113.9",
    "CF-Ray": "1",
    "True-Client-IP": "203.0.113.9",
    "X-Client-IP": "203.0.113.9",
    "X-Cluster-Client-IP": "203.0.113.9",
    "Fly-Client-IP": "203.0.113.9",
    "CDN-Loop": "x",
    "X-Original-URL": "/",
    "X-Envoy-External-Address": "203.0.113.9",
    "Tailscale-User-Login": "ana@example.org",
}


@pytest.fixture
async def stand(rig: Rig, tmp_path: Path) -> AsyncIterator[Stand]:
    rig.folder = tmp_path
    rig.web = WebSettings(allowed_hosts=(HOST,))
    site = tmp_path / "site"
    site.mkdir()
    (site / "index.html").write_text("the documentation")
    rig.documentation = Documentation.load(site)
    made = Stand(rig, tmp_path)
    await rig.start()
    yield made
    await made.close()


# -- without a token --------------------------------------------------------------------------------------------------


@pytest.mark.fault(
    "`web.allowed_hosts` has a name, and there is no token",
    "the daemon refuses to start, on loopback too",
)
@pytest.mark.parametrize("hosts", [(HOST,), ("localhost", HOST), ("192.168.1.5",)])
def test_a_name_for_a_proxy_needs_a_token_on_loopback_too(rig: Rig, hosts: tuple[str, ...]) -> None:
    rig.web = WebSettings(allowed_hosts=hosts)
    with pytest.raises(InsecureBindingError, match=r"web\.allowed_hosts: .*hawk-drone tokens rotate operator"):
        create_app(rig.services(), rig.page)
    rig.web = WebSettings(allowed_hosts=hosts, token=TOKEN)
    assert isinstance(create_app(rig.services(), rig.page), web.Application)
    rig.web = WebSettings(allowed_hosts=("localhost", "127.0.0.2"))
    assert isinstance(create_app(rig.services(), rig.page), web.Application)


@pytest.mark.fault(
    "without a token: a proxy or tunnel on this computer passes requests on",
    "refused with the remedy, page, WebSocket and files alike",
)
@pytest.mark.parametrize("name", FORWARDING)
async def test_without_a_token_what_a_proxy_passes_on_is_refused(rig: Rig, name: str) -> None:
    headers = {name: FORWARDING[name]}
    for path in ("/", "/login", "/api/session", "/snapshot.jpg", "/api/downloads.json", "/docs/", "/register_service"):
        assert await status_of(rig, path, headers=headers) == 403, path
    for path in ("/ws", "/video"):
        assert await socket_status(rig, path, headers=headers) == 403
    assert await status_of(rig, "/logout", "POST", headers=headers) == 403
    assert await status_of(rig) == 200


@pytest.mark.fault("without a token: a proxy or tunnel on this computer passes requests on")
@pytest.mark.parametrize("host", ["192.168.1.100", "203.0.113.9:3000", "[fe80::1]"])
async def test_without_a_token_another_host_than_this_computer_is_refused(rig: Rig, host: str) -> None:
    assert await status_of(rig, headers={"Host": host}) == 403
    assert await socket_status(rig, headers={"Host": host}) == 403


async def test_the_refusal_names_the_header_and_the_remedy(rig: Rig) -> None:
    server = await rig.start()
    async with aiohttp.ClientSession() as session, session.get(server.make_url("/"), headers={"Via": "x"}) as response:
        text = await response.text()
    assert text.startswith("Via: ")
    assert "hawk-drone tokens rotate operator" in text


@pytest.mark.slow
@pytest.mark.parametrize("name", FORWARDING)
async def test_with_a_token_a_proxy_is_asked_for_it(rig: Rig, name: str) -> None:
    rig.web = WebSettings(token=TOKEN)
    headers = {name: FORWARDING[name]}
    assert await status_of(rig, headers=headers) == 401
    assert await socket_status(rig, headers=headers) == 401
    assert await status_of(rig, headers={**headers, "Authorization": f"Bearer {TOKEN}"}) == 200


async def test_the_version_is_for_programs_of_this_computer_and_not_of_its_proxy(stand: Stand) -> None:
    session = await stand.browser()
    assert await stand.status(session, "/register_service") == 200
    proxied = await stand.browser(headers={"X-Real-IP": "203.0.113.9"})
    assert await stand.status(proxied, "/register_service") == 401


# -- what a proxy says ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("headers", "secure"),
    [
        ({}, False),
        ({"X-Forwarded-Proto": "https"}, True),
        ({"X-Forwarded-Proto": "HTTPS, http"}, True),
        ({"X-Forwarded-Proto": "http, https"}, False),
        ({"Forwarded": 'for="[2001:db8::1]";proto=https;by=x'}, True),
        ({"Forwarded": "proto=http, proto=https"}, False),
        ({"Forwarded": "for=1.2.3.4;xproto=https"}, False),
        ({"X-Forwarded-Proto": "ftp"}, False),
    ],
)
def test_the_scheme_is_that_of_the_browser(headers: dict[str, str], secure: bool) -> None:
    assert is_secure(make_mocked_request("GET", "/", headers=headers)) is secure


@pytest.mark.parametrize(
    ("given", "prefix"),
    [
        ("/drone", "/drone"),
        ("/drone/", "/drone"),
        ("/lots/drone-1", "/lots/drone-1"),
        ("/", ""),
        ("drone", ""),
        ("//evil.example", ""),
        ("/a/../b", ""),
        ("/a b", ""),
        ("/a;Domain=evil", ""),
        ('/"><script>', ""),
    ],
)
def test_a_prefix_is_a_plain_path_or_none(given: str, prefix: str) -> None:
    assert prefix_of(make_mocked_request("GET", "/", headers={"X-Forwarded-Prefix": given})) == prefix


@pytest.mark.parametrize("path", ["/", "/login", "/docs", "/docs/a/b.html", "//x", "/a%2Fb?c=/d"])
@pytest.mark.parametrize("root", ["https://drones.example/", "https://drones.example/hawk-1/"])
def test_a_relative_address_leads_to_this_server_under_any_path(path: str, root: str) -> None:
    request = make_mocked_request("GET", path, headers={"Via": "x"})
    assert urljoin(f"{root.rstrip('/')}{path}", place(request, "/login")) == f"{root}login"
    assert place(make_mocked_request("GET", path), "/login") == "/login"
    assert forwarding_header(request) == "Via"


# -- a sub-path -------------------------------------------------------------------------------------------------------


@pytest.mark.fault(
    "the page under a sub-path of a proxy with HTTPS",
    "login, cookies, WebSocket, files and documentation work; another drone beside it has its own login",
)
async def test_under_a_sub_path_everything_works(stand: Stand) -> None:
    """The proxy's part, cutting the path off, is the test's."""
    server = stand.rig.server
    assert server is not None
    outside = f"https://{HOST}/hawk-1"
    headers = {**PROXY, "Accept": "text/html"}
    async with aiohttp.ClientSession(cookie_jar=aiohttp.DummyCookieJar(), headers=headers) as session:
        for path in ("/", "/docs/how-to/x.html", "/login"):
            async with session.get(server.make_url(path)) as response:
                form = await response.text()
            for name, leads_to in (("href", "login.css"), ("action", "login")):
                found = re.search(rf'(?:rel="stylesheet" |method="post" ){name}="([^"]*)"', form)
                assert found is not None
                assert urljoin(outside + path, found[1]) == f"{outside}/{leads_to}"
        form_data = {"username": "operator", "password": stand.tokens[Role.OPERATOR]}
        async with session.post(
            server.make_url("/login"), data=form_data, headers={"Origin": f"https://{HOST}"}, allow_redirects=False
        ) as response:
            assert response.status == 303
            assert urljoin(f"{outside}/login", response.headers["Location"]) == f"{outside}/"
            (cookie,) = SimpleCookie(response.headers["Set-Cookie"]).values()
        assert cookie["path"] == "/hawk-1/"
        assert cookie["secure"]
        assert cookie.key.startswith("__Secure-")
        own = {"Cookie": f"{cookie.key}={cookie.value}", "Origin": f"https://{HOST}"}
        async with session.get(server.make_url("/api/session"), headers=own) as response:
            assert (await response.json())["role"] == "operator"
        async with session.ws_connect(server.make_url("/ws"), headers=own) as socket:
            assert (await socket.receive_json())["Type"] == "Welcome"
        async with session.get(server.make_url("/docs"), headers=own, allow_redirects=False) as response:
            assert urljoin(f"{outside}/docs", response.headers["Location"]) == f"{outside}/docs/"
        async with session.get(server.make_url("/docs/"), headers=own) as response:
            assert f"script-src {outside}/docs/;" in response.headers["Content-Security-Policy"]
        async with session.get(server.make_url("/"), headers=own) as response:
            assert f"wss://{HOST}" in response.headers["Content-Security-Policy"]
            assert f" ws://{HOST}" not in response.headers["Content-Security-Policy"]
        evil = {**own, "Origin": "https://evil.example"}
        with pytest.raises(aiohttp.WSServerHandshakeError):
            await session.ws_connect(server.make_url("/ws"), headers=evil)
        open_page = {**own, "Origin": f"http://{HOST}"}
        with pytest.raises(aiohttp.WSServerHandshakeError):
            await session.ws_connect(server.make_url("/ws"), headers=open_page)


# -- the documented nginx ---------------------------------------------------------------------------------------------


def _nginx_text(folder: Path, port: int, servers: dict[str, int]) -> str:
    """Return nginx's settings as the documentation gives them, with this test's ports and a location for each drone."""
    found = re.search(r"```nginx\n(.*?)```", ACCESS.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    text = found[1].replace("listen 443 ssl", f"listen 127.0.0.1:{port} ssl")
    text = text.replace("/etc/ssl/certs/drones.example.pem", f"{folder}/c.pem")
    text = text.replace("/etc/ssl/private/drones.example.key", f"{folder}/k.pem")
    block = text[text.index("    location") : text.rindex("}")]
    locations = "".join(
        block.replace("/hawk-1", f"/{name}").replace("127.0.0.1:3000", f"127.0.0.1:{to}")
        for name, to in servers.items()
    )
    temporary = "".join(
        f"{kind}_temp_path {folder}/{kind};\n" for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    )
    http = f"access_log off;\n{temporary}{text.replace(block, locations)}"
    return f"daemon off;\npid {folder}/pid;\nerror_log stderr;\nevents {{}}\nhttp {{\n{http}}}\n"


@pytest.fixture
def certificate(tmp_path: Path) -> Path:
    command = (
        "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=drones.example"
    )
    names = ["-addext", "subjectAltName=DNS:localhost", "-keyout", f"{tmp_path}/k.pem", "-out", f"{tmp_path}/c.pem"]
    subprocess.run([*command.split(), *names], check=True, capture_output=True)
    return tmp_path / "c.pem"


@pytest.mark.fault("the page under a sub-path of a proxy with HTTPS")
@pytest.mark.skipif(shutil.which("nginx") is None or shutil.which("openssl") is None, reason="needs nginx and openssl")
async def test_two_drones_behind_one_name_have_logins_of_their_own(
    stand: Stand, tmp_path: Path, certificate: Path, unused_tcp_port: int
) -> None:
    other = Rig(web=WebSettings(token=TOKEN, allowed_hosts=("localhost",)))
    servers = {"hawk-1": stand.rig.server, "hawk-2": await other.start()}
    ports = {name: server.port for name, server in servers.items() if server is not None and server.port is not None}
    (tmp_path / "nginx.conf").write_text(_nginx_text(tmp_path, unused_tcp_port, ports))
    nginx = await asyncio.create_subprocess_exec("nginx", "-c", tmp_path / "nginx.conf", "-p", tmp_path)
    root = f"https://localhost:{unused_tcp_port}"
    trusted = aiohttp.TCPConnector(ssl=ssl.create_default_context(cafile=str(certificate)))
    tokens = {"hawk-1": stand.tokens[Role.OPERATOR], "hawk-2": TOKEN}
    try:
        async with asyncio.timeout(15), aiohttp.ClientSession(connector=trusted) as session:
            while True:
                try:
                    async with session.get(f"{root}/hawk-1/", headers={"Accept": "text/html"}) as response:
                        assert response.status == 401
                        break
                except aiohttp.ClientConnectionError:
                    await asyncio.sleep(0.02)
            for name, token in tokens.items():
                form = {"username": "operator", "password": token}
                async with session.post(
                    f"{root}/{name}/login", data=form, headers={"Origin": root}
                ) as response:  # follows
                    assert (response.status, str(response.url)) == (200, f"{root}/{name}/")
            for name in tokens:  # the second login did not end the first
                async with session.get(f"{root}/{name}/api/session") as response:
                    assert (await response.json())["role"] == "operator"
                address = f"{root}/{name}/ws"
                async with session.ws_connect(address, headers={"Origin": root}) as socket:
                    assert (await socket.receive_json())["Type"] == "Welcome"
            async with session.get(f"{root}/hawk-1/docs") as response:
                assert (response.status, str(response.url)) == (200, f"{root}/hawk-1/docs/")
            async with session.post(
                f"{root}/hawk-1/logout", headers={"Origin": root}, allow_redirects=False
            ) as response:
                assert urljoin(f"{root}/hawk-1/logout", response.headers["Location"]) == f"{root}/hawk-1/login"
            async with session.get(f"{root}/hawk-1/api/session") as response:
                assert response.status == 401
            async with session.get(f"{root}/hawk-2/api/session") as response:
                assert response.status == 200
    finally:
        nginx.terminate()
        await nginx.wait()
        if other.server is not None:
            await other.server.close()


def test_the_settings_of_the_documentation_name_every_header() -> None:
    text = ACCESS.read_text(encoding="utf-8")
    assert text.count("X-Forwarded-Prefix /hawk-1") == 2
