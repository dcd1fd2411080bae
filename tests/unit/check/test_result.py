from __future__ import annotations

import io
import json

import pytest
from rich.console import Console

from hawk.check.result import failed, passed, print_json, print_table

SAID = "PreArm: \x1b[31mh\ufffd\udcff\u202e\nCheck"


@pytest.mark.fault(
    "`hawk-drone check --json` while a text that a terminal obeys comes from the autopilot",
    "JSON, in ASCII",
)
@pytest.mark.parametrize("encoding", ["utf-8", "ascii", "latin-1"])
def test_json_is_json_whatever_a_link_said_and_a_terminal_can_write(encoding: str) -> None:
    raw = io.BytesIO()
    file = io.TextIOWrapper(raw, encoding)
    print_json(Console(file=file), [failed("Autopilot", SAID, f"Read: {SAID}"), passed("Höhe", "±3 °")])
    file.flush()
    assert raw.getvalue().isascii()
    first, second = json.loads(raw.getvalue())["checks"]
    assert first["value"] == "PreArm: \\x1b[31mh\ufffd\\xff\\u202e\\nCheck"
    assert second == {"name": "Höhe", "outcome": "passed", "value": "±3 °", "remedy": ""}


def test_the_table_prints_nothing_raw() -> None:
    file = io.StringIO()
    print_table(Console(file=file, width=200), [failed("Autopilot", SAID, "Read.")])
    assert r"\x1b[31m" in file.getvalue()
    assert not {"\x1b", "\u202e", "\udcff"} & set(file.getvalue())
