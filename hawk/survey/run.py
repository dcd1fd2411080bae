"""The command ``hawk-drone survey``: flies a survey without a browser and writes the results."""

from __future__ import annotations

import asyncio
import json
import signal
import ssl
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import Any, Self
from urllib.parse import urlsplit

import numpy as np
from rich import progress as rich_progress
from rich.console import Console
from rich.progress import BarColumn, TaskID, TextColumn, TimeElapsedColumn

from hawk.comm.base_socket import ConnectionTimeout
from hawk.comm.protocol.commands import MOST_LOTS, SetOutline, SurveyAgain
from hawk.comm.protocol.heartbeat import Heartbeat, LeftOutStatus
from hawk.config.addresses import check_host
from hawk.config.sections import ConfigError
from hawk.daemon.start_checks import make_folder
from hawk.ddc.fence.geojson import read_survey_outline
from hawk.ddc.fence.outline import OutlineError, corners_of
from hawk.model.poses import GlobalPose
from hawk.results.stall_files import write_map
from hawk.results.survey_map import Made, SurveyMap, to_global
from hawk.sim.launch import SimulationOptions
from hawk.survey import report
from hawk.survey.client import CommandRefusedError, DroneClient, LinkLostError
from hawk.survey.handset import SurveyStatus
from hawk.survey.operator import CHECKING, SurveyLimits, SurveyOperator, SurveyOutcome, SurveyPlan
from hawk.survey.stack import SimulatedStack, StackError, StackOptionError
from hawk.survey.truth import GroundTruth, TruthError, read_truth

DEFAULT_PORT = 3000
"""Port of the page where --url names none, as in the settings."""
LATE_FRAMES_LIMIT = 0.01
"""Greatest share of pictures drawn late by the simulator in a valid run."""


@dataclass(frozen=True, slots=True)
class SurveyOptions:
    """Options of the command. ``url`` is a running daemon; without it ``simulation`` is started.

    ``continues``: fly only when there is an earlier survey to go on with. ``again``: ids or names of lots to survey
    again; ``due``: those that are due.
    """

    out: Path
    simulation: SimulationOptions | None
    url: str | None
    token: str | None
    certificate: Path | None
    config: Path | None
    fence: Path | None
    outline: Path | None
    truth: Path | None
    set_failsafes: bool
    continues: bool
    again: list[str] | None
    due: bool
    timeout_s: float
    quiet: bool


async def run_survey(options: SurveyOptions) -> int:
    """Fly one survey; return the exit status (docs/survey.md)."""
    outline = None if options.outline is None else outline_command(options.outline)
    address = None if options.url is None else address_of(options.url)
    check_certificate(options.certificate, address)
    trusted(options.certificate)
    truth = None if options.truth is None else _given_truth(options.truth)
    make_folder("--out", options.out)
    stack: SimulatedStack | None = None
    try:
        if address is not None:
            return await _fly(options, address, None, truth, outline)
        assert options.simulation is not None  # noqa: S101 - the command line refuses neither and both
        folder = options.out / "run"
        if not options.continues and not (options.again or options.due):
            set_store_aside(folder / "store")
        stack = SimulatedStack(options.simulation, folder, options.config, options.fence)
        ready = await stack.start()
        return await _fly(options, address_of(ready.url), stack, stack.truth, outline)
    except StackOptionError as error:
        raise ConfigError(str(error)) from error
    except (StackError, TruthError, ConnectionTimeout, LinkLostError) as error:
        print(f"hawk-drone survey: {error}", file=sys.stderr)
        return SurveyStatus.FAILED
    finally:
        if stack is not None:
            await stack.stop()


def _given_truth(file: Path) -> GroundTruth:
    try:
        return read_truth(file)
    except TruthError as error:
        raise ConfigError(f"--truth: {error}") from error


@dataclass(frozen=True, slots=True)
class Address:
    """Address of a daemon's page."""

    host: str
    port: int
    is_secure: bool


