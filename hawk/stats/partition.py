"""Parts of a lot that statistics count by themselves, beside the whole."""

from __future__ import annotations

from enum import StrEnum
from typing import Final


class Partition(StrEnum):
    """Partition of a lot: by hours of the day, or by its stalls."""

    HOUR = "hour"
    ROW = "row"
    ZONE = "zone"
    KIND = "kind"


PARTITIONS: Final = tuple(each.value for each in Partition)
"""Values of ``by``."""
