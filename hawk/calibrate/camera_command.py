"""``hawk-drone calibrate``: the lens from the camera's pictures, or from a folder of pictures."""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.live import Live
from rich.text import Text

from hawk.calibrate.lens import (
    CELL_CORNERS,
    CELLS,
    LEAST_VIEWS,
    NAMES,
    BoardFinder,
    Collector,
    Coverage,
    Lens,
    LensError,
    View,
    calibrate,
    coverage,
)
from hawk.calibrate.settings_file import write_camera_info, write_settings
from hawk.comm.cameras.drone_camera import DroneCamera, make_source
from hawk.comm.cameras.sources.source import CameraSource
from hawk.comm.clock import Clock
from hawk.config.loader import refuse_existing
from hawk.config.sections import CameraSettings, Config, ConfigError
from hawk.formats.image import NoImage, decode, decode_any
from hawk.runtime.supervision import Supervisor

_WIDTH: Final = 640  # pixels of the preview
_GREEN: Final = (90, 200, 60)
_RED: Final = (60, 60, 230)


def coverage_lines(there: Coverage, note: str) -> list[str]:
    """Return the parts of the picture (``##`` enough, ``..`` nothing yet), the tilts and distances, what to do next."""
    rows = ["  ".join(_cell(int(corners)) for corners in row) for row in there.cells]
    tilts = " ".join(
        f"{name}{'+' if seen else '-'}"
        for name, seen in zip(("left", "right", "top", "bottom"), there.leans, strict=True)
    )
    distances = f"near{'+' if there.is_near else '-'} far{'+' if there.is_far else '-'}"
    return [
        *(f"  {row}" for row in rows),
        f"  views {there.views}/{LEAST_VIEWS}   tilt: {tilts}   distance: {distances}   {there.share:.0%}",
        f"  next: {there.missing or 'nothing'}{f'  ({note})' if note else ''}",
    ]


def _cell(corners: int) -> str:
    return "##" if corners >= CELL_CORNERS else ".." if corners == 0 else f"{corners:>2}"


def lens_lines(lens: Lens) -> list[str]:
    """Return a lens with its spreads, for a person."""
    left_out = f", {lens.left_out} left out" if lens.left_out else ""
    rows = [f"{lens.width} x {lens.height}, {lens.views} views{left_out}, error {lens.rms:.3f} px"]
    for name, value, spread in zip(NAMES, lens.values, lens.spreads, strict=True):
        digits = 5 if name[0] in "kp" else 2
        rows.append(f"  {name}  {value:>10.{digits}f} ± {spread:.{digits}f}")
    return rows


def preview(image: NDArray[np.uint8], view: View | None, there: Coverage) -> NDArray[np.uint8]:
    """Return the picture, 640 wide, with the board's corners, and a red frame about each part that is still needed."""
    scale = _WIDTH / image.shape[1]
    small = np.asarray(cv2.resize(image, (_WIDTH, max(1, round(image.shape[0] * scale))), interpolation=cv2.INTER_AREA))
    columns, rows = CELLS
    for row, column in np.argwhere(there.cells < CELL_CORNERS):
        first = (round(column * _WIDTH / columns) + 2, round(row * small.shape[0] / rows) + 2)
        last = (round((column + 1) * _WIDTH / columns) - 3, round((row + 1) * small.shape[0] / rows) - 3)
        cv2.rectangle(small, first, last, _RED, 1)
    for x, y in () if view is None else view.corners * scale:
        cv2.circle(small, (round(x), round(y)), 3, _GREEN, -1)
    return np.asarray(small, np.uint8)


def write_preview(path: Path, picture: NDArray[np.uint8]) -> None:
    """Write a JPEG, whole or not at all, for a viewer that reads the file again and again. Raises OSError."""
    done, data = cv2.imencode(".jpg", picture)
    if not done:
        raise OSError(f"{path}: the picture cannot be encoded")
    temporary = path.with_name(f".{path.name}.new")
    temporary.write_bytes(data.tobytes())
    temporary.replace(path)


