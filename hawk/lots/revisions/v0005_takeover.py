"""Version 5: proposals that persons dropped, the turn of pinned lots, and the receiver's accuracy of a survey.

``dropped``: a proposal of a survey that a person does not want. ``does`` is ``begin``, with the shape in the lot's
frame, or ``end``, with the id of the stall. It stays away until later surveys show something else.

``pin.turn``: radians clockwise by which pins have turned the lot's frame; a lot without a row was never turned.

``survey.accuracy``: metres, the receiver's own estimate at the landing; empty for surveys of earlier versions.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    """Make the tables and add the column."""
    op.create_table(
        "dropped",
        sa.Column("id", sa.String(36), primary_key=True),
        sa.Column("lot", sa.String(36), nullable=False, index=True),
        sa.Column("survey", sa.Integer, sa.ForeignKey("survey.seq"), nullable=False),
        sa.Column("does", sa.String(5), nullable=False),
        sa.Column("stall", sa.String(36)),
        *(sa.Column(name, sa.Float) for name in ("north", "east", "angle", "width", "length")),
    )
    op.create_table(
        "pin",
        sa.Column("lot", sa.String(36), primary_key=True),
        sa.Column("turn", sa.Float, nullable=False),
    )
    op.add_column("survey", sa.Column("accuracy", sa.Float))
    op.execute("PRAGMA user_version = 5")
