"""The box: its bounds end the process that reads, it has no network, and every end of a reader has words."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from typing import Any

import pytest

from hawk.cli import make_parser
from hawk.formats import box

HERE = "tests.unit.formats.test_box"
HERE_FILE = __file__


class _FieldError(ValueError):
    field = "layer"
    reason = "is not there"


def takes_memory(data: bytes, asked: dict[str, Any]) -> bytes:
    return bytes(bytearray(b"x") * int(asked["bytes"]))[:1]


def fails(data: bytes, asked: dict[str, Any]) -> bytes:
    raise {"KeyError": KeyError("layer"), "field": _FieldError()}[asked["error"]]


def ends(data: bytes, asked: dict[str, Any]) -> bytes:
    os._exit(139)


def connects(data: bytes, asked: dict[str, Any]) -> bytes:
    with socket.socket() as opened:
        opened.settimeout(2.0)
        return str(opened.connect_ex(("127.0.0.1", int(asked["port"])))).encode()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("reader", "asked", "field", "words"),
    [
        ("takes_memory", {"bytes": 400_000_000}, "file", "takes more memory or time"),
        ("fails", {"error": "KeyError"}, "file", r"cannot be read \(KeyError\): export it again"),
        ("fails", {"error": "field"}, "layer", "is not there"),
        ("ends", {}, "file", "takes more memory or time"),
    ],
)
def test_every_end_of_a_reader_has_words(reader: str, asked: dict[str, Any], field: str, words: str) -> None:
    with pytest.raises(box.RefusedError, match=words) as refused:
        box.read_and_wait(f"{HERE}:{reader}", b"x", asked, box.Limits(300_000_000))
    assert refused.value.field == field


@pytest.mark.slow
def test_a_reader_reaches_no_network_where_the_system_can_take_it_away() -> None:
    can = subprocess.run(
        [sys.executable, "-c", "from hawk.formats.box import cut_network; exit(not cut_network())"], check=False
    )
    if can.returncode != 0:
        pytest.skip("this system lets no process leave its network")
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        assert box.read_and_wait(f"{HERE}:connects", b"", {"port": port}) != b"0"


COMMAND = """
import resource
from hawk.formats.box import enter_command, memory_for_command
enter_command(needs_network=True)
most = resource.getrlimit(resource.RLIMIT_DATA)[0]
assert most > 0 and abs(most - memory_for_command()) < 2e9, most
assert resource.getrlimit(resource.RLIMIT_CPU)[0] == resource.RLIM_INFINITY
"""


@pytest.mark.slow
def test_a_command_may_take_most_of_what_is_free() -> None:
    subprocess.run([sys.executable, "-c", COMMAND], check=True)


LIMITED = """
import resource
from hawk.formats.box import enter_command
enter_command(needs_network=True, memory_bytes=700 * 2**20)
assert resource.getrlimit(resource.RLIMIT_DATA)[0] == 700 * 2**20
try:
    bytearray(800 * 2**20)
except MemoryError:
    raise SystemExit(0)
raise SystemExit("more was taken")
"""


def test_a_command_takes_no_more_than_a_person_says() -> None:
    subprocess.run([sys.executable, "-c", LIMITED], check=True)


@pytest.mark.parametrize(
    "command",
    [("map", HERE_FILE, "--out", "new"), ("replay", HERE_FILE), ("restore", HERE_FILE), ("verify", HERE_FILE)],
    ids=lambda command: str(command[0]),
)
def test_a_command_that_reads_a_strangers_file_is_in_the_box_without_a_network(command: tuple[str, ...]) -> None:
    options = make_parser().parse_args(command)
    is_a_page_shown = command[0] == "replay"  # the page that shows it is served, to this computer alone
    assert options.boxed(options) is is_a_page_shown
