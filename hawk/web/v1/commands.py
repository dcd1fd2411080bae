"""Changes of lots, plans and links for `hawk.web.v1.table`.

Each function runs on the thread of the store that writes, which loads this module and SQLAlchemy with it
(`hawk.runtime.late`).
"""

from __future__ import annotations

from sqlalchemy import Connection

from hawk.lots import commands, shares
from hawk.lots.answers import Undone
from hawk.lots.plan import edits
from hawk.web.v1.changes import Command


def rename(connection: Connection, command: Command) -> object:
    """Name a lot."""
    return commands.rename(connection, command.id, command.body["name"], command.who, command.now)


def choose_time_zone(connection: Connection, command: Command) -> object:
    """Say a lot's time zone."""
    return commands.choose_time_zone(connection, command.id, command.body["time_zone"], command.who, command.now)


def merge(connection: Connection, command: Command) -> object:
    """Merge another lot into this one."""
    other = command.body["with"]
    return commands.merge(connection, command.id, other, command.who, command.now, command.register)


def split(connection: Connection, command: Command) -> object:
    """Split stalls off as a lot of their own."""
    return commands.split(connection, command.id, command.body, command.who, command.now)


def pin(connection: Connection, command: Command) -> object:
    """Pin a lot to its place on Earth."""
    return commands.pin(connection, command.id, command.body, command.who, command.now)


def take_over(connection: Connection, command: Command) -> object:
    """Take proposals of a survey over."""
    return commands.take_over(connection, command.id, command.body, command.who, command.now)


def drop(connection: Connection, command: Command) -> object:
    """Drop proposals of a survey: the same evidence does not propose them again."""
    return commands.drop(connection, command.id, command.body, command.who, command.now)


def move(connection: Connection, command: Command) -> object:
    """Move a survey to another lot."""
    return commands.move(connection, command.id, command.body, command.who, command.now, command.register)


def delete(connection: Connection, command: Command) -> object:
    """Delete a survey of a lot."""
    return commands.delete(connection, command.id, command.who, command.now)


def choose(connection: Connection, command: Command) -> object:
    """Register a survey at one of the places where it may lie."""
    return commands.choose(connection, command.id, command.body, command.who, command.now)


def undo(connection: Connection, command: Command) -> object:
    """Undo a change, once."""
    seq = int(command.path["seq"])
    return Undone(seq=seq, kind=commands.undo(connection, seq, command.now))


def open_edit(connection: Connection, command: Command) -> object:
    """Open an edit of a plan, or go on with it. One who has a token of their own edits under its name."""
    who = {"who": command.person} if command.person else {}
    return edits.open_edit(connection, command.id, {**command.body, **who}, command.now)


def close_edit(connection: Connection, command: Command) -> object:
    """Close an edit."""
    return edits.close(connection, command.id, command.body, command.now)


def edit_plan(connection: Connection, command: Command) -> object:
    """Do an operation within an edit."""
    return edits.do(connection, command.id, command.body, command.now)


def undo_step(connection: Connection, command: Command) -> object:
    """Undo the newest operation of an edit."""
    return edits.undo(connection, command.id, command.body, command.now)


def redo_step(connection: Connection, command: Command) -> object:
    """Do the operation of an edit again that was undone last."""
    return edits.redo(connection, command.id, command.body, command.now)


def share(connection: Connection, command: Command) -> object:
    """Make a link to a lot; the answer alone holds its token."""
    return shares.share(
        connection, command.id, command.body, command.now, command.person, command.lots_of
    )  # fmt: skip


def take_back(connection: Connection, command: Command) -> object:
    """Let a link open nothing from now on."""
    return shares.take_back(connection, command.id, command.now)
