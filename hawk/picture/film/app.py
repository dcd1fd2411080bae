"""Reads a film from the air as shots: frames at the pace of the ground with the drone's places."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, Protocol

import numpy as np

from hawk.model.pictures import CameraModel
from hawk.picture.film import autopilot_log, captions, clock, motion, pace, recording
from hawk.picture.film.container import ContainerFacts, read_made
from hawk.picture.film.course import Course
from hawk.picture.film.lens import FilmLens, LensChoice, lens_of
from hawk.picture.film.mount import find_mount
from hawk.picture.film.video import SUFFIXES, Picture, Video
from hawk.picture.photographs.heights import REMEDY, assign_heights, check_given
from hawk.picture.values import LeftOut, PictureError, Progress, Shot, ShotSet

FILMS: Final = (*SUFFIXES, recording.SUFFIX)
"""Endings of the names of films that are read."""
_LOGS: Final = (".srt", *autopilot_log.SUFFIXES)


class Frames(Protocol):
    """A film's frames by their numbers."""

    def frame(self, number: int) -> Picture:
        """Return a frame (H, W, 3), BGR. Raises NoImage."""
        ...

    def frames_of(self, numbers: Sequence[int]) -> Iterator[tuple[int, Picture]]:
        """Give the frames of rising numbers, as far as they can be read."""
        ...

    def close(self) -> None:
        """Close the file."""
        ...


@dataclass(frozen=True, slots=True)
class Film(ShotSet):
    """Shots of a film, each with the number of its frame; its ``frames``."""

    frames: Frames = field(repr=False, kw_only=True)

    def picture(self, shot: Shot) -> Picture:
        """Return a shot's picture (H, W, 3), BGR, quickest in their order. Raises NoImage; ValueError for no frame."""
        if shot.frame is None:
            raise ValueError(f"{shot.name}: is no frame of a film")
        return self.frames.frame(shot.frame)

    def close(self) -> None:
        """Close the file."""
        self.frames.close()


@dataclass(frozen=True, slots=True)
class _Known:
    """A film's course by its own clock, its lens, and sentences on both."""

    course: Course
    lens: FilmLens
    has_gimbal: bool
    notes: tuple[str, ...]


def read_film(
    path: Path,
    *,
    log: Path | None = None,
    log_offset_s: float | None = None,
    lens: LensChoice | None = None,
    height_m: float | None = None,
    progress: Progress = lambda *_: None,
) -> Film:
    """Read a film as shots; it is decoded once, and once more where a log's clock is fitted.

    Args:
        path: MP4, MOV or AVI, or hawk's own recording (MCAP), which needs nothing else.
        log: DJI's captions (SRT) or an ArduPilot log (tlog, bin); None: the file beside the film that has its name.
        log_offset_s: Seconds from the log's first place to the film's first frame, where its fit needs help.
        lens: A person's word on the lens.
        height_m: Height above the ground in the middle of the film, metres, where the log gives none or another one.
        progress: Is called with the step, how much of it is done, and of how much.

    Raises:
        PictureError: The film or its log cannot be read, do not belong together, or give no place, height or lens.
    """
    if height_m is not None:
        check_given(height_m)
    suffix = path.suffix.lower()
    if suffix == recording.SUFFIX:
        return _of_recording(path, height_m, progress)
    if suffix not in SUFFIXES:
        raise PictureError(f"{path}: is no film that is read: {', '.join(FILMS)}")
    video = Video(path)
    try:
        return _of_video(video, _log_of(path, log), log_offset_s, lens or LensChoice(), height_m, progress)
    except BaseException:
        video.close()
        raise


def _log_of(path: Path, log: Path | None) -> Path:
    if log is not None:
        if log.suffix.lower() not in _LOGS:
            raise PictureError(f"--log {log}: must be DJI's captions (.srt) or an ArduPilot log (.tlog, .bin)")
        if not log.is_file():
            raise PictureError(f"--log {log}: is not there; name the file that was written during the film")
        return log
    for suffix in _LOGS:
        found = captions.beside(path, suffix)
        if found is not None:
            return found
    if _made(path).has_captions:
        raise PictureError(
            f"{path}: its captions are a track of the film itself; write them beside it: "
            f"ffmpeg -i {path} -map 0:s:0 {path.with_suffix('.SRT')}"
        )
    raise PictureError(
        f"{path}: no captions ({path.stem}.SRT) and no log lie beside it, so nothing says where it was taken; copy the "
        "captions from the drone's card, or name an ArduPilot log by --log"
    )


def _of_video(
    video: Video, log: Path, offset_s: float | None, choice: LensChoice, height_m: float | None, progress: Progress
) -> Film:
    made = _made(video.path)
    if log.suffix.lower() == ".srt":
        known = _by_captions(video, log, choice, made, height_m)
    else:
        known = _by_log(video, log, offset_s, choice, made, height_m, progress)
    times = np.arange(video.frames) / video.fps
    course = known.course.at(times)
    planned = pace.plan(course, known.course.covers(times), known.lens.camera)
    left = _left_out(video.path.name, planned)
    chosen = _chosen(video.path, planned, video, left, progress)
    epoch = course.epoch if course.epoch is not None else made.begun
    common = _Common(video.path, choice.model or made.model, known.lens.is_known, known.has_gimbal, epoch)
    numbers = range(video.frames)
    shots = _shots(common, chosen, numbers, course, [known.lens.camera] * len(numbers))
    found, low = assign_heights(shots, height_m)
    is_sure = course.epoch is not None and log.suffix.lower() == ".bin"  # a .tlog has the desk's clock
    return Film(tuple(found), (*left, *low), known.notes, is_sure, frames=video)


