from __future__ import annotations

import stat
from pathlib import Path

from hawk.daemon.announcement import PageShown, announcement, shown_address

URL = "http://192.168.1.2:3000/"
PAGE_URL = f"{URL}?token=correct-horse-battery"


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
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_an_address_without_a_token_is_printed(tmp_path: Path) -> None:
    assert shown_address(URL, URL, tmp_path, on_terminal=False) == URL
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    shown = shown_address(URL, PAGE_URL, tmp_path / "absent", on_terminal=False)
    assert "absent" in shown
    assert "correct-horse" not in shown


def test_a_survey_to_look_at_has_a_line_of_its_own_below_the_page(tmp_path: Path) -> None:
    page = PageShown(URL, URL, asks_for_token=False, fingerprint=None)
    survey = "archive#lot=a&survey=b"
    assert announcement(page, tmp_path, is_simulation=False, survey=survey) == [
        f"hawk: open {URL}",
        f"hawk: the survey, with its stalls and counts: {URL}{survey}",
    ]
    assert announcement(page, tmp_path, is_simulation=False) == [f"hawk: open {URL}"]
