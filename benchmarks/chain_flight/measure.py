"""Scores of a flight against the truth: the fused map, and beside it each single frame.

Single frames are given the true position: drift is the map's to take out. Their stalls are those that the frame alone
shows with a score of .5, and the truth is what lies wholly in its picture. Stalls that the edge of the world's own
picture cuts count neither as missed nor as false, and what is found beyond that edge does not count.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from statistics import fmean

import numpy as np
import pymap3d
from numpy.typing import NDArray

from benchmarks.chain_flight.flight import Flown, Glance
from benchmarks.chain_flight.views import Views
from benchmarks.figures import Figure, Limit, Reference
from benchmarks.perception.edges import finds_of_cut, without
from benchmarks.perception.measures import Judged, calibration_error
from hawk.algo.vision import decode, quads
from hawk.algo.vision.detection import GroundImage
from hawk.model.lot_map import HELD_SHARE, TILE_CELLS, StallState, free_interval
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import SurveyMap
from hawk.survey import accuracy
from hawk.survey.accuracy import Finding, Tally, match, tally
from hawk.survey.report import compare, in_range, map_offset
from hawk.survey.truth import GroundTruth, in_picture
from hawk.worlds.world import World

ORIGIN = GlobalPose(43.2609, -79.9192, 0.0)
"""Place of a world's picture, its upper left corner."""
MINIMUM_SCORE = 0.5
WHOLE = 0.98
FREE_SHARE, FREE_STALLS = 0.05, 2
LEAST_LOOKED_AT = 0.97

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Judgement:
    """Scores of one finding against the truth. ``errors`` (N,) are metres between centres of matched stalls, and
    ``matched`` (N,) their numbers among the labels that count.
    """

    tally: Tally
    judged: Judged
    errors: Floats = field(repr=False)
    matched: NDArray[np.intp] = field(repr=False)

    @classmethod
    def of(
        cls,
        stalls: Floats,
        taken: Floats,
        states: NDArray[np.object_],
        truth: accuracy.LabelledPlace,
        cut: NDArray[np.bool_] | None = None,
    ) -> Judgement:
        """Judge stalls (N, 4, 2) with their probabilities of being taken (N,) and states (N,).

        ``cut`` (M,): labels that count neither as missed nor, when found, as false (`benchmarks.perception.edges`).
        """
        if cut is not None:
            kept = ~finds_of_cut(stalls, truth.stalls, cut)
            stalls, taken, states, truth = stalls[kept], taken[kept], states[kept], without(truth, cut)
        pairs = match(stalls, truth.stalls)
        real = np.asarray(truth.states, object)[pairs.true]
        known = (real == StallState.FREE) | (real == StallState.TAKEN)
        apart = stalls[pairs.found].mean(1) - truth.stalls[pairs.true].mean(1)
        return cls(
            tally(Finding(stalls, states), truth),
            Judged(taken[pairs.found][known], np.asarray(real[known] == StallState.TAKEN)),
            np.hypot(apart[:, 0], apart[:, 1]),
            pairs.true,
        )


@dataclass(frozen=True, slots=True)
class Pool:
    """Judgements taken together."""

    parts: tuple[Judgement, ...]

    @property
    def tally(self) -> Tally:
        """All counts."""
        return sum((part.tally for part in self.parts), Tally())

    @property
    def calibration_error(self) -> float:
        """Expected calibration error of the probability of being taken."""
        return calibration_error(part.judged for part in self.parts)

    @property
    def position_error(self) -> float | None:
        """95th percentile of the errors of matched centres, metres; None without a match."""
        errors = np.concatenate([np.zeros(0), *(part.errors for part in self.parts)])
        return float(np.percentile(errors, 95)) if len(errors) else None


