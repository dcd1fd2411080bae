"""HTTPS of the page: what is refused at the start, and attacks on the connection."""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import ssl
import stat
import subprocess
import time
import warnings
from collections.abc import AsyncIterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from hawk.comm.base_socket import ConnectionTimeout
from hawk.comm.protocol.authority import Role
from hawk.config.sections import ConfigError, WebSettings
from hawk.survey.client import DroneClient
from hawk.survey.run import trusted
from hawk.web.access.tls import (
    DAY_S,
    LONGEST_DAYS,
    RELEASED,
    CertificateError,
    CertificatePlan,
    Tls,
    clock_doubt,
    load_tls,
    make_certificate,
    usual_names,
    watch_certificate,
)
from hawk.web.access.tokens import TOKEN_FILE, rotate
from hawk.web.app import WebServer
from hawk.web.door import FIRST_REQUEST_S, Places
from tests.unit.comm.waiting import until
from tests.unit.web.access.certificates import Pair, make_pair, openssl
from tests.unit.web.rig import PATIENCE_S, Rig, Visitor, browser

FEW = Places(waiting=12, waiting_of_one=6, answered=8)


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> Pair:
    return make_pair(tmp_path_factory.mktemp("pair"))


def load(pair: Pair) -> Tls:
    found = load_tls(WebSettings(tls_certificate=pair.certificate, tls_key=pair.key))
    assert found is not None
    return found


def settings(pair: Pair, **more: Any) -> WebSettings:
    return WebSettings(port=0, tls_certificate=pair.certificate, tls_key=pair.key, **more)


@pytest.fixture
async def server(rig: Rig, pair: Pair, tmp_path: Path) -> AsyncIterator[WebServer]:
    rig.web, rig.tls, rig.folder = settings(pair), load(pair), tmp_path
    made = WebServer(rig.services(), rig.page)
    await made.start()
    made.door.places = FEW
    yield made
    await made.close()


def secure(pair: Pair, **options: Any) -> Any:
    return browser(connector=aiohttp.TCPConnector(ssl=ssl.create_default_context(cafile=pair.certificate)), **options)


async def closed(writer: asyncio.StreamWriter) -> None:
    writer.close()
    with contextlib.suppress(ConnectionError, ssl.SSLError):
        await writer.wait_closed()


# -- HTTPS ------------------------------------------------------------------------------------------------------------


async def test_page_and_websocket_are_served_by_https(server: WebServer, pair: Pair) -> None:
    assert server.url == f"https://127.0.0.1:{server.port}/"
    async with secure(pair) as session:
        async with session.get(server.url) as response:
            assert response.status == 200
        page = Visitor(await session.ws_connect(f"{server.url}ws"))
        await page.next("Welcome")
        assert (await page.take_control())["Accepted"]
        await page.socket.close()


async def test_cookies_are_for_https_and_for_this_server_only(rig: Rig, pair: Pair, tmp_path: Path) -> None:
    token = rotate(tmp_path / TOKEN_FILE, Role.OPERATOR)
    rig.web, rig.tls, rig.folder = settings(pair), load(pair), tmp_path
    server = WebServer(rig.services(), rig.page)
    await server.start()
    try:
        async with secure(pair) as session:
            headers = {"Origin": server.url.rstrip("/")}
            data = {"username": "operator", "password": token}
            async with session.post(f"{server.url}login", data=data, headers=headers, allow_redirects=False) as answer:
                assert answer.status == 303
                cookie = answer.headers["Set-Cookie"]
            assert cookie.startswith(f"__Host-hawk_login_{server.port}="), "no page without TLS can plant that name"
            assert "Secure" in cookie
            assert "Domain" not in cookie
            async with session.get(f"{server.url}api/session") as response:
                assert await response.json() == {"role": "operator", "login": True, "person": ""}
            async with session.get(f"{server.url}?token={token}", allow_redirects=False) as response:
                assert response.headers["Location"] == "/"
        async with secure(pair, headers={"Authorization": f"Bearer {token}"}) as tool:
            socket = await tool.ws_connect(f"{server.url}ws")
            assert "Secure" in socket._response.headers["Set-Cookie"]
            await socket.close()
    finally:
        await server.close()


