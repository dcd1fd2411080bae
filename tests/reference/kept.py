"""Reference recordings: flights that today's program must decide, and process, as they were.

They change only by a commit that says why: a change that makes them differ changes how the drone flies, or its map.
`tests.reference.make` makes them; their SHA-256 stand here, so that none changes unseen.
"""

from __future__ import annotations

import hashlib
import lzma
import platform
from pathlib import Path
from typing import Final

import cv2
import numpy as np

FOLDER: Final = Path(__file__).parent
SHA256: Final = {
    "survey.mcap.xz": "317bdd0061498fa41f4006950ffbbbd45f82bc252782f60f7a8afe30adeb270a",
    "faults.mcap.xz": "0ed1e3c1cac45e90412f1e75de911632f54c48afe0baaa571a32c0b0499f0643",
    "battery-swap-before.mcap.xz": "ff246cd3e6c2e4f2ad74460495df37f3ffb189645dc045c6f0f24bdc97d4b3ed",
    "battery-swap-after.mcap.xz": "ee3e9f877ff4973badbc2b7deee61c8ef818ab9e0af59d63db4169834d29d0a1",
}
"""Of the files as they stand in the tree. Say in the commit why one of them is another now."""
MAP: Final = "survey-map.json"
"""Map that the pictures of the survey give, and the kind of machine that made it (`machine`)."""


def unpack(name: str, folder: Path) -> Path:
    """Return the recording of a name, as ``survey``, unpacked into a folder."""
    path = folder / f"{name}.mcap"
    path.write_bytes(lzma.decompress((FOLDER / f"{name}.mcap.xz").read_bytes()))
    return path


def pack(recording: bytes, name: str) -> str:
    """Keep a recording under a name; return the SHA-256 of the file."""
    data = lzma.compress(recording, preset=9 | lzma.PRESET_EXTREME)
    (FOLDER / f"{name}.mcap.xz").write_bytes(data)
    return hashlib.sha256(data).hexdigest()


def machine() -> str:
    """Return the kind of machine, as far as it decides how floating-point numbers are rounded.

    Virtual machines give several generations of processors one name; numpy rounds angles otherwise with AVX-512.
    """
    facts = [line.partition(":") for line in Path("/proc/cpuinfo").read_text().splitlines()]
    said = {name.strip(): value.strip() for name, _, value in reversed(facts)}
    processor = said.get("model name") or platform.machine()
    if "avx512f" in said.get("flags", "").split():
        processor += " with AVX-512"
    return f"{processor}, OpenCV {cv2.__version__}, numpy {np.__version__}"
