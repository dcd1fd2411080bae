"""Version 1: the store as it is first released."""

from __future__ import annotations

from alembic import op

from hawk.lots import schema

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Make all tables and triggers."""
    schema.create(op.get_bind())
