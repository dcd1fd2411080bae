"""Parts of a lot that statistics count by themselves, beside the whole."""

from __future__ import annotations

from typing import Final, Literal, get_args

Partition = Literal["hour", "row", "zone", "kind", "section"]
"""Partition of a lot: by hours of the day, by its stalls, or by its sections."""
PARTITIONS: Final[tuple[Partition, ...]] = get_args(Partition)
"""Values of ``by``."""
