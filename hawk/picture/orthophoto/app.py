"""An orthophoto mapped as a survey, in this process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from hawk.picture.nadir import Eye
from hawk.picture.orthophoto.outline import LotOutline
from hawk.picture.orthophoto.steps import InMemory, looked, settle, start
from hawk.picture.values import Mapped

Progress = Callable[[int, int], None]
"""Takes the number of windows that are done, and of all."""


def map_orthophoto(
    path: Path,
    *,
    outline: Path | LotOutline | None = None,
    crs: str | None = None,
    model: Path | None = None,
    progress: Progress | None = None,
) -> Mapped:
    """Find the stalls of an orthophoto, free and taken.

    Args:
        path: A GeoTIFF, a VRT, or a JPEG or PNG with its world file.
        outline: Outlines of lots, or a file with them; nothing else is mapped. None: the whole picture.
        crs: The picture's system of coordinates, as ``EPSG:25832``, where its file does not say it.
        model: The network's ONNX file; None: that of the package.
        progress: Is called before the first window and after each one.

    Returns:
        The survey. A window that could not be read is named in ``left_out``, the others are mapped.

    Raises:
        PictureError: The picture or the outlines cannot be used, or no window can be read; the text has the remedy.
    """
    started = start(path, outline=outline, crs=crs, load=lambda: Eye.load(model))
    results, failures, count = InMemory(), dict[str, str](), len(started.tasks)
    if progress is not None:
        progress(0, count)
    for done, (task, reason) in enumerate(looked(started.tasks, started.source, started.eye, results), 1):
        if reason:
            failures[task.name] = reason
        if progress is not None:
            progress(done, count)
    return settle(started, results, failures)
