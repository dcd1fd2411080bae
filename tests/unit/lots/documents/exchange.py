"""Exchange of documents between the store of a drone and that of a desk, in both directions, for the tests."""

from __future__ import annotations

from sqlalchemy import select

from hawk.daemon.lots.keeper import find_stalls
from hawk.lots import outbox
from hawk.lots.documents import lot_document, lot_return, parts, source
from hawk.lots.documents.collection import collect_lots
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import OUTBOX
from hawk.lots.storage.states import KINDS, LOT_STATE
from tests.unit.lots.documents.drones import DRONE, NOW, Drone, collected

DESK = "desk"


def documents_to_send(drone: Drone) -> list[tuple[str, int, bytes]]:
    """Return the kind, the state and the document of each state that the desk has not got."""
    found = []
    with drone.store.reading() as connection:
        asked = select(OUTBOX.c.seq, OUTBOX.c.kind, OUTBOX.c.body).where(OUTBOX.c.kind.in_(KINDS))
        for seq, kind, named in connection.execute(asked.order_by(OUTBOX.c.seq)).all():
            if not outbox.is_waiting(connection, kind, named, DESK):
                continue
            if kind != LOT_STATE:
                found.append((kind, seq, parts.packed(source.document_of(connection, named, {}))))
            elif (lots := source.document_of_lot(connection, named)) is not None:
                found.append((kind, seq, parts.packed(lots)))
            else:
                found.append((kind, seq, b""))
    return found


def take(centre: Database, kind: str, data: bytes, writer: str) -> None:
    """Take a document in at a desk."""
    if kind != LOT_STATE:
        collected(centre, data, writer)
    elif data:
        with centre.writing() as connection:
            collect_lots(connection, lot_document.unpacked(data), writer)


def send(drone: Drone, centre: Database, writer: str = DRONE) -> int:
    """Send what the desk has not got; return how many documents that were."""
    sent = documents_to_send(drone)
    for kind, seq, data in sent:
        take(centre, kind, data, writer)
        drone.do(outbox.note_states_sent, [seq], DESK, NOW)
    return sum(bool(data) for _, _, data in sent)


def ask(drone: Drone, centre: Database, limit: int = 2, writer: str | None = None) -> list[str]:
    """Take the lots that changed at the desk; return the names of those whose plan was changed at both ends."""
    replaced: list[str] = []
    with drone.store.reading() as connection:
        asked: lot_return.LotQuery | None = lot_return.first_query(connection, DESK)
    while asked is not None:
        with centre.reading() as connection:
            data = parts.packed(source.changed_lots(connection, asked.after, limit, writer))
        returned = drone.do(lot_return.take_back, lot_document.unpacked(data), asked, NOW, find_stalls)
        replaced += returned.replaced
        asked = returned.next
    return replaced


def meet(drone: Drone, centre: Database, writer: str = DRONE) -> list[str]:
    """Send everything and ask, until neither end has anything to say; return as `ask`."""
    replaced: list[str] = []
    for _ in range(6):
        is_any = send(drone, centre, writer)
        replaced += ask(drone, centre)
        if not is_any and not send(drone, centre, writer):
            return replaced
    raise AssertionError("both ends go on for ever")
