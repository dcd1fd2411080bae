"""Version 3: the ground that a survey saw, and the places to choose from where its own is not certain.

``survey.seen``: zlib of JSON, WGS-84 rings of [latitude, longitude], degrees, not closed::

    {"polygons": [[[52.0, 5.0], ...]], "holes": [[[52.0001, 5.0001], ...]]}

``survey.doubt``: JSON. A place brings the survey's frame onto the lot's, metres and radians clockwise; ``score`` is in
nats; ``chosen`` is the number, from 0, of the place that a person chose::

    {
        "why": "two places fit alike",
        "places": [{"north": 0.4, "east": 2.5, "turn": 0.01, "score": 61.2}, ...],
        "chosen": null
    }

The ground is that of all cells of the map that are not unknown, with the holes in it, simplified by less than 0.6 m.
``chosen`` stays with a survey that goes on after a battery swap: the program does not overrule a person.

Both are empty for surveys of earlier versions. Such a survey is registered nowhere: without its ground, a row that the
edge of the flight cuts is a shorter row.
"""

from __future__ import annotations

from typing import Final

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"

_COLUMNS: Final = {"seen": sa.LargeBinary, "doubt": sa.Text}


def upgrade() -> None:
    """Add the columns."""
    for name, kind in _COLUMNS.items():
        op.add_column("survey", sa.Column(name, kind))
    op.execute("PRAGMA user_version = 3")
