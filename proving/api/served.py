"""A real server with a small store of lots, for tools that try the API from outside."""

from __future__ import annotations

import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from sqlalchemy import Connection, select

from benchmarks.archive import drawn_lot, flight
from hawk.comm.clock import Clock
from hawk.comm.topic import Topic
from hawk.config.sections import OperatorSettings, StoreSettings, WebSettings
from hawk.lots.ingest import save
from hawk.lots.registration.frames import Move, same_stalls
from hawk.lots.storage.schema import STALL, SURVEY
from hawk.lots.store import LotStore
from hawk.lots.values import KnownGround, MappedGround, Registration
from hawk.runtime.performance import LagSummary
from hawk.store.recordings import Recordings
from hawk.web.app import Page, WebServer
from hawk.web.services import OperatorSide, WebServices

STALLS: Final = 40
SURVEYS: Final = 4
RECORDING: Final = "20260501T100000Z.mcap"


def _ids(connection: Connection) -> tuple[str, str, str]:
    """Return the ids of a lot, its newest survey and a stall."""
    lot, stall = connection.execute(select(STALL.c.lot, STALL.c.id)).first() or ("", "")
    return lot, str(connection.execute(select(SURVEY.c.id).order_by(SURVEY.c.seq.desc())).scalar()), stall


def _by_place(known: KnownGround, found: MappedGround) -> Registration:
    return Registration(0.0, 0.0, 0.0, same_stalls(known.stalls, found.stalls))


async def filled(folder: Path, surveys: int = SURVEYS) -> LotStore:
    """Return a store with surveys of one lot."""
    store = LotStore(folder / "lots.db", _by_place, {"synchronous": 0})
    rng = np.random.default_rng(1)
    centres = drawn_lot(STALLS, rng)
    for number in range(1, surveys + 1):
        given = replace(flight(number, centres, Move(), rng), time_is_sure=number != surveys)
        await store.write(lambda connection, given=given: save(connection, given, store.register))  # type: ignore[misc]
    return store


@dataclass(frozen=True, slots=True)
class Served:
    """A server: the ``address`` of its API, and ids of a lot, a survey and a stall, and the name of a recording."""

    address: str
    lot: str
    survey: str
    stall: str
    recording: str = RECORDING


@contextlib.asynccontextmanager
async def served(folder: Path) -> AsyncIterator[Served]:
    """Serve a filled store on a free port. Who asks on this computer is an operator."""
    clock = Clock()
    operator = OperatorSettings()
    store = await filled(folder)
    recordings = Recordings(StoreSettings(directory=folder))
    recordings.folder.mkdir()
    (recordings.folder / RECORDING).touch()
    services = WebServices(
        clock=clock,
        web=WebSettings(port=0),
        operator=operator,
        side=OperatorSide.create(clock, operator),
        status=Topic("status", clock),
        occupancy_map=Topic("map", clock),
        video=Topic("video", clock),
        version="0",
        simulation=True,
        camera_fov_deg=70.0,
        travel_speed_m_s=4.0,
        loop_lag=lambda: LagSummary(0.0, 0.0, 0.0, 0),
        lots=store,
        recordings=recordings,
        folder=folder,
    )
    server = WebServer(services, Page.load(folder))
    await server.start()
    try:
        lot, survey, stall = await store.read(_ids)
        yield Served(f"http://127.0.0.1:{server.port}/api/v1", lot, survey, stall)
    finally:
        await server.close()
        await store.close()
