"""Version 6: surveys and lots have states by which they are sent on; a store takes in those of others."""

from __future__ import annotations

from typing import Final

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"

_DOCUMENT: Final = """CREATE TABLE document (
  survey INTEGER NOT NULL PRIMARY KEY,
  writer TEXT NOT NULL,
  state INTEGER NOT NULL,
  digest VARCHAR(64) NOT NULL,
  place TEXT NOT NULL,
  loose TEXT NOT NULL,
  picture INTEGER NOT NULL,
  FOREIGN KEY(survey) REFERENCES survey (seq) ON DELETE CASCADE
)"""
_LOT_DOCUMENT: Final = """CREATE TABLE lot_document (
  lot VARCHAR(36) NOT NULL PRIMARY KEY,
  writer TEXT NOT NULL,
  state INTEGER NOT NULL,
  digest VARCHAR(64) NOT NULL,
  is_current BOOLEAN NOT NULL,
  body BLOB NOT NULL
)"""
_INDICES: Final = (
    "CREATE INDEX ix_outbox_body ON outbox (kind, body)",
    "CREATE INDEX ix_document_loose ON document (survey) WHERE loose != '[]'",
)
_NOTES: Final = (
    "INSERT INTO digest (part, key) VALUES ('{part}', CAST({row}.{column} AS TEXT))"
    " ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; "
)
_ROWS: Final = {"insert": ("NEW",), "update": ("OLD", "NEW"), "delete": ("OLD",)}


def upgrade() -> None:
    """Add the tables with the triggers that note which digests change, the indices, and the column.

    The digests of all parts are stored behind the last step, and give every survey and lot its first state.
    """
    for statement in (_DOCUMENT, _LOT_DOCUMENT, *_INDICES):
        op.execute(statement)
    for table, part, column in (("document", "survey", "survey"), ("lot_document", "lot", "lot")):
        for does, rows in _ROWS.items():
            notes = "".join(_NOTES.format(part=part, row=row, column=column) for row in rows)
            op.execute(f"CREATE TRIGGER digest_{table}_{does} AFTER {does.upper()} ON {table} BEGIN {notes}END")
    op.add_column("survey", sa.Column("landing", sa.Integer))
    op.execute("PRAGMA user_version = 6")
