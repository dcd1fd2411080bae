from __future__ import annotations

import stat
from pathlib import Path

import pytest

from hawk.runtime.files import cookie_secret, shown_address, write_private

URL = "http://192.168.1.2:3000/"
PAGE_URL = f"{URL}?token=correct-horse-battery"


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def test_the_token_goes_to_a_terminal(tmp_path: Path) -> None:
    assert shown_address(URL, PAGE_URL, tmp_path, on_terminal=True) == PAGE_URL
    assert list(tmp_path.iterdir()) == []


def test_elsewhere_the_token_goes_into_a_file_of_this_user_alone(tmp_path: Path) -> None:
    shown = shown_address(URL, PAGE_URL, tmp_path, on_terminal=False)
    (path,) = tmp_path.iterdir()
    assert str(path) in shown
    assert URL in shown
    assert "correct-horse" not in shown
    assert path.read_text() == f"{PAGE_URL}\n"
    assert mode(path) == 0o600


def test_an_address_without_a_token_is_printed(tmp_path: Path) -> None:
    assert shown_address(URL, URL, tmp_path, on_terminal=False) == URL
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    shown = shown_address(URL, PAGE_URL, tmp_path / "absent", on_terminal=False)
    assert "absent" in shown
    assert "correct-horse" not in shown


def test_the_secret_is_kept_for_the_next_start(tmp_path: Path) -> None:
    made = cookie_secret(tmp_path)
    assert len(made) == 32
    assert cookie_secret(tmp_path) == made
    (path,) = tmp_path.iterdir()
    assert mode(path) == 0o600
    path.write_bytes(b"cut off")
    assert len(cookie_secret(tmp_path)) == 32


def test_a_secret_that_cannot_be_kept_is_reported(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert len(cookie_secret(tmp_path / "absent")) == 32
    assert "after a restart" in caplog.text


def test_a_file_with_wider_rights_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("old")
    path.chmod(0o644)
    path.with_name(".file.new").write_text("left by a crash")
    write_private(path, b"new")
    assert (path.read_bytes(), mode(path)) == (b"new", 0o600)
