"""Tables of the lots' store, of `VERSION`; the steps that make them (`hawk.lots.storage.revisions`) have the triggers.

Times are UTC, Unix seconds. Places in a lot or survey are metres north and east of its datum.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from sqlalchemy import (
    Boolean,
    Column,
    Float,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    Text,
    text,
)

APPLICATION_ID: Final = 0x4841574B
"""SQLite's application_id of this store: "HAWK"."""
VERSION: Final = 9
"""Newest version, as in SQLite's user_version and in the names of `hawk.lots.storage.revisions`."""
SCHEMA: Final = "7b25661a0c3be25f87290258b313fef7"
"""`hawk.lots.storage.schema_check.digest_of_schema` of a fresh store."""

METADATA: Final = MetaData()

LOT: Final = Table(
    "lot",
    METADATA,
    Column("id", String(36), primary_key=True),
    Column("name", Text, nullable=False),
    Column("outline", Text, nullable=False),
    Column("latitude", Float, nullable=False),
    Column("longitude", Float, nullable=False),
    Column("datum_is_pinned", Boolean, nullable=False),
    Column("merged_into", ForeignKey("lot.id")),
    Column("made", Float, nullable=False),
    Column("time_zone", String(64)),
)
"""``time_zone``: the one that a person chose; NULL: that of the place (`hawk.lots.time_zone`)."""
LAYOUT: Final = Table(
    "layout",
    METADATA,
    Column("lot", ForeignKey("lot.id"), primary_key=True),
    Column("version", Integer, primary_key=True, autoincrement=False),
    Column("valid_from", Float, nullable=False),
    Column("why", Text, nullable=False),
    Column("who", Text, nullable=False),
)
SURVEY: Final = Table(
    "survey",
    METADATA,
    Column("seq", Integer, primary_key=True),
    Column("id", String(36), nullable=False, unique=True),
    Column("origin", Text, nullable=False, unique=True),
    Column("lot", ForeignKey("lot.id"), index=True),
    Column("layout", Integer),
    Column("placed", String(12), nullable=False),
    Column("candidates", Text, nullable=False),
    Column("began", Float, nullable=False),
    Column("ended", Float, nullable=False),
    Column("time_is_sure", Boolean, nullable=False),
    Column("latitude", Float, nullable=False),
    Column("longitude", Float, nullable=False),
    Column("outline", Text, nullable=False),
    Column("north", Float),
    Column("east", Float),
    Column("turn", Float),
    Column("free", Integer, nullable=False),
    Column("taken", Integer, nullable=False),
    Column("unknown", Integer, nullable=False),
    Column("stalls", LargeBinary, nullable=False),
    Column("program", Text, nullable=False),
    Column("simulated", Boolean, nullable=False),
    Column("seen_ground", LargeBinary),
    Column("doubt", Text),
    Column("accuracy", Float),
    Column("blurred", Integer),
    Column("kind", String(8), nullable=False),
    Column("source", String(12), nullable=False),
    Column("source_name", Text, nullable=False),
    Column("limits", Text, nullable=False),
    Column("vehicles", LargeBinary),
    Column("landing", Integer),
    Index("ix_survey_order", "lot", "kind", "time_is_sure", "ended"),
    Index("ix_survey_began", "began"),
    Index("ix_survey_ended", "ended"),
    sqlite_autoincrement=True,
)
"""Order: `hawk.lots.survey.order`. ``stalls``, ``vehicles``: `hawk.lots.storage.tables`; ``vehicles`` is NULL where the
network knew none. ``seen_ground``: `pack_outline` of the ground that was seen, with the holes in it; NULL without any:
such a survey is registered nowhere, since a row that the edge of the flight cuts is a shorter row. ``doubt``: JSON of
`hawk.lots.registration.survey_place.Doubt`, of a survey whose place was not certain; the place that a person chose
stays with a survey that goes on after a battery swap. ``accuracy``: metres, the receiver's own estimate at the landing.
``blurred``: stalls that only blurred pictures showed; NULL: not measured. ``kind`` to ``limits``:
`hawk.lots.survey.source`. ``landing``: of a survey that came as a document, its ``seq`` in the store that it is from;
NULL: it was stored here."""
STALL: Final = Table(
    "stall",
    METADATA,
    Column("key", Integer, primary_key=True),
    Column("id", String(36), nullable=False, unique=True),
    Column("lot", ForeignKey("lot.id"), nullable=False, index=True),
    Column("label", Text, nullable=False),
    Column("north", Float, nullable=False),
    Column("east", Float, nullable=False),
    Column("angle", Float, nullable=False),
    Column("width", Float, nullable=False),
    Column("length", Float, nullable=False),
    Column("kind", Text, nullable=False),
    Column("is_confirmed", Boolean, nullable=False),
    Column("begins", Integer, nullable=False),
    Column("ends", Integer),
    Column("first_survey", ForeignKey("survey.seq")),
    Column("first_id", Integer),
    Column("is_named", Boolean, nullable=False, server_default="0"),
    Index("ix_stall_place", "lot", "north"),
    Index("ix_stall_present", "lot", sqlite_where=text("ends IS NULL")),
    sqlite_autoincrement=True,
)
"""``begins``: first layout version that has it; ``ends``: first one that has it no more. ``first_survey`` and
``first_id``: the survey that found it, and its number there. ``kind``: `hawk.lots.plan.kinds`. ``is_named``: a person
gave or confirmed the label; else it is ours, and yields to one that a person gives."""
FORMER: Final = Table(
    "former",
    METADATA,
    Column("lot", String(36), primary_key=True),
    Column("stall", ForeignKey("stall.key"), primary_key=True),
    Column("ends", Integer, primary_key=True, autoincrement=False),
    Column("label", Text, nullable=False),
    *(Column(name, Float, nullable=False) for name in ("north", "east", "angle", "width", "length")),
    Column("kind", Text, nullable=False),
    Column("is_confirmed", Boolean, nullable=False),
    Column("is_named", Boolean, nullable=False, server_default="0"),
    Index("ix_former_stall", "stall"),
    sqlite_with_rowid=False,
)
"""Stalls as they were in the layout versions before ``ends``, back to the row of the next smaller ``ends``."""
LAST_SURVEY: Final = Table(
    "last_survey",
    METADATA,
    Column("lot", ForeignKey("lot.id", ondelete="CASCADE"), primary_key=True),
    Column("stalls", Integer),
    Column("sections", Integer),
    Column("surveys", Integer),
    Column("survey", Integer),
    Column("survey_id", String(36)),
    Column("ended", Float),
    Column("taken_at", Float),
    Column("drone", Text),
    Column("free", Integer),
    Column("taken", Integer),
    Column("unknown", Integer),
    Column("been", Float),
    Column("to_come", Float),
    Index("ix_last_survey_open", "lot", sqlite_where=text("stalls IS NULL OR to_come IS NOT NULL")),
)
"""Newest surveys of lots with their counts (`hawk.lots.survey.last_surveys`), which follow from other rows. All NULL: a
part of the store that they follow from has changed, as triggers note."""
LABEL: Final = Table(
    "label",
    METADATA,
    Column("lot", String(36), primary_key=True),
    Column("label", Text, primary_key=True),
    Column("stall", String(36), nullable=False),
)
"""Empty: a label is a stall's as long as the stall has it. Earlier versions had every label that a lot ever gave here;
the table stays, since the digests of their files have its rows in them."""
ZONE: Final = Table(
    "zone",
    METADATA,
    Column("id", String(36), primary_key=True),
    Column("lot", ForeignKey("lot.id"), nullable=False, index=True),
    Column("name", Text, nullable=False),
    Column("kind", Text, nullable=False),
    Column("outline", Text, nullable=False),
    Column("begins", Integer, nullable=False),
    Column("ends", Integer),
)
"""``outline``: JSON, a ring of [north, east], metres in the lot's frame, not closed. ``kind``:
`hawk.lots.plan.values.NO_STALLS`, or one of `hawk.lots.plan.kinds` of a zone that statistics count by itself."""
SECTION: Final = Table(
    "section",
    METADATA,
    Column("key", Integer, primary_key=True),
    Column("id", String(36), nullable=False),
    Column("lot", ForeignKey("lot.id"), nullable=False, index=True),
    Column("name", Text, nullable=False),
    Column("outline", Text, nullable=False),
    Column("kind", Text, nullable=False),
    Column("length_m", Float, nullable=False),
    Column("capacity", Integer),
    Column("is_capacity_given", Boolean, nullable=False),
    Column("note", Text, nullable=False),
    Column("begins", Integer, nullable=False),
    Column("ends", Integer),
    sqlite_autoincrement=True,
)
"""Sections (`hawk.lots.plan.values.PlanSection`). One that changes ends, and a row with the same ``id`` begins."""
SECTION_LOOK: Final = Table(
    "section_look",
    METADATA,
    Column("survey", ForeignKey("survey.seq"), primary_key=True),
    Column("section", String(36), primary_key=True, index=True),
    Column("looked_at", Float, nullable=False),
    Column("source", String(8), nullable=False),
    Column("parked", Integer, nullable=False),
    Column("least", Integer, nullable=False),
    Column("most", Integer, nullable=False),
    Column("hidden_share", Float, nullable=False),
    Column("seen_share", Float, nullable=False),
    Column("room", Integer),
    sqlite_with_rowid=False,
)
"""Counts of surveys at the sections of their lots (`hawk.lots.survey.section_looks`), made again whenever a survey or a
section changes. ``section``: its id."""
OBSERVATION: Final = Table(
    "observation",
    METADATA,
    Column("survey", ForeignKey("survey.seq"), primary_key=True),
    Column("stall", ForeignKey("stall.key"), primary_key=True),
    Column("looked_at", Float, nullable=False),
    Column("taken_probability", Float, nullable=False),
    Column("state", String(8), nullable=False),
    Column("picture_count", Integer, nullable=False),
    Index("ix_observation_stall", "stall"),
    sqlite_with_rowid=False,
)
LOOKS: Final = Table(
    "looks",
    METADATA,
    Column("survey", ForeignKey("survey.seq", ondelete="CASCADE"), primary_key=True),
    Column("at", Float, nullable=False),
    Column("stalls", LargeBinary, nullable=False),
)
"""Observations of a survey in one piece (`hawk.lots.survey.observations`), which triggers remove when an observation
changes. ``at``: mean moment of the looks."""
OUTBOX: Final = Table(
    "outbox",
    METADATA,
    Column("seq", Integer, primary_key=True),
    Column("kind", Text, nullable=False),
    Column("body", Text, nullable=False),
    Column("made", Float, nullable=False),
    Column("sent", Float),
    Index("ix_outbox_body", "kind", "body"),
    sqlite_autoincrement=True,
)
"""Messages to others, written in the transaction that they report, and the states of surveys and lots
(`hawk.lots.storage.states`)."""
DELIVERY: Final = Table(
    "delivery",
    METADATA,
    Column("message", ForeignKey("outbox.seq", ondelete="CASCADE"), primary_key=True),
    Column("target", String(16), primary_key=True),
    Column("tries", Integer, nullable=False),
    Column("first", Float, nullable=False),
    Column("next", Float, nullable=False),
    Column("sent", Float),
    Column("given_up", Float),
)
"""Deliveries of the outbox's messages (`hawk.lots.outbox`)."""
DOCUMENT: Final = Table(
    "document",
    METADATA,
    Column("survey", ForeignKey("survey.seq", ondelete="CASCADE"), primary_key=True),
    Column("writer", Text, nullable=False),
    Column("state", Integer, nullable=False),
    Column("digest", String(64), nullable=False),
    Column("place", Text, nullable=False),
    Column("loose", Text, nullable=False),
    Column("picture", Integer, nullable=False),
    Index("ix_document_loose", "survey", sqlite_where=text("loose != '[]'")),
)
"""Surveys that came as documents (`hawk.lots.documents.collection`). ``writer``: name of the drone's token. ``state``,
``digest``: order of the newest document. ``place``: JSON of the survey's place as that document has it. ``loose``: JSON
of its looks at stalls that no plan here has. ``picture``: state of the document whose picture is kept; 0: none."""
LOT_DOCUMENT: Final = Table(
    "lot_document",
    METADATA,
    Column("lot", String(36), primary_key=True),
    Column("writer", Text, primary_key=True),
    Column("base", String(64), primary_key=True),
    Column("state", Integer, nullable=False),
    Column("digest", String(64), nullable=False),
    Column("plan", Text, nullable=False),
    Column("decided", Integer, nullable=False),
    Column("body", LargeBinary, nullable=False),
)
"""Plans that came as documents (`hawk.lots.documents.lot_states`): the newest state of a lot by each writer, from each
plan that the writer had of it. ``writer``: name of the drone's token; "": the desk that this store is sent to.
``base``: digest of the plan that the writer took from here; "": none. ``plan``: digests of the lot's tables since they
were written by this state, the last one as they are: states of other lots have taken stalls since, or brought them
back; "": they were not, or by another state since. ``decided``: the newest state that was written,
or that a person refused; of a desk's, the revision of the plan with it. ``body``: compressed JSON of
`hawk.lots.documents.lot_document.LotPart`."""
ARRIVAL: Final = Table(
    "arrival",
    METADATA,
    Column("seq", Integer, primary_key=True),
    Column("at", Float, nullable=False),
    Column("sender", Text, nullable=False, index=True),
    Column("kind", String(8), nullable=False),
    Column("name", Text, nullable=False),
    Column("lot", String(36), index=True),
    Column("state", Integer),
    Column("outcome", String(8), nullable=False),
    Column("reason", Text, nullable=False),
    Column("times", Integer, nullable=False),
    sqlite_autoincrement=True,
)
"""Everything that drones and programs have sent here, in the order of its arrival (`hawk.lots.documents.arrival`).
``times``: number of refusals in a row that were alike. The table has no digest: nothing is counted by it."""
DESK: Final = Table(
    "desk",
    METADATA,
    Column("target", String(16), primary_key=True),
    Column("state", Integer, nullable=False),
    Column("apart", Integer),
    Column("due", Text),
)
"""Desks that this store is sent to, as `DELIVERY` names them. ``state``: number at the desk up to which its lots were
taken from there. ``due``: JSON of `hawk.lots.documents.lot_document.LotDue`, of its newest answer. ``apart``: the least
of a lot that was left out, on the ground of another one; NULL: none was. The
table has no digest: the lots have, and what changes at the desk comes again."""
CHANGE: Final = Table(
    "change",
    METADATA,
    Column("seq", Integer, primary_key=True),
    Column("kind", Text, nullable=False),
    Column("lot", String(36), nullable=False, index=True),
    Column("who", Text, nullable=False),
    Column("made", Float, nullable=False),
    Column("body", Text, nullable=False),
    Column("state", String(8), nullable=False),
    Column("undone", Float),
    Column("edit", ForeignKey("edit.id"), index=True),
    Column("revision", Integer),
    sqlite_autoincrement=True,
)
"""Changes by persons (`hawk.lots.change_log`). ``lot``: the one that it is about. ``body``: columns as they were and as
they are since. ``edit``: the edit of a plan whose step it is; NULL for a change by itself. ``revision``: of the plan
when the step was last done, undone or done again."""
DROPPED: Final = Table(
    "dropped",
    METADATA,
    Column("id", String(36), primary_key=True),
    Column("lot", String(36), nullable=False, index=True),
    Column("survey", ForeignKey("survey.seq"), nullable=False),
    Column("does", String(5), nullable=False),
    Column("stall", String(36)),
    *(Column(name, Float) for name in ("north", "east", "angle", "width", "length")),
)
"""Proposals of a survey that persons dropped (`hawk.lots.change_detection.proposals`): ``begin`` with a shape in the
lot's frame, ``end`` with the id of a stall."""
SHARE: Final = Table(
    "share",
    METADATA,
    Column("id", String(36), primary_key=True),
    Column("lot", String(36), nullable=False, index=True),
    Column("digest", String(64), nullable=False, unique=True),
    Column("made", Float, nullable=False),
    Column("ends", Float, nullable=False),
    Column("taken_back", Float),
    Column("who", Text),
)
"""Links by which others read a lot (`hawk.lots.shares`). ``digest``: SHA-256 of the token. ``who``: the person with a
role for some lots who made it; NULL: a role for all lots did, or an earlier version."""
PIN: Final = Table(
    "pin",
    METADATA,
    Column("lot", String(36), primary_key=True),
    Column("turn", Float, nullable=False),
)
"""Radians clockwise by which pins have turned a lot's frame."""
PLAN: Final = Table(
    "plan",
    METADATA,
    Column("lot", String(36), primary_key=True),
    Column("revision", Integer, nullable=False),
    Column("whole", Integer, nullable=False),
)
"""``revision`` rises with every change of a lot's stalls and zones. ``whole``: the last one that no step of an edit
made; who knows an earlier one reads the plan again. Rows are never removed: revisions never fall."""
EDIT: Final = Table(
    "edit",
    METADATA,
    Column("id", String(36), primary_key=True),
    Column("lot", String(36), nullable=False),
    Column("version", Integer, nullable=False),
    Column("who", Text, nullable=False),
    Column("began", Float, nullable=False),
    Column("touched", Float, nullable=False),
    Column("closed", Float),
    Column("change", Integer),
)
"""Edits of plans by persons. ``version``: of the layout that it makes. ``change``: number of the change that its end
made; NULL while it is open, or where it changed nothing. Its steps are changes, too."""
Index("ix_edit_open", EDIT.c.lot, unique=True, sqlite_where=EDIT.c.closed.is_(None))
DIGEST: Final = Table(
    "digest",
    METADATA,
    Column("part", String(8), primary_key=True),
    Column("key", String(36), primary_key=True),
    Column("digest", LargeBinary),
    sqlite_with_rowid=False,
)
"""Digests of the parts of the store (`hawk.lots.storage.digests`)."""
Index("ix_digest_changed", DIGEST.c.part, DIGEST.c.key, sqlite_where=DIGEST.c.digest.is_(None))
ERASED: Final = Table("erased", METADATA, Column("id", String(64), primary_key=True))
"""SHA-256 of the ids of lots and surveys that were erased: a backup that is restored does not bring them back."""

_LOT_TABLES: Final = (
    "layout", "stall", "former", "label", "zone", "share", "pin", "plan", "edit", "section", "lot_document",
)  # fmt: skip
PARTS: Final[Mapping[str, Mapping[str, str]]] = {
    "survey": {
        "survey": "seq",
        "observation": "survey",
        "looks": "survey",
        "dropped": "survey",
        "section_look": "survey",
        "document": "survey",
    },
    "lot": {"lot": "id", **dict.fromkeys(_LOT_TABLES, "lot")},
    "change": {"change": "seq"},
    "outbox": {"outbox": "seq", "delivery": "message"},
    "last": {"last_survey": "lot"},
}
"""Kind of a part of the store, which has one digest -> its tables, with the column that is its key."""