_FAILED: Final = 1
_TRIED_EVERY: Final = 3  # views, once everything is covered
_PREVIEW_S: Final = 0.5
_WAIT_S: Final = 1.0
_SUFFIXES: Final = frozenset({".jpg", ".jpeg", ".png"})


@dataclass(frozen=True, slots=True)
class CameraPlan:
    """Files of one calibration, and its limit of time.

    ``pictures`` None: the camera of the settings. ``apply_to``: settings file that gets the line ``calibration``.
    """

    out: Path
    replace: bool = False
    apply_to: Path | None = None
    pictures: Path | None = None
    preview: Path | None = None
    limit_s: float = 600.0


@dataclass(slots=True)
class Session:
    """The views of one calibration. Takes pictures one by one and tries the lens when everything is covered.

    ``note`` says why the last picture was not kept, ``silence`` why none comes; ``lens`` is the accepted one.
    """

    must_be_still: bool
    note: str = ""
    lens: Lens | None = None
    problems: list[str] = field(default_factory=list)
    newest: View | None = None
    silence: str = ""
    _finder: BoardFinder | None = None
    _collector: Collector | None = None
    _size: tuple[int, int] = (0, 0)
    _tried: int = 0

    @property
    def there(self) -> Coverage:
        """Coverage of the views so far."""
        return coverage([] if self._collector is None else self._collector.views, *self._size)

    def take(self, image: NDArray[np.uint8]) -> bool:
        """Take a picture, BGR; return True when its view is kept. Raises LensError for pictures of another size."""
        size = (image.shape[1], image.shape[0])
        if self._finder is None or self._collector is None:
            self._size, self._finder = size, BoardFinder(*size)
            self._collector = Collector(size[0], [], self.must_be_still)
        if size != self._size:
            raise LensError(
                f"a picture is {size[0]} x {size[1]}, the first was {self._size[0]} x {self._size[1]}: use one size"
            )
        self.newest = self._finder.find(image)
        self.note = self._collector.take(self.newest)
        return not self.note

    def try_lens(self, *, at_once: bool = False) -> None:
        """Calibrate when everything is covered and enough views are new; set ``lens`` or ``problems``."""
        views = [] if self._collector is None else self._collector.views
        missing = self.there.missing
        if missing and not at_once:
            return
        if not at_once and self._tried and len(views) < self._tried + _TRIED_EVERY:
            return
        self._tried = len(views)
        try:
            lens = calibrate(views, *self._size)
        except LensError as error:
            self.problems = [str(error)]
            return
        self.problems = lens.problems + ([f"views are missing: {missing}"] if missing else [])
        self.lens = lens if not self.problems else None


def run_camera(
    config: Config, plan: CameraPlan, make: Callable[[CameraSettings, Clock], CameraSource] = make_source
) -> int:
    """Calibrate, print and write; return the exit status. Raises ConfigError for a file that cannot be used."""
    if not plan.replace:
        refuse_existing(plan.out, "name another file, or give --replace")
    try:
        if plan.pictures is not None:
            session = _from_folder(plan.pictures)
        else:
            session = asyncio.run(_from_camera(config.camera, plan, make))
    except LensError as error:
        print(f"hawk-drone calibrate: {error}.", file=sys.stderr)
        return _FAILED
    except KeyboardInterrupt:
        print("hawk-drone calibrate: ended; nothing is written.", file=sys.stderr)
        return _FAILED
    if session.lens is None:
        missing = session.silence or f"views are missing: {session.there.missing}"
        for problem in session.problems or [missing]:
            print(f"hawk-drone calibrate: not accepted: {problem}.", file=sys.stderr)
        return _FAILED
    _write(session.lens, plan)
    return 0


def _write(lens: Lens, plan: CameraPlan) -> None:
    print("\n".join(lens_lines(lens)))
    try:
        write_camera_info(lens, plan.out, datetime.now(UTC))
    except OSError as error:
        raise ConfigError(f"--out: {plan.out} cannot be written: {error.strerror or error}") from error
    line = f'"{plan.out.resolve()}"'
    if plan.apply_to is None:
        print("Write this into the settings, section [camera], and start the daemon again:", file=sys.stderr)
        print(f"calibration = {line}", file=sys.stderr)
        return
    write_settings(plan.apply_to, "camera", {"calibration": line})
    print(f"{plan.apply_to}: changed: calibration = {line}. Start the daemon again.", file=sys.stderr)


