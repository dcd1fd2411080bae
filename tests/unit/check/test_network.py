from __future__ import annotations

import errno
import socket
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from hawk.check.network import (
    NetworkTools,
    address_result,
    autopilot_port,
    bind_port,
    certificate_result,
    own_addresses,
    page_port,
    token_result,
)
from hawk.check.result import Outcome
from hawk.comm.protocol.authority import Role
from hawk.config.sections import AutopilotSettings, Config, WebSettings
from hawk.runtime.programs import Kind, Processes
from hawk.web.access.tls import CertificatePlan, make_certificate
from hawk.web.access.tokens import TOKEN_FILE, rotate
from tests.unit.check.fakes import write_process, write_sockets


def tools(proc: Path, error: int | None = None, addresses: tuple[str, ...] = ()) -> NetworkTools:
    def bind(_kind: Kind, _host: str, _port: int) -> None:
        if error is not None:
            raise OSError(error, "as the test wants")

    return NetworkTools(bind, Processes(proc), lambda: addresses)


def test_a_port_that_is_taken_is_found_by_opening_it() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as heard:
        heard.bind(("127.0.0.1", 0))
        for kind, port in (("tcp", taken.getsockname()[1]), ("udp", heard.getsockname()[1])):
            with pytest.raises(OSError, match="in use") as caught:
                bind_port(kind, "127.0.0.1", port)  # type: ignore[arg-type]
            assert caught.value.errno == errno.EADDRINUSE
    bind_port("tcp", "127.0.0.1", 0)
    bind_port("udp", "127.0.0.1", 0)


def test_a_page_s_port_of_a_running_daemon_names_it(tmp_path: Path) -> None:
    write_sockets(tmp_path, "tcp", (3000, "01", 10), (3000, "0A", 11))
    write_process(tmp_path, 41, ["python3", "/opt/hawk-drone"], ["socket:[10]", "socket:[11]"])
    found = page_port(WebSettings(port=3000), tools(tmp_path, errno.EADDRINUSE))
    assert found.outcome is Outcome.FAILED
    assert "hawk-drone (process 41)" in found.value
    assert "A daemon runs already" in found.remedy


def test_a_port_of_another_program_names_it(tmp_path: Path) -> None:
    write_sockets(tmp_path, "udp", (14550, "07", 12))
    write_process(tmp_path, 42, ["/usr/bin/mavproxy"], ["/dev/null", "socket:[12]"])
    found = autopilot_port(AutopilotSettings(), tools(tmp_path, errno.EADDRINUSE))
    assert found is not None
    assert found.outcome is Outcome.FAILED
    assert "mavproxy (process 42)" in found.value


def test_a_port_whose_holder_is_hidden_names_the_user(tmp_path: Path) -> None:
    write_sockets(tmp_path, "tcp6", (3000, "0A", 13))
    found = page_port(WebSettings(port=3000), tools(tmp_path, errno.EADDRINUSE))
    assert "a program of the user" in found.value


@pytest.mark.parametrize(("error", "words"), [(errno.EACCES, "web.port"), (errno.EADDRNOTAVAIL, "0.0.0.0"), (None, "")])
def test_a_port_that_cannot_be_opened_has_its_remedy(tmp_path: Path, error: int | None, words: str) -> None:
    found = page_port(WebSettings(), tools(tmp_path, error))
    assert (found.outcome is Outcome.PASSED) == (error is None)
    assert words in found.remedy


@pytest.mark.parametrize(
    ("url", "outcome"),
    [
        ("udpin://127.0.0.1:14550", Outcome.PASSED),
        ("tcpin://127.0.0.1:5760", Outcome.PASSED),
        ("udpout://10.0.0.1:14550", None),
        ("serial:///dev/ttyAMA0:921600", None),
    ],
)
def test_only_a_link_that_listens_needs_a_port(tmp_path: Path, url: str, outcome: Outcome | None) -> None:
    found = autopilot_port(AutopilotSettings(url=url), tools(tmp_path))
    assert (found and found.outcome) == outcome


