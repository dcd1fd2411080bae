"""Version 4: columns whose names had several meanings have other ones, in the tables and in the changes."""

from __future__ import annotations

import json
from typing import Any, Final

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"

_NAMES: Final = {
    "observation": {"looked": "looked_at", "taken": "taken_probability", "seen": "picture_count"},
    "survey": {"seen": "seen_ground"},
}
"""Table -> its columns and the names that they get."""


def upgrade() -> None:
    """Rename the columns. A change keeps them by their names: one of an earlier version can still be undone."""
    for table, names in _NAMES.items():
        for former, name in names.items():
            op.execute(f"ALTER TABLE {table} RENAME COLUMN {former} TO {name}")
    connection = op.get_bind()
    bodies = connection.exec_driver_sql("SELECT seq, body FROM change ORDER BY seq")
    renamed = [{"seq": seq, "body": new} for seq, body in bodies.all() if (new := _renamed(body)) != body]
    if renamed:
        connection.execute(sa.text("UPDATE change SET body = :body WHERE seq = :seq"), renamed)
    op.execute("PRAGMA user_version = 4")


def _renamed(body: str) -> str:
    """Return what a change says with the new names; one that is damaged stays as it is."""
    try:
        groups: list[dict[str, Any]] = json.loads(body)
        if not any(group["table"] in _NAMES for group in groups):
            return body
        for group in groups:
            names = _NAMES.get(group["table"], {})
            for side in ("before", "after"):
                if group[side] is not None:
                    group[side] = {names.get(column, column): value for column, value in group[side].items()}
    except (ValueError, LookupError, TypeError, AttributeError):
        return body
    return json.dumps(groups, allow_nan=False, separators=(",", ":"))
