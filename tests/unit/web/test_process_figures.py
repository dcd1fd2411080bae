from __future__ import annotations

import socket
from pathlib import Path

from hawk.web.metrics import open_files, process_figures


async def test_a_socket_and_a_file_are_counted(tmp_path: Path) -> None:
    def counts() -> tuple[float, float]:
        found = process_figures()
        return found["open_files"][1], found["open_sockets"][1]

    files, sockets = counts()
    with socket.socket(), (tmp_path / "file").open("w"):
        assert counts() == (files + 2, sockets + 1)
    assert counts() == (files, sockets)
    assert process_figures()["resident_memory_bytes"][1] > 1e6
    assert process_figures()["tasks"][1] == 1


def test_a_descriptor_that_is_closed_meanwhile_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "fd").mkdir()
    (tmp_path / "fd" / "0").symlink_to("/dev/null")
    (tmp_path / "fd" / "1").write_text("no link: as if it had been closed")
    assert open_files(tmp_path) == ["/dev/null"]
