"""Flown explorations against the exploration's benchmark and against a lawnmower over the same worlds.

``python -m benchmarks.flown_surveys --seeds 1-20 [--json FILE] [--out DIR]``

Each drawn world is flown three times: explored through the whole simulated stack, flown to and fro over all of its lots
through the same stack (a pilot who knows the border), and explored by the planner alone on the model of
``benchmarks/exploration``, from the same place inside the same fence. Distances are those of exploring, without
take-off and the flight home. A flight whose pictures the simulator drew too late is flown again, slower
(`benchmarks.pace`).
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import math
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import numpy as np
import shapely

from benchmarks.exploration import setups
from benchmarks.exploration.lots import Lot
from benchmarks.figures import BenchmarkError, Figure, Limit, Section, print_and_write
from benchmarks.lawnmower import LawnmowerOperator, lanes
from benchmarks.pace import in_time
from benchmarks.surveys import TIMEOUT_S, seeds_option
from benchmarks.world_lots import Ring, joined, kinematic_flight, rings_about
from hawk.comm.protocol.heartbeat import Heartbeat
from hawk.model.operation import StateName
from hawk.model.plans import Fence
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import SurveyMap
from hawk.sim.launch import SimulationOptions
from hawk.survey import report
from hawk.survey.client import DroneClient, LinkLostError
from hawk.survey.handset import Progress, SurveyStatus
from hawk.survey.operator import SurveyOperator, SurveyPlan
from hawk.survey.run import LATE_FRAMES_LIMIT, FenceSender
from hawk.survey.stack import SimulatedStack, StackError
from hawk.survey.truth import GroundTruth

DEFAULT_SEEDS: Final = "1-20"
APART: Final = 0.10
"""Flown distances may differ from the kinematic ones by this share."""

_MAP_ATTEMPTS: Final = 4

MakeOperator = Callable[[DroneClient, GroundTruth, Progress], SurveyOperator]


@dataclass(frozen=True, slots=True)
class FlownPart:
    """Heartbeats at the begin and at the end of the work: place and yaw, and metres in between."""

    first: Heartbeat
    last: Heartbeat

    @property
    def distance_m(self) -> float:
        """Metres flown in between, as the drone counts them."""
        return (self.last.distance_flown or 0.0) - (self.first.distance_flown or 0.0)

    @property
    def seconds(self) -> float:
        """Seconds in between."""
        return self.last.time - self.first.time


@dataclass(frozen=True, slots=True)
class StackFlight:
    """One flight through the stack; ``late`` is the share of pictures that the simulator drew late."""

    status: int
    reason: str
    flown: FlownPart
    survey: SurveyMap
    truth: GroundTruth
    f1: float
    late: float
    excursions: int


@dataclass(frozen=True, slots=True)
class WorldRun:
    """One world: distances in metres, seconds, stall F1."""

    seed: int
    status: int
    reason: str
    distance_m: float
    seconds: float
    f1: float
    kinematic_distance_m: float
    kinematic_seconds: float
    lawnmower_status: int
    lawnmower_distance_m: float
    lawnmower_f1: float
    late: float
    excursions: int


class WorkObserver:
    """Remembers the heartbeats where the work began and ended: exploring, or moving from lane to lane."""

    def __init__(self, states: frozenset[StateName]) -> None:
        self._states = states
        self._first: Heartbeat | None = None
        self._last: Heartbeat | None = None

    def look(self, beat: Heartbeat) -> None:
        """Take a heartbeat."""
        if beat.state in self._states:
            self._first = self._first or beat
            self._last = beat

    def flown(self) -> FlownPart:
        """Return both. Raises BenchmarkError when the work never began."""
        if self._first is None or self._last is None:
            raise BenchmarkError("the flight never came to its work; see the logs")
        return FlownPart(self._first, self._last)


async def fly_stack(
    seed: int, name: str, folder: Path, make: MakeOperator, states: frozenset[StateName]
) -> StackFlight:
    """Fly one world through simulator and daemon, in time. Raises StackError, BenchmarkError, TimeoutError."""

    async def fly(speed: float) -> StackFlight:
        async with asyncio.timeout(TIMEOUT_S):
            return await _fly_at(speed, seed, folder / f"{name}-speed-{speed:g}", make, states)

    return await in_time(f"world {seed}, {name}", fly, lambda flight: flight.late)


async def _fly_at(
    speed: float, seed: int, folder: Path, make: MakeOperator, states: frozenset[StateName]
) -> StackFlight:
    stack = SimulatedStack(SimulationOptions(seed=seed, speed=speed), folder, None, None)
    try:
        ready = await stack.start()
        truth = stack.truth
        if truth is None:
            raise BenchmarkError(f"world {seed} holds no lot")
        host, _, port = ready.url.rpartition("//")[2].rstrip("/").partition(":")
        async with DroneClient(host, int(port)) as drone:
            work, fence = WorkObserver(states), FenceSender(stack)

            def show(_: str, beat: Heartbeat) -> None:
                work.look(beat)
                fence.look(beat)

            outcome = await make(drone, truth, show).run()
            survey = await _map_of(drone)
            await fence.close()
        status = await stack.status()
    finally:
        await stack.stop()
    if survey is None:
        raise BenchmarkError(f"world {seed}: the drone has no map; see {folder}")
    f1 = float(report.compare(survey, truth)["stall_f1"])
    late = status["frames_late"] / max(status["frames_due"], 1)
    return StackFlight(
        int(outcome.status), outcome.reason, work.flown(), survey, truth, f1, late, int(status["excursions"])
    )


async def _map_of(drone: DroneClient) -> SurveyMap | None:
    """Return the map; a busy machine takes longer than one call waits."""
    for _ in range(_MAP_ATTEMPTS - 1):
        with contextlib.suppress(LinkLostError):
            return await drone.survey_map()
    return await drone.survey_map()


def lot_of(flight: StackFlight, seed: int) -> Lot:
    """Return the world's lots in the flight's map frame, with its start and its fence, for the kinematic model."""
    first = flight.flown.first
    fence = Fence(
        tuple((point.north, point.east) for point in first.fence),
        tuple((point.north, point.east) for point in first.fence_limit),
        first.ceiling or math.inf,
        math.inf,
    )
    if first.north is None or first.east is None:
        raise BenchmarkError(f"world {seed}: the drone did not know where it began")
    shape = joined(rings_of(flight.truth, flight.survey))
    return Lot(seed, "world", shape, (first.north, first.east), first.yaw or 0.0, fence)


def rings_of(truth: GroundTruth, survey: SurveyMap) -> list[Ring]:
    """Return the lots' outlines (N, 2) as (north, east) of the survey's map."""
    ((x, y),) = truth.to_world(np.zeros((1, 2)), survey.datum)
    return rings_about(truth.lots, (x, y))


async def measure(seed: int, folder: Path) -> WorldRun:
    """Fly one world three times."""
    explores, moves = (frozenset({state}) for state in (StateName.AUTONOMOUS_EXPLORE, StateName.COMPULSIVE_MOVE))
    explored = await fly_stack(seed, "explored", folder, _explorer, explores)
    mown = await fly_stack(seed, "lawnmower", folder, _lawnmower, moves)
    kinematic = kinematic_flight(lot_of(explored, seed))
    return WorldRun(
        seed,
        explored.status,
        explored.reason,
        explored.flown.distance_m,
        explored.flown.seconds,
        explored.f1,
        kinematic.whole_distance_m,
        kinematic.whole_seconds,
        mown.status,
        mown.flown.distance_m,
        mown.f1,
        max(explored.late, mown.late),
        explored.excursions + mown.excursions,
    )


def _explorer(drone: DroneClient, truth: GroundTruth, show: Progress) -> SurveyOperator:  # noqa: ARG001
    return SurveyOperator(drone, SurveyPlan(set_failsafes=True), show)


def _lawnmower(drone: DroneClient, truth: GroundTruth, show: Progress) -> SurveyOperator:
    def route(beat: Heartbeat) -> list[tuple[float, float]]:
        survey = SurveyMap(_datum(beat), {}, {})
        shape = joined(rings_of(truth, survey))
        fence = shapely.Polygon([(point.north, point.east) for point in beat.fence])
        return lanes(shape, fence, beat.yaw or 0.0, setups.flown().swath, (beat.north or 0.0, beat.east or 0.0))

    return LawnmowerOperator(drone, SurveyPlan(set_failsafes=True), show, route)


def _datum(beat: Heartbeat) -> GlobalPose:
    if beat.datum is None:
        raise BenchmarkError("the drone has no datum: its map lies nowhere")
    return GlobalPose(beat.datum[0], beat.datum[1], 0.0)


def figures(runs: Sequence[WorldRun]) -> list[Figure]:
    """Return the figures of all worlds together."""
    count = float(len(runs))
    ratio = sum(run.distance_m for run in runs) / sum(run.kinematic_distance_m for run in runs)
    seconds = sum(run.seconds for run in runs) / sum(run.kinematic_seconds for run in runs)
    ratios = [run.distance_m / run.kinematic_distance_m for run in runs]
    finished = float(sum(run.status == SurveyStatus.DONE for run in runs))
    late = max(run.late for run in runs)
    near = Limit(1 - APART, 1 + APART)
    gains = [run.f1 - run.lawnmower_f1 for run in runs]
    return [
        Figure("flown_worlds", "worlds", count),
        Figure("flown_finished", "explored, landed and disarmed", finished, limit=Limit(lowest=count)),
        Figure("flown_distance_over_kinematic", "distance of all by the kinematic one", ratio, limit=near),
        Figure("flown_distance_over_kinematic_median", "the same by world, median", float(np.median(ratios))),
        Figure("flown_seconds_over_kinematic", "time of all by the kinematic one", seconds),
        Figure("flown_f1", "stall F1, mean", float(np.mean([run.f1 for run in runs]))),
        Figure("lawnmower_f1", "stall F1 of the lawnmower, mean", float(np.mean([run.lawnmower_f1 for run in runs]))),
        Figure("flown_f1_gain", "F1 against the lawnmower, mean", float(np.mean(gains)), limit=Limit(lowest=-0.005)),
        Figure("flown_f1_gain_min", "F1 against the lawnmower, worst world", float(np.min(gains))),
        Figure("flown_distance_over_lawnmower", "distance by the lawnmower's", _share(runs)),
        Figure("flown_excursions", "excursions", float(sum(run.excursions for run in runs)), limit=Limit(0, 0)),
        Figure("flown_late_frames", "late frames, worst", late, limit=Limit(highest=LATE_FRAMES_LIMIT)),
    ]  # fmt: skip


def problem_of(runs: Sequence[WorldRun], asked: int) -> str:
    """Return why the figures are void or not of all worlds, nothing when they are good."""
    late = [str(run.seed) for run in runs if run.late > LATE_FRAMES_LIMIT]
    problems = [f"VOID: the simulator drew too late for {', '.join(late)}"] if late else []
    problems += [f"only {len(runs)} of {asked} worlds were measured"] if len(runs) < asked else []
    return "; ".join(problems)


def _share(runs: Sequence[WorldRun]) -> float:
    return sum(run.distance_m for run in runs) / max(sum(run.lawnmower_distance_m for run in runs), 1e-9)


async def _all(seeds: Sequence[int], folder: Path) -> list[WorldRun]:
    runs = []
    for seed in seeds:
        try:
            run = await measure(seed, folder / f"seed-{seed}")
        except (StackError, BenchmarkError, LinkLostError, TimeoutError) as error:
            print(f"world {seed}: not measured: {error!r}", file=sys.stderr, flush=True)
            continue
        runs.append(run)
        print(
            f"world {seed}: distance {run.distance_m:.0f} m, kinematic {run.kinematic_distance_m:.0f} m, "
            f"lawnmower {run.lawnmower_distance_m:.0f} m; F1 {run.f1:.3f}, lawnmower {run.lawnmower_f1:.3f}; "
            f"late {run.late:.2%}; {run.reason}",
            file=sys.stderr,
            flush=True,
        )
    return runs


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly, print, write."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.flown_surveys",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", type=seeds_option, default=DEFAULT_SEEDS, metavar="A-B", help="drawn worlds (1-20)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures and every world")
    parser.add_argument("--out", type=Path, metavar="DIR", help="keep logs, journals and recordings there")
    options = parser.parse_args(arguments)
    if options.json is not None:
        options.json.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="hawk-flown-") as scratch:
        runs = asyncio.run(_all(options.seeds, options.out or Path(scratch)))
    if not runs:
        print("no world was measured", file=sys.stderr)
        return 1
    section = Section("flown surveys", figures(runs), problem_of(runs, len(options.seeds)))
    print_and_write([section], options.json, worlds=[asdict(run) for run in runs])
    return 0


if __name__ == "__main__":
    sys.exit(main())
