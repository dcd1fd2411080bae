from __future__ import annotations

import io
import json

from hawk.picture.progress import shown_progress


def test_programs_get_a_line_a_step() -> None:
    out = io.StringIO()
    with shown_progress(out, as_json=True) as progress:
        progress("read", 0, 3)
        progress("read", 1, 3)
        progress("read", 3, 3)
        progress("map", 0, 2)
    lines = [json.loads(line) for line in out.getvalue().splitlines()]
    assert [(line["step"], line["done"], line["of"]) for line in lines] == [
        ("read", 0, 3),
        ("read", 3, 3),
        ("map", 0, 2),
    ]
    assert lines[0]["seconds_left"] is None
    assert lines[1]["seconds_left"] == 0.0


def test_persons_get_a_bar_with_the_step() -> None:
    out = io.StringIO()
    with shown_progress(out, as_json=False) as progress:
        progress("read", 1, 3)
        progress("map", 0, 2)
    assert "read" in out.getvalue()