def address_of(url: str) -> Address:
    """Return the address of ``http://HOST:PORT/``, also without scheme or port (3000). Raises ConfigError."""
    try:
        parts = urlsplit(url if "//" in url else f"//{url}")
        host, port = parts.hostname, parts.port
        check_host(host or "")
    except ValueError as error:
        raise ConfigError(f"--url: {url!r} is no address: {error}; write http://HOST:PORT/") from error
    if not host or port == 0 or parts.scheme not in ("", "http", "https"):
        raise ConfigError(f"--url: {url!r} is no address of a page; write http://HOST:PORT/ or https://HOST:PORT/")
    return Address(host, port or DEFAULT_PORT, parts.scheme == "https")


def check_certificate(certificate: Path | None, address: Address | None) -> None:
    """Raise ConfigError for a certificate that the page of an address does not use."""
    if certificate is not None and (address is None or not address.is_secure):
        raise ConfigError("--certificate: only for a page by HTTPS: write --url https://HOST:PORT/")


def trusted(certificate: Path | None) -> ssl.SSLContext:
    """Return the certificates that are trusted: those of the system, or this one alone, a self-signed one.

    Raises:
        ConfigError: The file cannot be used.
    """
    try:
        return ssl.create_default_context(cafile=certificate)
    except OSError as error:
        raise ConfigError(f"--certificate: {certificate} cannot be used: {error}") from error


def outline_command(file: Path) -> SetOutline:
    """Return the command for the outline of a GeoJSON file.

    Raises:
        ConfigError: The file cannot be used; the text names what is wrong.
    """
    try:
        outline = read_survey_outline(file)
    except OutlineError as error:
        raise ConfigError(f"--outline: {error}") from error
    return SetOutline(polygons=corners_of(outline.polygons), holes=corners_of(outline.holes))


def again_command(options: SurveyOptions, lots: Sequence[Mapping[str, Any]]) -> SurveyAgain | None:
    """Return the command for the lots to survey again; None without any. Raises ConfigError."""
    if options.due:
        return SurveyAgain(due=True)
    if not options.again:
        return None
    if len(options.again) > MOST_LOTS:
        raise ConfigError(f"--again: {len(options.again)} lots are too many for one flight: at most {MOST_LOTS}")
    return SurveyAgain(lots=[lot_named(each, lots) for each in options.again])


def lot_named(wanted: str, lots: Sequence[Mapping[str, Any]]) -> str:
    """Return the id of the lot with an id or a name. Raises ConfigError where none, or more than one, has it."""
    found = [lot for lot in lots if lot["id"] == wanted]
    found = found or [lot for lot in lots if str(lot["name"]).casefold() == wanted.casefold()]
    if len(found) == 1:
        return str(found[0]["id"])
    if found:
        ids = ", ".join(str(lot["id"]) for lot in found)
        raise ConfigError(f"--again: {len(found)} lots are called {wanted!r}: write the id of one of them: {ids}")
    names = ", ".join(str(lot["name"]) for lot in lots) or "there is none: survey a lot first"
    raise ConfigError(f"--again: no lot has the name or id {wanted!r}; known lots: {names}")


async def _fly(
    options: SurveyOptions,
    address: Address,
    stack: SimulatedStack | None,
    truth: GroundTruth | None,
    outline: SetOutline | None,
) -> int:
    async with DroneClient(
        address.host,
        address.port,
        token=options.token,
        tls=trusted(options.certificate) if address.is_secure else None,
    ) as drone:
        watch = FenceSender(stack)
        limits = replace(SurveyLimits(), explore_s=options.timeout_s)
        try:
            again = again_command(options, await drone.lots() if options.again else ())
        except CommandRefusedError as error:
            raise LinkLostError(f"the lots cannot be read: {error}") from error
        plan = SurveyPlan(
            set_failsafes=options.set_failsafes,
            continues=options.continues,
            outline=outline,
            again=again,
            limits=limits,
        )
        with SurveyProgress(quiet=options.quiet) as bar:

            def show(phase: str, beat: Heartbeat) -> None:
                bar.show(phase, beat)
                watch.look(beat)

            operator = SurveyOperator(drone, plan, show)
            loop = asyncio.get_running_loop()
            for name in (signal.SIGINT, signal.SIGTERM):
                loop.add_signal_handler(name, operator.interrupt)
            outcome = await operator.run()
        if not outcome.was_flown:
            await watch.close()
            print(outcome.reason)
            return int(outcome.status)
        survey = await _map_of(drone)
        await watch.close()
        status = None if stack is None else await stack.status()
    values = _report(outcome, survey, truth, status)
    write_results(options.out, survey, values)
    _say(options.out, outcome, values)
    return int(outcome.status)


