"""The fence that an operator drew, kept over restarts in a GeoJSON file of its own."""

from __future__ import annotations

from pathlib import Path

from hawk.ddc.atomic_file import put_aside, write_atomically
from hawk.ddc.fence_file import outline_geojson, read_outline
from hawk.ddc.fence_plan import FencePlan
from hawk.ddc.geofence import FenceError

FENCE_FILE = "fence.geojson"


class FenceStore:
    """Reads and writes the file. A write is atomic: a crash leaves the old fence or the new one, whole."""

    def __init__(self, directory: Path, ceiling: float) -> None:
        """``ceiling``: the highest allowed, metres; what is stored above it is lowered to it."""
        self._path = directory / FENCE_FILE
        self._ceiling = ceiling

    def read(self) -> FencePlan | None:
        """Return the stored fence, None when none was drawn. Raises FenceError for a file that cannot be used."""
        if not self._path.exists():
            return None
        ring, ceiling = read_outline(self._path)
        return FencePlan("drawn", ring, self._ceiling if ceiling is None else min(ceiling, self._ceiling))

    def write(self, plan: FencePlan) -> None:
        """Store the fence durably. Blocks on the disk: call it off the loop. Raises FenceError."""
        try:
            write_atomically(self._path, outline_geojson(plan.ring, plan.ceiling))
        except OSError as error:
            raise FenceError(f"The fence could not be stored in {self._path}: {error}") from error

    def put_aside(self) -> None:
        """Keep the file under another name: no fence is drawn any longer. Blocks on the disk. Raises FenceError."""
        try:
            put_aside(self._path, "former")
        except OSError as error:
            raise FenceError(f"The fence could not be put aside in {self._path.parent}: {error}") from error