def test_a_page_for_others_needs_an_address(tmp_path: Path) -> None:
    public, private = WebSettings(host="0.0.0.0"), WebSettings()
    assert address_result(public, tools(tmp_path)).outcome is Outcome.FAILED
    assert address_result(private, tools(tmp_path)).outcome is Outcome.PASSED
    found = address_result(public, tools(tmp_path, addresses=("10.0.0.5",)))
    assert (found.outcome, "10.0.0.5" in found.value) == (Outcome.PASSED, True)


def test_own_addresses_leave_loopback_out(tmp_path: Path) -> None:
    file = tmp_path / "if_inet6"
    file.write_text(
        "00000000000000000000000000000001 01 80 10 80       lo\n"
        "20010db8000000000000000000000007 02 40 00 80     eth0\n"
        "fe800000000000000000000000000001 02 40 20 80     eth0\n"
    )
    found = own_addresses(file)
    assert "2001:db8::7" in found
    assert not {"127.0.0.1", "::1", "fe80::1"} & set(found)


def test_a_page_for_others_needs_an_operator_s_token(tmp_path: Path) -> None:
    def found(host: str, token: str | None = None) -> tuple[Outcome, str]:
        web = {"host": host, **({} if token is None else {"token": token})}
        result = token_result(Config.model_validate({"web": web, "store": {"directory": tmp_path}}))
        return result.outcome, result.value + result.remedy

    assert found("127.0.0.1")[0] is Outcome.PASSED
    outcome, words = found("0.0.0.0")
    assert outcome is Outcome.FAILED
    assert "hawk-drone tokens rotate operator" in words
    outcome, words = found("0.0.0.0", "a-secret-of-one-s-own")
    assert outcome is Outcome.PASSED
    assert "a-secret-of-one-s-own" not in words
    rotate(tmp_path / TOKEN_FILE, Role.OPERATOR)
    assert found("0.0.0.0")[0] is Outcome.PASSED
    (tmp_path / TOKEN_FILE).write_text("{")
    outcome, words = found("0.0.0.0")
    assert outcome is Outcome.FAILED
    assert "damaged" in words


def test_a_certificate_is_tried_out(tmp_path: Path) -> None:
    def judge(change: Callable[[WebSettings], WebSettings], wall: float) -> Outcome:
        made = make_certificate(CertificatePlan(tmp_path, ("localhost",), 60, replace=True))
        web = WebSettings(host="0.0.0.0", tls_certificate=made.certificate, tls_key=made.key)
        return certificate_result(change(web), wall).outcome

    now = time.time()
    assert judge(lambda web: web, now) is Outcome.PASSED
    assert judge(lambda web: web, now + 50 * 86_400) is Outcome.WARNING
    assert judge(lambda web: web.model_copy(update={"tls_key": tmp_path / "none"}), now) is Outcome.FAILED
    assert certificate_result(WebSettings(host="0.0.0.0"), now).outcome is Outcome.WARNING
    assert certificate_result(WebSettings(), now).outcome is Outcome.PASSED


@pytest.mark.parametrize(
    ("command", "is_daemon"),
    [
        (["hawk-drone"], True),
        (["/usr/bin/python3", "/opt/hawk-drone", "run", "--port=1"], True),
        (["python3", "/opt/hawk-drone", "--config", "check.toml"], True),
        (["python3", "/opt/hawk-drone", "survey", "--out", "x", "--autopilot", "serial:///dev/ttyS0"], True),
        (["python3", "/opt/hawk-drone", "check"], False),
        (["python3", "/opt/hawk-drone", "tokens", "rotate", "operator"], False),
        (["python3", "/opt/hawk-drone", "run", "--sim"], False),
        (["python3", "/opt/hawk-drone", "run", "--attach-sim=x"], False),
        (["less", "notes-on", "hawk-drone"], False),
        (["hawk-sim"], False),
    ],
)
def test_a_daemon_is_known_by_its_command_line(tmp_path: Path, command: list[str], is_daemon: bool) -> None:
    write_process(tmp_path, 9, command)
    assert Processes(tmp_path).daemons() == ([9] if is_daemon else [])
    assert Processes(tmp_path, own=9).daemons() == []