def set_store_aside(store: Path) -> None:
    """Rename the store of an earlier simulated survey: a new one must not go on with it."""
    if store.exists():
        number = next(n for n in count(1) if not store.with_name(f"{store.name}-{n}").exists())
        store.rename(store.with_name(f"{store.name}-{number}"))


class FenceSender:
    """Sends our fence to the simulator as soon as it is known, so that it can count excursions of the true position."""

    def __init__(self, stack: SimulatedStack | None) -> None:
        self._stack = stack
        self._sent: tuple[object, ...] = ()
        self._task: asyncio.Task[None] | None = None

    def look(self, beat: Heartbeat) -> None:
        """Read the fence from a heartbeat; send it when it has changed."""
        if self._stack is None or beat.datum is None or not beat.fence:
            return
        fence = (beat.datum, beat.fence, beat.ceiling)
        if fence == self._sent or (self._task is not None and not self._task.done()):
            return
        self._sent = fence
        corners = to_global(GlobalPose(*beat.datum, 0.0), np.array([[p.north, p.east] for p in beat.fence]))
        polygon = [(float(latitude), float(longitude)) for latitude, longitude in corners]
        self._task = asyncio.create_task(
            self._stack.watch_fence(polygon, beat.ceiling or 1000.0), name="survey-fence-sender"
        )

    async def close(self) -> None:
        """Wait until the last fence was sent. Raises the error of sending it."""
        if self._task is not None:
            await self._task


def write_results(folder: Path, survey: SurveyMap, values: dict[str, Any]) -> None:
    """Write ``stalls.csv``, ``stalls.geojson``, ``map.png`` and ``report.json``."""
    made = Made.now(survey.survey)
    write_map(folder, survey, made)
    values = {**report.finite(values), **made.values()}
    (folder / "report.json").write_text(json.dumps(values, indent=1, allow_nan=False), encoding="utf-8")


async def _map_of(drone: DroneClient) -> SurveyMap:
    try:
        found = await drone.survey_map()
    except LinkLostError:
        found = None
    return found or SurveyMap(GlobalPose(0.0, 0.0, 0.0), {}, {})


def _report(
    outcome: SurveyOutcome, survey: SurveyMap, truth: GroundTruth | None, status: dict[str, Any] | None
) -> dict[str, Any]:
    """Return the report: the flight as the drone saw it, corrected by the simulator's account where there is one."""
    values: dict[str, Any] = {
        "status": int(outcome.status),
        "reason": outcome.reason,
        "landed": outcome.landed,
        "disarmed": outcome.disarmed,
        "duration_s": outcome.duration_s,
        "distance_flown_m": outcome.distance_m,
        "distance_planned_m": outcome.planned_m,
        "lots": [each.model_dump() for each in outcome.lots],
        "explored": outcome.explored,
        "lot_area_m2": None,
        "outline_m2": outcome.outline_m2,
        "outline_outside_m2": outcome.outline_outside_m2,
        "outline_unseen_m2": outcome.outline_unseen_m2,
        "left_out_m2": None if outcome.left_out is None else outcome.left_out.model_dump(),
        **report.counts(survey),
        "free_range": outcome.free_range,
    }
    if status is not None:
        due, late = status["frames_due"], status["frames_late"]
        values |= {key: status[key] for key in ("landed", "disarmed", "distance_flown_m", "excursions", "crashed")}
        values |= {"late_frames": late / due if due else 0.0, "frames_due": due}
        values["run_is_valid"] = values["late_frames"] <= LATE_FRAMES_LIMIT
    if truth is not None and truth.origin is not None and (survey.tiles or survey.stalls):
        values |= report.compare(survey, truth)
        values["free_in_range"] = report.in_range(values["true_free"], outcome.free_range)
    values["lot_area_m2"] = report.lot_area(survey)
    return values


