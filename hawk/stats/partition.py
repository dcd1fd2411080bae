"""Parts of a lot that statistics count by themselves, beside the whole."""

from __future__ import annotations

from typing import Final, Literal, get_args

Partition = Literal["hour", "row", "zone", "kind"]
"""Partition of a lot: by hours of the day, or by its stalls."""
PARTITIONS: Final[tuple[Partition, ...]] = get_args(Partition)
"""Values of ``by``."""
