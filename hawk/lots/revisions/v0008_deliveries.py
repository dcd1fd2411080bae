"""Version 8: the deliveries of the outbox's messages to each receiver; a layout is a message, too.

``delivery.target``: beginning of the SHA-256 of the receiver's address, which may hold a secret. ``first``, ``next``:
times of the first try and of the next one; ``sent``: of the answer that said yes; ``given_up``: when trying ended.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"


def upgrade() -> None:
    """Make the table and the trigger."""
    op.create_table(
        "delivery",
        sa.Column("message", sa.Integer, sa.ForeignKey("outbox.seq", ondelete="CASCADE"), primary_key=True),
        sa.Column("target", sa.String(16), primary_key=True),
        sa.Column("tries", sa.Integer, nullable=False),
        sa.Column("first", sa.Float, nullable=False),
        sa.Column("next", sa.Float, nullable=False),
        sa.Column("sent", sa.Float),
        sa.Column("given_up", sa.Float),
    )
    # SQLite's JSON functions are refused in triggers of a file that is not trusted; a lot's id needs no escape
    body = """'{"lot":"' || NEW.lot || '","version":' || NEW.version || '}'"""
    op.execute(
        "CREATE TRIGGER outbox_layout AFTER INSERT ON layout BEGIN INSERT INTO outbox (kind, body, made) "  # noqa: S608
        f"VALUES ('layout', {body}, NEW.valid_from); END"
    )
    op.execute("PRAGMA user_version = 8")