class SingleFrames:
    """Judges every frame of a flight by itself; ``watch`` goes to `flight.fly`."""

    def __init__(self, world: World) -> None:
        self._start, self._size = world.start(), world.size_m
        self._views = Views(world)
        self.cut = ~self._views.counted
        """A mask (N,) of the world's stalls that its picture does not show whole."""
        self.judgements: list[Judgement] = []
        self._shown, self._found = (np.zeros(len(self.cut), int) for _ in range(2))

    @property
    def looked_at(self) -> tuple[int, int]:
        """Labelled stalls that were wholly in the good part of a frame's picture, and all; without cut labels."""
        counted = self._views.well[~self.cut]
        return int(counted.sum()), len(counted)

    @property
    def recall_once(self) -> float | None:
        """Share of its frames that find a stall, mean over the stalls that any frame shows whole; None without one.

        Pooled over frames, a stall counts as often as it is shown: one in the lot's middle more than one at its rim.
        """
        judged = self._shown > 0
        return float((self._found[judged] / self._shown[judged]).mean()) if judged.any() else None

    def watch(self, glance: Glance) -> None:
        """Judge one frame."""
        seen, off = glance.seen, np.array(glance.off)
        sure = [s for s in seen.stalls if s.score >= MINIMUM_SCORE and s.visible > WHOLE]
        table = np.array([(s.north, s.east, s.angle, s.width, s.length, s.taken) for s in sure]).reshape(-1, 6)
        table[:, :2] -= off
        x0, y0 = self._start
        table = table[in_picture(np.column_stack((x0 + table[:, 1], y0 - table[:, 0])), self._size)]
        corners, known = self._views.corners, self._views.states
        whole = _is_whole(seen.picture, corners + off)
        self._views.see(glance)
        truth = accuracy.LabelledPlace(corners[whole], known[whole])
        states = np.where(table[:, 5] < 0.5, StallState.FREE, StallState.TAKEN).astype(object)
        judgement = Judgement.of(quads_of(table[:, :5]), table[:, 5], states, truth, self.cut[whole])
        self.judgements.append(judgement)
        counted = np.flatnonzero(whole & ~self.cut)
        self._shown[counted] += 1
        self._found[counted[judgement.matched]] += 1


@dataclass(frozen=True, slots=True)
class Result:
    """One flight: the report of its map, scores fused and frame by frame, recall of stalls not hidden, and the distance
    (metres) of the planner over the same lot on the exploration's model of a map. ``once`` is the recall of single
    frames with every stall counted once (`SingleFrames.recall_once`).
    """

    name: str
    flown: Flown
    report: dict[str, float]
    fused: Judgement
    single: Pool
    recall_seen: tuple[int, int]
    model_distance_m: float
    once: float | None = None
    looked_at: tuple[int, int] = (0, 0)

    @property
    def looked_at_share(self) -> float | None:
        """Share (0..1) of the labelled stalls that were looked at; None without stalls."""
        return self.looked_at[0] / self.looked_at[1] if self.looked_at[1] else None

    @property
    def recall_is_kept(self) -> bool:
        """True when the map holds no smaller share of the stalls than single frames find of them."""
        return self.once is None or self.fused.tally.recall >= self.once

    @property
    def free_is_right(self) -> bool:
        """True when the count of free stalls is right to 5 % or 2 stalls."""
        off, true = self.fused.tally.free_count_error, self.fused.tally.free_true
        return off <= FREE_STALLS or off <= FREE_SHARE * true

    @property
    def free_range(self) -> tuple[int, int] | None:
        """The interval about the count of free stalls, as it is published."""
        output = self.flown.output
        return free_interval(output.occupancy_map.counts, output.path_plan.explore)

    @property
    def free_in_range(self) -> bool:
        """True when the interval holds the true number of free stalls; False without an interval."""
        return in_range(self.fused.tally.free_true, self.free_range) is True


def judge(
    name: str, world: World, truth: GroundTruth, flown: Flown, single: SingleFrames, model_distance_m: float
) -> Result:
    """Compare a flight's map with the truth; the constant part of the position error is taken out (`map_offset`)."""
    survey = survey_of(world, flown)
    stalls = survey.marked
    x0, y0 = world.start()
    corners = np.array([stall.corners() for stall in stalls]).reshape(-1, 4, 2)
    found = np.stack([x0 + corners[..., 1], y0 - corners[..., 0]], axis=-1)
    true = np.asarray(truth.stalls, float).reshape(-1, 4, 2)
    found += map_offset(found.mean(1), true.mean(1))
    real = accuracy.LabelledPlace(true, np.array([s or StallState.UNKNOWN for s in truth.states], object), truth.lots)
    taken, states = np.array([s.taken for s in stalls]), np.array([s.state for s in stalls], object)
    inside = truth.in_picture(found.mean(1))
    found = found[inside]
    fused = Judgement.of(found, taken[inside], states[inside], real, single.cut)
    shown = ~(np.asarray(truth.hidden, np.bool_) | single.cut)
    matched = match(found, true).true
    report, seen = compare(survey, truth), (int(shown[matched].sum()), int(shown.sum()))
    once, looked_at = single.recall_once, single.looked_at
    return Result(name, flown, report, fused, Pool(tuple(single.judgements)), seen, model_distance_m, once, looked_at)


