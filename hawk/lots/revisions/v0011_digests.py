"""Version 11: a digest of each survey, lot, step, change and message, and what was erased.

``digest.part`` and ``key``: `hawk.lots.digests`. ``digest.digest``: BLAKE2b of its rows; NULL for a part that the
transaction under way has changed, which triggers note; empty for one that was damaged before it was changed.

``erased.id``: SHA-256 of the id of a lot or survey that was erased, so that a restored backup does not bring it back.
"""

from __future__ import annotations

from typing import Final

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"

_KEYS: Final = {
    "survey": {"survey": "seq", "observation": "survey", "looks": "survey", "dropped": "survey"},
    "lot": {"lot": "id"}
    | dict.fromkeys(("layout", "stall", "former", "label", "zone", "share", "pin", "plan", "edit"), "lot"),
    "step": {"step": "seq"},
    "change": {"change": "seq"},
    "outbox": {"outbox": "seq", "delivery": "message"},
}
"""Part -> its tables, with the column that is its key."""


def upgrade() -> None:
    """Make the tables and the triggers."""
    op.create_table(
        "digest",
        sa.Column("part", sa.String(8), primary_key=True),
        sa.Column("key", sa.String(36), primary_key=True),
        sa.Column("digest", sa.LargeBinary),
        sqlite_with_rowid=False,
    )
    op.create_index("ix_digest_changed", "digest", ["part", "key"], sqlite_where=sa.text("digest IS NULL"))
    op.create_table("erased", sa.Column("id", sa.String(64), primary_key=True))
    for part, tables in _KEYS.items():
        for table, key in tables.items():
            _note_changes(part, table, key)
    op.execute("PRAGMA user_version = 11")


def _note_changes(part: str, table: str, key: str) -> None:
    for event, rows in (("INSERT", ("NEW",)), ("UPDATE", ("OLD", "NEW")), ("DELETE", ("OLD",))):
        does = " ".join(
            f"INSERT INTO digest (part, key) VALUES ('{part}', CAST({row}.{key} AS TEXT)) "  # noqa: S608 - our words
            "ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL;"
            for row in rows
        )
        op.execute(f"CREATE TRIGGER digest_{table}_{event.lower()} AFTER {event} ON {table} BEGIN {does} END")
