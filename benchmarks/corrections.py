"""Cost of correcting the plan of a lot: milliseconds an operation, from the request's JSON to the answer's.

``python -m benchmarks.corrections [--json FILE]``

A lot of 300 and one of 20,000 stalls are corrected through the store as the daemon has it, with every commit on the
disk. Each operation is done, undone and done again five times, after a first time that loads libraries; the median
counts. Operations on a whole lot are shown without a limit.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
import uuid
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from pydantic_core import to_json
from sqlalchemy import insert

from benchmarks.figures import Figure, Limit, Section, print_and_write
from benchmarks.options import make_parser
from hawk.lots.plan import edits
from hawk.lots.plan.queries import all_stalls
from hawk.lots.plan.values import LayoutStall
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LAYOUT, LOT, STALL
from hawk.results.row_labels import letters

LIMITS_MS: Final = {300: 15.0, 20_000: 100.0}
ROUNDS: Final = 5
A_ROW: Final = 100
_PITCH_M, _DEEP_M, _APART_M = 2.5, 5.0, 9.0
Asked = Mapping[str, Any]


def drawn_lot(path: Path, count: int) -> tuple[Database, str]:
    """Store a lot of rows of `A_ROW` stalls, from the datum southwards, and return the store and the lot's id."""
    store, lot, names, letter = Database(path), str(uuid.uuid4()), letters(), ""
    rows: list[dict[str, Any]] = []
    for number in range(count):
        row, along = divmod(number, A_ROW)
        letter = letter if along else next(names)
        shape = {"north": -row * _APART_M, "east": along * _PITCH_M, "angle": 0.0, "width": _PITCH_M, "length": _DEEP_M}
        ids = {"id": str(uuid.uuid4()), "lot": lot, "label": f"{letter} {along + 1}", "begins": 1, "ends": None}
        rows.append({**ids, **shape, "kind": "", "is_confirmed": False, "first_survey": None, "first_id": None})
    place = {"outline": '{"polygons":[],"holes":[]}', "latitude": 52.0, "longitude": 5.0, "datum_is_pinned": True}
    with store.writing() as connection:
        connection.execute(insert(LOT).values(id=lot, name="Lot 1", **place, made=0.0))
        connection.execute(insert(LAYOUT).values(lot=lot, version=1, valid_from=0.0, why="drawn", who="benchmark"))
        connection.execute(insert(STALL), rows)
    return store, lot


def operations(stalls: Sequence[LayoutStall]) -> dict[str, Callable[[int], Asked]]:
    """Return what is measured by name: the operation of a round, from 0."""
    ids = [stall.id for stall in stalls]
    return {
        "add_stall": lambda n: {"do": "add_stall", "north": 60.0 + 9 * n, "east": 0.0, "angle": 0.0, "width": 2.5,
                                "length": 5.0},
        "add_row": lambda n: {"do": "add_row", "front": [[200 + 9 * n, 0], [200 + 9 * n, 50]], "far": [205 + 9 * n, 0]},
        "move_both_ends": lambda _: {"do": "move", "stalls": [ids[0], ids[-1]], "north": 0.01, "east": 0.0},
        "turn_row": lambda _: {"do": "turn", "row": "B", "by": 1e-4},
        "widen": lambda n: {"do": "widen", "stalls": ids[20:30], "width": 2.4 + 0.01 * n},
        "split": lambda n: {"do": "split", "stall": ids[40 + n], "parts": 2},
        "renumber": lambda n: {"do": "renumber", "stalls": ids[50:60], "letter": f"Z{'ABCDEF'[n]}Q"},
        "set_kind_of_row": lambda n: {"do": "set_kind", "row": "C", "kind": ("bus", "taxi")[n % 2]},
        "forbid": lambda n: {"do": "forbid", "outline": [[-3.0, 190 + 9 * n], [-3.0, 195 + 9 * n], [3.0, 195 + 9 * n]]},
        "draw_zone": lambda n: {"do": "draw_zone", "name": f"Zone {n}",
                                "outline": [[-9.0, 9.0 * n], [-9.0, 9.0 * n + 5], [9.0, 9.0 * n + 5]]},
        "remove": lambda n: {"do": "remove", "stalls": ids[30 + n : 31 + n]},
        "set_kind_of_all": lambda n: {"do": "set_kind", "all": True, "kind": ("bus", "taxi")[n % 2]},
    }  # fmt: skip


def measure(folder: Path, count: int) -> dict[str, tuple[float, float]]:
    """Return the median milliseconds of each operation, and of undoing it or doing it again, whichever is longer."""
    store, lot = drawn_lot(folder / f"{count}.db", count)

    def timed(act: Callable[..., object], asked: Asked) -> float:
        began = time.perf_counter()
        with store.writing() as connection:
            to_json(act(connection, lot, asked, 0.0))
        return (time.perf_counter() - began) * 1e3

    with store.writing() as connection:
        edit = edits.open_edit(connection, lot, {"who": "Ann"}, 0.0).edit
        stalls = all_stalls(connection, lot)
    found: dict[str, tuple[float, float]] = {}
    for name, asked in operations(stalls).items():
        done: list[float] = []
        again: list[float] = []
        for number in range(ROUNDS + 1):
            done.append(timed(edits.do, {"edit": edit, "operation": asked(number)}))
            again.append(max(timed(act, {"edit": edit}) for act in (edits.undo, edits.redo)))
        found[name] = (statistics.median(done[1:]), statistics.median(again[1:]))
    store.close()
    return found


def figures(measured: Mapping[int, Mapping[str, tuple[float, float]]]) -> list[Figure]:
    """Return the figures of lots by their number of stalls."""
    found = []
    for count, costs in measured.items():
        for name, (done, again) in costs.items():
            limit = None if name.endswith("_all") else Limit(highest=LIMITS_MS[count])
            words = f"{name.replace('_', ' ')}, {count} stalls"
            found.append(Figure(f"{name}_{count}_ms", words, done, "ms", limit=limit))
            found.append(Figure(f"{name}_again_{count}_ms", f"undo or redo: {words}", again, "ms", limit=limit))
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Correct plans, and print a table; return 1 when a figure lies outside its limits."""
    options = make_parser("benchmarks.corrections", __doc__).parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        measured = {count: measure(Path(folder), count) for count in LIMITS_MS}
    return print_and_write([Section("corrections", figures(measured))], options.json)


if __name__ == "__main__":
    sys.exit(main())
