"""Options of the command line that several measurements have."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection
from pathlib import Path


def make_parser(module: str, words: str | None, *, model: bool = False) -> argparse.ArgumentParser:
    """Return the parser of ``python -m MODULE`` with the option that all have, and that of a network where one looks.

    ``words`` describe it, as they stand.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m {module}", description=words, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every figure as one flat object")
    if model:
        parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    return parser


def parse_seeds(text: str) -> list[int]:
    """Return the seeds of ``1-5`` or ``2,4,7``. Raises ValueError."""
    seeds: list[int] = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        if not (first.isdigit() and (last or first).isdigit() and int(first) <= int(last or first)):
            raise ValueError(f"{text!r} names no seeds; write 1-5 or 2,4,7")
        seeds.extend(range(int(first), int(last or first) + 1))
    return seeds


def seeds_option(text: str) -> list[int]:
    """Return the seeds that a command line names. Raises ArgumentTypeError, which argparse prints."""
    try:
        return parse_seeds(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def names_option(known: Collection[str]) -> Callable[[str], tuple[str, ...]]:
    """Return what reads known names from ``A,B``; it raises ArgumentTypeError, which argparse prints."""

    def read(text: str) -> tuple[str, ...]:
        names = tuple(text.split(","))
        if unknown := [name for name in names if name not in known]:
            raise argparse.ArgumentTypeError(f"{', '.join(unknown)} is not one of {', '.join(known)}")
        return names

    return read


def folder_option(text: str) -> Path:
    """Return the folder that a command line names. Raises ArgumentTypeError, which argparse prints."""
    folder = Path(text)
    if not folder.is_dir():
        raise argparse.ArgumentTypeError(f"{folder} is no folder; name one that holds the pictures")
    return folder
