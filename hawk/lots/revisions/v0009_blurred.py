"""Version 9: the number of a survey's stalls that only blurred pictures showed.

``survey.blurred``: of ``free`` + ``taken`` + ``unknown``; NULL for surveys of earlier versions: it was not measured.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"


def upgrade() -> None:
    """Add the column."""
    op.add_column("survey", sa.Column("blurred", sa.Integer))
    op.execute("PRAGMA user_version = 9")
