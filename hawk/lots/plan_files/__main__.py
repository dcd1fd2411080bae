"""Reads a plan from the input and writes its stalls to the output: the process of `hawk.lots.plan_files.child`."""

from __future__ import annotations

import contextlib
import json
import os
import resource
import sys
import warnings
from pathlib import Path

from hawk.lots.plan_files.child import CPU_S, MEMORY_BYTES, NICENESS, REFUSED, TOO_MUCH, packed
from hawk.lots.plan_files.reading import read_plan
from hawk.lots.plan_files.values import Asked
from hawk.lots.values import LotInputError


def main(asked: str) -> int:
    """Return the exit status."""
    with contextlib.suppress(OSError):
        os.nice(NICENESS)
        Path("/proc/self/oom_score_adj").write_text("1000", "ascii")  # where memory is short, this process ends first
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_BYTES, MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S))
    warnings.simplefilter("ignore")  # of packages about a stranger's file: nobody reads them here
    try:
        sys.stdout.buffer.write(packed(read_plan(sys.stdin.buffer.read(), Asked(**json.loads(asked)))))
    except LotInputError as error:
        return _refuse(error.field, error.reason)
    except MemoryError:
        return _refuse("file", TOO_MUCH)
    except Exception as error:  # a stranger's file, and packages that expect whole ones
        return _refuse("file", f"cannot be read ({type(error).__name__}): export it again, or in another form")
    return 0


def _refuse(field: str, reason: str) -> int:
    sys.stdout.write(json.dumps({"field": field, "reason": reason}))
    return REFUSED


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
