"""An orthophoto mapped as a survey, in this process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from hawk.picture.nadir import Eye
from hawk.picture.orthophoto.outline import LotOutline, read_outline
from hawk.picture.orthophoto.source import open_orthophoto
from hawk.picture.orthophoto.survey import check_ground, to_survey
from hawk.picture.orthophoto.windows import WindowStalls, map_window, windows_of
from hawk.picture.values import LeftOut, Mapped, PictureError

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
    source = open_orthophoto(path, crs)
    lots = read_outline(outline) if isinstance(outline, Path) else outline
    if lots is not None:
        lots = lots.near(source.grid)
    windows = windows_of(source, lots)
    eye = Eye.load(model)
    results: list[WindowStalls] = []
    left_out: list[LeftOut] = []
    for done, window in enumerate(windows):
        if progress is not None:
            progress(done, len(windows))
        try:
            results.append(map_window(source, window, eye))
        except PictureError as error:
            left_out.append(LeftOut(window.name(source.grid), str(error)))
    if left_out and not results:
        raise PictureError(left_out[0].reason)
    if progress is not None:
        progress(len(windows), len(windows))
    mapped = to_survey(source, results, outline=lots, model=eye.model, left_out=left_out)
    check_ground(mapped, source, has_lots=lots is not None)
    return mapped
