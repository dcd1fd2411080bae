"""Version 10: the source of a survey: a flight with hawk, or pictures.

``survey.kind``: ``flown`` as all earlier ones, or ``picture``. ``source`` (photographs, orthophoto, film) and
``source_name`` are empty for a flown one. ``limits``: JSON list of `hawk.lots.source.Limit`.
"""

from __future__ import annotations

from typing import Final

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"

_COLUMNS: Final = {
    "kind": (sa.String(8), "flown"),
    "source": (sa.String(12), ""),
    "source_name": (sa.Text(), ""),
    "limits": (sa.Text(), "[]"),
}


def upgrade() -> None:
    """Add the columns."""
    for name, (kind, default) in _COLUMNS.items():
        op.add_column("survey", sa.Column(name, kind, nullable=False, server_default=default))
    op.execute("PRAGMA user_version = 10")
