from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.runtime.repeated_log import plain, plain_lines


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("PreArm: Check fence", "PreArm: Check fence"),
        ("Höhe 20 m, ±3 °, 停車場 🚗", "Höhe 20 m, ±3 °, 停車場 🚗"),
        ("\x1b[31mred\x1b[0m", r"\x1b[31mred\x1b[0m"),
        ("\x1b]0;title\x07", r"\x1b]0;title\x07"),
        ("\x9b31m", r"\x9b31m"),
        ("one\r\ntwo\0", r"one\r\ntwo\x00"),
        ("\x7f\x08", r"\x7f\x08"),
        ("\u202eright to left\u2066", r"\u202eright to left\u2066"),
        ("zero\u200bwidth\ufeff", r"zero\u200bwidth\ufeff"),
        ("line\u2028paragraph\u2029", r"line\u2028paragraph\u2029"),
        ("tag\U000e0041 private\ue000", r"tag\U000e0041 private\ue000"),
        (b"h\xff".decode("utf-8", "surrogateescape"), r"h\xff"),
        ("half \ud83d", r"half \ud83d"),
    ],
)
def test_what_is_obeyed_is_shown_as_an_escape(text: str, shown: str) -> None:
    assert plain(text) == shown


@pytest.mark.fault("control characters in anything that is logged: answers of a camera, file names, names of hosts")
@given(st.text(st.characters(codec=None), max_size=200))
def test_any_text_becomes_one_line_that_can_be_written_anywhere(text: str) -> None:
    shown = plain(text)
    assert not {unicodedata.category(each)[0] for each in shown} & {"C"}
    assert len(shown.splitlines()) <= 1
    shown.encode("utf-8")
    assert plain(shown) == shown


def test_lines_stay_lines() -> None:
    assert plain_lines("one\n\ttwo\x1b[2J\n") == "one\n    two\\x1b[2J\n"
