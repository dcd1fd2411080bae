"""Recordings and their films: the same flight mapped as it was flown, from the recording, and from MP4 with captions.

A flight to and fro over a drawn lot is recorded as a drone records it. From the recording an MP4 is made, with captions
as a Mavic 3 writes them: places to .1 m, angles to .1 degree. Beside the truth stand the map that the drone's own
program makes of the recording, that of the recording as a source of ``hawk-drone map``, and that of the film.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from importlib.metadata import version
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from benchmarks.chain_flight.measure import ORIGIN
from benchmarks.figures import Figure, Limit
from benchmarks.replayed import FlightKind, drawn_frames, write_flight
from benchmarks.vision_frame import camera_model
from hawk.ddc.recorder import TICK
from hawk.formats.image import NoImage, decode
from hawk.lots.survey.source import SourceKind
from hawk.model.pictures import angles, rotation
from hawk.model.poses import GlobalPose
from hawk.picture.film.app import read_film
from hawk.picture.film.course import Course
from hawk.picture.film.lens import LensChoice
from hawk.picture.film.recording import read_frames
from hawk.picture.photos import Taken, survey_shots
from hawk.replay.flight import RecordedFlight
from hawk.replay.process import Again, process
from hawk.results.survey_map import SurveyMap
from hawk.sim.photos import PhotoOptions, plan
from hawk.sim.photos_tags import CAMERAS
from hawk.store.frame_codec import FRAME_INPUT, picture_of
from hawk.store.recording_ring import Item
from hawk.survey.report import compare
from hawk.survey.truth import GroundTruth, parse_truth
from hawk.worlds.generate import generate_world
from hawk.worlds.world import World

PICTURES_S: Final = 5
HEIGHT_M: Final = 35.0
SPEED_M_S: Final = 5.0
_OVERLAP: Final = (0.8, 0.5)
_SWAY: Final = 0.02
_QUALITY: Final = 92
_ABOVE_M: Final = 100.0
"""Height of the drawn ground above the sea, in captions: an altitude that equals the height is refused."""
_BEGUN: Final = datetime(2026, 5, 4, 10, 30, tzinfo=UTC)


@dataclass(frozen=True, slots=True)
class Filmed:
    """F1 of the stalls of one flight: ``flown`` by the drone's own program, ``recording`` and ``film`` as sources."""

    name: str
    flown: float
    recording: float
    film: float
    frames: int
    shots: int


def film_figures(seeds: Sequence[int]) -> list[Figure]:
    """Return the figures of a flight over each drawn world, and print a line for each."""
    filmed = []
    for seed in seeds:
        with tempfile.TemporaryDirectory(prefix="hawk-film-") as path:
            filmed.append(judge(seed, Path(path)))
        print(filmed[-1], file=sys.stderr, flush=True)
    flown = float(np.mean([one.flown for one in filmed]))
    film, recorded = (float(np.mean([getattr(one, name) for one in filmed])) for name in ("film", "recording"))
    limit = Limit(lowest=-0.005)
    return [
        Figure("film_f1_flown", "drawn flights: F1 as flown", flown),
        Figure("film_f1", "drawn flights: F1 of MP4 with captions", film),
        Figure("film_f1_recording", "drawn flights: F1 of the recording as a source", recorded),
        Figure("film_f1_gain", "drawn flights: F1 of the film beyond that as flown", film - flown, limit=limit),
        Figure("film_shots", "drawn flights: frames taken of a film", float(np.mean([one.shots for one in filmed]))),
    ]


def judge(seed: int, folder: Path) -> Filmed:
    """Fly over a drawn world, and map the flight as it was flown, as a recording and as a film."""
    world = generate_world(seed)
    truth = parse_truth(world.truth_json())
    datum = truth.origin or ORIGIN
    truth = replace(truth, origin=datum)
    recording = record(world, folder / "flight.mcap", datum, seed)
    flight = RecordedFlight(recording)
    flown = process(flight, Again(flight.settings(), version("hawk-drone")))
    measured = compare(SurveyMap.of(datum, flown.final), truth)["stall_f1"]
    film = write_film(recording, folder / "DJI_0001.MP4")
    as_film, shots = _mapped(film, truth, LensChoice(calibration=camera_model(lens=False)))
    as_recording, _ = _mapped(recording, truth, LensChoice())
    return Filmed(f"seed {seed}", measured, as_recording, as_film, flown.frames, shots)


