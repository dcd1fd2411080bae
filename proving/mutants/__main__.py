"""Try the tests of the modules that decide about safety or keep surveys: ``python -m proving.mutants [--seed N]``.

A mutant is a module with one small fault from cosmic-ray's operators (a bound moved, a condition turned, a number one
larger). A seeded sample of each module's mutants is written into a copy of the checkout, one after the other, and the
fast unit tests that reach its line run against it. The exit status is 1 when too few mutants of a group are killed
(`NEEDED`).
"""

from __future__ import annotations

import argparse
import ast
import os
import shutil
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

from proving.mutants.modules import ALL_MODULES, GROUPS, NEEDED, ROOT, SAFETY_MODULES, WITHOUT_EVERY_BRANCH
from proving.mutants.reach import ReachMap, map_of_tests
from proving.mutants.runs import Verdict, run_all
from proving.mutants.sampling import Mutant, function_lines, sample

LEFT_BEHIND: Final = shutil.ignore_patterns(
    ".git", ".venv", "node_modules", ".mypy_cache", ".ruff_cache", ".hypothesis"
)


def table(verdicts: Iterable[Verdict]) -> str:
    """Return the table by module and group, in Markdown."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for verdict in verdicts:
        counts[verdict.mutant.module][verdict.outcome] += 1
    rows = ["| module | mutants | killed | survived | score |", "|---|---|---|---|---|"]
    for group, modules in GROUPS.items():
        tried = [module for module in modules if module in counts]
        if tried:
            rows.append(_row(f"**{group}**", sum((counts[module] for module in tried), Counter())))
            rows += [_row(f"`{module}`", counts[module]) for module in tried]
    rows.append(_row("**all**", sum(counts.values(), Counter())))
    return "\n".join(rows)


def _row(name: str, count: Mapping[str, int]) -> str:
    return f"| {name} | {_tried(count)} | {_killed(count)} | {count.get('survived', 0)} | {_score(count):.0%} |"


def _tried(count: Mapping[str, int]) -> int:
    return sum(count.values())


def _killed(count: Mapping[str, int]) -> int:
    return _tried(count) - count.get("survived", 0)


def _score(count: Mapping[str, int]) -> float:
    return _killed(count) / _tried(count) if _tried(count) else 1.0


def groups_below(verdicts: Iterable[Verdict]) -> list[str]:
    """Return the groups of which fewer mutants were killed than are needed."""
    group_of = {module: group for group, modules in GROUPS.items() for module in modules}
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for verdict in verdicts:
        counts[group_of[verdict.mutant.module]][verdict.outcome] += 1
    return [group for group, count in counts.items() if _score(count) < NEEDED[group]]


def main(arguments: Sequence[str] | None = None) -> int:
    """Try a sample of the mutants and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sample", type=int, default=25, help="mutants of a module")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--only", default="", help="modules whose path contains this text; several by commas")
    parser.add_argument(
        "--tests",
        default="",
        help="folders of the tests, with commas, in place of those of the rooms: fewer kill fewer",
    )
    parser.add_argument("--verbose", action="store_true", help="show the killed ones too")
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "hawk-mutants" / "map.json")
    parser.add_argument(
        "--list", action="store_true", help="print the modules whose every branch is reached, with commas"
    )
    options = parser.parse_args(arguments)
    if options.list:
        print(",".join(module for module in SAFETY_MODULES if module not in WITHOUT_EVERY_BRANCH))
        return 0
    modules = [module for module in ALL_MODULES if any(part in module for part in options.only.split(","))]
    if not modules:
        parser.error(f"--only: no module has {options.only!r} in its path; --list shows all")
    with tempfile.TemporaryDirectory(prefix="hawk-mutants-") as place:
        folders = [Path(place) / str(number) for number in range(options.processes)]
        shutil.copytree(ROOT, folders[0], ignore=LEFT_BEHIND)
        tests = tuple(filter(None, options.tests.split(",")))
        found = map_of_tests(folders[0], modules, options.processes, options.cache, tests)
        for folder in folders[1:]:
            shutil.copytree(folders[0], folder)
        jobs = list(_jobs(found, modules, options))
        verdicts = []
        for verdict in run_all(jobs, folders, found.known):
            verdicts.append(verdict)
            mutant = verdict.mutant
            if verdict.outcome == "survived" or options.verbose:
                name = mutant.operator.split("/")[-1]
                place = f"{mutant.module}:{mutant.line} {name}#{mutant.occurrence}"
                print(f"{verdict.outcome} {verdict.seconds:.0f} s {place}: {verdict.shown}", flush=True)
            if len(verdicts) % 50 == 0:
                print(f"{len(verdicts)} of {len(jobs)}", flush=True)
    print(table(verdicts))
    below = groups_below(verdicts)
    limits = ", ".join(f"{group} (needs {NEEDED[group]:.0%})" for group in below)
    print(f"Too few mutants are killed: {limits}." if below else "Every group is at its limit or above.")
    return 1 if below else 0


def _jobs(
    found: ReachMap, modules: Iterable[str], options: argparse.Namespace
) -> Iterator[tuple[Mutant, tuple[str, ...], float]]:
    for module in modules:
        source = (ROOT / module).read_text(encoding="utf-8")
        inside = function_lines(ast.parse(source))
        for mutant in sample(module, source, options.seed, options.sample):
            tests = found.tests(mutant, mutant.line in inside)
            limit = 60.0 + 10.0 * sum(map(found.cost, tests))
            yield mutant, tests, limit


if __name__ == "__main__":
    sys.exit(main())