async def test_the_browser_may_speak_tls_only(server: WebServer, pair: Pair) -> None:
    async with secure(pair) as session, session.get(server.url) as response:
        policy = response.headers["Content-Security-Policy"]
    assert f"wss://127.0.0.1:{server.port}" in policy
    assert "ws://" not in policy.replace("wss://", "")


@pytest.mark.fault("plain HTTP to the TLS port, an old TLS, a page without TLS")
async def test_a_page_without_tls_is_a_foreign_page(server: WebServer, pair: Pair) -> None:
    """Somebody on the path can write such a page; the page of this server has https in its origin."""
    own = f"127.0.0.1:{server.port}"
    async with secure(pair) as session:
        for origin, status in ((f"http://{own}", 403), (f"https://{own}", 101)):
            with contextlib.suppress(aiohttp.WSServerHandshakeError) if status == 403 else contextlib.nullcontext():
                socket = await session.ws_connect(f"{server.url}ws", headers={"Origin": origin})
                assert status == 101
                await socket.close()
        async with session.post(f"{server.url}login", headers={"Origin": f"http://{own}"}) as response:
            assert response.status == 403


@pytest.mark.parametrize("is_self_signed", [True, False])
async def test_only_a_certificate_of_an_authority_is_remembered(rig: Rig, tmp_path: Path, is_self_signed: bool) -> None:
    authority = make_pair(tmp_path / "authority", "authority")
    made = make_pair(tmp_path / "page", authority=None if is_self_signed else authority)
    rig.web, rig.tls = settings(made), load(made)
    server = WebServer(rig.services(), rig.page)
    await server.start()
    try:
        trust = made if is_self_signed else authority
        async with secure(trust) as session, session.get(server.url) as response:
            assert ("Strict-Transport-Security" in response.headers) == (not is_self_signed)
    finally:
        await server.close()


# -- attacks on the connection ----------------------------------------------------------------------------------------