def _from_folder(folder: Path) -> Session:
    session = Session(must_be_still=False)
    for path, image in _pictures(folder):
        kept = session.take(image)
        print(f"{path.name}: {'kept' if kept else session.note}")
    print("\n".join(coverage_lines(session.there, "")))
    session.try_lens(at_once=True)
    return session


def _pictures(folder: Path) -> Iterator[tuple[Path, NDArray[np.uint8]]]:
    try:
        paths = sorted(path for path in folder.iterdir() if path.suffix.lower() in _SUFFIXES)
    except OSError as error:
        raise ConfigError(f"--pictures: {folder} cannot be read: {error.strerror or error}") from error
    if not paths:
        raise ConfigError(f"--pictures: {folder} has no pictures (.jpg, .png)")
    for path in paths:
        try:
            yield path, decode_any(path.read_bytes())
        except OSError as error:
            print(f"{path.name}: cannot be read ({error.strerror}), left out", file=sys.stderr)
        except NoImage as error:
            print(f"{path.name}: cannot be read ({error}), left out", file=sys.stderr)


async def _from_camera(
    settings: CameraSettings, plan: CameraPlan, make: Callable[[CameraSettings, Clock], CameraSource]
) -> Session:
    session = Session(must_be_still=True)
    clock = Clock()
    camera = DroneCamera(settings.model_copy(update={"calibration": None}), clock, make=make, supervisor=Supervisor())
    camera.init()
    loop = asyncio.get_running_loop()
    console = Console()
    end = clock() + plan.limit_s
    try:
        with (
            ThreadPoolExecutor(1, thread_name_prefix="calibrate") as worker,
            _Display(console, plan.preview) as display,
        ):
            while session.lens is None and clock() < end:
                try:
                    async with asyncio.timeout(_WAIT_S):
                        frame = await camera.next_frame()
                except TimeoutError:
                    session.note = session.silence = camera.health.reason
                    display.show(session, None)
                    continue
                session.silence = ""
                image = await loop.run_in_executor(worker, _taken, session, frame.jpeg)
                display.show(session, image)
    finally:
        await camera.close()
    return session


def _taken(session: Session, jpeg: bytes) -> NDArray[np.uint8] | None:
    """Take a picture of the camera, and try the lens; return the picture."""
    try:
        image = decode(jpeg)
    except NoImage as error:
        session.note = str(error)
        return None
    if session.take(image):
        session.try_lens()
    return image


class _Display:
    """Shows a session: on a terminal in place, else a line for each change; and as a picture in a file."""

    def __init__(self, console: Console, path: Path | None) -> None:
        self._console = console
        self._live = Live(console=console, auto_refresh=False) if console.is_terminal else None
        self._path = path
        self._next = 0.0
        self._said = ""

    def __enter__(self) -> _Display:
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._live is not None:
            self._live.stop()

    def show(self, session: Session, image: NDArray[np.uint8] | None) -> None:
        """Show the session after a picture; None when there was none. Raises ConfigError for the preview's file."""
        there = session.there
        lines = coverage_lines(there, session.note)
        lines += [f"  not accepted yet: {problem}" for problem in session.problems]
        if self._live is not None:
            self._live.update(Text("\n".join(lines)), refresh=True)
        else:
            said = session.silence or f"{there.views} views, {there.share:.0%}; next: {there.missing or 'nothing'}"
            if said != self._said:
                self._said = said
                print(said, flush=True)
        now = time.monotonic()
        if self._path is None or image is None or now < self._next:
            return
        self._next = now + _PREVIEW_S
        try:
            write_preview(self._path, preview(image, session.newest, there))
        except OSError as error:
            raise ConfigError(f"--preview: {self._path} cannot be written: {error.strerror or error}") from error
