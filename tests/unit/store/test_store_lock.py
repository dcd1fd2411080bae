from __future__ import annotations

import errno
import fcntl
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hawk.store.store_lock import FILE, StoreInUseError, held_store, holder

ABOUT = {"version": "1.2.3", "port": "3000"}
HOLDER = """
import sys, time
from pathlib import Path
from hawk.store.store_lock import held_store
with held_store(Path(sys.argv[1]), {"version": "1.2.3", "port": "3000"}):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.mark.fault("a second daemon is started on the store of one that runs")
def test_a_second_program_is_refused_by_name_and_may_hold_it_when_the_first_was_killed(tmp_path: Path) -> None:
    store = tmp_path / "a" / "store"
    first = subprocess.Popen([sys.executable, "-c", HOLDER, str(store)], stdout=subprocess.PIPE)
    try:
        assert first.stdout is not None
        assert first.stdout.readline() == b"held\n"
        with pytest.raises(StoreInUseError) as refused, held_store(store, ABOUT, wait_s=0.1):
            pytest.fail("held twice")
        named = f"another hawk-drone (process {first.pid}, port 3000, version 1.2.3)"
        assert str(refused.value) == f"{store} is in use by {named}"
    finally:
        first.kill()
        first.communicate()
    with held_store(store, ABOUT):
        assert json.loads((store / FILE).read_text()) == {**ABOUT, "pid": os.getpid()}
    assert not (store / FILE).exists()


@pytest.mark.slow
def test_a_start_waits_for_the_run_before_to_end(tmp_path: Path) -> None:
    first = subprocess.Popen([sys.executable, "-c", HOLDER, str(tmp_path)], stdout=subprocess.PIPE)
    assert first.stdout is not None
    first.stdout.readline()
    killer = subprocess.Popen(["/bin/sh", "-c", f"sleep 0.3; kill -9 {first.pid}"])
    with held_store(tmp_path, ABOUT, wait_s=30.0):
        pass
    first.communicate()
    assert (first.returncode, killer.wait()) == (-9, 0)


def test_two_stores_are_held_side_by_side(tmp_path: Path) -> None:
    with held_store(tmp_path / "one", ABOUT), held_store(tmp_path / "two", ABOUT):
        pass


@pytest.mark.parametrize("text", ["", "{", "[]", '{"pid": "x"}', '{"version": "1"}', "\x00"])
def test_a_file_that_names_nobody_is_another_daemon(tmp_path: Path, text: str) -> None:
    (tmp_path / FILE).write_text(text)
    assert holder(tmp_path) == "another hawk-drone"


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.EOPNOTSUPP, errno.EBADF])
def test_a_file_system_without_locks_stops_no_start(
    tmp_path: Path, number: int, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def refuse(_descriptor: int, _operation: int) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(fcntl, "flock", refuse)
    with held_store(tmp_path, ABOUT):
        pass
    assert "cannot be locked" in caplog.text


def test_a_folder_that_cannot_be_made_stops_no_start(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "file").write_text("")
    with held_store(tmp_path / "file" / "store", ABOUT):
        pass
    assert "cannot be locked" in caplog.text


def test_a_full_disk_stops_no_lock(tmp_path: Path) -> None:
    (tmp_path / FILE).mkdir()  # nothing can be written there
    with held_store(tmp_path, ABOUT), pytest.raises(StoreInUseError), held_store(tmp_path, ABOUT, wait_s=0.0):
        pass
