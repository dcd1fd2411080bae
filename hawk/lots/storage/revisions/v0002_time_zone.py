"""Version 2: a lot has the time zone that a person chose."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Add the column; no lot has one yet."""
    op.add_column("lot", sa.Column("time_zone", sa.String(64)))
    op.execute("PRAGMA user_version = 2")
