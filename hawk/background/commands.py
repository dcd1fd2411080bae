"""The command ``hawk-drone make-background``: a GeoTIFF becomes a folder of map tiles for the page."""

from __future__ import annotations

import argparse
import re
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import cv2
from rich.console import Console
from rich.progress import track

from hawk.background.geotiff import OPAQUE, GroundPicture, PictureError, open_picture
from hawk.background.tiling import Tile, count_tiles, tiles_of, zooms_for
from hawk.config import ConfigError
from hawk.web.background import DEEPEST_ZOOM

COMMAND: Final = "make-background"
MOST_TILES: Final = 200_000
"""At some 15 kB a tile these take 3 GB."""
_JPEG: Final = (cv2.IMWRITE_JPEG_QUALITY, 85)


@dataclass(frozen=True, slots=True)
class Written:
    """A folder of tiles: their number and bytes."""

    tiles: int
    size: int


def add_background_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(COMMAND, help="make map tiles for the page's background from a GeoTIFF")
    parser.add_argument("picture", type=Path, metavar="PICTURE", help="picture of the ground that says where it lies")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the tiles: new, or empty")
    parser.add_argument("--zooms", type=_zooms, metavar="A-B", help="these zooms (default: as fine as the picture)")
    parser.set_defaults(action=_run)


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


def _run(options: argparse.Namespace) -> int:
    try:
        with open_picture(options.picture) as picture:
            zooms = options.zooms or zooms_for(picture.bounds, picture.metres_per_pixel)
            written = write_tiles(picture, options.out, zooms)
    except PictureError as error:
        raise ConfigError(f"{COMMAND}: {error}") from error
    except OSError as error:
        raise ConfigError(f"--out: {options.out}: {error}") from error
    print(f"{written.tiles} tiles of the zooms {zooms[0]} to {zooms[-1]}, {written.size / 1e6:.1f} MB")
    print("Write this into the settings, section [web], and start the daemon again:", file=sys.stderr)
    print(f'background_tiles = "{options.out.resolve()}"', file=sys.stderr)
    return 0


def _zooms(text: str) -> range:
    found = re.fullmatch(r"(\d{1,2})(?:-(\d{1,2}))?", text)
    first, last = (int(found[1]), int(found[2] or found[1])) if found else (1, 0)
    if not first <= last <= DEEPEST_ZOOM:
        raise argparse.ArgumentTypeError(f"must be A-B with 0 <= A <= B <= {DEEPEST_ZOOM}, not {text}")
    return range(first, last + 1)
