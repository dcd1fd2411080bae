"""Version 3: a stall knows whether its label is a person's or ours; the list of all labels that were given is empty."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Add the columns. A label is a person's where they confirmed a stall that was found, or gave it another label."""
    for table in ("stall", "former"):
        op.add_column(table, sa.Column("is_named", sa.Boolean, nullable=False, server_default="0"))
        op.execute(f"UPDATE {table} SET is_named = is_confirmed")  # noqa: S608 - our own words
    drawn = {key for group in _groups("'add_row', 'split'") if "ends" in group["after"] for key in group["keys"]}
    _set_named([{"key": key} for key in drawn], "is_named = 0 WHERE key = :key")
    given = [
        {"key": key, "label": group["after"]["label"]}
        for group in _groups("'renumber', 'import'") if "label" in group["after"] for key in group["keys"]
    ]  # fmt: skip
    _set_named(given, "is_named = 1 WHERE key = :key AND label = :label")
    op.execute("DELETE FROM label")
    op.execute("PRAGMA user_version = 3")


def _groups(kinds: str) -> Iterator[dict[str, Any]]:
    """Yield what steps of some kinds set in the table of stalls. A change that is damaged says nothing."""
    asked = f"SELECT body FROM change WHERE kind IN ({kinds}) AND state = 'done' ORDER BY seq"  # noqa: S608 - our own words
    for (body,) in op.get_bind().exec_driver_sql(asked).all():
        try:
            groups = json.loads(body)
        except ValueError:
            continue
        yield from (group for group in groups if group["table"] == "stall" and group["after"])


def _set_named(rows: list[dict[str, Any]], how: str) -> None:
    if rows:
        op.get_bind().execute(sa.text(f"UPDATE stall SET {how}"), rows)  # noqa: S608 - our own words
