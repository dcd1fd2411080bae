"""Write the page of all settings from ``config.toml`` and their bounds.

``python packaging/settings_page.py`` writes ``docs/settings.md``; ``--check`` fails when that is out of date.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from hawk.config.reference import Setting, Value, reference_text, settings
from hawk.config.sections import Config

TARGET = Path(__file__).resolve().parent.parent / "docs" / "settings.md"

_HEADER = """# Settings

Written by `packaging/settings_page.py` from `config.toml`, whose comments say more of each: change that and run this
again.

A file (`hawk-drone run --config FILE`), then the environment (`HAWK_<SECTION>__<KEY>`, as `HAWK_WEB__PORT=3001`), then
command-line options set them; the last wins. They are checked as a whole before anything starts. A setting that cannot
be used is named with file, line, key and remedy, and the status is 2; so is a variable `HAWK_...` that is no setting,
and an option that would change nothing. `~` in a path is the home folder. The page shows all of them with their present
values under **Settings**, programs find them at `/api/settings.json`. How to add one:
[Add a setting](how-to/add-a-setting.md). A key is followed by its default and its bounds; one
without a text is as the one above.
"""


def page(found: Sequence[Setting]) -> str:
    """Return the page (Markdown): a list for each section."""
    blocks = [_HEADER]
    for section, group in groupby(found, lambda each: each.section):
        rows, before = [], ""
        for each in group:
            text = "" if each.text == before else f": {_short(each.text)}"
            rows.append(f"- `{each.key}` ({_value(each)}){text}")
            before = each.text
        blocks.append("\n".join([f"## {section}", "", *rows, ""]))
    return "\n".join(blocks)


def _value(setting: Setting) -> str:
    """Return the default and the bounds, with the unit behind the last of them."""
    text = _text(setting.default)
    parts = [f"`{text}`" if text else "none"]
    if setting.lowest is not None and setting.highest is not None:
        parts.append(f"{setting.lowest:.10g} to {setting.highest:.10g}")
    return f"{', '.join(parts)} {setting.unit if text or len(parts) > 1 else ''}".rstrip()


def _text(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return str(value)
    return "" if value is None else str(value)


def _short(text: str) -> str:
    """Return the first clause of a text; what parentheses hold belongs to it."""
    clause = re.match(r"(?:\([^)]*\)|(?!; |\. |: true or false).)*", text)
    return (clause[0] if clause else text).replace("<", "\\<")


def main() -> int:
    """Write the page, or check it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="fail when docs/settings.md is out of date")
    options = parser.parse_args()
    text = page(settings(Config(), reference_text()))
    if not options.check:
        TARGET.write_text(text, encoding="utf-8")
        return 0
    if not TARGET.is_file() or TARGET.read_text(encoding="utf-8") != text:
        print("docs/settings.md is out of date: run python packaging/settings_page.py", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
