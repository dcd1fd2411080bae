from __future__ import annotations

from typing import Any

import pytest

from hawk.comm.autopilot.status_texts import StatusTexts


def text(words: str, severity: int = 6, number: int = 0, chunk: int = 0) -> dict[str, Any]:
    return {"text": words, "severity": severity, "id": number, "chunk_seq": chunk}


def test_a_short_text_is_given_as_it_is() -> None:
    found = StatusTexts().take(text("Arming motors\0\0"), 5.0)
    assert found is not None
    assert (found.time, found.severity, found.text) == (5.0, 6, "Arming motors")


def test_a_long_text_is_put_together_in_order() -> None:
    texts = StatusTexts()
    first, second = "a" * 50, "b" * 50
    assert texts.take(text(second, number=7, chunk=1), 1.0) is None
    assert texts.take(text(first, number=7, chunk=0), 1.0) is None
    found = texts.take(text("end", number=7, chunk=2), 1.0)
    assert found is not None
    assert found.text == first + second + "end"


def test_two_long_texts_do_not_mix() -> None:
    texts = StatusTexts()
    texts.take(text("x" * 50, number=1), 1.0)
    texts.take(text("y" * 50, number=2), 1.0)
    found = texts.take(text("!", number=2, chunk=1), 1.0)
    assert found is not None
    assert found.text == "y" * 50 + "!"


def test_texts_that_never_end_do_not_pile_up_and_the_last_fifty_are_kept() -> None:
    texts = StatusTexts()
    for number in range(1, 500):
        texts.take(text("z" * 50, number=number), 1.0)
    assert len(texts._chunks) == 50
    newest = texts.take(text("!", number=450, chunk=1), 1.0)
    assert newest is not None
    assert newest.text == "z" * 50 + "!"
    older = texts.take(text("!", number=449, chunk=1), 1.0)
    assert older is not None
    assert older.text == "!"


def test_a_text_without_a_number_is_whole() -> None:
    found = StatusTexts().take({"text": "x" * 50, "severity": 6}, 1.0)
    assert found is not None
    assert found.text == "x" * 50


def test_fifty_texts_explain_and_a_notice_does_not() -> None:
    texts = StatusTexts()
    texts.take(text("Arm: first", 2), 1.0)
    for number in range(49):
        texts.take(text(f"word {number}", 5), 2.0)
    assert texts.reason_since(0.0) == "Arm: first"
    texts.take(text("one more", 5), 2.0)
    assert texts.reason_since(0.0) is None


def test_the_arming_reason_is_found_among_other_words() -> None:
    texts = StatusTexts()
    texts.take(text("Arm: old reason", 2), 1.0)
    texts.take(text("EKF3 IMU0 is using GPS", 4), 9.5)
    texts.take(text("Arm: Throttle too high", 2), 9.8)
    texts.take(text("PreArm: Compass not healthy", 2), 9.9)
    texts.take(text("Arm: Throttle too high", 2), 10.0)
    assert texts.reason_since(9.0) == "Arm: Throttle too high; PreArm: Compass not healthy"


def test_without_an_arming_reason_any_warning_explains() -> None:
    texts = StatusTexts()
    texts.take(text("Mission: 1 WP", 6), 9.0)
    assert texts.reason_since(8.0) is None
    texts.take(text("Mode change to AUTO failed: init failed", 4), 9.1)
    assert texts.reason_since(8.0) == "Mode change to AUTO failed: init failed"
    assert texts.reason_since(9.2) is None


def chunk(number: int, sequence: int, data: bytes) -> dict[str, Any]:
    """Return a chunk as MAVSDK gives it: U+FFFD for each byte that is no UTF-8."""
    whole = data.decode("utf-8", "surrogateescape")
    text = "".join("\ufffd" if "\ud800" <= each <= "\udfff" else each for each in whole)
    return {"id": number, "chunk_seq": sequence, "severity": 4, "text": text}


@pytest.mark.fault("a STATUSTEXT that is no UTF-8, with escape sequences or a turned writing direction")
@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b[2J\x1b[31mall well", r"\x1b[2J\x1b[31mall well"),
        ("h\ufffd\ufffdello", "h\ufffd\ufffdello"),
        ("two\nlines\r", r"two\nlines"),
        ("\u202eturned", r"\u202eturned"),
    ],
)
def test_what_a_terminal_obeys_is_shown_as_an_escape(text: str, shown: str) -> None:
    found = StatusTexts().take({"text": text, "severity": 4}, 1.0)
    assert found is not None
    assert found.text == shown


@pytest.mark.parametrize("data", [b"\xff" * 50, ("é" * 25).encode(), b"\x1b" * 50, b"x" * 49 + b"\xc3"])
def test_a_whole_chunk_is_counted_in_bytes(data: bytes) -> None:
    texts = StatusTexts()
    assert len(data) == 50
    assert texts.take(chunk(7, 0, data), 1.0) is None, "more follows"
    found = texts.take(chunk(7, 1, b"end"), 1.1)
    assert found is not None
    assert found.text.endswith("end")