@pytest.mark.fault(
    "plain HTTP to the TLS port, an old TLS, a page without TLS",
    "closed without an answer; refused; a foreign origin",
)
async def test_plain_http_to_the_tls_port_gets_nothing_and_keeps_no_place(server: WebServer) -> None:
    reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
    writer.write(b"GET /?token=correct-horse-battery HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    with contextlib.suppress(ConnectionError):
        async with asyncio.timeout(PATIENCE_S):
            answer = await reader.read()
            assert b"HTTP" not in answer
    await until(lambda: server.door.waiting == 0)
    await closed(writer)


@pytest.mark.fault("plain HTTP to the TLS port, an old TLS, a page without TLS")
async def test_an_old_version_of_tls_is_refused(server: WebServer) -> None:
    old = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    old.check_hostname, old.verify_mode = False, ssl.CERT_NONE
    old.set_ciphers("ALL:@SECLEVEL=0")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        old.minimum_version, old.maximum_version = ssl.TLSVersion.TLSv1, ssl.TLSVersion.TLSv1_1
    with pytest.raises((ssl.SSLError, ConnectionError)):
        await asyncio.open_connection("127.0.0.1", server.port, ssl=old)
    await until(lambda: server.door.waiting == 0)
    assert server._tls is not None
    assert server._tls.context.minimum_version is ssl.TLSVersion.TLSv1_2


@pytest.mark.fault(
    "TLS handshakes that stall",
    "they count among the connections that wait, end after 10 s, and hold up nobody",
)
@pytest.mark.parametrize("begun", [b"", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03"])
async def test_a_stalled_handshake_holds_no_place_for_ever_and_holds_up_nobody(
    rig: Rig, server: WebServer, pair: Pair, begun: bytes
) -> None:
    stalled = [await asyncio.open_connection("127.0.0.1", server.port) for _ in range(20)]
    for _, writer in stalled:
        writer.write(begun)
    await until(lambda: server.door.closed >= 20 - FEW.waiting_of_one)
    assert server.door.waiting <= FEW.waiting_of_one, "those that shake hands count among those that wait"
    async with secure(pair) as session, session.get(server.url) as response:
        assert response.status == 200
    rig.real.advance(FIRST_REQUEST_S + 0.1)
    server.door.sweep()
    await until(lambda: server.door.waiting == 0)
    assert server._listener is not None
    await until(lambda: not server._listener._handshakes if server._listener else False)
    for reader, writer in stalled:
        with contextlib.suppress(ConnectionError):
            async with asyncio.timeout(PATIENCE_S):
                await reader.read()
        await closed(writer)


async def test_a_handshake_takes_its_place_before_a_request_that_stalls_after_it(
    rig: Rig, server: WebServer, pair: Pair
) -> None:
    trust = ssl.create_default_context(cafile=pair.certificate)
    reader, writer = await asyncio.open_connection("127.0.0.1", server.port, ssl=trust)
    writer.write(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Slow: ")
    await until(lambda: server.door.waiting == 1)
    rig.real.advance(FIRST_REQUEST_S + 0.1)
    server.door.sweep()
    with contextlib.suppress(ConnectionError, ssl.SSLError):
        async with asyncio.timeout(PATIENCE_S):
            assert await reader.read() == b""
    assert server.door.waiting == 0
    await closed(writer)


async def test_the_server_stops_while_somebody_shakes_hands(rig: Rig, pair: Pair) -> None:
    rig.web, rig.tls = settings(pair), load(pair)
    server = WebServer(rig.services(), rig.page)
    await server.start()
    _, writer = await asyncio.open_connection("127.0.0.1", server.port)
    await until(lambda: server.door.waiting == 1)
    await server.close()
    assert not [task for task in asyncio.all_tasks() if task.get_name() == "web-handshake"]
    assert server.door.waiting == 0
    await closed(writer)


# -- the files --------------------------------------------------------------------------------------------------------


def refused(certificate: Path, key: Path) -> str:
    with pytest.raises(ConfigError) as error:
        load_tls(WebSettings(tls_certificate=certificate, tls_key=key))
    return str(error.value)


def test_without_files_there_is_no_tls() -> None:
    assert load_tls(WebSettings()) is None


def test_one_file_without_the_other_is_refused(pair: Pair) -> None:
    with pytest.raises(ValueError, match="tls_key is missing"):
        WebSettings(tls_certificate=pair.certificate)
    with pytest.raises(ValueError, match="tls_certificate is missing"):
        WebSettings(tls_key=pair.key)


@pytest.mark.fault("certificate or key missing, expired, of another pair, readable by all")
def test_files_that_cannot_be_used_are_named_with_their_setting(pair: Pair, tmp_path: Path) -> None:
    other = make_pair(tmp_path / "other")
    nothing, text = tmp_path / "absent.pem", tmp_path / "text.pem"
    text.write_text("no certificate")
    text.chmod(0o600)
    assert refused(nothing, pair.key).startswith(f"web.tls_certificate: {nothing} cannot be read")
    assert refused(pair.certificate, nothing).startswith(f"web.tls_key: {nothing} cannot be read")
    assert "is not the key of web.tls_certificate" in refused(pair.certificate, other.key)
    assert refused(text, pair.key).startswith("web.tls_certificate, web.tls_key")
    assert refused(pair.certificate, text).startswith("web.tls_certificate, web.tls_key")


def test_a_key_that_everybody_may_read_is_refused(pair: Pair, tmp_path: Path) -> None:
    key = tmp_path / "key.pem"
    key.write_bytes(pair.key.read_bytes())
    key.chmod(0o644)
    assert "chmod 600" in refused(pair.certificate, key)


def test_a_key_with_a_pass_phrase_is_refused_and_nobody_is_asked_for_it(pair: Pair, tmp_path: Path) -> None:
    key = tmp_path / "key.pem"
    openssl("ec", "-in", pair.key, "-aes256", "-passout", "pass:secret", "-out", key)
    key.chmod(0o600)
    assert "pass phrase" in refused(pair.certificate, key)


@pytest.mark.fault("the page's certificate is over, or the clock says so")
def test_an_expired_certificate_is_refused(tmp_path: Path) -> None:
    old = make_pair(tmp_path, days=-1, age_days=10)
    text = refused(old.certificate, old.key)
    assert text.startswith(f"web.tls_certificate: {old.certificate} has expired")
    assert "make-certificate" in text


def test_a_certificate_of_an_authority_itself_is_no_servers(tmp_path: Path) -> None:
    authority = make_pair(tmp_path, "authority")
    assert "is no server's certificate" in refused(authority.certificate, authority.key)


def test_a_certificate_that_begins_tomorrow_is_served_with_a_warning(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A computer without a clock of its own starts in the past."""
    early = load(make_pair(tmp_path, age_days=-1))
    assert "not valid yet" in caplog.text
    assert "not valid yet" in early.warning(time.time())
    assert re.fullmatch(r"([0-9A-F]{2}:){31}[0-9A-F]{2}", early.fingerprint)


async def test_a_certificate_that_ends_within_thirty_days_is_reported(pair: Pair, tmp_path: Path) -> None:
    soon = load(make_pair(tmp_path, days=20.5))
    assert 20 < soon.days_left(time.time()) < 21
    reported: list[str] = []
    watch = asyncio.create_task(watch_certificate(soon, time.time, reported.append))
    await until(lambda: bool(reported))
    watch.cancel()
    await asyncio.gather(watch, return_exceptions=True)
    assert reported == ["The certificate of the page ends in 20 days: replace web.tls_certificate."]
    late = load(pair)
    assert late.warning(time.time()) == ""
    assert late.warning(time.time() + 271 * DAY_S) != ""


@pytest.mark.fault(
    "certificate or key missing, expired, of another pair, readable by all",
    "status 2 with the setting, before anything starts",
)
def test_the_daemon_refuses_bad_files_before_anything_starts(
    pair: Pair, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from hawk.cli import EXIT_USAGE, main

    old = make_pair(tmp_path / "old", days=-1, age_days=10)
    monkeypatch.setenv("HAWK_WEB__TLS_CERTIFICATE", str(old.certificate))
    monkeypatch.setenv("HAWK_WEB__TLS_KEY", str(old.key))
    store = tmp_path / "store"
    assert main(["run", "--sim", "--port", "0", "--store", str(store)]) == EXIT_USAGE
    assert "web.tls_certificate" in capsys.readouterr().err
    assert not store.exists()


# -- make-certificate -------------------------------------------------------------------------------------------------


@pytest.mark.slow
async def test_the_command_makes_a_pair_that_the_page_and_the_client_use(
    rig: Rig, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from hawk.cli import main

    store = tmp_path / "store"
    assert main(["make-certificate", "--store", str(store), "--name", "127.0.0.1", "--name", "drone.local"]) == 0
    made = Pair(store / "certificate.pem", store / "certificate-key.pem")
    assert stat.S_IMODE(made.key.stat().st_mode) == 0o600
    rig.tls, rig.web, rig.folder = load(made), settings(made), store
    assert rig.tls.is_self_signed
    assert f"fingerprint (SHA-256): {rig.tls.fingerprint}" in capsys.readouterr().out
    token = rotate(store / TOKEN_FILE, Role.OPERATOR)
    server = WebServer(rig.services(), rig.page)
    await server.start()
    try:
        async with DroneClient("127.0.0.1", server.port, token=token, tls=trusted(made.certificate)) as drone:
            assert drone.welcome is not None
            assert drone.welcome.role == "operator"
        other = make_pair(tmp_path / "other")
        with pytest.raises(ConnectionTimeout, match=r"is not trusted: .*self-signed one \(--certificate FILE\)"):
            async with DroneClient("127.0.0.1", server.port, token=token, tls=trusted(other.certificate)):
                pass
    finally:
        await server.close()
    assert main(["make-certificate", "--store", str(store)]) == 2, "the key may be in use"
    assert main(["make-certificate", "--store", str(store), "--replace"]) == 0
    assert load(made).fingerprint != rig.tls.fingerprint


@pytest.mark.parametrize(("option", "field"), [("--out", "--out"), ("--store", "store.directory")])
def test_a_folder_that_cannot_be_used_is_named(option: str, field: str, capsys: pytest.CaptureFixture[str]) -> None:
    from hawk.cli import main

    assert main(["make-certificate", option, "/dev/null/folder"]) == 2
    said = capsys.readouterr().err
    assert f"{field}: /dev/null/folder cannot be used: Not a directory; name a folder that this user may write" in said


@pytest.mark.parametrize(
    "name", ["", "a b", "a\nb", "x,DNS:evil.example", "*", "http://drone", "0.0.0.0", "-a", "ä.example"]
)
def test_a_name_that_is_none_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(CertificateError, match="--name"):
        make_certificate(CertificatePlan(tmp_path, (name,)))
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("days", [0, -1, 826])
def test_days_have_bounds(tmp_path: Path, days: int) -> None:
    with pytest.raises(CertificateError, match="--days"):
        make_certificate(CertificatePlan(tmp_path, ("localhost",), days))


def test_a_missing_openssl_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CertificateError, match="apt install openssl"):
        make_certificate(CertificatePlan(tmp_path, ("localhost",)))


def test_the_usual_names_are_those_by_which_the_page_is_opened() -> None:
    names = usual_names(WebSettings(host="0.0.0.0", allowed_hosts=("drone.example",)))
    assert {"localhost", "127.0.0.1", "::1", "drone.example"} <= set(names)
    assert "0.0.0.0" not in names


@pytest.mark.fault(
    "the page's certificate is over, or the clock says so",
    "at a start on the ground status 2 with both remedies; in the air it is served and reported",
)
def test_an_expired_certificate_is_served_while_a_flight_is_under_way(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    old = make_pair(tmp_path, days=-1, age_days=10)
    found = load_tls(WebSettings(tls_certificate=old.certificate, tls_key=old.key), in_flight=True)
    assert found is not None
    assert "has expired by this computer's clock" in caplog.text
    assert "ends in 0 days" in found.warning(time.time())


def valid(certificate: Path) -> tuple[datetime, datetime]:
    """Return begin and end of a certificate's validity."""
    command = ["openssl", "x509", "-in", str(certificate), "-noout", "-dates"]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    pattern = "%b %d %H:%M:%S %Y GMT"
    begin, end = (datetime.strptime(line.partition("=")[2], pattern).replace(tzinfo=UTC) for line in lines)
    return begin, end


@pytest.mark.fault("`make-certificate` while the clock is before this version (1970 after a start without a clock)")
@pytest.mark.parametrize("days", [1, 30, LONGEST_DAYS])
def test_a_made_certificate_begins_before_it_is_made_and_never_lasts_too_long(tmp_path: Path, days: int) -> None:
    made = make_certificate(CertificatePlan(tmp_path, ("localhost",), days))
    begin, end = valid(made.certificate)
    now = datetime.now(UTC)
    assert timedelta(days=1, hours=23) < now - begin < timedelta(days=2, hours=1)
    assert timedelta(days=min(days, LONGEST_DAYS - 2), hours=-1) <= end - now <= timedelta(days=days)
    assert end - begin <= timedelta(days=LONGEST_DAYS)


@pytest.mark.fault(
    "`make-certificate` while the clock is before this version (1970 after a start without a clock)",
    "refused, with the remedy; a made one begins two days before, for clocks that are behind",
)
@pytest.mark.parametrize("clock", [0.0, RELEASED.timestamp() - 1.0])
def test_no_certificate_is_made_by_a_clock_before_this_version(tmp_path: Path, clock: float) -> None:
    with pytest.raises(CertificateError, match="set the clock first"):
        make_certificate(CertificatePlan(tmp_path, ("localhost",)), lambda: clock)
    assert list(tmp_path.iterdir()) == []


def test_the_date_of_this_version_is_that_of_the_changelog() -> None:
    changelog = (Path(__file__).parents[4] / "CHANGELOG.md").read_text()
    newest = re.search(r"^## \d\S* - (\d{4}-\d{2}-\d{2})", changelog, re.MULTILINE)
    assert newest is not None
    assert f"{RELEASED:%Y-%m-%d}" == newest[1]


@pytest.mark.parametrize(("state", "is_doubted"), [(5, True), (0, False), (-1, False)])
def test_a_clock_that_nothing_keeps_right_is_doubted(
    monkeypatch: pytest.MonkeyPatch, state: int, is_doubted: bool
) -> None:
    library = type("Library", (), {"adjtimex": staticmethod(lambda _buffer: state)})
    monkeypatch.setattr("ctypes.CDLL", lambda _name: library)
    assert bool(clock_doubt()) is is_doubted


def test_without_that_call_no_clock_is_doubted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ctypes.CDLL", lambda _name: object())
    assert clock_doubt() == ""
