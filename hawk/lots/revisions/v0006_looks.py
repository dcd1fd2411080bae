"""Version 6: the looks of each survey in one piece, for statistics over a thousand surveys.

``looks.at``: mean moment of its looks, UTC, Unix seconds. ``looks.stalls``: `hawk.lots.looks.pack_looks`. A row repeats
what the table of observations says; triggers remove it when these change, and it is made again from them.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Make the table and the triggers."""
    op.create_table(
        "looks",
        sa.Column("survey", sa.Integer, sa.ForeignKey("survey.seq", ondelete="CASCADE"), primary_key=True),
        sa.Column("at", sa.Float, nullable=False),
        sa.Column("stalls", sa.LargeBinary, nullable=False),
    )
    for event, row in (("INSERT", "NEW"), ("UPDATE", "NEW"), ("DELETE", "OLD")):
        does = f"DELETE FROM looks WHERE survey = {row}.survey"  # noqa: S608 - no value from outside is in it
        op.execute(f"CREATE TRIGGER looks_{event.lower()} AFTER {event} ON observation BEGIN {does}; END")
    op.execute("PRAGMA user_version = 6")
