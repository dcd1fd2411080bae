"""The command ``hawk-drone survey``: flies a survey without a browser and writes what it found."""

from __future__ import annotations

import asyncio
import json
import signal
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import cv2
import numpy as np

from hawk.comm.base_socket import ConnectionTimeout
from hawk.comm.messages import Heartbeat
from hawk.model import GlobalPose
from hawk.simulation import SimulationOptions
from hawk.stall_exports import stalls_csv, stalls_geojson_text
from hawk.survey import report
from hawk.survey.client import DroneClient, LinkLostError
from hawk.survey.map_picture import map_picture
from hawk.survey.operator import Progress, SurveyLimits, SurveyOperator, SurveyOutcome, SurveyPlan, SurveyStatus
from hawk.survey.progress import SurveyProgress
from hawk.survey.stack import SimulatedStack, StackError
from hawk.survey.survey_map import SurveyMap
from hawk.survey.truth import Truth, TruthError, read_truth

LATE_FRAMES_LIMIT = 0.01
"""Share of pictures that the simulator drew late above which a run says nothing about perception."""


@dataclass(frozen=True, slots=True)
class SurveyOptions:
    """What to survey and where to write. ``url`` is a daemon that runs already, else ``simulation`` is started."""

    out: Path
    simulation: SimulationOptions | None
    url: str | None
    token: str | None
    config: Path | None
    fence: Path | None
    truth: Path | None
    set_failsafes: bool
    timeout_s: float
    quiet: bool


async def run_survey(options: SurveyOptions) -> int:
    """Fly one survey; return the exit status (docs/survey.md)."""
    options.out.mkdir(parents=True, exist_ok=True)
    stack: SimulatedStack | None = None
    try:
        if options.simulation is None:
            truth = None if options.truth is None else read_truth(options.truth)
            return await _fly(options, options.url or "", None, truth)
        stack = SimulatedStack(options.simulation, options.out / "run", options.config, options.fence)
        ready = await stack.start()
        return await _fly(options, ready.url, stack, stack.truth)
    except (StackError, TruthError, ConnectionTimeout, LinkLostError) as error:
        print(f"hawk-drone survey: {error}", file=sys.stderr)
        return SurveyStatus.FAILED
    finally:
        if stack is not None:
            await stack.stop()


async def _fly(options: SurveyOptions, url: str, stack: SimulatedStack | None, truth: Truth | None) -> int:
    address = urlsplit(url if "//" in url else f"//{url}")
    async with DroneClient(address.hostname or "127.0.0.1", address.port or 3000, token=options.token) as drone:
        watch = FenceWatch(stack)
        limits = replace(SurveyLimits(), explore_s=options.timeout_s)
        plan = SurveyPlan(set_failsafes=options.set_failsafes, limits=limits)
        with SurveyProgress(quiet=options.quiet) as bar:

            def show(progress: Progress) -> None:
                bar.show(progress)
                watch.look(progress.heartbeat)

            operator = SurveyOperator(drone, plan, show)
            loop = asyncio.get_running_loop()
            for name in (signal.SIGINT, signal.SIGTERM):
                loop.add_signal_handler(name, operator.interrupt)
            outcome = await operator.run()
        survey = await _map_of(drone)
        await watch.close()
        status = None if stack is None else await stack.status()
    values = _report(outcome, survey, truth, status)
    write_results(options.out, survey, values)
    _say(options.out, outcome, values)
    return int(outcome.status)


class FenceWatch:
    """Tells the simulator our fence as soon as it is known, so that it can count excursions of the true position."""

    def __init__(self, stack: SimulatedStack | None) -> None:
        self._stack = stack
        self._told: tuple[object, ...] = ()
        self._task: asyncio.Task[None] | None = None

    def look(self, beat: Heartbeat) -> None:
        """Take the fence from a heartbeat; tell it when it is another one."""
        if self._stack is None or beat.datum is None or not beat.fence:
            return
        fence = (tuple(beat.datum), tuple((p.north, p.east) for p in beat.fence), beat.ceiling)
        if fence == self._told or (self._task is not None and not self._task.done()):
            return
        self._told = fence
        place = SurveyMap(GlobalPose(beat.datum[0], beat.datum[1], 0.0), {}, {})
        corners = place.to_global(np.array([[p.north, p.east] for p in beat.fence]))
        polygon = [(float(latitude), float(longitude)) for latitude, longitude in corners]
        self._task = asyncio.create_task(
            self._stack.watch_fence(polygon, beat.ceiling or 1000.0), name="survey-fence-watch"
        )

    async def close(self) -> None:
        """Wait until the last one was told. Raises what went wrong."""
        if self._task is not None:
            await self._task


def write_results(folder: Path, survey: SurveyMap, values: dict[str, Any]) -> None:
    """Write ``stalls.csv``, ``stalls.geojson``, ``map.png`` and ``report.json``."""
    (folder / "stalls.csv").write_text(stalls_csv(survey.datum, survey.stalls), encoding="utf-8")
    (folder / "stalls.geojson").write_text(stalls_geojson_text(survey.datum, survey.stalls), encoding="utf-8")
    cv2.imwrite(str(folder / "map.png"), map_picture(survey))
    (folder / "report.json").write_text(json.dumps(report.finite(values), indent=1, allow_nan=False), encoding="utf-8")


async def _map_of(drone: DroneClient) -> SurveyMap:
    try:
        found = await drone.survey_map()
    except LinkLostError:
        found = None
    return found or SurveyMap(GlobalPose(0.0, 0.0, 0.0), {}, {})


def _report(
    outcome: SurveyOutcome, survey: SurveyMap, truth: Truth | None, status: dict[str, Any] | None
) -> dict[str, Any]:
    """Return the report: what was flown as the drone saw it, corrected by what really happened where that is known."""
    values: dict[str, Any] = {
        "status": int(outcome.status),
        "reason": outcome.reason,
        "landed": outcome.landed,
        "disarmed": outcome.disarmed,
        "duration_s": outcome.duration_s,
        "way_m": outcome.way_m,
        "explored": outcome.explored,
        "lot_area_m2": None,
        **report.counts(survey),
    }
    if status is not None:
        due, late = status["frames_due"], status["frames_late"]
        values |= {key: status[key] for key in ("landed", "disarmed", "way_m", "excursions", "crashed")}
        values |= {"late_frames": late / due if due else 0.0, "frames_due": due}
        values["run_is_valid"] = values["late_frames"] <= LATE_FRAMES_LIMIT
    if truth is not None and truth.origin is not None and (survey.tiles or survey.stalls):
        values |= report.compare(survey, truth)
    values["lot_area_m2"] = report.lot_area(survey)
    return values


def _say(folder: Path, outcome: SurveyOutcome, values: dict[str, Any]) -> None:
    print(f"{outcome.reason}")
    print(
        f"{values['stalls']} stalls: {values['free']} free, {values['taken']} taken, {values['unknown']} unclear. "
        f"Results in {folder}"
    )
    if "stall_f1" in values:
        keys = ("stall_f1", "stall_precision", "stall_recall", "recall_whole", "state_accuracy", "lot_iou")
        print(", ".join(f"{key} {values[key]:.3f}" for key in keys) + f", excursions {values.get('excursions')}")
