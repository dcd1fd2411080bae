"""Version 9: a store keeps the newest survey of each lot, with its counts, what is due at the desk that it is sent to,
and who made a link; surveys have indices of their times.
"""

from __future__ import annotations

import sqlite3
from typing import Final, cast

from alembic import op

from hawk.lots.storage.digests import Part, differs, digest_of

revision = "0009"
down_revision = "0008"
CHANGES_NO_ROW: Final = True
"""The rows of version 8 stay as they are, and their digests, but for those of lots with links."""

_LAST_SURVEY: Final = """CREATE TABLE last_survey (
  lot VARCHAR(36) NOT NULL PRIMARY KEY,
  stalls INTEGER,
  sections INTEGER,
  surveys INTEGER,
  survey INTEGER,
  survey_id VARCHAR(36),
  ended FLOAT,
  taken_at FLOAT,
  drone TEXT,
  free INTEGER,
  taken INTEGER,
  unknown INTEGER,
  been FLOAT,
  to_come FLOAT,
  FOREIGN KEY(lot) REFERENCES lot (id) ON DELETE CASCADE
)"""
_VALUES: Final = (
    "stalls", "sections", "surveys", "survey", "survey_id", "ended", "taken_at", "drone", "free", "taken", "unknown",
    "been", "to_come",
)  # fmt: skip
_NONE: Final = ", ".join(f"{each} = NULL" for each in _VALUES)
_FORGET: Final = f"UPDATE last_survey SET {_NONE} WHERE stalls IS NOT NULL AND lot"  # noqa: S608 - our own words
_OF_PART: Final = (
    "(CASE NEW.part WHEN 'lot' THEN NEW.\"key\" ELSE "
    '(SELECT lot FROM survey WHERE seq = CAST(NEW."key" AS INTEGER)) END)'
)
_NOTES: Final = (
    "INSERT INTO digest (part, key) VALUES ('last', {row}.lot)"
    " ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; "
)
_ROWS: Final = {"insert": ("NEW",), "update": ("OLD", "NEW"), "delete": ("OLD",)}


def upgrade() -> None:
    """Make the table with a row for each lot, all NULL, and its triggers; add the column.

    A part of the store that changes has no digest any more: then the row of its lot is NULL, and so is that of a lot
    which a survey leaves or comes to.
    """
    op.execute(_LAST_SURVEY)
    op.execute("CREATE INDEX ix_last_survey_open ON last_survey (lot) WHERE stalls IS NULL OR to_come IS NOT NULL")
    for does, rows in _ROWS.items():
        notes = "".join(_NOTES.format(row=row) for row in rows)
        op.execute(f"CREATE TRIGGER digest_last_survey_{does} AFTER {does.upper()} ON last_survey BEGIN {notes}END")
        lots = ", ".join(f"{row}.lot" for row in rows)
        forget = f"{_FORGET} IN ({lots}); "
        op.execute(f"CREATE TRIGGER last_survey_survey_{does} AFTER {does.upper()} ON survey BEGIN {forget}END")
    op.execute(
        "CREATE TRIGGER last_survey_digest_update AFTER UPDATE ON digest "
        f"WHEN NEW.digest IS NULL AND NEW.part IN ('lot', 'survey') BEGIN {_FORGET} = {_OF_PART}; END"
    )
    op.execute(
        "CREATE TRIGGER last_survey_lot_insert AFTER INSERT ON lot "
        "BEGIN INSERT INTO last_survey (lot) VALUES (NEW.id) ON CONFLICT DO NOTHING; END"
    )
    op.execute("INSERT INTO last_survey (lot) SELECT id FROM lot")
    op.execute("ALTER TABLE desk ADD COLUMN due TEXT")
    for column in ("began", "ended"):
        op.execute(f"CREATE INDEX ix_survey_{column} ON survey ({column})")
    _add_makers()
    op.execute("PRAGMA user_version = 9")


def _add_makers() -> None:
    """Add the column of who made a link, and digest the lots with links again: no row gets a new state, and what is
    damaged stays so.
    """
    store = cast("sqlite3.Connection", op.get_bind().connection.dbapi_connection)
    sealed = "SELECT key, digest FROM digest WHERE part = 'lot' AND key IN (SELECT lot FROM share)"
    found = [(Part("lot", lot), digest) for lot, digest in store.execute(sealed).fetchall()]
    whole = [part for part, digest in found if not differs(store, part, digest)]
    op.execute("ALTER TABLE share ADD COLUMN who TEXT")
    for part in whole:
        given = digest_of(store, part), part.key
        store.execute("UPDATE digest SET digest = ? WHERE part = 'lot' AND key = ?", given)
