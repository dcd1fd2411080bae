"""The composition root: builds every part, starts them in order, runs the loop, and ends them in order.

Journal, autopilot and states come first, and vision with all its libraries later: a daemon that starts in the air acts
within three seconds.
"""

from __future__ import annotations

import asyncio
import logging
import os
import signal
import sys
import time
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hawk.algo.loop import AlgorithmLoop, fixed_mount, unknown_sun
from hawk.algo.topic_interface import AlgorithmTopics
from hawk.comm.autopilot.autopilot import MavsdkAutopilot
from hawk.comm.autopilot.remote_id_sender import RemoteIdSender
from hawk.comm.autopilot.vehicle import VehicleTopics
from hawk.comm.cameras.calibration import load_calibration
from hawk.comm.cameras.drone_camera import DroneCamera
from hawk.comm.clock import Clock
from hawk.comm.topic import Topic
from hawk.config.reference import reference_text, settings
from hawk.config.sections import Config, ConfigError
from hawk.daemon.announcement import PageShown, announcement, seconds_since_process_start, serve, write_ready_file
from hawk.daemon.flight_offer import FlightOffer
from hawk.daemon.flight_trace import FlightTrace
from hawk.daemon.flights import FlightFollower, FlightParts
from hawk.daemon.lots.parts import LotParts, program_name, surroundings
from hawk.daemon.map_keeper import MapKeeper
from hawk.daemon.monitor import Monitor, MonitoredParts
from hawk.daemon.options import DaemonOptions, start_words
from hawk.daemon.recording_parts import FlightViews, make_recording
from hawk.daemon.situation import SituationReader
from hawk.daemon.start_checks import (
    make_folder,
)
from hawk.daemon.starts import Starts, survey_at_start, wait_away
from hawk.ddc.fence.geojson import editable_area
from hawk.ddc.operations_manager import OperationsManager
from hawk.ddc.readings.topic_interface import DdcInputs, DdcTopicInterface
from hawk.ddc.requests.service_interface import DdcServiceInterface
from hawk.ddc.rules.follower import RestartRule, flight_goes_on
from hawk.ddc.settings import DdcSettings, ManagerSetup, SurveyMemory
from hawk.lots.survey.landing import LandingFacts, at_landing
from hawk.model.lot_map import OccupancyMap
from hawk.model.moment import is_wall_clock_kept, this_moment
from hawk.model.plans import PathPlan
from hawk.runtime.performance import LoopLag, Performance
from hawk.runtime.process import SystemdNotifier, Ticker, Watchdog
from hawk.runtime.program_log import STANDARD_OUTPUT, LineWriter, ProgramLog
from hawk.runtime.supervision import Supervisor, end_tasks
from hawk.store.journal import FlightJournal
from hawk.store.run_notes import RunNotes, notes_file
from hawk.versions.flight_state import FlightStateFile
from hawk.web.access.tls import Tls, watch_certificate
from hawk.web.access.tokens import cookie_secret
from hawk.web.app import WebServer
from hawk.web.services import OperatorSide, WebServices

if TYPE_CHECKING:
    from hawk.algo.manager import AlgorithmManagerApp

_LOG = logging.getLogger(__name__)

START_NOTED_S = 0.5
"""The start is on the disk before the link is opened, but the drone does not wait longer for it, real seconds."""


