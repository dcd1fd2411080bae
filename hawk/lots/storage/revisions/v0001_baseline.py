"""Version 1: the store as release 0.4.0 made it. ``v0001_baseline.sql`` is a copy of its tables and triggers."""

from __future__ import annotations

from pathlib import Path

from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Make all tables and triggers."""
    for statement in Path(__file__).with_suffix(".sql").read_text("utf-8").split("\n\n"):
        op.get_bind().exec_driver_sql(statement)
    op.execute("PRAGMA user_version = 1")
