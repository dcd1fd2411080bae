"""Version 7: links by which others read a lot.

``share.digest``: SHA-256 of the link's token, which is kept nowhere.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"


def upgrade() -> None:
    """Make the table."""
    op.create_table(
        "share",
        sa.Column("id", sa.String(36), primary_key=True),
        sa.Column("lot", sa.String(36), nullable=False, index=True),
        sa.Column("digest", sa.String(64), nullable=False, unique=True),
        sa.Column("made", sa.Float, nullable=False),
        sa.Column("ends", sa.Float, nullable=False),
        sa.Column("taken_back", sa.Float),
    )
    op.execute("PRAGMA user_version = 7")
