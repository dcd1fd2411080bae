"""Writes a picture of the ground as a folder of map tiles."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
from rich.console import Console
from rich.progress import track

from hawk.background.geotiff import OPAQUE, GroundPicture, PictureError
from hawk.background.tiling import Tile, count_tiles, tiles_of

MOST_TILES: Final = 200_000
"""At some 15 kB a tile these take 3 GB."""
_JPEG: Final = (cv2.IMWRITE_JPEG_QUALITY, 85)


@dataclass(frozen=True, slots=True)
class Written:
    """A folder of tiles: their number and bytes."""

    tiles: int
    size: int


def write_tiles(picture: GroundPicture, folder: Path, zooms: range) -> Written:
    """Write every tile on which the picture shows something, as JPEG, or as PNG where it ends on the tile.

    ``folder`` must be new or empty; it is there with all tiles, or not at all. Raises PictureError.
    """
    count = count_tiles(picture.bounds, zooms)
    if count > MOST_TILES:
        raise PictureError(f"--zooms: {count} tiles are too many, at most {MOST_TILES}: name lower zooms")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise PictureError(f"--out: {folder} is not empty: name a new folder")
    folder.parent.mkdir(parents=True, exist_ok=True)
    part = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        tiles = track(tiles_of(picture.bounds, zooms), "tiles", count, transient=True, console=Console(stderr=True))
        sizes = [size for tile in tiles if (size := _write(picture, part, tile))]
        if not sizes:
            raise PictureError("the picture shows nothing: all of it is transparent")
        part.chmod(0o755)
        part.replace(folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return Written(len(sizes), sum(sizes))


def _write(picture: GroundPicture, folder: Path, tile: Tile) -> int:
    """Write one tile; return its bytes, none where the picture shows nothing."""
    pixels = picture.read(tile)
    if pixels is None:
        return 0
    if (pixels[..., 3] == OPAQUE).all():
        suffix, (_, data) = ".jpg", cv2.imencode(".jpg", cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGR), _JPEG)
    else:
        suffix, (_, data) = ".png", cv2.imencode(".png", cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGRA))
    path = folder / str(tile.zoom) / str(tile.x) / f"{tile.y}{suffix}"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data.tobytes())
    return len(data)