def _made(path: Path) -> ContainerFacts:
    try:
        return read_made(path)
    except OSError as error:
        raise PictureError(f"{path} cannot be read ({error.strerror or error}); copy it again") from None


def _by_captions(video: Video, log: Path, choice: LensChoice, made: ContainerFacts, height_m: float | None) -> _Known:
    found = captions.read_captions(log, video.frames, video.fps)
    lens = lens_of(video.path.name, video.size, choice, made.model, found.focal_mm, found.zoom)
    course = _with_heights(found.course, height_m, log)
    notes = list(lens.notes)
    if not np.isfinite(course.attitude).all(axis=1).any():
        notes.append("The captions do not say where the camera looked: straight down is assumed, its yaw is not known")
    return _Known(course, lens, True, tuple(notes))


def _by_log(
    video: Video,
    log: Path,
    offset_s: float | None,
    choice: LensChoice,
    made: ContainerFacts,
    height_m: float | None,
    progress: Progress,
) -> _Known:
    lens = lens_of(video.path.name, video.size, choice, made.model, None, 1.0)
    flight = autopilot_log.read_log(log, choice.calibration)
    course = _with_heights(flight.course, height_m, log)
    moved = motion.measure(video, lens.camera, lambda done, of: progress("fit the clock", done, of))
    length = video.frames / video.fps
    fit: Callable[[Course], clock.ClockFit] = lambda each: clock.fit(  # noqa: E731
        video.path.name, moved, length, each, offset_s, made.begun
    )
    if flight.has_gimbal:
        fitted = fit(course)
        return _Known(course.shifted(-fitted.begin), lens, True, (*lens.notes, fitted.note))
    found = find_mount(course, fit)
    notes = (*lens.notes, found.fitted.note, found.note)
    return _Known(found.course.shifted(-found.fitted.begin), lens, found.is_steadied, notes)


def _with_heights(course: Course, height_m: float | None, log: Path) -> Course:
    found = course.with_heights(height_m)
    if not np.isfinite(found.height).any():
        raise PictureError(f"{log}: gives no height above the ground; {REMEDY}")
    return found


def _chosen(path: Path, planned: pace.Plan, frames: Frames, left: list[LeftOut], progress: Progress) -> list[int]:
    """Return the numbers of the frames that are taken."""
    if not planned.due:
        reasons = "; ".join(f"{each.name} {each.reason}" for each in left)
        raise PictureError(f"{path}: no frame of it can be used: {reasons}")
    step: Callable[[int, int], None] = lambda done, of: progress("choose frames", done, of)  # noqa: E731
    chosen, missing = pace.sharpest(planned.due, frames.frames_of, step)
    if not chosen:
        raise PictureError(
            f"{path}: none of its frames can be read: it is damaged; copy it again from the camera's card"
        )
    if missing:
        left.append(
            LeftOut(f"{missing} of {len(planned.due)} frames of {path.name}", "are damaged or torn off; copy it again")
        )
    return chosen


def _left_out(name: str, planned: pace.Plan) -> list[LeftOut]:
    return [
        LeftOut(f"{count} {'frame' if count == 1 else 'frames'} of {name}", reason)
        for reason, count in planned.left_out.items()
    ]


@dataclass(frozen=True, slots=True)
class _Common:
    """Facts that all shots of a film share. ``epoch``: Unix time of second 0, None where nothing says it."""

    path: Path
    model: str
    lens_is_known: bool
    has_gimbal: bool
    epoch: float | None


def _shots(
    common: _Common, rows: Sequence[int], numbers: Sequence[int], course: Course, cameras: Sequence[CameraModel]
) -> list[Shot]:
    """Return the shots of these rows of ``numbers``, the frames', and of ``course`` and ``cameras``."""
    velocity = course.velocity()
    shots = []
    for row in rows:
        roll, pitch, yaw = course.attitude[row].tolist()
        altitude = float(course.altitude[row])
        shots.append(
            Shot(
                path=common.path,
                camera=cameras[row],
                latitude=float(course.latitude[row]),
                longitude=float(course.longitude[row]),
                altitude=altitude if math.isfinite(altitude) else None,
                height=float(course.height[row]),
                attitude=(roll, pitch, yaw) if math.isfinite(roll + pitch + yaw) else None,
                sigma=course.sigma,
                time=None if common.epoch is None else common.epoch + float(course.time[row]),
                model=common.model,
                lens_is_known=common.lens_is_known,
                has_gimbal=common.has_gimbal,
                velocity=(float(velocity[row, 0]), float(velocity[row, 1])),
                frame=numbers[row],
            )
        )
    return shots


def _of_recording(path: Path, height_m: float | None, progress: Progress) -> Film:
    read = recording.read_frames(path)
    course = read.course.with_heights(height_m)
    frames = recording.RecordedPictures(path)
    planned = pace.plan(course, np.ones(len(read.numbers), np.bool_), read.cameras[0])
    rows = {number: row for row, number in enumerate(read.numbers)}
    left = _left_out(path.name, planned)
    if read.left_out:
        left.append(LeftOut(f"{read.left_out} frames of {path.name}", "were taken on the ground, or have no place"))
    due = [replace(each, candidates=tuple(read.numbers[row] for row in each.candidates)) for each in planned.due]
    chosen = [rows[n] for n in _chosen(path, replace(planned, due=tuple(due)), frames, left, progress)]
    notes = (f"The rest of {path.name} is missing: {read.damage}",) if read.damage else ()
    common = _Common(path, "hawk-drone", True, True, course.epoch)
    shots = _shots(common, chosen, read.numbers, course, read.cameras)
    return Film(tuple(shots), tuple(left), notes, frames=frames)