def survey_of(world: World, flown: Flown) -> SurveyMap:
    """Return the map of a flight as a survey would: its datum is the world's start."""
    x0, y0 = world.start()
    latitude, longitude, _ = pymap3d.ned2geodetic(-y0, x0, 0.0, ORIGIN.latitude, ORIGIN.longitude, 0.0)
    found = flown.output.occupancy_map
    shape = (TILE_CELLS, TILE_CELLS)
    tiles = {k: np.frombuffer(zlib.decompress(tile.data), np.uint8).reshape(shape) for k, tile in found.tiles.items()}
    mosaic = {key: tile.data for key, tile in found.mosaic.items()}
    return SurveyMap(GlobalPose(float(latitude), float(longitude), 0.0), found.stalls, tiles, mosaic)


def line(result: Result) -> str:
    """Return the figures of one flight for people."""
    fused, single = result.fused.tally, result.single.tally
    alone = Pool((result.fused,))
    parts = [
        f"F1 {fused.f1:.3f} (P {fused.precision:.3f} R {fused.recall:.3f}) free {fused.free_found}/{fused.free_true}",
        f"state {fused.state_accuracy:.3f} unknown {fused.unknown_share:.3f} ECE {alone.calibration_error:.3f}",
        f"p95 {alone.position_error or float('nan'):.2f} m lot {result.report['lot_iou']:.3f}",
        f"looked at {result.looked_at[0]}/{result.looked_at[1]}",
        f"in view: lot {result.report['lot_seen']:.3f}, stalls {result.report['stalls_seen']:.3f}, "
        f"recall of those {result.report['stall_recall_seen']:.3f}",
        f"single frames F1 {single.f1:.3f} (P {single.precision:.3f} R {single.recall:.3f}, every stall once "
        f"{float('nan') if result.once is None else result.once:.3f}) "
        f"state {single.state_accuracy:.3f} ECE {result.single.calibration_error:.3f}",
        f"{result.flown.distance_m:.0f} m (model {result.model_distance_m:.0f} m) {result.flown.seconds:.0f} s, "
        f"mapper p99 {np.percentile(result.flown.mapper_ms, 99):.1f} ms",
    ]
    return f"{result.name}: " + ", ".join(parts)


def figures(results: Sequence[Result]) -> list[Figure]:
    """Return the figures of all flights together: counts added up, fused beside single frames."""
    count = len(results)
    return [
        Figure("chain_flights", "flights", float(count)),
        Figure("chain_finished", "whole lot seen", float(sum(r.flown.finished for r in results)), limit=Limit(count)),
        *_of_stalls(results),
        Figure("chain_lot_iou", "lot IoU, mean", fmean(r.report["lot_iou"] for r in results)),
        *_looked_at(results),
        *_in_view(results),
        *_of_flights(results),
    ]


def _of_stalls(results: Sequence[Result]) -> list[Figure]:
    fused = Pool(tuple(result.fused for result in results))
    single = Pool(tuple(part for result in results for part in result.single.parts))
    one, many = fused.tally, single.tally
    free_off = (one.free_found - one.free_true) / one.free_true if one.free_true else None
    seen = np.sum([result.recall_seen for result in results], axis=0)
    widths = [bounds[1] - bounds[0] for result in results if (bounds := result.free_range) is not None]

    def beside(key: str, text: str, limit: Limit | None = None) -> list[Figure]:
        value, alone = getattr(one, key), getattr(many, key)
        name = "stall_f1" if key == "f1" else key
        return [
            Figure(f"chain_{name}", text, value, reference=Reference("single frames", alone), limit=limit),
            Figure(f"chain_single_{name}", f"{text}, single frames", alone),
        ]

    return [
        *beside("f1", "stall F1, pooled", Limit(lowest=0.97)),
        Figure("chain_stall_f1_min", "stall F1, worst", min((r.fused.tally.f1 for r in results), default=None)),
        *beside("precision", "precision"),
        *beside("recall", "recall"),
        Figure(
            "chain_recall_kept", "flights whose recall is no less than single frames', every stall once, share",
            fmean(r.recall_is_kept for r in results), limit=Limit(lowest=1.0),
        ),
        Figure("chain_recall_seen", "recall of stalls that are not hidden", float(seen[0] / seen[1])),
        *beside("precision_star", "precision, counted false alarms only"),
        *beside("recall_whole", "recall of whole stalls"),
        *beside("free_precision_star", "free precision, counted false alarms only"),
        *beside("free_recall", "free recall"),
        *beside("state_accuracy", "state accuracy (unknown is wrong)"),
        Figure("chain_unknown_share", "unknown state", one.unknown_share, limit=Limit(highest=0.05)),
        Figure("chain_free_count_error", "free stalls, pooled error", free_off, limit=Limit(-0.02, 0.02)),
        Figure(
            "chain_free_counts_right", f"free stalls within {FREE_SHARE:.0%} or {FREE_STALLS} stalls",
            float(sum(r.free_is_right for r in results)), limit=Limit(lowest=len(results)),
        ),
        Figure(
            "chain_free_in_range", "flights whose interval holds the free count, share",
            fmean(r.free_in_range for r in results), limit=Limit(lowest=HELD_SHARE),
        ),
        Figure("chain_free_range_width", "width of that interval, mean, stalls", fmean(widths) if widths else None),
        Figure(
            "chain_position_error_p95_m", "position error of centres, p95", fused.position_error, "m",
            Reference("single frames", single.position_error), Limit(highest=0.5),
        ),
        Figure(
            "chain_ece", "calibration error of the state", fused.calibration_error, "",
            Reference("single frames", single.calibration_error), Limit(highest=0.05),
        ),
    ]  # fmt: skip


