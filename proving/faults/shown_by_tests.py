"""Faults that tests show, by the marker ``fault`` at each of them. The sources are read, no test is run."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

_DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)


class MarkerError(ValueError):
    """A marker that cannot be used; the text names its test."""


@dataclass(frozen=True, slots=True)
class ShownFault:
    """A fault, its required end, and the tests that show it: ``FILE::NAME`` below the folder of tests."""

    words: str
    end: str
    tests: tuple[str, ...]


def shown_by_tests(folder: Path) -> tuple[ShownFault, ...]:
    """Return the marked faults of a folder of tests, in the order of their files.

    The end stands at one test of a fault; the others repeat the fault's words alone. Raises MarkerError for a fault
    without an end, or with two.
    """
    tests: dict[str, list[str]] = {}
    ends: dict[str, str] = {}
    for test, words, end in _markers(folder):
        tests.setdefault(words, []).append(test)
        if end is not None and words in ends:
            raise MarkerError(f"{test}: {words!r} has an end at another test: leave one of them out")
        if end is not None:
            ends[words] = end
    for words in tests.keys() - ends.keys():
        raise MarkerError(f"{tests[words][0]}: {words!r} has no end at any test: add it as the second argument")
    return tuple(ShownFault(words, ends[words], tuple(names)) for words, names in tests.items())


def table(faults: Iterable[ShownFault]) -> str:
    """Return the faults as a table in Markdown."""
    rows = [(fault.words, fault.end, ", ".join(f"`{test}`" for test in fault.tests)) for fault in faults]
    return "\n".join(["| fault | required end | tests |", "|---|---|---|", *(f"| {' | '.join(row)} |" for row in rows)])


def _markers(folder: Path) -> Iterator[tuple[str, str, str | None]]:
    """Yield test, fault and end (None where the marker has none) of each marker."""
    for path in sorted(folder.rglob("test_*.py")):
        source = path.read_text(encoding="utf-8")
        if "mark.fault" in source:
            yield from _of(ast.parse(source).body, path.relative_to(folder).as_posix())


def _of(body: Iterable[ast.stmt], place: str) -> Iterator[tuple[str, str, str | None]]:
    for node in body:
        if not isinstance(node, _DEFINITIONS):
            continue
        test = f"{place}::{node.name}"
        for decorator in node.decorator_list:
            if isinstance(decorator, ast.Call) and ast.unparse(decorator.func) == "pytest.mark.fault":
                words, *end = (ast.literal_eval(argument) for argument in decorator.args)
                yield test, words, end[0] if end else None
        if isinstance(node, ast.ClassDef):
            yield from _of(node.body, test)
