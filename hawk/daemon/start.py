"""The start of a daemon: log, store, simulator, checks of files; then `hawk.daemon.root.Daemon` runs."""

from __future__ import annotations

import os
from importlib.metadata import version

from hawk.config.secrets import SecretUrl
from hawk.config.sections import Config, ConfigError
from hawk.daemon.options import DaemonOptions
from hawk.daemon.root import Daemon
from hawk.daemon.start_checks import check_access, check_background, check_files, check_model
from hawk.ddc.fence.geometry import FenceError
from hawk.ddc.rules.follower import flight_goes_on
from hawk.model.moment import this_moment
from hawk.runtime.process import LOOP_NICENESS, ParentGoneError, set_niceness, set_session_niceness, watched_parent
from hawk.runtime.program_log import ProgramLog
from hawk.sim.launch import Simulation, SimulationAddress
from hawk.store.run_notes import RunNotes, notes_file
from hawk.store.store_lock import StoreInUseError, held_store
from hawk.web.access.tls import Tls, load_tls
from hawk.web.access.tokens import TokensError
from hawk.web.security import InsecureBindingError

_SIMULATION = "simulation"
"""Folder in the store for what simulated flights leave."""


async def run_daemon(config: Config, options: DaemonOptions) -> int:
    """Run until SIGTERM or SIGINT; return the exit status. Raises ConfigError for settings that cannot be used."""
    log = ProgramLog(config.log.level)
    try:
        return await _run_with_log(config, options, log)
    finally:
        log.close()


async def _run_with_log(config: Config, options: DaemonOptions, log: ProgramLog) -> int:
    store = config.store.directory
    if options.simulation is not None:
        store /= _SIMULATION
    noted = RunNotes(notes_file(store, os.environ)).notes.flight
    tls = load_tls(config.web, in_flight=flight_goes_on(noted, this_moment(), options.speed) is not None)
    about = {"version": version("hawk-drone"), "port": str(config.web.port)}
    try:
        with held_store(store, about):
            return await _run_alone(config, options, log, tls)
    except StoreInUseError as error:
        remedy = "Stop that one, or name another folder: --store DIR"
        raise ConfigError(f"store.directory: {error}; two would write over each other. {remedy}") from error


async def _run_alone(config: Config, options: DaemonOptions, log: ProgramLog, tls: Tls | None) -> int:
    simulation = None
    if options.simulation is not None:
        check_files(config)
        check_background(config.web)
        check_access(_simulated(config, SimulationAddress("", "")))
        simulation = Simulation(options.simulation)
        config = _simulated(config, await simulation.start())
    set_niceness(LOOP_NICENESS)  # after the simulator has started: it stands for another computer
    set_session_niceness(LOOP_NICENESS)
    try:
        daemon = Daemon(config, options, log, tls)
        if not daemon.flew_lately:
            check_model(config.vision)
            check_background(config.web)
        with watched_parent(options.parent_pid, daemon.stop_without_parent):
            return await daemon.run()
    except ParentGoneError as error:
        raise ConfigError(f"--parent-pid: {error}") from error
    except (FenceError, InsecureBindingError, TokensError) as error:
        raise ConfigError(str(error)) from error
    finally:
        if simulation is not None:
            await simulation.stop()


def _simulated(config: Config, address: SimulationAddress) -> Config:
    """Return the settings for the simulated drone; its files stay apart from those of real flights."""
    return config.model_copy(
        update={
            "autopilot": config.autopilot.model_copy(update={"url": address.autopilot_url}),
            "camera": config.camera.model_copy(update={"url": SecretUrl(address.camera_url)}),
            "store": config.store.model_copy(update={"directory": config.store.directory / _SIMULATION, "lots": None}),
        }
    )
