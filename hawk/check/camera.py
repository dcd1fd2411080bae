"""Check of the camera: its source is opened by the daemon's own code, and its pictures are counted for some seconds."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from hawk.check.result import CheckResult, failed, on_thread, passed, warning
from hawk.comm.cameras.drone_camera import STALE_S, CameraFrame, DroneCamera, make_source
from hawk.comm.cameras.sources.source import CameraSource
from hawk.comm.clock import Clock
from hawk.config.addresses import RPICAM, V4L2, v4l2_camera
from hawk.config.sections import CameraSettings, ConfigError
from hawk.formats.image import NoImage
from hawk.runtime.supervision import Supervisor

FIRST_PICTURE_S: Final = 7.0
"""Real seconds for the first picture: counting and the source's end must fit into `hawk.check.run.REST_S`, too."""
COUNTED_S: Final = 3.0
"""Real seconds in which pictures are counted."""
LEAST_HZ: Final = 3.0
"""Fewer pictures a second are too few at travel speed: the map has holes, and the camera's turn is not found."""
_NAME: Final = "Camera"


@dataclass(frozen=True, slots=True)
class CameraSight:
    """The camera's results, and the bytes a second of its pictures; None when none was received."""

    results: Sequence[CheckResult]
    picture_bytes_s: float | None = None


@dataclass(frozen=True, slots=True)
class CameraTimes:
    """Real seconds to wait: for the first picture, and while pictures are counted."""

    first_s: float = FIRST_PICTURE_S
    counted_s: float = COUNTED_S


async def look_at_camera(
    settings: CameraSettings,
    clock: Clock,
    make: Callable[[CameraSettings, Clock], CameraSource] = make_source,
    times: CameraTimes = CameraTimes(),
) -> CameraSight:
    """Open the camera, count its pictures, decode one, close it."""
    try:
        camera = DroneCamera(settings, clock, make=make, supervisor=Supervisor())
    except ConfigError as error:
        return CameraSight([failed(_NAME, f"{error}.", "Correct camera.calibration, or leave it out.")])
    camera.init()
    try:
        return await _watch(camera, settings, clock, times)
    finally:
        await camera.close()


async def _watch(camera: DroneCamera, settings: CameraSettings, clock: Clock, times: CameraTimes) -> CameraSight:
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(times.first_s):
            await camera.next_frame()
    if camera.latest is None:
        said = without_camera(camera.health.reason)
        return CameraSight([failed(_NAME, f"No picture came: {said}.", remedy(settings))])
    frames = await _count(camera, times.counted_s)
    newest = frames[-1]
    size = f"{newest.width} x {newest.height}"
    age, rate = clock() - newest.arrived, _rate(frames, times.counted_s)
    bytes_s = rate * sum(len(frame.jpeg) for frame in frames) / len(frames)
    found = f"{size}, {rate:.1f} pictures a second, the newest {age:.2f} s old"
    if age > STALE_S or rate == 0:
        return CameraSight([failed(_NAME, f"The pictures stopped: {found}.", remedy(settings))])
    try:
        await on_thread(camera.get_image)
    except NoImage as error:
        wrong = f"A picture cannot be used: {without_camera(str(error))} ({found})."
        return CameraSight([failed(_NAME, wrong, "Check camera.calibration and the camera's format.")], bytes_s)
    if not camera.health.is_healthy:  # the calibration is of another size
        words = f"{without_camera(camera.health.reason)} ({found})."
        return CameraSight([failed(_NAME, words, "Calibrate at this size, or set the camera's size.")], bytes_s)
    if rate < LEAST_HZ:
        slow = f"{found}; {LEAST_HZ:g} a second are needed."
        return CameraSight(
            [warning(_NAME, slow, "Choose a smaller picture or another format; is it too dark?")], bytes_s
        )
    damaged = f"; {camera.damaged} damaged ones were dropped" if camera.damaged else ""
    return CameraSight([passed(_NAME, f"{found}{damaged}.")], bytes_s)


async def _count(camera: DroneCamera, seconds: float) -> list[CameraFrame]:
    """Return the pictures of that time; one at least."""
    assert camera.latest is not None  # noqa: S101 - the caller waited for it
    frames = [camera.latest]
    loop = asyncio.get_running_loop()
    end = loop.time() + seconds
    while (left := end - loop.time()) > 0:
        try:
            async with asyncio.timeout(left):
                frames.append(await camera.next_frame())
        except TimeoutError:
            break
    return frames


def _rate(frames: Sequence[CameraFrame], seconds: float) -> float:
    """Return pictures a second; the sequence counts those between two looks, too. Silence at the end counts."""
    return (frames[-1].sequence - frames[0].sequence) / seconds


def without_camera(words: str) -> str:
    """Return the source's words without the prefix of the health."""
    return words.removeprefix("Camera: ").rstrip(". ")


def remedy(settings: CameraSettings) -> str:
    """Return what to do about a camera without pictures, by the kind of its address."""
    url = settings.url.get_secret_value()
    if url.startswith("gst:"):
        return "Try the pipeline by hand with gst-launch-1.0 and autovideosink in place of hawk."
    if url.startswith(RPICAM):
        return "See whether rpicam-hello --list-cameras names it; if not: the flat cable, its direction, config.txt."
    if url.startswith(V4L2):
        path = v4l2_camera(url).device
        if not path.exists():
            return "Plug the camera in; v4l2-ctl --list-devices names the devices."
        return f"Join the group video (sudo usermod -aG video hawk), and see who else uses it: fuser {path}."
    if url.startswith("file:"):
        return "Name a film that exists and can be read."
    if url.startswith(("http:", "https:")):
        return "Start the camera's server (ustreamer), and open camera.url in a browser or with curl."
    return "Switch the camera on, check its address, user and password with another player (ffplay)."
