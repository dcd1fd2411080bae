"""Try the API by its own definition with schemathesis.

``python -m proving.api [--seconds 600] [--examples 100] [--seed 1]``

A server with a small store of lots takes requests that its definition allows, and such as it does not: no answer may be
an error of the program, and each has a status, a type and a form that the definition names. What is refused must be
what the definition refuses. The rest of the words is schemathesis' own. Status 1 when it finds something.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from proving.api.served import Served, served

RULES: Final = """
[checks]
positive_data_acceptance.expected-statuses = ["2XX", 400, 401, 403, 404, 409, 422, 429]
"""
"""Rules that no schema can say are refused with 422, or 400 as OGC API Features asks: a period that ends before it
begins, a name of spaces alone, an outline without a stall. Links that are guessed are slowed with 429."""
DEFINITION: Final = "openapi.json"
MOST_FAILURES: Final = 20


def main(arguments: Sequence[str] | None = None) -> int:
    """Serve, send, and return the status."""
    parser = argparse.ArgumentParser(
        prog="python -m proving.api", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=int, default=600, help="most seconds of the run (default 600)")
    parser.add_argument("--examples", type=int, default=100, help="examples of an address (default 100)")
    parser.add_argument("--seed", type=int, default=1, help="of the examples (default 1)")
    options = parser.parse_args(arguments)
    return asyncio.run(tried(options.seconds, options.examples, options.seed))


async def tried(seconds: int, examples: int, seed: int) -> int:
    """Send examples, half of the time with ids of schemathesis' own and half with those that there are.

    Returns the worse status of schemathesis.
    """
    found = [await _run(seconds // 2, examples, seed, has_ids=has_ids) for has_ids in (False, True)]
    return max(found)


async def _run(seconds: int, examples: int, seed: int, *, has_ids: bool) -> int:
    with tempfile.TemporaryDirectory(prefix="hawk-api-") as folder:
        async with served(Path(folder)) as server:
            rules = Path(folder) / "schemathesis.toml"
            rules.write_text(RULES + (known_ids(server) if has_ids else ""), encoding="utf-8")
            command = (
                sys.executable, "-m", "schemathesis.cli", "--config-file", str(rules), "run",
                f"{server.address}/{DEFINITION}", "--max-time", str(seconds), "--max-examples", str(examples),
                "--seed", str(seed), "--max-failures", str(MOST_FAILURES), "--generation-database", "none",
            )  # fmt: skip
            program = await asyncio.create_subprocess_exec(*command, cwd=folder, env={**os.environ, "NO_COLOR": "1"})
            try:
                return await program.wait()
            finally:
                if program.returncode is None:
                    program.kill()


def known_ids(server: Served) -> str:
    """Return rules of schemathesis by which its requests name what the store has."""
    rules = [
        (r"^/lots/\\{id\\}", {"path.id": server.lot}),
        (r"^/surveys/\\{id\\}", {"path.id": server.survey}),
        (r"^/stalls/\\{id\\}", {"path.id": server.stall}),
        ("^/features/collections/", {"path.collection": "stalls", "path.id": server.stall}),
        ("^/recordings/", {"path.name": server.recording}),
        ("^/changes/", {"path.seq": "1"}),
    ]
    return "".join(
        f'[[operations]]\ninclude-path-regex = "{where}"\nparameters = {{ {_pairs(values)} }}\n'
        for where, values in rules
    )


def _pairs(values: Mapping[str, str]) -> str:
    return ", ".join(f'"{name}" = "{value}"' for name, value in values.items())


if __name__ == "__main__":
    sys.exit(main())
