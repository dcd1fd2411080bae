"""Version 5: a plan has sections, a survey its vehicles and its looks at sections; indices find a lot's last survey and
its number of stalls.
"""

from __future__ import annotations

from typing import Final

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"

_SECTION: Final = """CREATE TABLE section (
  "key" INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
  id VARCHAR(36) NOT NULL,
  lot VARCHAR(36) NOT NULL,
  name TEXT NOT NULL,
  outline TEXT NOT NULL,
  kind TEXT NOT NULL,
  length_m FLOAT NOT NULL,
  capacity INTEGER,
  is_capacity_given BOOLEAN NOT NULL,
  note TEXT NOT NULL,
  begins INTEGER NOT NULL,
  ends INTEGER,
  FOREIGN KEY(lot) REFERENCES lot (id)
)"""
_SECTION_LOOK: Final = """CREATE TABLE section_look (
  survey INTEGER NOT NULL,
  section VARCHAR(36) NOT NULL,
  looked_at FLOAT NOT NULL,
  source VARCHAR(8) NOT NULL,
  parked INTEGER NOT NULL,
  least INTEGER NOT NULL,
  most INTEGER NOT NULL,
  hidden_share FLOAT NOT NULL,
  seen_share FLOAT NOT NULL,
  room INTEGER,
  PRIMARY KEY (survey, section),
  FOREIGN KEY(survey) REFERENCES survey (seq)
)
 WITHOUT ROWID"""
_INDICES: Final = (
    "CREATE INDEX ix_section_lot ON section (lot)",
    "CREATE INDEX ix_section_look_section ON section_look (section)",
    "CREATE INDEX ix_survey_order ON survey (lot, kind, time_is_sure, ended)",
    "CREATE INDEX ix_stall_present ON stall (lot) WHERE ends IS NULL",
)
_NOTES: Final = (
    "INSERT INTO digest (part, key) VALUES ('{part}', CAST({row}.{column} AS TEXT))"
    " ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; "
)
_ROWS: Final = {"insert": ("NEW",), "update": ("OLD", "NEW"), "delete": ("OLD",)}


def upgrade() -> None:
    """Add the tables with the triggers that note which digests change, and the column; no survey has vehicles yet."""
    for statement in (_SECTION, _SECTION_LOOK, *_INDICES):
        op.execute(statement)
    for table, part, column in (("section", "lot", "lot"), ("section_look", "survey", "survey")):
        for does, rows in _ROWS.items():
            notes = "".join(_NOTES.format(part=part, row=row, column=column) for row in rows)
            op.execute(f"CREATE TRIGGER digest_{table}_{does} AFTER {does.upper()} ON {table} BEGIN {notes}END")
    op.add_column("survey", sa.Column("vehicles", sa.LargeBinary))
    op.execute("PRAGMA user_version = 5")
