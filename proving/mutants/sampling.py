"""Faults for a module, by cosmic-ray's operators, and a sample of them that depends on a seed alone."""

from __future__ import annotations

import ast
import random
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

SWAPS: Final = {
    "BinaryOperator": {
        "Add_Sub",
        "Sub_Add",
        "Mul_Div",
        "Div_Mul",
        "FloorDiv_Mul",
        "Mod_Mul",
        "BitOr_BitAnd",
        "BitAnd_BitOr",
    },
    "ComparisonOperator": {
        *("Lt_LtE", "Lt_GtE", "LtE_Lt", "LtE_Gt", "Gt_GtE", "Gt_LtE", "GtE_Gt", "GtE_Lt"),
        *("Eq_NotEq", "NotEq_Eq", "Is_IsNot", "IsNot_Is"),
    },
    "UnaryOperator": {"USub_UAdd", "Delete_Not"},
}
"""Replacements of cosmic-ray that are tried. The others fail at once (``a ** b`` for names), or change nothing (``==``
for ``is`` between members of an enumeration)."""

PLAIN: Final = (
    *("AddNot", "ReplaceTrueWithFalse", "ReplaceFalseWithTrue", "ReplaceAndWithOr", "ReplaceOrWithAnd"),
    *("ReplaceBreakWithContinue", "ReplaceContinueWithBreak", "ExceptionReplacer", "NumberReplacer"),
    "ZeroIterationForLoop",
)

Position = tuple[int, int]
"""Line from 1 and column from 0."""


@dataclass(frozen=True, slots=True)
class Mutant:
    """One fault: the operator's occurrence in the module, and where."""

    module: str
    operator: str
    occurrence: int
    line: int


def operators() -> Iterator[tuple[str, Any]]:
    """Yield name and instance of each operator that is tried."""
    from cosmic_ray.plugins import get_operator, operator_names

    for name in operator_names():
        short = name.split("/")[-1]
        kind = re.fullmatch(r"Replace(\w+?Operator)_(\w+)|ReplaceUnaryOperator_(\w+)", short)
        if short in PLAIN or (kind and kind[2] in SWAPS.get(kind[1], set())):
            yield name, get_operator(name)()


def spans_left_out(tree: ast.Module) -> Iterator[tuple[Position, Position]]:
    """Yield what is never mutated: annotations, decorators, imports for types, ``|`` between types, a lone ``*``."""
    for node in ast.walk(tree):
        left_out: list[ast.AST | None] = []
        match node:
            case ast.FunctionDef() | ast.AsyncFunctionDef():
                left_out += [node.returns, *node.decorator_list]
                yield from _star(node)
            case ast.ClassDef():
                left_out += node.decorator_list
            case ast.arg() | ast.AnnAssign():
                left_out.append(node.annotation)
            case ast.If(test=ast.Name(id="TYPE_CHECKING")):
                left_out.append(node)
        yield from (span(item) for item in left_out if item is not None)
    for statement in tree.body:
        match statement:
            case ast.Assign(value=ast.BinOp(op=ast.BitOr())):
                yield span(statement)


def _star(function: ast.FunctionDef | ast.AsyncFunctionDef) -> Iterator[tuple[Position, Position]]:
    """Yield where the ``*`` before parameters by name stands: a ``/`` in its place changes nothing for such calls."""
    taken = function.args
    if taken.kwonlyargs and taken.vararg is None:
        before = [*taken.posonlyargs, *taken.args, *taken.defaults]
        begin = max((span(item)[1] for item in before), default=span(function)[0])
        yield begin, span(taken.kwonlyargs[0])[0]


def span(node: ast.AST) -> tuple[Position, Position]:
    """Return where a node begins and ends."""
    place: Any = node
    return (place.lineno, place.col_offset), (place.end_lineno, place.end_col_offset)


def function_lines(tree: ast.Module) -> set[int]:
    """Return the lines of function bodies."""
    lines: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            lines.update(range(node.body[0].lineno, (node.end_lineno or node.lineno) + 1))
    return lines


def mutants_of(module: str, source: str) -> list[Mutant]:
    """Return all mutants of a module (its path in the checkout)."""
    from cosmic_ray.ast import get_ast

    left_out = list(spans_left_out(ast.parse(source)))
    found = []
    nodes = list(_nodes(get_ast(source)))
    for name, operator in operators():
        places = [place for node in nodes for place in operator.mutation_positions(node)]
        for occurrence, (begin, end) in enumerate(places):
            if not any(first <= begin and end <= last for first, last in left_out):
                found.append(Mutant(module, name, occurrence, begin[0]))
    return found


def _nodes(node: Any) -> Iterator[Any]:
    yield node
    for child in getattr(node, "children", ()):
        yield from _nodes(child)


def sample(module: str, source: str, seed: int, count: int) -> list[Mutant]:
    """Return a sample of a module's mutants that depends on the seed and the module alone."""
    every = mutants_of(module, source)
    chosen = random.Random(f"{seed} {module}").sample(every, min(count, len(every)))
    return sorted(chosen, key=lambda mutant: (mutant.line, mutant.operator, mutant.occurrence))


def mutated(source: str, mutant: Mutant) -> str:
    """Return the module's source with the fault."""
    from cosmic_ray.mutating import mutate_code
    from cosmic_ray.plugins import get_operator

    code = mutate_code(source, get_operator(mutant.operator)(), mutant.occurrence)
    if code is None:
        raise ValueError(f"{mutant}: there is no such mutant: take a new sample.")
    return str(code)


def difference(before: str, after: str) -> str:
    """Return the changed lines before and after."""
    pairs = zip(before.splitlines(), after.splitlines(), strict=False)
    return "; ".join(f"{old.strip()}  ->  {new.strip()}" for old, new in pairs if old != new)