def _mapped(path: Path, truth: GroundTruth, lens: LensChoice) -> tuple[float, int]:
    film = read_film(path, lens=lens)
    survey = survey_shots(Taken(path.name, SourceKind.FILM), film.shots, film)
    film.close()
    found = SurveyMap.of(survey.landed.datum, survey.landed.current)
    return compare(found, truth)["stall_f1"], len(film.shots)


def record(world: World, path: Path, datum: GlobalPose, seed: int) -> Path:
    """Write the recording of a flight over a world's lots."""
    place = {name: getattr(datum, name) for name in GlobalPose.__slots__}
    tick = Item(TICK, {"facts": {"position": {"datum": place, "pose": None}}}, "json", 1, 100)
    kind = FlightKind(HEIGHT_M, SPEED_M_S, PICTURES_S, _SWAY, _QUALITY)
    return write_flight(path, _BEGUN, drawn_frames(world, _places(world), kind, seed), [tick])


def _places(world: World) -> Iterator[tuple[float, float, float]]:
    """Give the places and yaws of the pictures: along lanes as `hawk.sim.photos` plans them."""
    poses = plan(world, PhotoOptions(height=HEIGHT_M, overlap=_OVERLAP, camera=CAMERAS["FC6310"]))
    times = np.array([pose.seconds for pose in poses])
    for at in np.arange(0.0, times[-1], 1.0 / PICTURES_S).tolist():
        after = int(np.clip(np.searchsorted(times, at), 1, len(times) - 1))
        share = (at - times[after - 1]) / max(times[after] - times[after - 1], 1e-9)
        before, later = poses[after - 1], poses[after]
        x, y = (a + share * (b - a) for a, b in ((before.x_east, later.x_east), (before.y_south, later.y_south)))
        yield x, y, before.yaw


def write_film(recording: Path, path: Path) -> Path:
    """Write a recording's pictures as an MP4 with captions beside it; return the film's path."""
    read = read_frames(recording)
    wanted = dict(zip(read.numbers, range(len(read.numbers)), strict=True))
    writer: cv2.VideoWriter | None = None
    blocks: list[str] = []
    number = 0
    for message in RecordedFlight(recording).messages():
        if message.topic != FRAME_INPUT:
            continue
        row, number = wanted.get(number), number + 1
        if row is None:
            continue
        try:
            picture = decode(picture_of(message.data))
        except NoImage:  # the flight left it out, too
            continue
        if writer is None:
            size = (picture.shape[1], picture.shape[0])
            writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), PICTURES_S, size)
        writer.write(picture)
        blocks.append(_caption(len(blocks), PICTURES_S, read.course.at(read.course.time[row : row + 1])))
    if writer is not None:
        writer.release()
    path.with_suffix(".SRT").write_text("\n".join(blocks), encoding="utf-8")
    return path


def _caption(number: int, rate: float, at: Course) -> str:
    """Return the caption of a frame as a Mavic 3 writes it: angles of 0, -90, 0 look straight down to north."""
    turn = rotation(*at.attitude[0]) @ rotation(0.0, math.pi / 2, 0.0).T
    roll, pitch, yaw = (math.degrees(angle) for angle in angles(turn))
    begin, end = number / rate, (number + 1) / rate
    moment = _BEGUN + timedelta(seconds=begin)
    return (
        f"{number + 1}\n{_stamp(begin)} --> {_stamp(end)}\n"
        f'<font size="28">FrameCnt: {number + 1}, DiffTime: {1000 / rate:.0f}ms\n'
        f"{moment:%Y-%m-%d %H:%M:%S}.{moment.microsecond // 1000:03d}\n"
        f"[latitude: {at.latitude[0]:.6f}] [longitude: {at.longitude[0]:.6f}] "
        f"[rel_alt: {at.height[0]:.3f} abs_alt: {at.altitude[0] + _ABOVE_M:.3f}] "
        f"[gb_yaw: {yaw:.1f} gb_pitch: {pitch:.1f} gb_roll: {roll:.1f}] </font>\n"
    )


def _stamp(at: float) -> str:
    whole = round(at * 1000)
    return f"{whole // 3_600_000:02d}:{whole // 60_000 % 60:02d}:{whole // 1000 % 60:02d},{whole % 1000:03d}"
