"""Version 7: a lot has documents of several writers; a store knows the lots of the desk that it is sent to."""

from __future__ import annotations

from typing import Final

from alembic import op

revision = "0007"
down_revision = "0006"

_LOT_DOCUMENT: Final = """CREATE TABLE lot_document (
  lot VARCHAR(36) NOT NULL,
  writer TEXT NOT NULL,
  base VARCHAR(64) NOT NULL,
  state INTEGER NOT NULL,
  digest VARCHAR(64) NOT NULL,
  "plan" VARCHAR(64) NOT NULL,
  decided INTEGER NOT NULL,
  body BLOB NOT NULL,
  PRIMARY KEY (lot, writer, base)
)"""
_DESK: Final = """CREATE TABLE desk (
  target VARCHAR(16) NOT NULL PRIMARY KEY,
  state INTEGER NOT NULL
)"""
_CHANGED_HERE: Final = """SELECT 1 FROM change WHERE change.state = 'done' AND (
  (lot = former_document.lot AND kind NOT IN ('name', 'time_zone', 'move', 'delete', 'place', 'drop'))
  OR (kind = 'merge' AND instr(body, former_document.lot) > 0))"""
_CARRIED: Final = f"""INSERT INTO lot_document
  SELECT lot, writer, '', state, digest,
    CASE WHEN is_current AND NOT EXISTS ({_CHANGED_HERE}) THEN 'unknown' ELSE '' END,
    CASE WHEN is_current THEN state ELSE 0 END, body
  FROM former_document"""  # noqa: S608 - our own words
"""A plan that the tables follow has a digest that this step cannot say: `hawk.lots.documents.lot_states.UNKNOWN`."""
_NOTES: Final = (
    "INSERT INTO digest (part, key) VALUES ('lot', CAST({row}.lot AS TEXT))"
    " ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; "
)
_ROWS: Final = {"insert": ("NEW",), "update": ("OLD", "NEW"), "delete": ("OLD",)}


def upgrade() -> None:
    """Make both tables, carry the documents over, and make the triggers again that note which digests change."""
    for does in _ROWS:
        op.execute(f"DROP TRIGGER digest_lot_document_{does}")
    op.execute("ALTER TABLE lot_document RENAME TO former_document")
    op.execute(_LOT_DOCUMENT)
    op.execute(_CARRIED)
    op.execute("DROP TABLE former_document")
    for does, rows in _ROWS.items():
        notes = "".join(_NOTES.format(row=row) for row in rows)
        op.execute(f"CREATE TRIGGER digest_lot_document_{does} AFTER {does.upper()} ON lot_document BEGIN {notes}END")
    op.execute(_DESK)
    op.execute("PRAGMA user_version = 7")
