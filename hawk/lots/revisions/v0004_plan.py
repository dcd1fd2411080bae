"""Version 4: plans that persons correct: edits with their steps, and stalls as earlier layout versions had them.

``step.body``: JSON, a list of groups of rows whose columns changed alike; ``table`` is ``stall`` or ``zone``::

    [{"table": "stall", "keys": [17, 18], "before": {"is_confirmed": false}, "after": {"is_confirmed": true}}]

A stall or zone that a step adds is a row whose ``ends`` was that of its first version: it is never deleted.

``zone.outline``: JSON, a ring of [north, east] in the lot's frame, metres; no earlier version wrote a zone.

``change.before`` and ``change.after`` of the kind ``plan`` name the edit: ``{"edit": ID}``.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    """Make the tables and the index by place."""
    op.create_index("ix_stall_place", "stall", ["lot", "north"])
    _former()
    _edits()
    op.execute("PRAGMA user_version = 4")


def _former() -> None:
    op.create_table(
        "former",
        sa.Column("lot", sa.String(36), primary_key=True),
        sa.Column("stall", sa.Integer, sa.ForeignKey("stall.key"), primary_key=True),
        sa.Column("ends", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("label", sa.Text, nullable=False),
        *(sa.Column(name, sa.Float, nullable=False) for name in ("north", "east", "angle", "width", "length")),
        sa.Column("kind", sa.Text, nullable=False),
        sa.Column("is_confirmed", sa.Boolean, nullable=False),
        sa.Index("ix_former_stall", "stall"),
        sqlite_with_rowid=False,
    )


def _edits() -> None:
    op.create_table(
        "plan",
        sa.Column("lot", sa.String(36), primary_key=True),
        sa.Column("revision", sa.Integer, nullable=False),
        sa.Column("whole", sa.Integer, nullable=False),
    )
    op.create_table(
        "edit",
        sa.Column("id", sa.String(36), primary_key=True),
        sa.Column("lot", sa.String(36), nullable=False),
        sa.Column("version", sa.Integer, nullable=False),
        sa.Column("who", sa.Text, nullable=False),
        sa.Column("began", sa.Float, nullable=False),
        sa.Column("touched", sa.Float, nullable=False),
        sa.Column("closed", sa.Float),
    )
    op.create_index("ix_edit_open", "edit", ["lot"], unique=True, sqlite_where=sa.text("closed IS NULL"))
    op.create_table(
        "step",
        sa.Column("seq", sa.Integer, primary_key=True),
        sa.Column("edit", sa.String(36), sa.ForeignKey("edit.id"), nullable=False, index=True),
        sa.Column("kind", sa.Text, nullable=False),
        sa.Column("made", sa.Float, nullable=False),
        sa.Column("revision", sa.Integer, nullable=False),
        sa.Column("state", sa.String(8), nullable=False),
        sa.Column("body", sa.Text, nullable=False),
        sqlite_autoincrement=True,
    )
