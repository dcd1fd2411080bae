from __future__ import annotations

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from hawk.comm.mavlink.claim import Claim, ClaimedError, device_of, place_of

URL = f"tcpout://127.0.0.1:{20_000 + os.getpid() % 20_000}"
HOLDER = """
import sys, time
from hawk.comm.mavlink.claim import Claim
Claim(sys.argv[1]).take()
print("taken", flush=True)
time.sleep(60)
"""


@pytest.mark.fault("a second daemon of this computer on the same serial line, TCP or UDP address")
def test_the_second_names_the_first_and_gets_it_when_that_was_killed() -> None:
    first = subprocess.Popen([sys.executable, "-c", HOLDER, URL], stdout=subprocess.PIPE)
    second = Claim(URL)
    try:
        assert first.stdout is not None
        assert first.stdout.readline() == b"taken\n"
        for _ in range(2):
            with pytest.raises(ClaimedError, match=rf"in use by another hawk-drone \(process {first.pid}, version "):
                second.take()
    finally:
        first.kill()
        first.communicate()
    second.take()
    second.take()
    second.release()
    second.release()


@pytest.mark.slow
def test_a_released_claim_is_free() -> None:
    for _ in range(50):
        first, second = Claim(URL), Claim(URL)
        first.take()
        with pytest.raises(ClaimedError, match=rf"\(process {os.getpid()}, version "):
            second.take()
        first.release()
        second.take()
        second.release()


def test_one_that_does_not_answer_is_named_by_its_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hawk.comm.mavlink.claim._ANSWER_S", 0.05)
    monkeypatch.setattr(Claim, "_serve", lambda _self, _made: None)
    first = Claim(URL)
    first.take()
    with pytest.raises(ClaimedError, match=rf"\(process {os.getpid()}\)$"):
        Claim(URL).take()
    first.release()


def test_one_that_cannot_be_asked_is_another_daemon(monkeypatch: pytest.MonkeyPatch) -> None:
    first = Claim(URL)
    first.take()

    def refuse(_self: socket.socket, _name: str) -> None:
        raise ConnectionRefusedError

    monkeypatch.setattr(socket.socket, "connect", refuse)
    with pytest.raises(ClaimedError, match=r"in use by another hawk-drone$"):
        Claim(URL).take()
    first.release()


def test_where_nothing_can_be_claimed_the_autopilot_is_opened_all_the_same(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def refuse(_self: socket.socket, _name: str) -> None:
        raise PermissionError

    monkeypatch.setattr(socket.socket, "bind", refuse)
    Claim(URL).take()
    assert "cannot be claimed" in caplog.text


def test_a_device_is_one_by_all_its_names(tmp_path: Path) -> None:
    device = tmp_path / "ttyACM0"
    device.touch()
    (tmp_path / "autopilot").symlink_to(device)
    names = [f"serial://{tmp_path}/autopilot:57600", f"serial_flowcontrol://{device}:115200", f"serial://{device}"]
    assert {place_of(name) for name in names} == {str(device)}
    assert device_of("udpin://127.0.0.1:14550") is None


@pytest.mark.parametrize("other", ["udpin://127.0.0.1:14551", "udpout://127.0.0.1:14550", "udpin://127.0.0.2:14550"])
def test_another_address_is_another_autopilot(other: str) -> None:
    assert place_of(other) != place_of("udpin://127.0.0.1:14550")
