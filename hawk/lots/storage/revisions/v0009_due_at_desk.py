"""Version 9: a store knows what is due at the desk that it is sent to."""

from __future__ import annotations

from alembic import op

revision = "0009"
down_revision = "0008"


def upgrade() -> None:
    """Add the column."""
    op.execute("ALTER TABLE desk ADD COLUMN due TEXT")
    op.execute("PRAGMA user_version = 9")
