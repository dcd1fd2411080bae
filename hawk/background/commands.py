"""The command ``hawk-drone make-background``: a GeoTIFF becomes a folder of map tiles for the page.

Other commands pay nothing for it: what reads and writes pictures is imported when it is run.
"""

from __future__ import annotations

import argparse
import re
import sys
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.config.sections import ConfigError
from hawk.runtime.late import late

if TYPE_CHECKING:
    from hawk.background import tiles
    from hawk.web import background
else:
    tiles = late("hawk.background.tiles")
    background = late("hawk.web.background")

COMMAND: Final = "make-background"


def add_background_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(COMMAND, help="make map tiles for the page's background from a GeoTIFF")
    parser.add_argument(
        "picture", type=values.file, metavar="PICTURE", help="picture of the ground that says where it lies"
    )
    parser.add_argument(
        "--out", type=values.path, required=True, metavar="DIR", help="folder of the tiles: new, or empty"
    )
    parser.add_argument("--zooms", type=_zooms, metavar="A-B", help="these zooms (default: as fine as the picture)")
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    try:
        with tiles.open_picture(options.picture) as picture:
            zooms = options.zooms or tiles.zooms_for(picture.bounds, picture.metres_per_pixel)
            written = tiles.write_tiles(picture, options.out, zooms)
    except tiles.PictureError as error:
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
    if not first <= last <= background.DEEPEST_ZOOM:
        raise argparse.ArgumentTypeError(f"must be A-B with 0 <= A <= B <= {background.DEEPEST_ZOOM}, not {text}")
    return range(first, last + 1)
