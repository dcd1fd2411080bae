"""Version 8: a store knows what came from drones and programs, and what became of it."""

from __future__ import annotations

from typing import Final

from alembic import op

revision = "0008"
down_revision = "0007"

_ARRIVAL: Final = """CREATE TABLE arrival (
  seq INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
  at FLOAT NOT NULL,
  sender TEXT NOT NULL,
  kind VARCHAR(8) NOT NULL,
  name TEXT NOT NULL,
  lot VARCHAR(36),
  state INTEGER,
  outcome VARCHAR(8) NOT NULL,
  reason TEXT NOT NULL,
  times INTEGER NOT NULL
)"""


def upgrade() -> None:
    """Make the table and its indices."""
    op.execute(_ARRIVAL)
    for column in ("sender", "lot"):
        op.execute(f"CREATE INDEX ix_arrival_{column} ON arrival ({column})")
    op.execute("PRAGMA user_version = 8")
