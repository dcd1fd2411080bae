"""hawk-sim with a camera of small pictures: a reference recording must be small.

``python -m tests.reference.small_camera [options of hawk-sim]``
"""

from __future__ import annotations

import sys
from typing import Final
from unittest import mock

from hawk.sim import cli
from hawk.sim.camera import camera

WIDTH: Final = 448
HEIGHT: Final = 252
QUALITY: Final = 60
"""At 20 m above the ground a pixel has 6 cm, and the network sees 10 cm a pixel."""


def main() -> int:
    """Run hawk-sim with small pictures; return its exit status."""
    with (
        mock.patch.object(camera, "WIDTH", WIDTH),
        mock.patch.object(camera, "HEIGHT", HEIGHT),
        mock.patch.object(camera, "JPEG_QUALITY", QUALITY),
    ):
        return cli.main()


if __name__ == "__main__":
    sys.exit(main())