def _looked_at(results: Sequence[Result]) -> list[Figure]:
    """Return the share of the labelled stalls that were looked at, of all flights and of the worst one."""
    looked_at, labelled = np.sum([result.looked_at for result in results], axis=0)
    shares = [share for result in results if (share := result.looked_at_share) is not None]
    pooled = float(looked_at / labelled) if labelled else None
    least, limit = min(shares, default=None), Limit(lowest=LEAST_LOOKED_AT)
    return [
        Figure("chain_stalls_seen", "stalls ever wholly in the good part of a picture, share", pooled, limit=limit),
        Figure("chain_stalls_seen_min", "the same, least flight", least, limit=limit),
    ]


def _in_view(results: Sequence[Result]) -> list[Figure]:
    """Return what was ever in view of all lots and stalls, beside what was found: stalls added up, lots a mean."""
    lots = [share for r in results if math.isfinite(share := r.report["lot_seen"])]
    true, seen, found = 0.0, 0.0, 0.0
    for report in (result.report for result in results):
        if report["true_stalls"]:
            part = report["stalls_seen"] * report["true_stalls"]
            true, seen = true + report["true_stalls"], seen + part
            found += report["stall_recall_seen"] * part if part else 0.0
    return [
        Figure("chain_lot_seen", "share of the true lot ever in view, mean", fmean(lots) if lots else None),
        Figure("chain_stalls_in_view", "share of the true stalls ever in view", seen / true if true else None),
        Figure("chain_recall_in_view", "recall of stalls ever in view", found / seen if seen else None),
    ]


def _of_flights(results: Sequence[Result]) -> list[Figure]:
    count = len(results)
    distances, model = (
        sum(result.flown.distance_m for result in results),
        sum(result.model_distance_m for result in results),
    )
    frame_ms, mapper_ms = (
        np.concatenate([np.zeros(0), *(getattr(r.flown, key) for r in results)]) for key in ("frame_ms", "mapper_ms")
    )
    return [
        Figure(
            "chain_distance_m",
            "distance, mean",
            distances / count,
            "m",
            Reference("the exploration's model", model / count),
        ),
        Figure("chain_distance_over_model", "distance of all by the exploration's model", distances / model),
        Figure("chain_frame_ms_p50", "frame, JPEG to plan, median", float(np.median(frame_ms)), "ms"),
        Figure("chain_frame_ms_p95", "frame, JPEG to plan, p95", float(np.percentile(frame_ms, 95)), "ms"),
        Figure("chain_mapper_ms_p50", "map update, median", float(np.median(mapper_ms)), "ms"),
        Figure("chain_mapper_ms_p99", "map update, p99", float(np.percentile(mapper_ms, 99)), "ms"),
    ]


def quads_of(table: Floats) -> Floats:
    """Return corners (N, 4, 2) of (north, east) for rows (N, 5) of north, east, angle, width, length."""
    return quads.corners(*table.T)


def _is_whole(picture: GroundImage, corners: Floats) -> NDArray[np.bool_]:
    pixels = picture.pixel_points(corners)
    return np.asarray(decode.sample(picture.valid, pixels).all(axis=1))