def _say(folder: Path, outcome: SurveyOutcome, values: dict[str, Any]) -> None:
    print(f"{outcome.reason}")
    if outcome.left_out is not None and outcome.explored is not None:
        print(f"Seen: {outcome.explored:.1%} of the lot found. {left_out_words(outcome.left_out)}")
    if outcome.planned_m is not None:
        print(f"The flight over the lots was planned as {outcome.planned_m:.0f} m, without the flight home.")
    for lot in outcome.lots if len(outcome.lots) > 1 else ():
        left = "its rim was not looked at" if lot.seen >= 1.0 else "not finished"
        end = "" if lot.is_over else f"; {left}: fly on with --continue"
        print(f"{lot.name}: {int(100 * lot.seen)} % of the stalls looked at{end}")
    bounds = values["free_range"]
    between = "" if bounds is None else f" (between {bounds[0]} and {bounds[1]})"
    print(
        f"{values['stalls']} stalls: {values['free']} free{between}, {values['taken']} taken, "
        f"{values['unknown']} unclear. Results in {folder}"
    )
    if "stall_f1" in values:
        keys = ["stall_f1", "stall_precision", "stall_recall", "recall_whole", "state_accuracy", "lot_iou", "lot_seen"]
        keys += ["stalls_seen", "stall_recall_seen"]
        print(", ".join(f"{key} {values[key]:.3f}" for key in keys) + f", excursions {values.get('excursions')}")
    if values.get("run_is_valid") is False:
        print(
            f"VOID: {values['late_frames']:.2%} of the simulator's pictures came late or not at all, at most "
            f"{LATE_FRAMES_LIMIT:.2%} may: this computer is too busy for --speed; the figures above count for nothing.",
            file=sys.stderr,
        )


def left_out_words(left: LeftOutStatus) -> str:
    """Return in words what was not looked at, and why."""
    parts = (
        (left.outside, "outside the fence"),
        (left.hidden, "hidden from every place inside the fence"),
        (left.given_up, "given up, where pictures showed nothing new"),
        (left.beside, "of other ground beside it, where the lot may go on"),
    )
    words = [f"{area:.0f} m² {where}" for area, where in parts if area >= 1]
    return f"Left out: {', '.join(words)}." if words else "Nothing inside the fence was left out."


class SurveyProgress:
    """Shows phase, share of the known lot that was seen, stalls, height and battery on standard error."""

    def __init__(self, *, quiet: bool, console: Console | None = None) -> None:
        self._bar = rich_progress.Progress(
            TextColumn("{task.description:<14}"),
            BarColumn(bar_width=30),
            TextColumn("{task.fields[facts]}"),
            TimeElapsedColumn(),
            console=console or Console(stderr=True),
            disable=quiet,
        )
        self._task: TaskID | None = None

    def __enter__(self) -> Self:
        self._bar.start()
        self._task = self._bar.add_task("Connecting", total=1.0, facts="")
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def show(self, phase: str, beat: Heartbeat) -> None:
        """Show one heartbeat."""
        if self._task is None:
            return
        self._bar.update(
            self._task,
            description=phase,
            completed=beat.explored or 0.0,
            facts=_failed(beat) if phase == CHECKING else _facts(beat),
        )


def _failed(beat: Heartbeat) -> str:
    """Return the checks that keep the drone on the ground."""
    return " · ".join(f"{check.name}: {check.value}" for check in beat.checks if not check.passed)


def _facts(beat: Heartbeat) -> str:
    height = "–" if beat.relative_altitude is None else f"{beat.relative_altitude:z.0f} m"
    battery = "–" if beat.battery_percentage is None else f"{beat.battery_percentage:.0f} %"
    seen = "" if beat.explored is None else f"{100 * beat.explored:.0f} % seen so far · "
    return f"{seen}{beat.free} free, {beat.taken} taken, {beat.unknown} unclear · {height} · battery {battery}"