class Daemon:
    """Every part of the drone's side. Nothing is opened before `run`."""

    def __init__(self, config: Config, options: DaemonOptions, log: ProgramLog, tls: Tls | None = None) -> None:
        """Build what needs no link. Raises ConfigError, FenceError, InsecureBindingError, TokensError."""
        self._config = config
        self._tls = tls
        self._options = options
        self._log = log
        self._stopping = asyncio.Event()
        self._tasks: list[asyncio.Task[None]] = []
        self._supervisor = Supervisor(lambda name, words: self._monitor.report_end(name, words))
        self._algorithms: AlgorithmLoop | None = None
        self._map_keeper: MapKeeper | None = None
        self._first_tick_s: float | None = None
        self._output = LineWriter(STANDARD_OUTPUT)
        load_calibration(config.camera)
        self._notes = RunNotes(notes_file(config.store.directory, os.environ))
        try:
            make_folder("store.directory", config.store.directory)
        except ConfigError as error:
            if flight_goes_on(self._notes.notes.flight, this_moment(), options.speed) is None:
                raise
            _LOG.error("%s. A flight is under way: it goes on without", error)
        self.clock = Clock(options.speed)
        self._watchdog = Watchdog(
            config.watchdog.timeout_s, SystemdNotifier(), sys.stderr, enabled=config.watchdog.enabled
        )
        self._lag = LoopLag()
        self.performance = Performance(self.clock, self._lag)
        self._journal = FlightJournal(config.store.directory / "journal")
        self._recording = make_recording(
            config,
            self.clock,
            self.clock.speed,
            options.simulation,
            lambda: self._journal.survey_id,
            lambda time: self.autopilot.telemetry.utc_at(time),
        )
        runtime = os.environ.get("RUNTIME_DIRECTORY")  # systemd.exec(5)
        self._flight_state = FlightStateFile(Path(runtime) if runtime else None)
        self._make_vehicle()
        self._make_operations()
        self._make_results()
        self._make_monitor()
        self._web = WebServer(self._web_services())

    # -- building ----------------------------------------------------------------------------------------------------

    def _make_vehicle(self) -> None:
        self.vehicle = VehicleTopics.create(self.clock)
        is_new_world = self._options.simulation is not None and not self._options.is_again
        self._starts = Starts(self._journal, self._notes, self._options.speed, is_new_world=is_new_world)
        self.autopilot = MavsdkAutopilot(
            self._config.autopilot,
            self.clock,
            self.vehicle,
            supervisor=self._supervisor,
            has_gimbal=self._config.camera.gimbal,
            flown_id=self._starts.flown_id,
            in_flight=self._starts.flew_lately,
        )
        self.autopilot.calls.on_overdue = lambda name: self._monitor.report_hang(name, is_flying=self._is_in_the_air())
        stamped = self.autopilot.telemetry.from_boot if self._options.is_simulation else None
        self.camera = DroneCamera(self._config.camera, self.clock, stamped, supervisor=self._supervisor)
        begun = survey_at_start(
            self._journal,
            flies=self._starts.flew_lately,
            is_new_world=is_new_world,
            continues=self._options.is_again,
        )
        self._kept, self._set_aside, self._has_same_cars = begun.kept, begun.words, begun.is_young
        self.autopilot.set_datum(self._kept.datum)
        if self._kept.arm_place is not None:
            self.autopilot.telemetry.restore_arm_place(self._kept.arm_place)

    def _make_operations(self) -> None:
        self.inputs = DdcInputs.create(self.clock)
        self.side = OperatorSide.create(self.clock, self._config.operator)
        self._trace = FlightTrace(self.side.desk.names, self.side.desk.controller)
        self.topics = DdcTopicInterface(self.vehicle, self.inputs, self.clock)
        self._flights = FlightFollower(
            FlightParts(self._journal, self._starts, self._recording, self._flight_state, self._make_flight_offer()),
            self.topics,
            lambda: self.autopilot.datum,
            lambda armed: self._lots.keeper.note(armed=armed),
        )
        self.manager = OperationsManager(
            ManagerSetup(
                clock=self.clock,
                desk=self.side.desk,
                directory=self._config.store.directory,
                settings=DdcSettings.from_config(self._config),
                record=self._record,
                wants_memory=self._recording.wants_memory,
                count_start=self._starts.found_in_air,
                continues_survey=bool(self._kept.map_parts),
                begin_survey=self._begin_another_survey,
                flight=self._starts.flight,
                keep_flight=lambda flight: self._starts.keep_flight(flight, self.autopilot.vehicle_id),
                fall=self._kept.fall,
                keep_fall=self._journal.set_fall,
                survey=SurveyMemory(
                    self._kept.left,
                    self._kept.drains,
                    self._journal.set_left,
                    self._journal.set_drains,
                    self._kept.outline,
                    self._journal.set_outline,
                ),
                speed=self.clock.speed,
            ),
            self.side.socket,
            self.topics,
            DdcServiceInterface(
                self.autopilot, self.topics, self.clock, self._config.flight.speed_m_s, self._recording.record
            ),
        )
        self.manager.init()
        self.manager.status.listen(self._trace.follow)
        views = FlightViews(self._recording.show, self._recording.record, self.clock, lambda: self.autopilot.datum)
        views.listen(self.vehicle, self.manager.status, self.inputs.occupancy_map)
        if self._set_aside:
            _LOG.warning("%s", self._set_aside)
            self.manager.log.add("warning", f"{self._set_aside}.", "")
        self.side.socket.attach(self.manager.handle_now)

    def _make_flight_offer(self) -> FlightOffer | None:
        """After flights of a real drone only: a simulated camera stamps by the autopilot's clock."""
        if self._options.is_simulation:
            return None
        return FlightOffer(
            self._config.camera,
            lambda: None if self._recording.recording or self._recording.waiting else self._recording.path,
            lambda text, details: self.manager.log.add("info", text, details),
        )

    def _record(self, kind: str, payload: dict[str, Any]) -> None:
        self._recording.record(kind, payload)
        self._trace.record(kind, payload)

    def _make_results(self) -> None:
        """Make the topics on which the algorithms publish once they have started."""
        self.results = AlgorithmTopics(
            frame_output=Topic("frame_output", self.clock),
            park_lot_detected=self.inputs.park_lot_detected,
            des_loc_inbound=self.inputs.verdict,
            occupancy_map=self.inputs.occupancy_map,
            local_pos=self.inputs.path_plan,
            annotated=Topic("annotated", self.clock),
            footprint=self.inputs.footprint,
            camera_check=self.inputs.camera_check,
            ground_step=self.inputs.ground_step,
            stall_size=self.inputs.stall_size,
            vision_app_health=self.inputs.vision_health,
            mapper_app_health=self.inputs.mapper_health,
            path_plan_app_health=self.inputs.path_plan_health,
        )
        self.results.frame_output.listen(
            lambda output: self.performance.frame_published(output.captured, output.timings)
        )
        self.results.frame_output.listen(lambda output: self.camera.looked_at(is_damaged=output.is_damaged))
        self._lots = LotParts.create(
            self._config,
            self._landed_survey,
            lambda: self.autopilot.datum,
            lambda: self._journal.survey_id,
            self.manager.log.add,
            surroundings(self.autopilot, self.camera, self.inputs, self.topics, self.manager, self._config.fence),
            lambda: self.inputs.occupancy_map.value,
            self._recording.folder,
            is_restored=bool(self._kept.map_parts),
            full_battery=self.manager.full_battery,
        )
        self.inputs.path_plan.listen(self._lots.keeper.note_plan)

    def _make_monitor(self) -> None:
        self._monitor = Monitor(
            MonitoredParts(
                autopilot=self.autopilot,
                camera=self.camera,
                recording=self._recording,
                journal=self._journal,
                supervisor=self._supervisor,
                lag=self._lag,
                performance=self.performance,
            ),
            self.inputs,
            self.manager.log.add,
            lambda: self._flight_state.write(may_fly=self._flights.may_fly),
        )

    def _web_services(self) -> WebServices:
        return WebServices(
            clock=self.clock,
            web=self._config.web,
            operator=self._config.operator,
            side=self.side,
            status=self.manager.status,
            occupancy_map=self.inputs.occupancy_map,
            video=self.results.annotated,
            version=version("hawk-drone"),
            simulation=self._options.is_simulation,
            queues=lambda: {"journal": self._journal.waiting, "recording": self._recording.waiting},
            settings=settings(self._config, reference_text()),
            newest_recording=self._recording.newest,
            recordings=self._recording.folder,
            sections=lambda: self._lots.sections.current,
            lots=self._lots.store,
            due=None if self._lots.timetable.is_empty else self._lots.timetable.moments,
            day_plan=self._lots.days.plan,
            read_area=editable_area,
            cookie_secret=cookie_secret(self._config.store.directory),
            folder=self._config.store.directory,
            tls=self._tls,
            camera_fov_deg=self._config.camera.horizontal_fov_deg,
            travel_speed_m_s=self._config.flight.speed_m_s,
            loop_lag=self._lag.summary,
            performance=lambda: asdict(self.performance.summary()),
            counters=lambda: {
                "autopilot_messages_dropped": self.autopilot.dropped,
                "autopilot_datagrams_refused": self.autopilot.hearing.refused,
                "camera_pictures_damaged": self.camera.damaged,
                "recording_messages_dropped": self._recording.dropped,
                "log_lines_dropped": self._log.dropped,
            },
        )

    @property
    def flew_lately(self) -> bool:
        """True when the journal knows of a flight under way: this start must act at once."""
        return self._starts.flew_lately

    # -- running -----------------------------------------------------------------------------------------------------

    async def run(self) -> int:
        """Start every part, run until a stop signal, end every part; return the exit status."""
        loop = asyncio.get_running_loop()
        for name in (signal.SIGINT, signal.SIGTERM):
            loop.add_signal_handler(name, self._stopping.set)
        if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:  # nohup(1) ignores it for us
            loop.add_signal_handler(signal.SIGHUP, self._lose_terminal)
        ticker = Ticker(1 / (self._config.flight.tick_hz * self.clock.speed), self._tick, self.performance.ticked)
        self._trace.begin(start_words(self._options, self._config, flew_lately=self.flew_lately))
        ticker.start()
        self._watchdog.ready()
        try:
            self._own("loop-lag", self._lag.run)
            self._own("monitor", self._monitor.run)
            if (tls := self._tls) is not None:
                self._own("certificate", lambda: watch_certificate(tls, time.time, self._report_certificate))
            await serve(self._web, self._config.web)
            self._announce()
            await self._open_autopilot()
            await self._start_algorithms()
            await self._stopping.wait()
            flew = await self.manager.shutdown_in_air()
            self._starts.ended_in_order()
            self._trace.end("in the air, with a return under way" if flew else "in order")
        finally:
            ticker.stop()
            await self._close()
        return 0

    def stop_without_parent(self) -> None:
        """End in order: the program that started this one has ended."""
        _LOG.warning("the program that started this one has ended")
        self._stopping.set()

    def _lose_terminal(self) -> None:
        """Go on flying without a terminal; on the ground end in order."""
        if self._flights.may_fly:
            _LOG.warning("SIGHUP: the terminal was lost; the flight goes on. SIGTERM ends it")
        else:
            self._stopping.set()

    def _tick(self) -> None:
        before = self.manager.ticks
        self.manager.process()
        if self.manager.ticks > before:
            self._watchdog.progress(may_fly=self._flights.may_fly)
        if self._first_tick_s is None:
            self._first_tick_s = seconds_since_process_start()

    async def _open_autopilot(self) -> None:
        """Open MAVLink, unless this program crashed twice in the air within a minute: then only when disarmed."""
        if self._starts.rule is RestartRule.STAY_AWAY:
            await wait_away(self._config.autopilot, self._starts.flown_id, self._stopping)
        if not self._stopping.is_set():
            await self._starts.settle(START_NOTED_S)
            await self.autopilot.start()
            if self._config.remote_id.enabled:
                send = self.autopilot.send_message
                sender = RemoteIdSender(self._config.remote_id, self.vehicle, self.clock, send, time.time)
                self._own("remote-id", sender.run)

    async def _start_algorithms(self) -> None:
        if self._stopping.is_set():
            return
        self.camera.init()
        # the ticks go on meanwhile
        with ThreadPoolExecutor(1, thread_name_prefix="hawk-imports") as worker:
            manager = await asyncio.get_running_loop().run_in_executor(
                worker, _make_manager, self._config, self._kept.survey_id, self._options
            )
        self._algorithms = algorithms = AlgorithmLoop(
            manager,
            self.camera.next_frame,
            self.autopilot.telemetry.pose_at,
            SituationReader(self.clock, self.autopilot, self.camera, self.topics, self.manager.outlines, self._lots),
            self.results,
            self._recording.record_frame,
            self._supervisor,
            self.autopilot.telemetry.gimbal.aim if self._config.camera.gimbal else fixed_mount,
            self.autopilot.telemetry.sun_at if self._config.vision.sun == "auto" else unknown_sun,
        )
        if self._kept.map_parts:
            for problem in await algorithms.restore_map([self._kept.map_parts], has_same_cars=self._has_same_cars):
                _LOG.warning("the journalled map: %s", problem)
        algorithms.start()
        self._map_keeper = MapKeeper(algorithms.changes_since, self._journal.put_map)
        self._own("map-keeper", self._map_keeper.run)
        for name, run in self._lots.loops():
            self._own(name, run)
        if (offer := self._flights.offer) is not None:
            self._own("flight-offer", offer.run)

    async def _close(self) -> None:
        """End the parts in order: no part sends to one that has ended."""
        await end_tasks(*self._tasks)
        self._watchdog.stop()
        await self._web.close()
        await self.camera.close()
        await self._keep_last_map()
        if self._algorithms is not None:
            await self._algorithms.close()
        await self.manager.close()
        await self.autopilot.close()
        await self._recording.close()
        await self._journal.close()
        await self._lots.close()
        self._output.close()
        self._flight_state.close()

    async def _keep_last_map(self) -> None:
        if self._map_keeper is None:
            return
        try:
            async with asyncio.timeout(2.0):
                await self._map_keeper.keep()
        except Exception:
            _LOG.exception("the last changes of the map were not journalled")
        try:
            async with asyncio.timeout(2.0):
                await self._lots.keeper.keep()  # it landed a moment ago
        except Exception:
            _LOG.exception("the survey was not stored")

    # -- between the parts -------------------------------------------------------------------------------------------

    def _landed_survey(self) -> LandingFacts | None:
        """Return the survey as it is now; None before there is a map with a place on Earth."""
        current, datum = self.inputs.occupancy_map.value, self.autopilot.datum
        if current is None or datum is None or not (current.tiles or current.stalls):
            return None
        heard = self.autopilot.telemetry.utc_at(self.clock())
        moment = at_landing(heard, time.time(), is_kept=is_wall_clock_kept(), is_simulated=self._options.is_simulation)
        return LandingFacts(
            name=self._journal.survey_id,
            datum=datum,
            current=current,
            outline=self.manager.outlines.outline,
            seconds=self.clock(),
            utc=moment.value,
            time_is_sure=moment.is_sure,
            program=program_name(self._config.vision.model),
            simulated=self._options.is_simulation,
            speed=self.clock.speed,
            accuracy=None if (seen := self.vehicle.diagnostics.value) is None else seen.horizontal_accuracy,
        )

    def _begin_another_survey(self) -> None:
        if self._map_keeper is not None:
            switching = self._map_keeper.switch(self._switch_survey)
            self._tasks.append(asyncio.create_task(switching, name="another survey"))

    async def _switch_survey(self) -> None:
        """Begin an empty map and a journal of its own; the page sees the empty map at once."""
        assert self._algorithms is not None  # noqa: S101 - the map keeper came after it
        await self._lots.keeper.keep()
        survey = self._journal.new_survey()
        self.manager.outlines.begin_survey()
        await self._algorithms.begin_survey(survey)
        self.inputs.occupancy_map.publish(OccupancyMap(map_id=survey))
        self.inputs.path_plan.publish(PathPlan())

    def _announce(self) -> None:
        page = PageShown.of(self._web, self._tls)
        for line in announcement(page, self._config.store.directory, is_simulation=self._options.is_simulation):
            self._output.put(line)
        if self._options.ready_file is not None:
            write_ready_file(self._options.ready_file, self._web.url, self._first_tick_s)

    def _is_in_the_air(self) -> bool:
        state = self.vehicle.state.value
        return state is not None and state.armed and not self.manager.state.on_ground

    def _report_certificate(self, words: str) -> None:
        _LOG.warning("%s", words)
        self.manager.log.add("warning", words, "")

    def _own(self, name: str, work: Callable[[], Awaitable[None]]) -> None:
        self._tasks.append(self._supervisor.start(name, work))


def _make_manager(config: Config, survey_id: str, options: DaemonOptions) -> AlgorithmManagerApp:
    # Imported here: vision's libraries take half of the time in which a start in the air must act.
    from hawk.daemon.algorithms import make_manager

    return make_manager(config, survey_id, is_simulation=options.is_simulation)
