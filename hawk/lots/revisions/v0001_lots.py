"""Version 1: lots with layouts, stalls, zones and labels; surveys with what they saw."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Make the tables."""
    _lots()
    _surveys()
    op.execute("PRAGMA user_version = 1")


def _lots() -> None:
    op.create_table(
        "lot",
        sa.Column("id", sa.String(36), primary_key=True),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("outline", sa.Text, nullable=False),
        sa.Column("latitude", sa.Float, nullable=False),
        sa.Column("longitude", sa.Float, nullable=False),
        sa.Column("datum_is_pinned", sa.Boolean, nullable=False),
        sa.Column("merged_into", sa.String(36), sa.ForeignKey("lot.id")),
        sa.Column("made", sa.Float, nullable=False),
    )
    op.create_table(
        "layout",
        sa.Column("lot", sa.String(36), sa.ForeignKey("lot.id"), primary_key=True),
        sa.Column("version", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("valid_from", sa.Float, nullable=False),
        sa.Column("why", sa.Text, nullable=False),
        sa.Column("who", sa.Text, nullable=False),
    )
    op.create_table(
        "zone",
        sa.Column("id", sa.String(36), primary_key=True),
        sa.Column("lot", sa.String(36), sa.ForeignKey("lot.id"), nullable=False, index=True),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("kind", sa.Text, nullable=False),
        sa.Column("outline", sa.Text, nullable=False),
        sa.Column("begins", sa.Integer, nullable=False),
        sa.Column("ends", sa.Integer),
    )
    op.create_table(
        "label",
        sa.Column("lot", sa.String(36), primary_key=True),
        sa.Column("label", sa.Text, primary_key=True),
        sa.Column("stall", sa.String(36), nullable=False),
    )


def _surveys() -> None:
    op.create_table(
        "survey",
        sa.Column("seq", sa.Integer, primary_key=True),
        sa.Column("id", sa.String(36), nullable=False, unique=True),
        sa.Column("origin", sa.Text, nullable=False, unique=True),
        sa.Column("lot", sa.String(36), sa.ForeignKey("lot.id"), index=True),
        sa.Column("layout", sa.Integer),
        sa.Column("placed", sa.String(12), nullable=False),
        sa.Column("candidates", sa.Text, nullable=False),
        sa.Column("began", sa.Float, nullable=False),
        sa.Column("ended", sa.Float, nullable=False),
        sa.Column("time_is_sure", sa.Boolean, nullable=False),
        sa.Column("latitude", sa.Float, nullable=False),
        sa.Column("longitude", sa.Float, nullable=False),
        sa.Column("outline", sa.Text, nullable=False),
        *(sa.Column(name, sa.Float) for name in ("north", "east", "turn")),
        *(sa.Column(name, sa.Integer, nullable=False) for name in ("free", "taken", "unknown")),
        sa.Column("stalls", sa.LargeBinary, nullable=False),
        sa.Column("program", sa.Text, nullable=False),
        sa.Column("simulated", sa.Boolean, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "stall",
        sa.Column("key", sa.Integer, primary_key=True),
        sa.Column("id", sa.String(36), nullable=False, unique=True),
        sa.Column("lot", sa.String(36), sa.ForeignKey("lot.id"), nullable=False, index=True),
        sa.Column("label", sa.Text, nullable=False),
        *(sa.Column(name, sa.Float, nullable=False) for name in ("north", "east", "angle", "width", "length")),
        sa.Column("kind", sa.Text, nullable=False),
        sa.Column("is_confirmed", sa.Boolean, nullable=False),
        sa.Column("begins", sa.Integer, nullable=False),
        sa.Column("ends", sa.Integer),
        sa.Column("first_survey", sa.Integer, sa.ForeignKey("survey.seq")),
        sa.Column("first_id", sa.Integer),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "observation",
        sa.Column("survey", sa.Integer, sa.ForeignKey("survey.seq"), primary_key=True),
        sa.Column("stall", sa.Integer, sa.ForeignKey("stall.key"), primary_key=True),
        sa.Column("looked", sa.Float, nullable=False),
        sa.Column("taken", sa.Float, nullable=False),
        sa.Column("state", sa.String(8), nullable=False),
        sa.Column("seen", sa.Integer, nullable=False),
        sa.Index("ix_observation_stall", "stall"),
        sqlite_with_rowid=False,
    )
