"""The desk: lots and their plans on the page, from a store, on a computer without a drone.

It serves the same page and the same answers as the daemon, recordings too, and flies nothing: no link is opened, every
command to a drone is refused. Under the plan lies the picture of a survey of the lot.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import secrets
import signal
import time
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Final

from sqlalchemy import Connection

from hawk.comm.clock import Clock
from hawk.comm.protocol.commands import Ack, Command, Outgoing
from hawk.comm.protocol.heartbeat import ClientId, DroneStatus, SiteStatus, StatusStamp
from hawk.comm.topic import Topic
from hawk.config.reference import reference_text, settings
from hawk.config.sections import Config, ConfigError, InboxSettings
from hawk.daemon.announcement import PageShown, announcement, serve
from hawk.daemon.lots.day_flights import DayPlanner, drone_of
from hawk.daemon.lots.keeper import find_stalls
from hawk.daemon.lots.schedule import ScheduledNames, Timetable
from hawk.daemon.start_checks import check_background
from hawk.lots.change_detection.comparison import newest_placed
from hawk.lots.names import lot_named
from hawk.lots.store import LotStore, lots_file
from hawk.lots.survey.pictures import PictureFolder, pictures_of
from hawk.lots.survey.private_ground import hidden_in
from hawk.lots.values import LotStoreError, NotFoundError
from hawk.model.lot_map import EncodedTile, OccupancyMap
from hawk.model.operation import Level
from hawk.model.pictures import AnnotatedFrame
from hawk.model.sentences import say
from hawk.runtime.performance import LoopLag
from hawk.runtime.program_log import ProgramLog
from hawk.store.inbox import InboxFolder, InboxQuota
from hawk.store.recording_requests import RecordingRequests
from hawk.store.recordings import OneRecording, Recordings
from hawk.store.replay import read_metadata
from hawk.store.store_lock import StoreInUseError, held_store
from hawk.web.access.tls import load_tls
from hawk.web.access.tokens import TokensError, cookie_secret
from hawk.web.app import WebServer
from hawk.web.security import InsecureBindingError
from hawk.web.services import OperatorSide, WebServices
from hawk.webhooks.documents import DocumentSender

_LOG = logging.getLogger(__name__)

STATUS_S: Final = 0.5
"""Real seconds between two words to the page: it takes a longer silence for a lost connection."""


@dataclass(frozen=True, slots=True)
class Under:
    """The ground under a plan: the ``mosaic`` of a survey in the frame about its ``datum`` (latitude, longitude)."""

    datum: tuple[float, float]
    mosaic: OccupancyMap


def ground_under(connection: Connection, pictures: PictureFolder, lot: str | None) -> Under | None:
    """Return the newest placed survey with a picture that can be read, of one lot or of any; None without one.

    ``lot``: id or name. Raises NotFoundError for a lot that is not there.
    """
    chosen = lot_named(connection, lot) if lot else None
    for newest in newest_placed(connection, pictures.surveys(), chosen):
        try:
            shown = pictures.read(newest["id"], hidden_in(connection, newest["id"]))
            tiles = {key: EncodedTile(1, data) for key, data in shown.items()}
        except LotStoreError as error:
            _LOG.warning("%s", error)
            continue
        datum = float(newest["latitude"]), float(newest["longitude"])
        return Under(datum, OccupancyMap(mosaic=tiles, version=1, map_id=str(newest["id"])))
    return None


def inbox_folder(settings: InboxSettings) -> InboxFolder | None:
    """Return the folder that programs fill, without half files of a former run; None where the settings name none.

    Raises ConfigError for a folder that is not there or cannot be read.
    """
    if settings.folder is None:
        return None
    quota = InboxQuota(int(settings.largest_gb * 1e9), int(settings.most_gb * 1e9), settings.most_files)
    folder = InboxFolder(settings.folder, quota)
    try:
        folder.clear()
    except OSError as error:
        words = f"inbox.folder: {settings.folder}: {error.strerror or error}; name the folder of hawk-drone map --watch"
        raise ConfigError(words) from error
    return folder


def refuse(_: ClientId, command: Command) -> Outgoing:
    """Answer a command that is for a drone."""
    return Ack(id=command.id, accepted=False, reason=say("There is no drone here: lots and plans alone."))


async def run_desk(config: Config, lot: str | None, survey: str | None = None, *, collects: bool = False) -> int:
    """Serve until SIGTERM or SIGINT; return the exit status. Raises ConfigError for what cannot be used.

    ``lot``: id or name of the one to begin with; ``survey``: id of the one of it whose address is printed, too.
    ``collects``: surveys are taken from drones, and the store is made where there is none.
    """
    log = ProgramLog(config.log.level)
    about = {"version": version("hawk-drone"), "port": str(config.web.port)}
    try:
        check_background(config.web)
        path = lots_file(config.store.directory, config.store.lots)
        if not path.exists() and not collects:
            raise ConfigError(f"--store: {path} is not there. Name the folder of a drone's files, or restore a backup")
        with held_store(config.store.directory, about):
            return await _serve(config, path, lot, survey, collects=collects)
    except StoreInUseError as error:
        raise ConfigError(f"store.directory: {error}. It serves these lots already: open its page") from error
    except (InsecureBindingError, TokensError) as error:
        raise ConfigError(str(error)) from error
    except NotFoundError as error:
        raise ConfigError(f"--lot: {str(error).removeprefix('LOT: ')}") from error
    except LotStoreError as error:
        raise ConfigError(f"--store: {error}") from error
    finally:
        log.close()


async def _serve(config: Config, path: Path, lot: str | None, survey: str | None, *, collects: bool) -> int:
    store = LotStore(path, find_stalls)
    try:
        if notice := await store.open():
            _LOG.warning("%s", notice)
        under = await store.read(lambda connection: ground_under(connection, pictures_of(path), lot))
        place = f"#/lots/{lot}/{survey}" if lot and survey else ""
        await _serve_page(config, store, Recordings(config.store), under, place, collects=collects)
    finally:
        await store.close()
    return 0


async def run_replay(config: Config, recording: Path) -> int:
    """Show one recording alone until SIGTERM or SIGINT; return the exit status. Raises ConfigError, RecordingError."""
    log = ProgramLog(config.log.level)
    try:
        shown = OneRecording(recording)
        read_metadata(recording)  # what is no recording is refused before a page opens
        await _serve_page(config, None, shown, None, f"#/recordings//{shown.name}")
    finally:
        log.close()
    return 0


async def _serve_page(
    config: Config,
    store: LotStore | None,
    recordings: Recordings,
    under: Under | None,
    place: str,
    *,
    collects: bool = False,
) -> None:
    clock, lag = Clock(), LoopLag()
    status: Topic[DroneStatus] = Topic("status", clock)
    occupancy_map: Topic[OccupancyMap] = Topic("occupancy_map", clock)
    video: Topic[AnnotatedFrame] = Topic("annotated", clock)
    side = OperatorSide.create(clock, config.operator, refuse)
    tls = load_tls(config.web, in_flight=False)
    folder = config.store.directory
    services = WebServices(
        clock=clock,
        web=config.web,
        operator=config.operator,
        side=side,
        status=status,
        occupancy_map=occupancy_map,
        video=video,
        version=version("hawk-drone"),
        simulation=False,
        is_desk=True,
        settings=settings(config, reference_text()),
        recordings=recordings,
        cookie_secret=secrets.token_bytes(32) if store is None else cookie_secret(folder),
        tls=tls,
        camera_fov_deg=config.camera.horizontal_fov_deg,
        travel_speed_m_s=config.flight.speed_m_s,
        loop_lag=lag.summary,
    )
    timetable = Timetable(config.schedule, has_desk=config.collect.url is not None)
    with _of_store(config, store, services, timetable, collects=collects) as whole:
        server = WebServer(whole)
        if under is not None:
            occupancy_map.publish(under.mosaic)
        await serve(server, config.web)
        _announce(PageShown.of(server, tls), folder, place, is_recording=store is None)
        try:
            async with _sending(config, store, timetable):
                await _speak(status, clock, under)
        finally:
            await server.close()


@contextlib.contextmanager
def _of_store(
    config: Config, store: LotStore | None, services: WebServices, timetable: Timetable, *, collects: bool
) -> Iterator[WebServices]:
    """Give the services with those of a store, where there is one."""
    if store is None:
        yield services
        return
    recordings = services.recordings if collects else None
    with contextlib.closing(DayPlanner(store, config, timetable, partial(drone_of, config))) as days:
        yield replace(
            services,
            lots=store,
            collects=collects,
            inbox=inbox_folder(config.inbox),
            recording_requests=RecordingRequests(recordings, config.store) if recordings else None,
            due=None if timetable.is_empty else timetable.moments,
            day_plan=days.plan,
            folder=config.store.directory,
        )


def _announce(page: PageShown, folder: Path, place: str, *, is_recording: bool) -> None:
    for line in announcement(page, folder, is_simulation=False, survey="" if is_recording else place):
        print(line, flush=True)
    if is_recording:
        print(f"hawk: the recording: {page.url.rstrip('/')}/{place}", flush=True)


@contextlib.asynccontextmanager
async def _sending(config: Config, store: LotStore | None, timetable: Timetable) -> AsyncIterator[None]:
    """Send surveys of the store to the desk that collects them, where the settings name one, and log which lots of the
    schedule are not known.
    """
    if store is None:
        yield
        return
    sender = DocumentSender(store, config.collect, time.time, lambda: False, _log_message, take_due=timetable.take)
    scheduled = ScheduledNames(store, config.schedule, _log_message)
    running = [asyncio.create_task(sender.run(), name="collect"), asyncio.create_task(scheduled.run(), name="schedule")]
    try:
        yield
    finally:
        for each in running:
            each.cancel()
        await asyncio.gather(*running, return_exceptions=True)


def _log_message(level: Level, text: str, details: str) -> None:
    _LOG.log(logging.getLevelNamesMapping()[level.upper()], "%s %s", text, details)


async def _speak(status: Topic[DroneStatus], clock: Clock, under: Under | None) -> None:
    """Publish a status again and again until a stop signal."""
    stopping = asyncio.Event()
    for name in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(name, stopping.set)
    site, number = SiteStatus(datum=None if under is None else under.datum), 0
    while not stopping.is_set():
        number += 1
        stamp = StatusStamp(sequence=number, time=clock(), utc=datetime.now(UTC).isoformat(timespec="seconds"))
        status.publish(DroneStatus(stamp=stamp, site=site))
        try:
            async with asyncio.timeout(STATUS_S):
                await stopping.wait()
        except TimeoutError:
            continue
