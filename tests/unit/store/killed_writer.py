"""A process that writes a journal until it is killed: prints the number of each value after it put it."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from hawk.model.poses import ArmPlace, GlobalPose
from hawk.store.journal import FlightJournal


def main() -> None:
    """Put numbered values, a hundred a second."""
    journal = FlightJournal(Path(sys.argv[1]))
    journal.set_datum(GlobalPose(43.0, -79.0, 100.0))
    journal.set_arm_place(ArmPlace(43.0, -79.0, 100.0, 1.0, 2.0, 3.0))
    number = 0
    while True:
        number += 1
        journal.put_map(
            {f"stall/{number}": str(number).encode(), "grid/0,0": bytes(100_000), "meta": str(number).encode()}
        )
        sys.stdout.write(f"{number} {time.monotonic():.6f}\n")
        sys.stdout.flush()
        time.sleep(0.01)


if __name__ == "__main__":
    main()
