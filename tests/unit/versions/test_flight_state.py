from __future__ import annotations

import logging
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hawk.versions.flight_word import FILE, FlightWord, Heard, Word, hear

HOLDER = """
import sys, time
from pathlib import Path
from hawk.versions.flight_word import FlightWord
word = FlightWord(Path(sys.argv[1]), lambda: 7.0)
word.say(may_fly=True)
print("held", flush=True)
time.sleep(60)
"""


def test_a_word_is_heard_with_its_time_while_it_is_held_and_after(tmp_path: Path) -> None:
    now = 5.0
    word = FlightWord(tmp_path, lambda: now)
    word.say(may_fly=True)
    assert hear(tmp_path) == Heard(Word(may_fly=True, at_s=5.0), is_held=True)
    now = 6.25
    word.say(may_fly=False)
    assert hear(tmp_path) == Heard(Word(may_fly=False, at_s=6.25), is_held=True)
    word.close()
    assert hear(tmp_path) == Heard(Word(may_fly=False, at_s=6.25), is_held=False)


def test_a_killed_daemon_releases_its_word_and_leaves_it(tmp_path: Path) -> None:
    daemon = subprocess.Popen([sys.executable, "-c", HOLDER, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    assert daemon.stdout is not None
    with daemon:
        assert daemon.stdout.readline() == "held\n"
        assert hear(tmp_path).is_held
        daemon.kill()
    assert hear(tmp_path) == Heard(Word(may_fly=True, at_s=7.0), is_held=False)


def test_nothing_is_heard_where_no_daemon_ever_spoke(tmp_path: Path) -> None:
    assert hear(tmp_path) == Heard(None, is_held=False)


@pytest.mark.parametrize(
    "text",
    ["", "\0\0", "[]", "{", '{"may_fly": false}', '{"may_fly": 0, "at_s": 1.0}', '{"may_fly": false, "at_s": "1"}'],
)
def test_a_damaged_word_is_no_word(tmp_path: Path, text: str) -> None:
    (tmp_path / FILE).write_text(text)
    assert hear(tmp_path).word is None


def test_a_second_daemon_waits_until_the_first_has_ended(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    first, second = FlightWord(tmp_path, lambda: 1.0), FlightWord(tmp_path, lambda: 2.0)
    first.say(may_fly=True)
    with caplog.at_level(logging.WARNING):
        second.say(may_fly=False)
        second.say(may_fly=False)
    assert len(caplog.records) == 1
    assert hear(tmp_path).word == Word(may_fly=True, at_s=1.0)
    first.close()
    second.say(may_fly=False)
    assert hear(tmp_path) == Heard(Word(may_fly=False, at_s=2.0), is_held=True)
    second.close()


def test_a_folder_that_is_missing_is_reported_and_stops_nothing(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    word = FlightWord(tmp_path / "gone")
    with caplog.at_level(logging.WARNING):
        word.say(may_fly=False)
    assert "gone" in caplog.text
    word.close()


def test_without_systemd_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    word = FlightWord(None)
    word.say(may_fly=True)
    word.close()
    assert list(tmp_path.iterdir()) == []


def test_everybody_may_read_the_word_under_the_unit_s_mask(tmp_path: Path) -> None:
    before = os.umask(0o077)
    try:
        word = FlightWord(tmp_path)
        word.say(may_fly=False)
    finally:
        os.umask(before)
    assert (tmp_path / FILE).stat().st_mode & 0o777 == 0o644
    word.close()
